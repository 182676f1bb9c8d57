//! Schedule of bakes, measurements and steps of undo after changed choices.

use super::history::Gesture;
use super::measurement::{self, Measured};
use super::vertex_numbers::Quantity;
use super::{App, Choices, Rebake};
use planish_files::failure::Failure;
use planish_render::settings::camera::Camera;
use planish_render::settings::{Settings, Shading, Size};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time for which nothing must change before a new bake begins.
pub const DEBOUNCE: Duration = Duration::from_millis(250);

impl App {
    /// Takes note of changes and of what came from the background. A slider that moves is baked when it rests or is let go,
    /// and is one step of undo. Returns when to look again although nothing happens.
    pub fn tick(&mut self, now: Instant, gesture: Gesture) -> Option<Instant> {
        self.now = now;
        self.note_choices(gesture);
        self.take_results();
        self.tend_mask();
        if self.watch.has_changed() {
            self.reload();
        }
        self.schedule_bake();
        self.take_measured();
        self.schedule_measurement();
        self.forget_old_news();
        self.news_end().into_iter().chain(self.due).min()
    }

    /// Undoes a step.
    pub fn undo(&mut self) {
        if let Some(before) = self.history.undo() {
            self.go_to(before);
        }
    }
    /// Redoes a step.
    pub fn redo(&mut self) {
        if let Some(after) = self.history.redo() {
            self.go_to(after);
        }
    }
    /// Returns whether there is something to undo, and to redo.
    pub fn can_undo_redo(&self) -> [bool; 2] {
        self.history.can()
    }
    fn go_to(&mut self, choices: Choices) {
        let Settings { camera, size, .. } = self.choices.view;
        self.choices = choices;
        (self.choices.view.camera, self.choices.view.size) = (camera, size);
    }

    fn note_choices(&mut self, gesture: Gesture) {
        let mut choices = self.choices.clone();
        without_camera(&mut choices);
        self.history.note(&choices, gesture);
    }

    /// Starts a bake once the settings have not changed for a while.
    fn schedule_bake(&mut self) {
        if self.choices.bake_config != self.seen {
            self.seen = self.choices.bake_config.clone();
            self.due = Some(self.now + DEBOUNCE);
        }
        if self.document.is_none() || self.begun.as_ref() == Some(&self.choices.bake_config) {
            self.due = None;
            return;
        }
        if self.is_baked() {
            // Back to what is on screen: nothing is to be done, and what goes on was for something else.
            self.baking.drop_running();
            (self.due, self.begun) = (None, self.shown.clone());
            return;
        }
        let Some(due) = self.due else { return };
        // What is being baked is out of date.
        self.baking.drop_running();
        if self.rebake == Rebake::OnDemand {
            self.due = None;
        } else if self.now >= due {
            self.bake();
        }
    }

    fn take_measured(&mut self) {
        match self.measuring.poll() {
            None => {}
            Some(Ok(measured)) => self.measured = Some(measured),
            Some(Err(failure)) => {
                // It would fail for every λ.
                self.fail(&failure);
                if failure != Failure::Interrupted {
                    self.clean = None;
                }
            }
        }
    }

    /// The clean mesh is compared with whenever λ or the map has changed.
    fn schedule_measurement(&mut self) {
        let (Some(clean), Some(document)) = (self.clean.clone(), self.document.clone()) else { return };
        let lambda = self.choices.view.displace.lambda;
        let wants_errors = self.choices.view.shading == Shading::Heat && self.quantity == Quantity::Error;
        let key = (lambda, self.map.as_ref().map(|map| Arc::as_ptr(map) as usize), wants_errors);
        // A measurement that is under way is let finish, so that numbers come while λ moves.
        if self.measured_for == Some(key) || self.measuring.is_busy() {
            return;
        }
        self.measured_for = Some(key);
        let (map, known) = (self.map.clone(), self.measured.as_ref().map(Measured::known));
        self.measuring.start(move |ticket| {
            let map = map.as_deref().map(|map| (map, lambda));
            let request = measurement::Request { known, map, wants_errors };
            measurement::measure(&clean, &document, request, ticket)
        });
    }
}

/// Looking from elsewhere, or in a window of another size, is no step of undo.
pub(super) fn without_camera(choices: &mut Choices) {
    choices.view.camera = Camera::default();
    choices.view.size = Size::default();
}
