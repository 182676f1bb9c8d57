//! File formats of meshes: their names, and how a file shows which one it has.
//!
//! ```
//! use planish_geometry::source::format::Format;
//!
//! assert_eq!(Format::of_extension("PLY"), Some(Format::Ply));
//! // The content decides, whatever the file is called.
//! assert_eq!(Format::of_content(b"glTF\x02\0\0\0", Some(Format::Obj)), Format::Glb);
//! assert_eq!(Format::of_content(b"v 0 0 0\n", None), Format::Obj);
//! ```

use crate::named;

named! {
    /// File format of a mesh.
    pub enum Format {
        /// Wavefront OBJ.
        Obj = "obj",
        /// PLY, the Stanford polygon format: text, or binary in either byte order.
        Ply = "ply",
        /// STL, triangles for printers: text or binary.
        Stl = "stl",
        /// OFF, the Geomview object file format: text.
        Off = "off",
        /// Binary glTF 2.0.
        Glb = "glb",
        /// glTF 2.0 as JSON, with buffers inside or beside it.
        Gltf = "gltf",
    }
}

impl Format {
    /// Format that the extension of a file name stands for, in any case; `None` if none is known.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let lower = extension.to_ascii_lowercase();
        match lower.as_str() {
            // Geomview's variants with attributes are the same format, whose first word says which one it is.
            "coff" | "noff" | "cnoff" | "stoff" => Some(Self::Off),
            word => Self::ALL.into_iter().find(|format| format.name() == word),
        }
    }

    /// Extensions of the file names of all formats, for messages: `.obj, .ply` and so on.
    pub fn extensions() -> String {
        Self::ALL.map(|format| format!(".{}", format.name())).join(", ")
    }

    /// Word for the source vertices of a file in messages.
    pub fn vertices(self) -> &'static str {
        if self == Self::Obj { "`v` lines" } else { "vertices" }
    }

    /// Format of a file with these bytes. `named` is what the file name says; it decides where the content does not.
    pub fn of_content(bytes: &[u8], named: Option<Self>) -> Self {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let first_word = text.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        match first_word {
            _ if bytes.starts_with(b"glTF") => Self::Glb,
            b"ply" => Self::Ply,
            word if word.eq_ignore_ascii_case(b"solid") && named != Some(Self::Obj) => Self::Stl,
            word if is_off(word) => Self::Off,
            word if word.starts_with(b"{") && named != Some(Self::Obj) => Self::Gltf,
            _ if is_binary_stl(bytes) => Self::Stl,
            // A file without any of these signs cannot be in the formats that have one.
            _ => match named {
                Some(named @ (Self::Stl | Self::Off | Self::Ply | Self::Glb | Self::Gltf)) => named,
                Some(Self::Obj) | None => Self::Obj,
            },
        }
    }
}

/// Returns true for the keyword at the start of an OFF file, such as `OFF` or `STCNOFF`.
pub(super) fn is_off(word: &[u8]) -> bool {
    word.strip_suffix(b"OFF").is_some_and(|rest| rest.iter().all(|b| b"STCN4n".contains(b)))
}

/// Returns true if the number of facets in the header of a binary STL goes with the size of the file.
pub(super) fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| count > 0 && bytes.len() as u64 == 84 + 50 * u64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides_before_the_name_does() {
        let of = |bytes: &[u8], named| Format::of_content(bytes, named).name();
        assert_eq!(of(b"ply\nformat ascii 1.0\n", Some(Format::Obj)), "ply");
        assert_eq!(of(b"glTF\x02\0\0\0", None), "glb");
        assert_eq!(of(b"  \n{ \"asset\": {} }", None), "gltf");
        assert_eq!(of(b"COFF 3 1 0\n", Some(Format::Stl)), "off");
        assert_eq!(of(b"solid a\nfacet normal", None), "stl");
        assert_eq!(of(b"solid\nv 0 0 0\n", Some(Format::Obj)), "obj", "OBJ readers skip words that they do not know");
        assert_eq!(of(b"v 0 0 0\n", None), "obj");
        assert_eq!(of(b"v 0 0 0\n", Some(Format::Off)), "off", "the header is optional");
        let binary = [vec![0; 80], vec![1, 0, 0, 0], vec![0; 50]].concat();
        assert_eq!(of(&binary, None), "stl");
        assert_eq!(of(&binary[1..], None), "obj");
    }

    #[test]
    fn extensions_are_known_in_any_case() {
        assert_eq!(Format::of_extension("PLY"), Some(Format::Ply));
        assert_eq!(Format::of_extension("Coff"), Some(Format::Off));
        assert_eq!(Format::of_extension("png"), None);
    }
}
