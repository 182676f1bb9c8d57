//! Saved state of the window, in the platform's folder for configuration.

use etcetera::BaseStrategy as _;
use planish_files::failure::Failure;
use planish_files::output::Output;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Largest number of recent files.
const MOST_RECENT: usize = 10;

/// State from one start to the next. What cannot be read is as at the first start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowState {
    /// Inner size of the window, in points that do not depend on the screen.
    pub size: Option<[f32; 2]>,
    /// Whether the window was maximised.
    pub maximised: bool,
    /// Whether the panel was hidden.
    pub panel_hidden: bool,
    /// Files that were opened, the last one first.
    pub recent: Vec<PathBuf>,
}

/// Returns the file that the state is kept in; none where the platform names no folder.
pub fn path() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.config_dir().join("planish").join("window.json"))
}

impl WindowState {
    /// Reads the state; what cannot be read is the default.
    pub fn load(path: &Path) -> Self {
        std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
    }

    /// Writes the state, whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        // Paths that are not Unicode have no form in JSON; they are not worth an error.
        let Ok(json) = serde_json::to_string_pretty(self) else { return Ok(()) };
        Output::open(path, &[])?.write((json + "\n").as_bytes()).map(drop)
    }

    /// Puts a file first in the list of recent files.
    pub fn opened(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn state_comes_back_and_broken_state_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new").join("window.json");
        assert_eq!(WindowState::load(&path), WindowState::default());
        let mut state = WindowState { size: Some([900.0, 700.5]), ..WindowState::default() };
        for i in 0..20 {
            state.opened(Path::new(&format!("/{}.obj", i % 12)));
        }
        assert_eq!((state.recent.len(), state.recent[0].as_path()), (10, Path::new("/7.obj")));
        state.save(&path).unwrap();
        assert_eq!(WindowState::load(&path), state);
        std::fs::write(&path, "{ \"size\": 3").unwrap();
        assert_eq!(WindowState::load(&path), WindowState::default());
    }
}
