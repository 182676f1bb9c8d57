//! File dialogs of the desktop: those of Windows and macOS, and on Linux that of the portal which flatpaks use.

use super::{FilePurpose, Outcome, Purpose};
use planish_geometry::source::format::Format;
use rfd::{AsyncFileDialog, FileHandle};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Returns true where there is a desktop that shows dialogs.
pub(super) fn has_dialogs() -> bool {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    if cfg!(any(windows, target_os = "macos")) {
        return true;
    }
    let bus = variable("XDG_RUNTIME_DIR").map(|folder| PathBuf::from(folder).join("bus"));
    let has_bus = variable("DBUS_SESSION_BUS_ADDRESS").is_some() || bus.is_some_and(|bus| bus.exists());
    // The defaults are those of the XDG base directory specification.
    let own = variable("XDG_DATA_HOME").map(PathBuf::from);
    let own = own.or_else(|| variable("HOME").map(|home| PathBuf::from(home).join(".local/share")));
    let shared = variable("XDG_DATA_DIRS").unwrap_or_else(|| "/usr/local/share:/usr/share".into());
    has_bus && has_portal(own.into_iter().chain(std::env::split_paths(&shared)))
}

/// Returns true if one of these folders of data has the service of the portal, which the bus starts when it is asked for.
fn has_portal(mut folders: impl Iterator<Item = PathBuf>) -> bool {
    folders.any(|folder| folder.join("dbus-1/services/org.freedesktop.portal.Desktop.service").is_file())
}

/// A dialog of the desktop, from the first frame on that looks for its answer.
#[derive(Default)]
pub(super) struct Asked(Option<Receiver<Option<PathBuf>>>);

impl Asked {
    /// The answer, if there is one yet; asks the desktop if that was not done.
    pub(super) fn answer(&mut self, context: &egui::Context, purpose: Purpose, start: &Path) -> Outcome {
        let answer = self.0.get_or_insert_with(|| ask(context, purpose, start));
        match answer.try_recv() {
            Ok(Some(path)) => purpose.chosen(path),
            Ok(None) | Err(TryRecvError::Disconnected) => Outcome::Closed,
            Err(TryRecvError::Empty) => Outcome::Open,
        }
    }
}

/// Asks the desktop, and wakes the window when it has answered.
fn ask(context: &egui::Context, purpose: Purpose, start: &Path) -> Receiver<Option<PathBuf>> {
    let dialog = AsyncFileDialog::new().set_title(purpose.words().0);
    // macOS wants dialogs to be made where the window is, and waits elsewhere.
    let chosen: Pin<Box<dyn Future<Output = Option<FileHandle>> + Send>> = match purpose {
        Purpose::Save => Box::pin(dialog.set_directory(start.parent().unwrap_or(start)).pick_folder()),
        Purpose::Open(file) => Box::pin(filtered(dialog, file).set_directory(start).pick_file()),
    };
    let (sender, receiver) = channel();
    let context = context.clone();
    std::thread::spawn(move || {
        let chosen = pollster::block_on(chosen).map(|handle| handle.path().to_owned());
        // Nobody waits any more where the window was closed meanwhile.
        let _ = sender.send(chosen);
        context.request_repaint();
    });
    receiver
}

/// The dialog with the kinds of files that suit, and all files as another choice.
fn filtered(dialog: AsyncFileDialog, purpose: FilePurpose) -> AsyncFileDialog {
    let mut endings: Vec<&str> = match purpose {
        FilePurpose::FixedVertices | FilePurpose::Mask | FilePurpose::Environment => return dialog,
        FilePurpose::Volume => vec!["nrrd", "nhdr"],
        FilePurpose::Open | FilePurpose::Clean | FilePurpose::Target => {
            Format::ALL.iter().map(|format| format.name()).chain(["gz", "xz"]).collect()
        }
    };
    if purpose == FilePurpose::Open {
        // The manifest of a map.
        endings.push("json");
    }
    // On Linux case counts.
    let upper: Vec<String> = endings.iter().map(|ending| ending.to_uppercase()).collect();
    endings.extend(upper.iter().map(String::as_str));
    dialog.add_filter("What planish reads", &endings).add_filter("All files", &["*"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_portal_is_there_where_its_service_is() {
        let [with, without] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let services = with.path().join("dbus-1/services");
        std::fs::create_dir_all(&services).unwrap();
        let folders = || [without.path().to_owned(), with.path().to_owned()].into_iter();
        assert!(!has_portal(folders()));
        std::fs::write(services.join("org.freedesktop.portal.Desktop.service"), "[D-BUS Service]\n").unwrap();
        assert!(has_portal(folders()));
    }
}
