//! Choosing a file or a folder: the dialog of the desktop where there is one (feature `desktop-dialogs`), otherwise a path to type or
//! paste, and what is in its folder to click, drawn by the window itself.

#[cfg(feature = "desktop-dialogs")]
mod desktop;

use crate::app::document;
use std::path::{Path, PathBuf};

/// Purpose of the file that the user is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum FilePurpose {
    /// The file is a mesh or a map to open.
    #[default]
    Open,
    /// The file is the clean mesh to compare with.
    Clean,
    /// The file is the result of another denoiser, which the map leads to.
    Target,
    /// The file is a text that lists the `v` lines that stay.
    FixedVertices,
    /// The file is a mask: a picture or a text with weights.
    Mask,
    /// The file is a picture of the surroundings, or a folder with the six faces of a cube map.
    Environment,
    /// The file is a volume (NRRD).
    Volume,
}

/// File dialog that is open.
pub(super) struct Dialog {
    purpose: Purpose,
    /// Path that is typed, or from which the desktop starts.
    text: String,
    by: Drawn,
}

/// Who draws a dialog.
enum Drawn {
    /// The window does.
    ByWindow(Listing),
    /// The desktop does.
    #[cfg(feature = "desktop-dialogs")]
    ByDesktop(desktop::Asked),
}

/// Dialog that the window draws: the entries of a folder.
struct Listing {
    /// Folder that is listed, and its entries.
    listed: Option<(PathBuf, Vec<Entry>)>,
    fresh: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Open(FilePurpose),
    Save,
}

struct Entry {
    path: PathBuf,
    name: String,
    is_folder: bool,
}

/// Outcome of a frame of the dialog.
pub(super) enum Outcome {
    /// The dialog is still open.
    Open,
    /// The dialog was closed without a choice.
    Closed,
    /// The user has chosen this file.
    File(FilePurpose, PathBuf),
    /// The user has chosen the folder to save the map to.
    SaveTo(PathBuf),
}

/// Largest number of entries that are listed.
const MOST_ENTRIES: usize = 2000;

impl Dialog {
    /// Asks for a file.
    pub(super) fn open(file: FilePurpose) -> Self {
        let here = std::env::current_dir().unwrap_or_default().join("");
        Self::new(Purpose::Open(file), &here)
    }

    /// Asks for a folder.
    pub(super) fn save(folder: &Path) -> Self {
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        Self::new(Purpose::Save, &folder)
    }

    fn new(purpose: Purpose, start: &Path) -> Self {
        let by = Drawn::ByWindow(Listing { listed: None, fresh: true });
        #[cfg(feature = "desktop-dialogs")]
        let by = if desktop::has_dialogs() { Drawn::ByDesktop(desktop::Asked::default()) } else { by };
        Self { purpose, text: start.display().to_string(), by }
    }

    /// Draws it, or looks whether the desktop has an answer. Listing a folder is quick, and done once for each.
    pub(super) fn show(&mut self, context: &egui::Context, mark: impl FnMut(&str, egui::Rect)) -> Outcome {
        match &mut self.by {
            Drawn::ByWindow(listing) => listing.show(context, self.purpose, &mut self.text, mark),
            #[cfg(feature = "desktop-dialogs")]
            Drawn::ByDesktop(asked) => asked.answer(context, self.purpose, Path::new(&self.text)),
        }
    }
}

impl Purpose {
    /// Title of the dialog, and the word on the button that ends it.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Open(FilePurpose::Open) => ("Open a mesh or a map", "Open"),
            Self::Open(FilePurpose::Clean) => ("The clean mesh", "Compare"),
            Self::Open(FilePurpose::Environment) => {
                ("A picture of what is all around, or a folder with six faces", "Use")
            }
            Self::Open(FilePurpose::Volume) => ("A volume (.nrrd, .nhdr)", "Use"),
            Self::Open(FilePurpose::FixedVertices) => ("Numbers of `v` lines that stay", "Use"),
            Self::Open(FilePurpose::Mask) => {
                ("A grey picture in the texture coordinates, or a text with weights", "Use")
            }
            Self::Open(FilePurpose::Target) => ("The result of another denoiser", "Use"),
            Self::Save => ("Save the map to a folder", "Save"),
        }
    }

    /// Outcome of a dialog in which this path was chosen.
    fn chosen(self, path: PathBuf) -> Outcome {
        match self {
            Self::Save => Outcome::SaveTo(path),
            Self::Open(file) => Outcome::File(file, path),
        }
    }
}

