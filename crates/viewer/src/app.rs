//! State of the window: what is open, what is chosen, and what goes on in the background. No GPU, no widgets;
//! [`App::tick`] never waits.

pub mod bake_config;
pub mod capture;
pub mod document;
pub mod history;
pub mod jobs;
pub mod mask_painter;
pub mod measurement;
pub mod mesh_list;
mod messages;
mod results;
mod schedule;
pub mod vertex_numbers;
pub mod watch;
pub mod window_state;

pub use history::Gesture;
pub use messages::{Message, MessageKind};
pub use schedule::DEBOUNCE;

use bake_config::BakeConfig;
use document::{Document, Map, Origin};
use history::History;
use jobs::{Slot, Status, Wake};
use mask_painter::{Brush, Canvas, MaskPainter};
use measurement::{Clean, Measured};
use mesh_list::MeshList;
use planish_files::bake_files;
use planish_files::failure::Failure;
use planish_files::input::Trust;
use planish_files::output::Folder;
use planish_geometry::mesh::weld::Welding;
use planish_render::settings::Settings;
use results::{Loaded, Saved};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use vertex_numbers::Quantity;
use watch::Watch;
use window_state::WindowState;

/// Choices that undo restores.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choices {
    /// Settings of the bake.
    pub bake_config: BakeConfig,
    /// Settings of the view. The camera is no matter of undo.
    pub view: Settings,
}

/// Time at which a change of the bake settings is baked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rebake {
    /// Changes are baked as soon as they settle.
    #[default]
    Live,
    /// Changes are baked when the user asks for it.
    OnDemand,
}

/// The state behind the window.
pub struct App {
    /// Choices that can be undone.
    pub choices: Choices,
    /// Time at which changes are baked.
    pub rebake: Rebake,
    /// State that is kept from one start to the next.
    pub window_state: WindowState,
    /// Rule on the files that a mesh or a manifest names.
    pub trust: Trust,
    /// Brush that paints masks.
    pub brush: Brush,
    /// Numbers that the model is coloured by, in the shading that shows numbers.
    pub quantity: Quantity,
    painter: MaskPainter,
    meshes: MeshList,
    document: Option<Arc<Document>>,
    map: Option<Arc<Map>>,
    clean: Option<Arc<Clean>>,
    measured: Option<Measured>,
    /// Settings of the last bake that was begun, or of the map that was opened.
    begun: Option<BakeConfig>,
    /// Settings of the map that is shown.
    shown: Option<BakeConfig>,
    /// Settings of the bake at the last tick.
    seen: BakeConfig,
    /// Time at which the next bake begins.
    due: Option<Instant>,
    /// The time of the last tick.
    now: Instant,
    history: History<Choices>,
    messages: Vec<Message>,
    loading: Slot<Loaded>,
    baking: Slot<Map>,
    saving: Slot<Saved>,
    measuring: Slot<Measured>,
    /// Subject of the last measurement that was begun.
    measured_for: Option<measurement::Key>,
    drawing: Slot<Vec<PathBuf>>,
    preparing: Slot<(Arc<Document>, Arc<Canvas>)>,
    baking_all: Slot<mesh_list::Baked>,
    watch: Watch,
    /// Path that is being loaded, or was loaded last.
    source: Option<PathBuf>,
}

/// Kinds of work in the background, as the user would call them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Work that reads files.
    Load,
    /// Work that bakes a map.
    Bake,
    /// Work that writes files.
    Save,
    /// Work that compares with the clean mesh.
    Measure,
    /// Work that draws pictures to disk.
    Draw,
    /// Work that prepares a mesh for painting.
    Prepare,
    /// Work that bakes all meshes of the list.
    BakeAll,
}

impl Work {
    /// Every kind of work.
    pub const ALL: [Self; 7] =
        [Self::Load, Self::Bake, Self::Save, Self::Measure, Self::Draw, Self::Prepare, Self::BakeAll];
}

impl App {
    /// Creates an app with nothing open. `wake` is called when [`tick`](Self::tick) has something to do.
    pub fn new(wake: &Wake, window_state: WindowState) -> Self {
        let choices = Choices::default();
        Self {
            history: History::new(choices.clone()),
            choices,
            rebake: Rebake::default(),
            window_state,
            trust: Trust::default(),
            brush: Brush::default(),
            quantity: Quantity::default(),
            painter: MaskPainter::default(),
            meshes: MeshList::default(),
            document: None,
            map: None,
            clean: None,
            measured: None,
            begun: None,
            shown: None,
            seen: BakeConfig::default(),
            due: None,
            now: Instant::now(),
            messages: Vec::new(),
            loading: Slot::new(Arc::clone(wake)),
            baking: Slot::new(Arc::clone(wake)),
            saving: Slot::new(Arc::clone(wake)),
            measuring: Slot::new(Arc::clone(wake)),
            measured_for: None,
            drawing: Slot::new(Arc::clone(wake)),
            preparing: Slot::new(Arc::clone(wake)),
            baking_all: Slot::new(Arc::clone(wake)),
            watch: Watch::new(Arc::clone(wake)),
            source: None,
        }
    }

    /// Returns the open mesh.
    pub fn document(&self) -> Option<&Arc<Document>> {
        self.document.as_ref()
    }
    /// Returns the last map that was opened or baked successfully.
    pub fn map(&self) -> Option<&Arc<Map>> {
        self.map.as_ref()
    }
    /// Returns the clean mesh that is compared with.
    pub fn clean(&self) -> Option<&Arc<Clean>> {
        self.clean.as_ref()
    }
    /// Returns the comparison with the clean mesh.
    pub fn measured(&self) -> Option<&Measured> {
        self.measured.as_ref()
    }

