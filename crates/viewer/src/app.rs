//! The window without its window: what is open, what is wanted, and what goes on in the background. No GPU, no widgets;
//! [`App::tick`] never waits.

pub mod document;
pub mod history;
pub mod jobs;
pub mod pictures;
pub mod recipe;
pub mod remembered;
pub mod watch;

use crate::camera::Camera;
use crate::settings::{Settings, Size};
use document::{Clean, Document, Map, Measured, Origin};
use history::History;
use jobs::{Slot, Status, Wake};
use planish_files::bake;
use planish_files::failure::Failure;
use planish_files::output::Folder;
use recipe::Recipe;
use remembered::Remembered;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use watch::Watch;

/// How long nothing must change before a new bake begins.
pub const DEBOUNCE: Duration = Duration::from_millis(250);

/// How long good news are shown.
const NEWS_STAY: Duration = Duration::from_secs(10);

/// What undo goes back over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choices {
    /// What is baked.
    pub recipe: Recipe,
    /// How it is drawn. The camera is no matter of undo.
    pub view: Settings,
}

/// Something to tell the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How bad it is.
    pub kind: MessageKind,
    /// One sentence.
    pub text: String,
    /// When it goes away by itself; errors stay until they are put away.
    until: Option<Instant>,
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    /// All is well.
    Done,
    /// All is well, but.
    Warning,
    /// Something could not be done.
    Error,
}

/// Whether a change of the recipe is baked at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rebake {
    /// As soon as it settles.
    #[default]
    Live,
    /// When asked to.
    OnDemand,
}

/// The state behind the window.
pub struct App {
    /// What can be undone.
    pub choices: Choices,
    /// Whether changes are baked at once.
    pub rebake: Rebake,
    /// What is remembered from start to start.
    pub remembered: Remembered,
    document: Option<Arc<Document>>,
    map: Option<Arc<Map>>,
    clean: Option<Arc<Clean>>,
    measured: Option<Measured>,
    /// Of the last bake that was begun, or of the map that was opened.
    begun: Option<Recipe>,
    /// Of the map that is shown.
    shown: Option<Recipe>,
    /// As it was at the last look.
    seen: Recipe,
    /// When the next bake begins.
    due: Option<Instant>,
    history: History<Choices>,
    messages: Vec<Message>,
    loading: Slot<Loaded>,
    baking: Slot<Map>,
    saving: Slot<Saved>,
    measuring: Slot<Measured>,
    /// The λ and map of the last measurement that was begun.
    measured_for: Option<(f32, Option<usize>)>,
    drawing: Slot<Vec<PathBuf>>,
    watch: Watch,
    /// What is loaded now, or was last.
    source: Option<PathBuf>,
}

enum Loaded {
    Document(PathBuf, Box<Document>, Option<Box<Map>>),
    Clean(Clean),
}

struct Saved {
    files: Vec<PathBuf>,
    /// Where it had to be baked again, for another folder.
    map: Option<Map>,
}

/// What runs in the background, by what the user would call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Reading files.
    Load,
    /// Making a map.
    Bake,
    /// Writing files.
    Save,
    /// Comparing with the clean mesh.
    Measure,
    /// Pictures on disk.
    Draw,
}

impl App {
    /// Nothing is open. `wake` is called when [`tick`](Self::tick) has something to do.
    pub fn new(wake: &Wake, remembered: Remembered) -> Self {
        let choices = Choices::default();
        Self {
            history: History::new(choices.clone()),
            choices,
            rebake: Rebake::default(),
            remembered,
            document: None,
            map: None,
            clean: None,
            measured: None,
            begun: None,
            shown: None,
            seen: Recipe::default(),
            due: None,
            messages: Vec::new(),
            loading: Slot::new(Arc::clone(wake)),
            baking: Slot::new(Arc::clone(wake)),
            saving: Slot::new(Arc::clone(wake)),
            measuring: Slot::new(Arc::clone(wake)),
            measured_for: None,
            drawing: Slot::new(Arc::clone(wake)),
            watch: Watch::new(Arc::clone(wake)),
            source: None,
        }
    }

