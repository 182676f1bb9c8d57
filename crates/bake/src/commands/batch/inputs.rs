//! Finds the meshes of a batch, and the places of their results.

use crate::args::BatchArgs;
use crate::failure::Failure;
use planish_files::text::shown;
use planish_files::{bake_files, compression, input};
use planish_geometry::source::format::Format;
use std::collections::HashMap;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};
use walkdir::WalkDir;

/// A mesh of a batch.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Task {
    /// Path of the mesh.
    pub(super) input: PathBuf,
    /// Path of the result: a file, or a folder for a bake.
    pub(super) output: PathBuf,
    /// Path of the result below the folder of all results, which names it in the journal.
    pub(super) place: PathBuf,
}

/// Lists the meshes of this part of a batch, in the order of their paths. Fails if there is none at all, or if two results would
/// have the same place.
pub(super) fn tasks(args: &BatchArgs) -> Result<Vec<Task>, Failure> {
    let mut found = Vec::new();
    for path in &args.inputs {
        find(path, &args.output, &mut found)?;
    }
    if let Some(list) = &args.list {
        for path in listed(list)? {
            let name = path.file_name().map(PathBuf::from).ok_or_else(|| Failure::at(&path, "names no file"))?;
            found.push((path, name));
        }
    }
    let all = found.into_iter().map(|(input, relative)| task(args, input, &relative));
    let mut all = all.collect::<Result<Vec<_>, _>>()?;
    all.sort();
    all.dedup();
    if all.is_empty() {
        return Err(Failure::Input(format!("there are no meshes; planish reads {}", Format::extensions())));
    }
    let mut places: HashMap<&Path, &Path> = HashMap::new();
    for task in &all {
        if let Some(other) = places.insert(&task.place, &task.input) {
            let reason = format!("would have the same result as {}: {}", shown(other), shown(&task.place));
            return Err(Failure::at(&task.input, reason));
        }
    }
    let Some(shard) = args.shard else { return Ok(all) };
    Ok(all.into_iter().skip(shard.part - 1).step_by(shard.parts).collect())
}

/// Adds the meshes that a path names, each with its place below what was searched.
fn find(path: &Path, output: &Path, found: &mut Vec<(PathBuf, PathBuf)>) -> Result<(), Failure> {
    if path.is_dir() {
        return walk(path, output, found);
    }
    let text = path.to_string_lossy();
    if path.exists() || !text.contains(['*', '?', '[']) {
        // A file that is missing is reported as any other that cannot be read.
        let name = path.file_name().map(PathBuf::from).ok_or_else(|| Failure::at(path, "names no file"))?;
        found.push((path.to_path_buf(), name));
        return Ok(());
    }
    let is_fixed = |part: &Component| !part.as_os_str().to_string_lossy().contains(['*', '?', '[']);
    let base: PathBuf = path.components().take_while(is_fixed).collect();
    let own = output.canonicalize().ok();
    let before = found.len();
    for entry in glob::glob(&text).map_err(|e| Failure::at(path, e))? {
        let entry = entry.map_err(|e| Failure::at(e.path(), input::plain(e.error())))?;
        if entry.is_file() && input::format_of(&entry).is_some() && !is_below(&entry, own.as_deref()) {
            let relative = entry.strip_prefix(&base).unwrap_or(&entry).to_path_buf();
            found.push((entry, relative));
        }
    }
    if found.len() == before { Err(Failure::at(path, "no mesh has such a name")) } else { Ok(()) }
}

/// Adds the meshes in a folder and below, but for those among the results.
fn walk(folder: &Path, output: &Path, found: &mut Vec<(PathBuf, PathBuf)>) -> Result<(), Failure> {
    let own = output.canonicalize().ok();
    // The results may lie below the meshes, and not the other way round.
    let own = own.filter(|own| folder.canonicalize().is_ok_and(|folder| folder != *own));
    let is_searched = |entry: &walkdir::DirEntry| own.is_none() || entry.path().canonicalize().ok() != own;
    for entry in WalkDir::new(folder).follow_links(true).into_iter().filter_entry(is_searched) {
        let entry = entry.map_err(|e| Failure::at(folder, e))?;
        if entry.file_type().is_file() && input::format_of(entry.path()).is_some() {
            let relative = entry.path().strip_prefix(folder).unwrap_or(entry.path()).to_path_buf();
            found.push((entry.into_path(), relative));
        }
    }
    Ok(())
}

fn is_below(path: &Path, folder: Option<&Path>) -> bool {
    folder.is_some_and(|folder| path.canonicalize().is_ok_and(|path| path.starts_with(folder)))
}

/// Reads a list of paths, one in each line.
fn listed(list: &Path) -> Result<Vec<PathBuf>, Failure> {
    let bytes = if list == Path::new("-") {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes);
        read.map_err(|e| Failure::Input(format!("standard input cannot be read: {}", input::plain(&e))))?;
        bytes
    } else {
        input::read(list)?
    };
    let text = String::from_utf8(bytes).map_err(|_| Failure::at(list, "is not a text file with paths"))?;
    Ok(text.lines().map(str::trim_end).filter(|line| !line.is_empty()).map(PathBuf::from).collect())
}

/// Makes the task of a mesh.
fn task(args: &BatchArgs, input: PathBuf, relative: &Path) -> Result<Task, Failure> {
    let place = if args.bake {
        relative.with_file_name(bake_files::default_folder(&input)?)
    } else if compression::is_only_read(relative) {
        compression::uncompressed_name(relative).to_path_buf()
    } else {
        relative.to_path_buf()
    };
    Ok(Task { output: args.output.join(&place), input, place })
}
