//! Files of numbers in a working folder.

use crate::failure::Failure;
use crate::input::plain;
use crate::text::shown;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Number of bytes of a position.
pub(super) const POSITION: usize = 24;

/// Makes the failure of a file that cannot be read or written.
pub(super) fn failed(path: &Path) -> impl Fn(std::io::Error) -> Failure + '_ {
    move |e| Failure::Internal(format!("{}: {}", shown(path), plain(&e)))
}

/// Reader of numbers.
pub(super) struct Numbers {
    file: BufReader<File>,
    path: PathBuf,
}

impl Numbers {
    pub(super) fn open(path: PathBuf) -> Result<Self, Failure> {
        let file = File::open(&path).map_err(failed(&path))?;
        Ok(Self { file: BufReader::with_capacity(1 << 16, file), path })
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Failure> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes).map_err(failed(&self.path))?;
        Ok(bytes)
    }
    pub(super) fn index(&mut self) -> Result<u32, Failure> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }
    pub(super) fn number(&mut self) -> Result<f64, Failure> {
        Ok(f64::from_le_bytes(self.bytes()?))
    }
    pub(super) fn position(&mut self) -> Result<DVec3, Failure> {
        Ok(position(&self.bytes::<POSITION>()?))
    }
    /// Whether all has been read.
    pub(super) fn is_at_end(&mut self) -> Result<bool, Failure> {
        use std::io::BufRead as _;
        Ok(self.file.fill_buf().map_err(failed(&self.path))?.is_empty())
    }
}

/// Positions of some source vertices, by ascending indices, from a file with those of all.
pub(super) fn positions_at(path: PathBuf, ids: &[Index]) -> Result<Vec<DVec3>, Failure> {
    let mut file = Numbers::open(path)?;
    let mut next = 0;
    let position = |id: &Index| {
        let skipped = i64::from(*id - next) * POSITION as i64;
        file.file.seek_relative(skipped).map_err(failed(&file.path))?;
        next = *id + 1;
        file.position()
    };
    ids.iter().map(position).collect()
}

/// Reads a value that [`write_json`] wrote.
pub(super) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    serde_json::from_slice(&std::fs::read(path).map_err(failed(path))?).map_err(Failure::internal)
}

/// Writes a value to a file, which gets its name when it is whole.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let unfinished = path.with_added_extension(format!("{}.unfinished", std::process::id()));
    std::fs::write(&unfinished, serde_json::to_vec(value).map_err(Failure::internal)?).map_err(failed(&unfinished))?;
    std::fs::rename(&unfinished, path).map_err(failed(path))
}

/// Position of its bytes.
pub(super) fn position(bytes: &[u8]) -> DVec3 {
    let number = |axis: usize| {
        let mut eight = [0; 8];
        eight.copy_from_slice(&bytes[8 * axis..8 * axis + 8]);
        f64::from_le_bytes(eight)
    };
    DVec3::new(number(0), number(1), number(2))
}

/// Bytes of a position.
pub(super) fn position_bytes(p: DVec3) -> [u8; POSITION] {
    let mut bytes = [0; POSITION];
    for (eight, x) in bytes.chunks_exact_mut(8).zip(p.to_array()) {
        eight.copy_from_slice(&x.to_le_bytes());
    }
    bytes
}

/// Writer of numbers, whose file gets its name when it is finished, so that what has the name is whole.
pub(super) struct NumbersOut {
    file: BufWriter<File>,
    path: PathBuf,
    unfinished: PathBuf,
}

impl NumbersOut {
    pub(super) fn create(path: PathBuf) -> Result<Self, Failure> {
        // Two processes may work on the same tile: a worker that was thought dead, and its successor.
        let unfinished = path.with_added_extension(format!("{}.unfinished", std::process::id()));
        let file = File::create(&unfinished).map_err(failed(&unfinished))?;
        Ok(Self { file: BufWriter::with_capacity(1 << 16, file), path, unfinished })
    }
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file.write_all(bytes).map_err(failed(&self.unfinished))
    }
    pub(super) fn index(&mut self, index: u32) -> Result<(), Failure> {
        self.bytes(&index.to_le_bytes())
    }
    pub(super) fn number(&mut self, x: f64) -> Result<(), Failure> {
        self.bytes(&x.to_le_bytes())
    }
    pub(super) fn position(&mut self, p: DVec3) -> Result<(), Failure> {
        self.bytes(&position_bytes(p))
    }
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        self.file.flush().map_err(failed(&self.unfinished))?;
        std::fs::rename(&self.unfinished, &self.path).map_err(failed(&self.path))
    }
}