    /// The mesh.
    pub fn document(&self) -> Option<&Arc<Document>> {
        self.document.as_ref()
    }
    /// The last map that came out well.
    pub fn map(&self) -> Option<&Arc<Map>> {
        self.map.as_ref()
    }
    /// The clean mesh.
    pub fn clean(&self) -> Option<&Arc<Clean>> {
        self.clean.as_ref()
    }
    /// Against the clean mesh.
    pub fn measured(&self) -> Option<&Measured> {
        self.measured.as_ref()
    }
    /// What the user was told and has not put away.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }
    /// Puts a message away.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }
    /// Tells the user something.
    pub fn say(&mut self, kind: MessageKind, text: impl Into<String>) {
        let text = text.into();
        // The same again says nothing new.
        self.messages.retain(|known| known.text != text);
        let until = (kind != MessageKind::Error).then(|| Instant::now() + NEWS_STAY);
        self.messages.push(Message { kind, text, until });
    }
    /// Tells the user what could not be done; an interruption is no news.
    pub(crate) fn fail(&mut self, failure: &Failure) {
        match failure {
            Failure::Interrupted => {}
            Failure::Input(text) | Failure::Internal(text) => self.say(MessageKind::Error, text.clone()),
        }
    }

    /// Where work is.
    pub fn status(&self, work: Work) -> Option<Status> {
        match work {
            Work::Load => self.loading.status(),
            Work::Bake => self.baking.status(),
            Work::Save => self.saving.status(),
            Work::Measure => self.measuring.status(),
            Work::Draw => self.drawing.status(),
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
        }
    }

    /// Stops all work. What writes files is waited for, so that none is left half written.
    pub fn close(&mut self) {
        self.loading.cancel();
        self.baking.cancel();
        self.measuring.cancel();
        self.saving.finish();
        self.drawing.finish();
    }

    /// Opens a mesh, a manifest or a map. What is open stays until that is read.
    pub fn open(&mut self, path: &Path) {
        let path = path.to_owned();
        self.loading.start(move |ticket| {
            let (document, map) = document::load(&path, ticket)?;
            Ok(Loaded::Document(path, Box::new(document), map.map(Box::new)))
        });
    }

    /// Reads a clean mesh to compare with.
    pub fn compare_with(&mut self, path: &Path) {
        let path = path.to_owned();
        self.loading.start(move |ticket| Ok(Loaded::Clean(Clean::read(&path, ticket)?)));
    }

    /// Compares no more.
    pub fn forget_clean(&mut self) {
        self.measuring.drop_running();
        (self.clean, self.measured, self.measured_for) = (None, None, None);
    }

    /// Reads the file again.
    pub fn reload(&mut self) {
        if let Some(path) = self.source.clone() {
            self.open(&path);
        }
    }

    /// The folder that files are baked for: that of the map that is shown, or one beside the mesh.
    pub fn folder(&self) -> Option<PathBuf> {
        let document = self.document.as_ref()?;
        match self.map.as_ref().map(|map| &map.origin) {
            Some(Origin::Baked { folder, .. }) => Some(folder.clone()),
            // A map that was opened is baked again to where it is.
            Some(Origin::File(path)) => path.parent().map(Path::to_path_buf),
            None => Some(document.mesh.with_file_name(bake::default_folder(&document.mesh).ok()?)),
        }
    }

    /// Whether the map that is shown is what the recipe would give.
    pub fn is_baked(&self) -> bool {
        self.shown.as_ref() == Some(&self.choices.recipe)
    }

    /// Begins to bake now.
    pub fn bake(&mut self) {
        let (Some(document), Some(folder)) = (self.document.clone(), self.folder()) else { return };
        self.due = None;
        let recipe = self.choices.recipe.clone();
        self.begun = Some(recipe.clone());
        self.baking.start(move |ticket| document::bake(&document, &recipe, &folder, ticket));
    }

