//! The journal of a batch: one line of JSON for each mesh that was done or has failed.

use super::inputs::Task;
use crate::args::BatchArgs;
use crate::failure::Failure;
use planish_files::input;
use planish_geometry::map::manifest;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, UNIX_EPOCH};

/// How the names of all journals begin.
const STEM: &str = "planish-batch";

/// A line of a journal.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Line {
    /// Path of the mesh.
    mesh: String,
    /// Path of the result below the folder of all results.
    place: String,
    /// Whether the mesh is done.
    pub(super) ok: bool,
    /// Time that the mesh took.
    seconds: f64,
    /// Number that stands for the settings.
    settings: String,
    /// Size of the mesh in bytes, and the time when it was changed, in nanoseconds; `None` if it cannot be found.
    state: Option<(u64, u64)>,
    /// Report of the command, or the error.
    #[serde(flatten)]
    pub(super) fields: Map<String, Value>,
}

/// Lines of earlier runs, and the file that new ones go to.
pub(super) struct Journal {
    file: Mutex<File>,
    path: PathBuf,
    settings: String,
    /// Meshes that are done, by the places of their results.
    done: HashMap<String, Line>,
}

impl Journal {
    /// Opens the journal of this part of the batch, in the folder of the results, which is created. Without `--resume` it begins anew.
    pub(super) fn open(args: &BatchArgs) -> Result<Self, Failure> {
        let failed =
            |path: &Path, e: &std::io::Error| Failure::at(path, format!("cannot be written: {}", input::plain(e)));
        std::fs::create_dir_all(&args.output).map_err(|e| failed(&args.output, &e))?;
        let settings = settings(args);
        let done = if args.resume { earlier(&args.output)? } else { HashMap::new() };
        let part = args.shard.map(|shard| format!("-{}-of-{}", shard.part, shard.parts)).unwrap_or_default();
        let path = args.output.join(format!("{STEM}{part}.jsonl"));
        let mut options = OpenOptions::new();
        if args.resume {
            options.append(true)
        } else {
            options.write(true).truncate(true)
        };
        let mut file = options.create(true).open(&path).map_err(|e| failed(&path, &e))?;
        if args.resume && ends_within_a_line(&path) {
            // The run before this one was killed while it wrote.
            file.write_all(b"\n").map_err(|e| failed(&path, &e))?;
        }
        Ok(Self { file: Mutex::new(file), path, settings, done })
    }

    /// Returns true if a mesh is done with these settings, has not changed since, and its result is there.
    pub(super) fn has(&self, task: &Task) -> bool {
        self.done.get(&*task.place.to_string_lossy()).is_some_and(|line| {
            line.settings == self.settings && line.state == state(&task.input) && task.output.exists()
        })
    }

    /// Makes the line of a mesh.
    pub(super) fn line(&self, task: &Task, time: Duration, result: Result<Value, Failure>) -> Line {
        let line = Line {
            mesh: task.input.display().to_string(),
            place: task.place.to_string_lossy().into_owned(),
            ok: true,
            seconds: time.as_secs_f64(),
            settings: self.settings.clone(),
            state: state(&task.input),
            fields: Map::new(),
        };
        line.with_result(result)
    }

    /// Appends a line, and returns its text with the line break.
    pub(super) fn append(&self, line: &Line) -> Result<String, Failure> {
        let text = serde_json::to_string(line).map_err(Failure::internal)? + "\n";
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.write_all(text.as_bytes()).and_then(|()| file.flush());
        written.map_err(|e| Failure::at(&self.path, format!("cannot be written: {}", input::plain(&e))))?;
        Ok(text)
    }
}

/// Number that stands for all options that change results.
fn settings(args: &BatchArgs) -> String {
    let BatchArgs { bake, method, welding, update_normals, map, trust, .. } = args;
    let version = env!("CARGO_PKG_VERSION");
    let text = format!("{version} {bake} {method:?} {welding:?} {update_normals} {map:?} {trust:?}");
    manifest::sha256(text.as_bytes())[..16].to_owned()
}

/// Size of a file and the time of its last change.
fn state(path: &Path) -> Option<(u64, u64)> {
    let metadata = path.metadata().ok()?;
    let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some((metadata.len(), u64::try_from(modified.as_nanos()).ok()?))
}

/// Lines of the meshes that are done by all journals in a folder, by the places of their results.
fn earlier(folder: &Path) -> Result<HashMap<String, Line>, Failure> {
    let failed = |e: std::io::Error| Failure::at(folder, format!("cannot be read: {}", input::plain(&e)));
    let mut done = HashMap::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        let name = name.to_string_lossy();
        if !name.starts_with(STEM) || !name.ends_with(".jsonl") {
            continue;
        }
        let bytes = input::read(&folder.join(&*name))?;
        // A line that was not written to its end is of a mesh that may not be done.
        let lines = bytes.split(|byte| *byte == b'\n').filter_map(|line| serde_json::from_slice::<Line>(line).ok());
        done.extend(lines.filter(|line| line.ok).map(|line| (line.place.clone(), line)));
    }
    Ok(done)
}

fn ends_within_a_line(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.last().is_some_and(|byte| *byte != b'\n'))
}
