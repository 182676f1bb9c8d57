//! Reads a file piece by piece, and writes it again with other positions.

use super::PIECE;
use super::merge;
use super::plan::{self, Plan};
use super::records::Numbers;
use crate::compression;
use crate::failure::Failure;
use crate::input;
use crate::output::{Folder, Output, Staged};
use planish_geometry::progress::Progress;
use planish_geometry::source::stream::{Piece, Stream};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A mesh file that is read piece by piece.
pub(super) struct Pieces {
    file: File,
    path: PathBuf,
    size: u64,
    buffer: Vec<u8>,
    is_last: bool,
    pub(super) stream: Stream,
}

impl Pieces {
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let failed = |e: std::io::Error| Failure::at(path, input::plain(&e));
        if compression::is_compressed_name(path) || compression::is_only_read(path) {
            return Err(Failure::at(path, "is compressed, and cannot be read piece by piece"));
        }
        let mut file = File::open(path).map_err(failed)?;
        let size = file.metadata().map_err(failed)?.len();
        let mut buffer = Vec::new();
        let is_last = fill(&mut file, &mut buffer).map_err(failed)?;
        let stream = Stream::begin(&buffer, size, input::format_of(path)).map_err(|e| Failure::at(path, e))?;
        Ok(Self { file, path: path.to_path_buf(), size, buffer, is_last, stream })
    }

    /// Hands the file over, piece by piece; `take` says how many bytes of a piece it took.
    pub(super) fn each(
        &mut self,
        progress: &dyn Progress,
        mut take: impl FnMut(&mut Stream, &[u8], bool) -> Result<usize, Failure>,
    ) -> Result<(), Failure> {
        let mut done = 0;
        loop {
            let taken = take(&mut self.stream, &self.buffer, self.is_last)?;
            if self.is_last {
                return Ok(());
            }
            progress.check()?;
            done += taken;
            progress.done(done as f64 / self.size.max(1) as f64);
            self.buffer.drain(..taken);
            let filled = fill(&mut self.file, &mut self.buffer);
            self.is_last = filled.map_err(|e| Failure::at(&self.path, input::plain(&e)))?;
        }
    }
}

/// Appends a piece to what is left of the last one, and returns whether the file ends with it.
fn fill(file: &mut File, buffer: &mut Vec<u8>) -> std::io::Result<bool> {
    Ok(file.take(PIECE as u64).read_to_end(buffer)? < PIECE)
}

/// Checks before any work is done that the mesh file at `path` can be read piece by piece, and written as `output`.
pub fn check_output(path: &Path, output: &Path) -> Result<(), Failure> {
    let format = Pieces::open(path)?.stream.format();
    let other = input::format_of(output).is_some_and(|named| named != format);
    if other || compression::is_compressed_name(output) {
        return Err(Failure::at(output, format!("a mesh in tiles is written as it was read, as .{}", format.name())));
    }
    // It checks the same things as for any other output, and is not written to.
    Output::open(output, &[path]).map(drop)
}

/// Checks before any work is done that the mesh file at `path` can be read piece by piece, and a bundle be written to a folder.
pub fn check_folder(path: &Path, folder: &Path) -> Result<(), Failure> {
    Pieces::open(path)?;
    // It goes again if it is new.
    Folder::open(folder).map(drop)
}

/// Writes the mesh file at `path` again, as `output`, with the positions that [`merge`](super::merge()) has put together. All bytes but the
/// numbers of moved vertices stay. The file is there whole or not at all.
pub fn write(path: &Path, output: &Path, folder: &Path, progress: &dyn Progress) -> Result<(), Failure> {
    progress.stage("writing");
    check_output(path, output)?;
    let plan = Plan::of(folder)?;
    let mut pieces = Pieces::open(path)?;
    let mut before = Numbers::open(plan::positions(folder))?;
    let mut after = Numbers::open(merge::positions(folder))?;
    let mut staged = Staged::begin(output)?;
    let (mut out, mut count, mut failure) = (Vec::new(), 0, None);
    pieces.each(progress, |stream, bytes, is_last| {
        out.clear();
        let mut next = || {
            count += 1;
            let change = before.position().and_then(|p| Ok([p, after.position()?]));
            change.unwrap_or_else(|e| {
                failure = Some(e);
                [glam::DVec3::ZERO; 2]
            })
        };
        let taken = stream.rewrite(Piece { bytes, is_last }, &mut next, &mut out).map_err(|e| Failure::at(path, e))?;
        match failure.take() {
            Some(e) => return Err(e),
            None => staged.append(&out)?,
        }
        Ok(taken)
    })?;
    if count != plan.vertices {
        return Err(Failure::at(path, "has changed since it was spread into tiles"));
    }
    staged.finish()
}