    /// Writes the files of the map to a folder, the very bytes that the command line writes.
    pub fn save(&mut self, folder: &Path) {
        let (Some(document), Some(map)) = (self.document.clone(), self.map.clone()) else { return };
        let (folder, recipe) = (folder.to_owned(), self.choices.recipe.clone());
        self.saving.start(move |ticket| {
            let place = Folder::open(&folder)?;
            let ready = |map: &Map| match &map.origin {
                Origin::Baked { recipe: of, folder: to, baked } if **of == recipe && *to == folder => {
                    Some(baked.clone())
                }
                _ => None,
            };
            let (baked, map) = match ready(&map) {
                Some(baked) => (baked, None),
                None => {
                    let map = document::bake(&document, &recipe, &folder, ticket)?;
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

    /// The command line that bakes the same files.
    pub fn command(&self) -> Option<String> {
        let document = self.document.as_ref()?;
        Some(self.choices.recipe.command(&document.mesh, &self.folder()?))
    }

    /// Goes back a step.
    pub fn undo(&mut self) {
        if let Some(before) = self.history.undo() {
            self.go_to(before);
        }
    }
    /// Goes forth again.
    pub fn redo(&mut self) {
        if let Some(after) = self.history.redo() {
            self.go_to(after);
        }
    }
    /// Whether there is something to undo, and to redo.
    pub fn can_undo_redo(&self) -> [bool; 2] {
        self.history.can()
    }
    fn go_to(&mut self, choices: Choices) {
        let Settings { camera, size, .. } = self.choices.view;
        self.choices = choices;
        (self.choices.view.camera, self.choices.view.size) = (camera, size);
    }

    /// Takes note of changes and of what came from the background. `held` while the mouse is down: a slider that moves
    /// bakes when it rests or is let go. Returns when to look again although nothing happens.
    pub fn tick(&mut self, now: Instant, held: bool) -> Option<Instant> {
        self.note_choices(held);
        self.take_loaded();
        self.take_baked();
        self.take_saved();
        self.take_drawn();
        if self.watch.has_changed() {
            self.reload();
        }
        self.schedule_bake(now);
        self.schedule_measurement();
        self.messages.retain(|message| message.until.is_none_or(|until| now < until));
        self.messages.iter().filter_map(|message| message.until).chain(self.due).min()
    }

    fn note_choices(&mut self, held: bool) {
        let mut choices = self.choices.clone();
        without_camera(&mut choices);
        self.history.note(&choices, held);
    }

    fn take_loaded(&mut self) {
        let Some(outcome) = self.loading.poll() else { return };
        match outcome {
            Ok(Loaded::Document(path, document, map)) => self.show(path, *document, map.map(|map| *map)),
            Ok(Loaded::Clean(clean)) => {
                self.forget_clean();
                self.clean = Some(Arc::new(clean));
            }
            Err(failure) => self.fail(&failure),
        }
    }

    fn show(&mut self, path: PathBuf, document: Document, map: Option<Map>) {
        let again = self.source.as_deref() == Some(&*path);
        self.baking.drop_running();
        self.measuring.drop_running();
        (self.measured, self.measured_for, self.due) = (None, None, None);
        if !again {
            self.messages.clear();
        }
        let mut watched = vec![document.mesh.clone()];
        if path != document.mesh {
            watched.push(path.clone());
        }
        self.watch.these(&watched);
        self.remembered.opened(&path);
        if let Some(map) = &map {
            self.choices.recipe = Recipe::of(&map.manifest, &path);
            self.choices.view.displace.lambda = map.manifest.displacement.lambda as f32;
        } else {
            self.choices.recipe.settings.welding = <_>::default();
        }
        if !again && map.is_none() {
            self.choices.recipe.target = None;
            (self.choices.recipe.limits.mask, self.choices.recipe.limits.lines) = <_>::default();
        }
        if !again {
            self.choices.view.camera = Camera { up: self.choices.view.camera.up, ..<_>::default() };
        }
        (self.choices.view.displace.bias, self.choices.view.displace.scale) = (None, None);
        jobs::discard(self.document.replace(Arc::new(document)));
        self.source = Some(path);
        let recipe = self.choices.recipe.clone();
        (self.begun, self.shown) = if map.is_some() { (Some(recipe.clone()), Some(recipe)) } else { (None, None) };
        self.seen = self.choices.recipe.clone();
        jobs::discard(std::mem::replace(&mut self.map, map.map(Arc::new)));
        if !again {
            let mut now = self.choices.clone();
            without_camera(&mut now);
            self.history = History::new(now);
        }
        if self.map.is_none() {
            self.bake();
        }
    }

    fn take_baked(&mut self) {
        match self.baking.poll() {
            None => {}
            // Its warnings stand in the panel.
            Some(Ok(map)) => self.put(map),
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, "stopped; the last result stays"),
            Some(Err(failure)) => self.fail(&failure),
        }
    }

    fn put(&mut self, map: Map) {
        if let Origin::Baked { recipe, .. } = &map.origin {
            self.shown = Some((**recipe).clone());
        }
        jobs::discard(self.map.replace(Arc::new(map)));
    }

    fn take_saved(&mut self) {
        match self.saving.poll() {
            None => {}
            Some(Ok(Saved { files, map })) => {
                if let Some(map) = map {
                    self.put(map);
                }
                self.say(MessageKind::Done, format!("wrote {}", listed(&files)));
            }
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, Failure::Interrupted.to_string()),
            Some(Err(failure)) => self.fail(&failure),
        }
    }

    fn take_drawn(&mut self) {
        match self.drawing.poll() {
            None => {}
            Some(Ok(files)) => self.say(MessageKind::Done, format!("wrote {}", listed(&files))),
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, Failure::Interrupted.to_string()),
            Some(Err(failure)) => self.fail(&failure),
        }
    }

    /// A changed recipe is baked once it has not changed for a while.
    fn schedule_bake(&mut self, now: Instant) {
        if self.choices.recipe != self.seen {
            self.seen = self.choices.recipe.clone();
            self.due = Some(now + DEBOUNCE);
        }
        if self.document.is_none() || self.begun.as_ref() == Some(&self.choices.recipe) {
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
        // What is being baked is not wanted any more.
        self.baking.drop_running();
        if self.rebake == Rebake::OnDemand {
            self.due = None;
        } else if now >= due {
            self.bake();
        }
    }

    fn schedule_measurement(&mut self) {
        if let Some(outcome) = self.measuring.poll() {
            match outcome {
                Ok(measured) => self.measured = Some(measured),
                Err(failure) => {
                    // It would fail for every λ.
                    self.fail(&failure);
                    if failure != Failure::Interrupted {
                        self.clean = None;
                    }
                }
            }
        }
        let (Some(clean), Some(document)) = (self.clean.clone(), self.document.clone()) else { return };
        let lambda = self.choices.view.displace.lambda;
        let wanted = (lambda, self.map.as_ref().map(|map| Arc::as_ptr(map) as usize));
        // A measurement that is under way is let finish, so that numbers come while λ moves.
        if self.measured_for == Some(wanted) || self.measuring.is_busy() {
            return;
        }
        self.measured_for = Some(wanted);
        let map = self.map.clone();
        self.measuring.start(move |ticket| document::measure(&clean, &document, map.as_deref(), lambda, ticket));
    }
}

/// Looking from elsewhere, or in a window of another size, is no step of undo.
fn without_camera(choices: &mut Choices) {
    choices.view.camera = Camera::default();
    choices.view.size = Size::default();
}

/// A few files by name, many by the first and their number.
fn listed(files: &[PathBuf]) -> String {
    match files {
        [] => "nothing".to_owned(),
        [one] => one.display().to_string(),
        [first, ..] => {
            let folder = first.parent().unwrap_or(Path::new("")).display();
            format!("{} files to {folder}", files.len())
        }
    }
}

#[cfg(test)]
mod tests;