impl Listing {
    fn show(
        &mut self,
        context: &egui::Context,
        purpose: Purpose,
        text: &mut String,
        mut mark: impl FnMut(&str, egui::Rect),
    ) -> Outcome {
        let (title, verb) = purpose.words();
        let mut outcome = Outcome::Open;
        let mut open = true;
        let window = egui::Window::new(title).open(&mut open).collapsible(false).default_size([560.0, 420.0]);
        window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).show(context, |ui| {
            let field = ui.add(egui::TextEdit::singleline(text).desired_width(f32::INFINITY));
            mark("path", field.rect);
            if std::mem::take(&mut self.fresh) {
                field.request_focus();
            }
            let mut entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if let Some(clicked) = self.list(ui, purpose, text, &mut entered) {
                *text = clicked.path.display().to_string();
                if clicked.is_folder {
                    text.push(std::path::MAIN_SEPARATOR);
                }
            }
            ui.horizontal(|ui| {
                let chosen = PathBuf::from(text.trim());
                let button = ui.button(verb);
                mark("choose", button.rect);
                if ui.button("Cancel").clicked() {
                    outcome = Outcome::Closed;
                } else if (button.clicked() || entered) && !chosen.as_os_str().is_empty() {
                    outcome = purpose.chosen(chosen);
                }
            });
        });
        if open || !matches!(outcome, Outcome::Open) { outcome } else { Outcome::Closed }
    }

    /// Lists the folder that is typed; returns an entry that was clicked, and sets `chosen` where it was clicked twice.
    fn list(&mut self, ui: &mut egui::Ui, purpose: Purpose, text: &str, chosen: &mut bool) -> Option<Entry> {
        let typed = Path::new(text.trim());
        let ends = text.ends_with(std::path::is_separator);
        let folder = if ends { typed } else { typed.parent().unwrap_or(typed) };
        if self.listed.as_ref().is_none_or(|(of, _)| of != folder) {
            self.listed = Some((folder.to_owned(), entries(folder, purpose)));
        }
        let mut clicked = None;
        let height = ui.available_height() - 36.0;
        egui::ScrollArea::vertical().max_height(height.max(80.0)).auto_shrink(false).show(ui, |ui| {
            if let Some(up) = folder.parent()
                && ui.selectable_label(false, "⬆ ..").clicked()
            {
                clicked = Some(Entry { path: up.to_owned(), name: String::new(), is_folder: true });
            }
            for entry in self.listed.iter().flat_map(|(_, entries)| entries) {
                let icon = if entry.is_folder { "🗀" } else { "🗋" };
                let label = ui.selectable_label(entry.path == typed, format!("{icon} {}", entry.name));
                *chosen |= label.double_clicked() && !entry.is_folder;
                if label.clicked() {
                    let Entry { path, name, is_folder } = entry;
                    clicked = Some(Entry { path: path.clone(), name: name.clone(), is_folder: *is_folder });
                }
            }
        });
        clicked
    }
}

/// Folders first, then what can be opened, by name.
fn entries(folder: &Path, purpose: Purpose) -> Vec<Entry> {
    let Ok(found) = std::fs::read_dir(folder) else { return Vec::new() };
    let entry = |entry: std::fs::DirEntry| {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = path.is_dir();
        let fits = match purpose {
            Purpose::Save => false,
            Purpose::Open(
                FilePurpose::FixedVertices | FilePurpose::Mask | FilePurpose::Environment | FilePurpose::Volume,
            ) => true,
            // Of the pictures only maps can be opened.
            Purpose::Open(FilePurpose::Open) => match document::kind(&path) {
                Some(document::Kind::Picture) => name.contains(".displacement."),
                kind => kind.is_some(),
            },
            Purpose::Open(_) => document::kind(&path) == Some(document::Kind::Mesh),
        };
        let shown = is_folder || fits;
        (shown && !name.starts_with('.')).then_some(Entry { path, name, is_folder })
    };
    let mut all: Vec<Entry> = found.filter_map(|e| entry(e.ok()?)).take(MOST_ENTRIES).collect();
    all.sort_by(|a, b| (!a.is_folder, &a.name).cmp(&(!b.is_folder, &b.name)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use planish_geometry::source::format::Format;

    #[test]
    fn the_dialog_lists_meshes_of_all_formats() {
        let folder = tempfile::tempdir().unwrap();
        let mut meshes: Vec<String> = Format::ALL.iter().map(|format| format!("a.{}", format.name())).collect();
        meshes.push("B.PLY.gz".to_owned());
        meshes.sort();
        for name in
            meshes.iter().map(String::as_str).chain(["notes.txt", "skin.png", "a.displacement.png", "a.planish.json"])
        {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let listed = |purpose| -> Vec<String> {
            entries(folder.path(), Purpose::Open(purpose)).into_iter().map(|entry| entry.name).collect()
        };
        assert_eq!(listed(FilePurpose::Clean), meshes);
        let mut all = [meshes.clone(), vec!["a.displacement.png".to_owned(), "a.planish.json".to_owned()]].concat();
        all.sort();
        assert_eq!(listed(FilePurpose::Open), all);
        assert!(listed(FilePurpose::FixedVertices).contains(&"notes.txt".to_owned()));
    }
}
