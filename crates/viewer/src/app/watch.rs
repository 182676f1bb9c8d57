//! Tells when files change: a thread looks at them twice a second. Events of the operating system would come sooner, but
//! network folders and the shared folders of containers send none, and editors that replace a file end them.

use super::jobs::Wake;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, SystemTime};

const EVERY: Duration = Duration::from_millis(500);

/// Time of the last write and length of a file; none where it is gone.
type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

struct Watched {
    path: PathBuf,
    /// Stamp of the file as it was read.
    known: Stamp,
    /// Stamp of the file at the last look.
    last: Stamp,
    changed: bool,
}

/// Watcher of a list of files.
pub struct Watch {
    files: Arc<Mutex<Vec<Watched>>>,
}

impl Watch {
    /// Begins to watch nothing.
    pub fn new(wake: Wake) -> Self {
        let files = Arc::new(Mutex::new(Vec::new()));
        let weak = Arc::downgrade(&files);
        // Without a thread nothing is watched, which is no reason not to work.
        let _ = std::thread::Builder::new().name("planish-watch".to_owned()).spawn(move || keep_looking(&weak, &wake));
        Self { files }
    }

    /// Watches these files from now on, instead of those before.
    pub fn these(&self, paths: &[PathBuf]) {
        let watched = |path: &PathBuf| {
            let now = stamp(path);
            Watched { path: path.clone(), known: now, last: now, changed: false }
        };
        *self.files.lock().unwrap_or_else(PoisonError::into_inner) = paths.iter().map(watched).collect();
    }

    /// Whether a file has changed since it was first watched, or since the last call that said so.
    pub fn has_changed(&self) -> bool {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let mut any = false;
        for file in files.iter_mut() {
            any |= std::mem::take(&mut file.changed);
        }
        any
    }
}

fn keep_looking(files: &Weak<Mutex<Vec<Watched>>>, wake: &Wake) {
    loop {
        std::thread::sleep(EVERY);
        let Some(files) = files.upgrade() else { return };
        if look(&files) {
            wake();
        }
    }
}

/// Looks at the files once, and says whether one has changed and come to rest since.
fn look(files: &Mutex<Vec<Watched>>) -> bool {
    let mut news = false;
    for file in files.lock().unwrap_or_else(PoisonError::into_inner).iter_mut() {
        let now = stamp(&file.path);
        // A file that is being written changes from look to look, and one that is replaced may be gone for a moment.
        if now.is_some() && now == file.last && now != file.known {
            file.known = now;
            file.changed = true;
            news = true;
        }
        file.last = now;
    }
    news
}

#[cfg(test)]
impl Watch {
    /// Looks as often as it takes to notice a change.
    pub(super) fn look_now(&self) {
        look(&self.files);
        look(&self.files);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_change_wakes_the_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\n").unwrap();
        let (told, heard) = mpsc::channel();
        let watch = Watch::new(Arc::new(move || {
            let _ = told.send(());
        }));
        watch.these(std::slice::from_ref(&path));
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\n").unwrap();
        heard.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(watch.has_changed());
    }

    #[test]
    fn a_changed_file_is_reported_once_and_a_vanished_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\n").unwrap();
        let watch = Watch::new(Arc::new(|| ()));
        watch.these(std::slice::from_ref(&path));
        watch.look_now();
        assert!(!watch.has_changed());
        std::fs::remove_file(&path).unwrap();
        watch.look_now();
        assert!(!watch.has_changed(), "it is gone");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\n").unwrap();
        watch.look_now();
        assert!(watch.has_changed());
        watch.look_now();
        assert!(!watch.has_changed(), "that was said before");
    }
}
