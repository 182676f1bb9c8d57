//! State of the user interface: dialogs that are open, and actions that only the window can do.

use super::dialog::Dialog;
use crate::app::jobs::Status;
use egui::{Rect, TextureHandle, TextureId};
use std::collections::BTreeMap;

/// Comparison of the mesh with its map and the mesh alone.
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

/// Actions that only the window can do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Close the window.
    Quit,
    /// Copy a text to the clipboard.
    Copy(String),
    /// Save the view.
    Screenshot,
    /// Save the view before and after, side by side.
    BeforeAfter,
    /// Save an animation of λ.
    Animation,
    /// Save so many views all around.
    Turntable(u32),
}

/// State of the user interface.
pub struct UiState {
    /// Comparison of noisy and denoised.
    pub comparing: Comparing,
    /// Position of the line of the split view, 0..=1; none in the middle.
    pub divider: Option<f32>,
    /// Whether the list of keys is shown.
    pub help: bool,
    /// Whether the model has the whole window.
    pub panel_hidden: bool,
    /// Actions for the window to do.
    pub actions: Vec<Action>,
    /// Textures of the picture with the map and of the one without; none before there is something to see.
    pub pictures: [Option<TextureId>; 2],
    /// Progress of the upload to the GPU.
    pub showing: Option<Status>,
    /// Rectangle that the model is drawn in; none while the window has no space for it.
    pub view: Option<Rect>,
    /// Number of pictures of a turntable.
    pub turntable: u32,
    /// Index of the light that the mouse drags.
    pub light: usize,
    /// The picture of the map.
    pub(super) map: MapView,
    pub(super) dialog: Option<Dialog>,
    /// Rectangles of the widgets that the log lists, by name.
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
    /// Texture on the device, and the address of the map that it shows.
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
