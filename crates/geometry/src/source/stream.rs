//! Mesh files that are read and rewritten piece by piece, for meshes that are larger than memory.
//!
//! A caller hands over the bytes of a file in pieces. Of each piece a [`Stream`] takes what is whole, and says how many bytes that
//! were; the rest goes in front of the next piece. OBJ files and binary PLY files can be read like this.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::source::{SourceError, stream::{Piece, Receiver, Stream}};
//!
//! #[derive(Default)]
//! struct Counts {
//!     vertices: usize,
//!     faces: usize,
//! }
//!
//! impl Receiver for Counts {
//!     fn vertex(&mut self, _position: DVec3) {
//!         self.vertices += 1;
//!     }
//!     fn face(&mut self, _vertices: &[u32]) {
//!         self.faces += 1;
//!     }
//! }
//!
//! // Pieces of 15 bytes, which end in the middle of lines.
//! let file = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 4\n";
//! let (mut stream, mut counts) = (Stream::begin(file, file.len() as u64, None)?, Counts::default());
//! let mut taken = 0;
//! while taken < file.len() {
//!     let end = (taken + 15).min(file.len());
//!     let piece = Piece { bytes: &file[taken..end], is_last: end == file.len() };
//!     taken += stream.read(piece, &mut counts)?;
//! }
//! stream.finish()?;
//! assert_eq!((counts.vertices, counts.faces), (4, 2));
//! # Ok::<(), SourceError>(())
//! ```

pub(super) mod piece;

pub use piece::{Change, Piece, Receiver};

use super::SourceError;
use super::format::Format;
use super::obj::stream::ObjStream;
use super::ply::stream::PlyStream;
use super::read_error::{Place, ReadErrorKind};

/// State of a file that is read or rewritten piece by piece.
#[derive(Debug)]
pub struct Stream(Kind);

#[derive(Debug)]
enum Kind {
    Obj(ObjStream),
    Ply(PlyStream),
}

impl Stream {
    /// Begins a file of `size` bytes. `first` are its first bytes, all of the header of a PLY file among them, and `named` is the
    /// format that the file name stands for. Fails for formats that cannot be read piece by piece.
    pub fn begin(first: &[u8], size: u64, named: Option<Format>) -> Result<Self, SourceError> {
        Ok(Self(match Format::of_content(first, named) {
            Format::Obj => Kind::Obj(ObjStream::default()),
            Format::Ply => Kind::Ply(PlyStream::begin(first, size)?),
            format => {
                let name = format.name().to_uppercase();
                let reason =
                    format!("{name} files cannot be read piece by piece: convert it to a binary PLY or an OBJ");
                return Err(ReadErrorKind::Malformed(reason).at(Place::File).into());
            }
        }))
    }

    /// Format of the file.
    pub fn format(&self) -> Format {
        match self.0 {
            Kind::Obj(_) => Format::Obj,
            Kind::Ply(_) => Format::Ply,
        }
    }

    /// Reads what is whole in a piece, and returns how many bytes that were.
    pub fn read(&mut self, piece: Piece, receiver: &mut dyn Receiver) -> Result<usize, SourceError> {
        Ok(match &mut self.0 {
            Kind::Obj(obj) => obj.read(piece, receiver)?,
            Kind::Ply(ply) => ply.read(piece, receiver)?,
        })
    }

    /// Checks what is known only when the whole file has been read.
    pub fn finish(&self) -> Result<(), SourceError> {
        match &self.0 {
            Kind::Obj(obj) => obj.finish()?,
            Kind::Ply(ply) => ply.finish()?,
        }
        Ok(())
    }

