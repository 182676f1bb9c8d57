//! What the window itself knows: which helpers are open, and what the user asked for and only the window can do.

use super::dialog::Dialog;
use crate::app::jobs::Status;
use egui::{Rect, TextureHandle, TextureId};
use std::collections::BTreeMap;

/// How the mesh with its map is compared with the mesh alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Comparing {
    /// Only the mesh with its map.
    #[default]
    Off,
    /// The noisy mesh on the left of a line that can be dragged.
    Split,
    /// One after the other.
    Blink,
}

/// What only the window can do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// End.
    Quit,
    /// To the clipboard.
    Copy(String),
    /// Save the view.
    Screenshot,
    /// Save so many views all around.
    Turntable(u32),
}

/// What is open and asked for.
pub struct UiState {
    /// Noisy against denoised.
    pub comparing: Comparing,
    /// Where the line of the split view is, 0..=1; none in the middle.
    pub divider: Option<f32>,
    /// Whether the list of keys is shown.
    pub help: bool,
    /// Whether the model has the whole window.
    pub panel_hidden: bool,
    /// For the shell of the window to do.
    pub actions: Vec<Action>,
    /// With the map and without; none before there is something to see.
    pub pictures: [Option<TextureId>; 2],
    /// Where the way of a scene to the device is.
    pub showing: Option<Status>,
    /// Where the model is to be drawn; none while the window has no room for it.
    pub view: Option<Rect>,
    /// How many pictures a turntable has.
    pub turntable: u32,
    /// Which light the mouse drags, in the order of the settings.
    pub light: usize,
    /// The picture of the map.
    pub(super) map: MapView,
    pub(super) dialog: Option<Dialog>,
    /// Where widgets are that a log tells of, by name.
    pub(super) marks: BTreeMap<String, Rect>,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            comparing: Comparing::Off,
            divider: None,
            help: false,
            panel_hidden: false,
            actions: Vec::new(),
            pictures: [None; 2],
            showing: None,
            view: None,
            turntable: 120,
            light: 0,
            map: MapView::default(),
            dialog: None,
            marks: BTreeMap::new(),
        }
    }
}

impl UiState {
    /// Notes where a widget is.
    pub(super) fn mark(&mut self, name: &str, rect: Rect) {
        match self.marks.get_mut(name) {
            Some(known) => *known = rect,
            None => drop(self.marks.insert(name.to_owned(), rect)),
        }
    }
    /// Forgets what lies on the device.
    pub(super) fn forget_device(&mut self) {
        self.map.texture = None;
        self.pictures = [None; 2];
    }
    /// The widgets of this frame; forgets them.
    pub(super) fn take_marks(&mut self) -> BTreeMap<String, Rect> {
        std::mem::take(&mut self.marks)
    }
}

/// The picture of the map in the panel.
pub(super) struct MapView {
    /// On the device, and which map it is of.
    pub(super) texture: Option<(usize, TextureHandle)>,
    /// Share of the map that is seen along a side.
    pub(super) share: f32,
    /// Middle of what is seen, in the unit square, down.
    pub(super) middle: egui::Pos2,
}

impl Default for MapView {
    fn default() -> Self {
        Self { texture: None, share: 1.0, middle: egui::pos2(0.5, 0.5) }
    }
}
