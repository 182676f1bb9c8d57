//! Log of the window, one JSON object a line: frames with the time they took, and the state whenever it changes. It serves
//! measurements, and tests that drive the window from outside.

use super::ui_state::UiState;
use super::viewport;
use crate::app::{App, Work};
use planish_files::failure::Failure;
use planish_files::input;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::time::Duration;

/// Writes to a file, or nowhere.
pub(super) struct Log {
    file: Option<BufWriter<File>>,
    last: Value,
}

impl Log {
    pub(super) fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let file = path.map(|path| File::create(path).map_err(|e| Failure::at(path, input::plain(&e)))).transpose()?;
        Ok(Self { file: file.map(BufWriter::new), last: Value::Null })
    }

    fn write(&mut self, line: &Value) {
        if let Some(file) = &mut self.file {
            // A full disk must not end the window.
            let _ = writeln!(file, "{line}").and_then(|()| file.flush());
        }
    }

    /// A frame: how long the window's thread was busy with it, how much of that it waited for the display, and how many
    /// pictures of the model were drawn anew.
    pub(super) fn frame(&mut self, took: Duration, waited: Duration, drawn: usize, app: &App) {
        if self.file.is_none() {
            return;
        }
        let ms = |d: Duration| (1e5 * d.as_secs_f64()).round() / 100.0;
        let busy = busy(app);
        self.write(&json!({ "frame": { "ms": ms(took), "waited": ms(waited), "drawn": drawn, "busy": busy } }));
    }

    /// The state, where it has changed.
    pub(super) fn state(&mut self, app: &App, ui_state: &mut UiState, pixels_per_point: f32) {
        if self.file.is_none() {
            return;
        }
        let rect = |r: egui::Rect| [r.min.x, r.min.y, r.max.x, r.max.y].map(|x| (x * pixels_per_point).round());
        let marks: serde_json::Map<_, _> =
            ui_state.take_marks().into_iter().map(|(name, r)| (name, json!(rect(r)))).collect();
        let messages: Vec<&str> = app.messages().iter().map(|m| m.text.as_str()).collect();
        let state = json!({
            "mesh": app.document().map(|d| d.mesh.display().to_string()),
            "method": app.map().map(|m| &m.manifest.method),
            "wanted": app.choices.bake_config.denoiser.name(),
            "lambda": app.choices.view.displace.lambda,
            "baked": app.is_baked(),
            "measured": app.measured().map(|m| [Some(m.noisy().ea), m.displaced.as_ref().map(|d| d.1.ea)]),
            "busy": busy(app),
            "showing": ui_state.showing.is_some(),
            "painting": app.has_brush(),
            "comparing": format!("{:?}", ui_state.comparing),
            "captions": viewport::captions(app),
            "messages": messages,
            "widgets": marks,
        });
        if state != self.last {
            self.write(&json!({ "state": state }));
            self.last = state;
        }
    }
}

fn busy(app: &App) -> Vec<&'static str> {
    let all = [
        (Work::Load, "load"),
        (Work::Bake, "bake"),
        (Work::Save, "save"),
        (Work::Measure, "measure"),
        (Work::Draw, "draw"),
        (Work::Prepare, "prepare"),
        (Work::BakeAll, "bake all"),
    ];
    all.into_iter().filter(|(work, _)| app.status(*work).is_some()).map(|(_, name)| name).collect()
}