    /// Returns the progress of one kind of work; none while it does not run.
    pub fn status(&self, work: Work) -> Option<Status> {
        match work {
            Work::Load => self.loading.status(),
            Work::Bake => self.baking.status(),
            Work::Save => self.saving.status(),
            Work::Measure => self.measuring.status(),
            Work::Draw => self.drawing.status(),
            Work::Prepare => self.preparing.status(),
            Work::BakeAll => self.baking_all.status(),
        }
    }

    /// Stops work; what it would have replaced stays.
    pub fn cancel(&mut self, work: Work) {
        match work {
            Work::Load => self.loading.cancel(),
            Work::Bake => {
                self.due = None;
                self.baking.cancel();
            }
            Work::Save => self.saving.cancel(),
            Work::Measure => self.measuring.cancel(),
            Work::Draw => self.drawing.cancel(),
            Work::Prepare => self.preparing.cancel(),
            Work::BakeAll => self.baking_all.cancel(),
        }
    }

    /// Stops all work. What writes files is waited for, so that none is left half written.
    pub fn close(&mut self) {
        self.loading.cancel();
        self.baking.cancel();
        self.measuring.cancel();
        self.preparing.cancel();
        self.saving.finish();
        self.baking_all.finish();
        self.drawing.finish();
    }

    /// Opens a mesh, a manifest or a map. What is open stays until that is read.
    pub fn open(&mut self, path: &Path) {
        self.open_welded(path, Welding::default());
    }

    fn open_welded(&mut self, path: &Path, welding: Welding) {
        let (path, trust) = (path.to_owned(), self.trust);
        self.loading.start(move |ticket| {
            let (document, map) = document::load(&path, welding, trust, ticket)?;
            Ok(Loaded::Document(path, Box::new(document), map.map(Box::new)))
        });
    }

    /// Reads a clean mesh to compare with.
    pub fn compare_with(&mut self, path: &Path) {
        let (path, trust) = (path.to_owned(), self.trust);
        self.loading.start(move |ticket| Ok(Loaded::Clean(Clean::read(&path, trust, ticket)?)));
    }

    /// Stops comparing with the clean mesh.
    pub fn forget_clean(&mut self) {
        self.measuring.drop_running();
        (self.clean, self.measured, self.measured_for) = (None, None, None);
    }

    /// Reads the file again.
    pub fn reload(&mut self) {
        if let Some(path) = self.source.clone() {
            self.open_welded(&path, self.choices.bake_config.settings.welding);
        }
    }

    /// Returns the folder that files are baked for: that of the map that is shown, or one beside the mesh.
    pub fn folder(&self) -> Option<PathBuf> {
        let document = self.document.as_ref()?;
        match self.map.as_ref().map(|map| &map.origin) {
            Some(Origin::Baked { folder, .. }) => Some(folder.clone()),
            // A map that was opened is baked again to where it is.
            Some(Origin::File(path)) => path.parent().map(Path::to_path_buf),
            None => bake_files::folder_beside(&document.mesh).ok(),
        }
    }

    /// Returns whether the map that is shown is what the settings of the bake would give.
    pub fn is_baked(&self) -> bool {
        self.shown.as_ref() == Some(&self.choices.bake_config)
    }

    /// Whether the open mesh is welded as the settings say.
    fn is_welded(&self) -> bool {
        let welding = self.choices.bake_config.settings.welding;
        self.document.as_ref().is_none_or(|document| document.welding == welding)
    }

    /// Starts a bake now; a mesh that is to be welded otherwise is read again first.
    pub fn bake(&mut self) {
        let (Some(document), Some(folder)) = (self.document.clone(), self.folder()) else { return };
        self.due = None;
        let bake_config = self.choices.bake_config.clone();
        self.begun = Some(bake_config.clone());
        if !self.is_welded() {
            self.open_welded(&document.mesh, bake_config.settings.welding);
            return;
        }
        self.baking.start(move |ticket| document::bake(&document, &bake_config, &folder, ticket));
    }

    /// Writes the files of the map to a folder, the very bytes that the command line writes.
    pub fn save(&mut self, folder: &Path) {
        let (Some(document), Some(map)) = (self.document.clone(), self.map.clone()) else { return };
        if !self.is_welded() {
            self.say(MessageKind::Warning, "the mesh is not welded as chosen yet; save again once it is baked");
            return;
        }
        let (folder, bake_config) = (folder.to_owned(), self.choices.bake_config.clone());
        self.saving.start(move |ticket| {
            let place = Folder::open(&folder)?;
            let ready = |map: &Map| match &map.origin {
                Origin::Baked { bake_config: of, folder: to, baked } if **of == bake_config && *to == folder => {
                    Some(baked.clone())
                }
                _ => None,
            };
            let (baked, map) = match ready(&map) {
                Some(baked) => (baked, None),
                None => {
                    let map = document::bake(&document, &bake_config, &folder, ticket)?;
                    let baked =
                        ready(&map).ok_or_else(|| Failure::Internal("the bake is of another mesh".to_owned()))?;
                    (baked, Some(map))
                }
            };
            Ok(Saved { files: baked.write(place)?, map })
        });
    }

    /// Draws pictures to disk in the background.
    pub fn draw(&mut self, work: impl FnOnce(&jobs::Ticket) -> Result<Vec<PathBuf>, Failure> + Send + 'static) {
        self.drawing.start(work);
    }

    /// Returns the command line that bakes the same files.
    pub fn command(&self) -> Option<String> {
        let document = self.document.as_ref()?;
        Some(self.choices.bake_config.command(&document.mesh, &self.folder()?))
    }
}

#[cfg(test)]
mod tests;