    /// Appends to `out` what is whole in a piece, with other positions, and returns how many bytes of the piece that were. `next` gives
    /// the change of each source vertex in turn. Numbers that do not change keep their bytes, as does all else.
    pub fn rewrite(
        &mut self,
        piece: Piece,
        next: &mut dyn FnMut() -> Change,
        out: &mut Vec<u8>,
    ) -> Result<usize, SourceError> {
        Ok(match &mut self.0 {
            Kind::Obj(obj) => obj.rewrite(piece, next, out),
            Kind::Ply(ply) => ply.rewrite(piece, next, out)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::jagged::Index;
    use crate::source::Source;
    use glam::DVec3;

    #[derive(Default)]
    struct Collected {
        positions: Vec<DVec3>,
        faces: Vec<Vec<Index>>,
    }

    impl Receiver for Collected {
        fn vertex(&mut self, position: DVec3) {
            self.positions.push(position);
        }
        fn face(&mut self, vertices: &[Index]) {
            self.faces.push(vertices.to_vec());
        }
    }

    /// Hands a file over in pieces that grow from `size` bytes where nothing is whole.
    fn in_pieces(
        file: &[u8],
        size: usize,
        mut take: impl FnMut(Piece) -> Result<usize, SourceError>,
    ) -> Result<(), SourceError> {
        let (mut at, mut length) = (0, size);
        while at < file.len() {
            let end = (at + length).min(file.len());
            let taken = take(Piece { bytes: &file[at..end], is_last: end == file.len() })?;
            length = if taken == 0 { length + size } else { size };
            at += taken;
        }
        Ok(())
    }

    fn read(file: &[u8], size: usize) -> Result<Collected, SourceError> {
        let mut stream = Stream::begin(file, file.len() as u64, None)?;
        let mut all = Collected::default();
        in_pieces(file, size, |piece| stream.read(piece, &mut all))?;
        stream.finish()?;
        Ok(all)
    }

    const OBJ: &[u8] =
        b"# head\r\nmtllib a.mtl\nf -0 1\nv 0 0 0 # a\nv 1e0 \\\n0 0 0.5 0.5 0.5\r\nv 1 1 -0\n\nf 1/1 2//2 -1\n\
        v 0 1 0.25\nf 3 4 1 \\\n 2\nf 1 2\nv 7 7 7";

    fn ply(order: &str) -> Vec<u8> {
        let big = order == "big";
        let mut file = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement edge 1\nproperty list uchar int a\nelement vertex 4\nproperty uchar q\n\
             property float x\nproperty double y\nproperty float z\nelement face 3\nproperty list uchar int vertex_indices\n\
             property short flag\nend_header\n"
        )
        .into_bytes();
        let mut push = |bytes: &[u8]| match big {
            true => file.extend(bytes.iter().rev()),
            false => file.extend(bytes),
        };
        push(&[2]);
        push(&1i32.to_le_bytes());
        push(&2i32.to_le_bytes());
        for [x, y, z] in [[0.0, 0.1, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.3], [0.0, 1.0, 0.0]] {
            push(&[9]);
            push(&(x as f32).to_le_bytes());
            push(&f64::to_le_bytes(y));
            push(&(z as f32).to_le_bytes());
        }
        for face in [&[0, 1, 2][..], &[0, 2, 3, 1], &[0, 1]] {
            push(&[face.len() as u8]);
            face.iter().for_each(|v: &i32| push(&v.to_le_bytes()));
            push(&7i16.to_le_bytes());
        }
        file
    }

    #[test]
    fn pieces_of_any_size_hold_what_the_whole_file_does() {
        for file in [OBJ.replace_zero_index(), ply("little"), ply("big")] {
            let source = Source::parse(file.clone(), None).unwrap();
            let expected: Vec<Vec<Index>> =
                source.data().faces().iter().map(|face| face.iter().map(|c| c.position).collect()).collect();
            let moved: Vec<DVec3> = source.data().positions().iter().map(|p| *p + DVec3::new(0.0, 0.1, p.x)).collect();
            let written = source.with_positions(&moved, None).unwrap();
            for size in [1, 7, 64, 10_000] {
                let found = read(&file, size).unwrap();
                assert_eq!((&found.positions[..], &found.faces), (source.data().positions(), &expected), "{size}");
                let mut stream = Stream::begin(&file, file.len() as u64, None).unwrap();
                let mut changes = source.data().positions().iter().zip(&moved).map(|(a, b)| [*a, *b]);
                let mut out = Vec::new();
                in_pieces(&file, size, |piece| stream.rewrite(piece, &mut || changes.next().unwrap(), &mut out))
                    .unwrap();
                assert!(out == written && changes.next().is_none(), "{size}");
            }
        }
    }

    trait Fixed {
        fn replace_zero_index(&self) -> Vec<u8>;
    }

    impl Fixed for [u8] {
        /// The file without the line that no reader takes.
        fn replace_zero_index(&self) -> Vec<u8> {
            String::from_utf8_lossy(self).replace("f -0 1\n", "").into_bytes()
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let message = |file: &[u8]| read(file, 16).map(|_| ()).unwrap_err().to_string();
        assert_eq!(message(OBJ), "line 3: index 0 in `-0`: OBJ counts from 1");
        assert_eq!(message(b"v 0 0 0\nv 1 0\n"), "line 2: `v` needs 3 numbers, found 2");
        assert_eq!(message(b"v 0 0 0\n\nv 1 0 nan\n"), "line 3: coordinate `nan` is not finite");
        assert_eq!(message(b"v 0 0 0\nf 1 2 3\n\n"), "line 2: index 3 names no `v` line: there are 1");
        assert_eq!(message(b"v 0 0 0\nf 1 b 3\n\n"), "line 2: `b` is not a face corner (v, v/vt, v//vn or v/vt/vn)");
        let mut cut = ply("little");
        cut.truncate(cut.len() - 3);
        assert!(message(&cut).contains("ends within face 2"), "{}", message(&cut));
        let mut far = ply("little");
        let at = far.len() - 3;
        far[at] = 77;
        assert!(message(&far).contains("face 2 names vertex"), "{}", message(&far));
        assert!(message(b"OFF\n3 1 0\n").contains("OFF"));
        let ascii = b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
        assert!(message(ascii).contains("text"), "{}", message(ascii));
    }
}
