//! Masks as users name them: a channel of the colours, a picture, a list of weights, groups or materials.
//!
//! ```
//! use planish_files::mask::MaskOption;
//! use planish_geometry::denoise::limits::Weights;
//! use planish_geometry::source::{Source, obj::Obj};
//! use std::path::Path;
//!
//! // The first vertex is red, and the others are black.
//! let mesh = Source::from(Obj::parse(b"v 0 0 0 1 0 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n".to_vec())?);
//! let mask: MaskOption = "not:colour:red".parse()?;
//! assert_eq!(mask.weights(&mesh, Path::new("scan.obj"))?.weights, Weights::new(&[0.0, 1.0, 1.0]));
//!
//! let foreign: MaskOption = "material:hair".parse()?;
//! let failure = foreign.weights(&mesh, Path::new("scan.obj")).unwrap_err();
//! assert_eq!(failure.to_string(), "scan.obj: has no faces of a material `hair`; it has none");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::failure::Failure;
use crate::input;
use crate::text::one_line;
use planish_geometry::denoise::limits::{WeightMask, Weights};
use planish_geometry::source::vertex_weights::{self, ColourChannel, GreyPicture};
use planish_geometry::source::{MeshData, Source};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A mask that says how far each vertex may go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskOption {
    /// The mask as the user gave it.
    pub text: String,
    /// Weights are 1 minus those of the mask.
    inverted: bool,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind {
    Colour(ColourChannel),
    Groups(Vec<String>),
    Materials(Vec<String>),
    Picture(PathBuf),
    Weights(PathBuf),
}

impl FromStr for MaskOption {
    type Err = String;

    /// Reads `colour:CHANNEL`, `group:NAME,…`, `material:NAME,…`, `weights:FILE` or the name of a picture, after `not:` if it is inverted.
    fn from_str(text: &str) -> Result<Self, String> {
        let (inverted, mask) = text.strip_prefix("not:").map_or((false, text), |mask| (true, mask));
        let names = |names: &str| -> Result<Vec<String>, String> {
            let names: Vec<String> = names.split(',').map(|name| name.trim().to_owned()).collect();
            if names.iter().any(String::is_empty) { Err("a name is missing".to_owned()) } else { Ok(names) }
        };
        let kind = match mask.split_once(':') {
            Some(("colour" | "color", channel)) => {
                let channel = if channel == "gray" { "grey" } else { channel };
                Kind::Colour(channel.parse().map_err(|_| {
                    let all: Vec<&str> = ColourChannel::ALL.iter().map(|channel| channel.name()).collect();
                    format!("`{channel}` is no channel; the channels are {}", all.join(", "))
                })?)
            }
            Some(("group", list)) => Kind::Groups(names(list)?),
            Some(("material", list)) => Kind::Materials(names(list)?),
            Some(("weights", "")) => return Err("a name is missing".to_owned()),
            Some(("weights", file)) => Kind::Weights(file.into()),
            _ if mask.is_empty() => return Err("a name is missing".to_owned()),
            _ => Kind::Picture(mask.into()),
        };
        Ok(Self { text: text.to_owned(), inverted, kind })
    }
}

impl MaskOption {
    /// Path of the file that the mask is read from; `None` for masks that are in the mesh.
    pub fn file(&self) -> Option<&PathBuf> {
        match &self.kind {
            Kind::Picture(path) | Kind::Weights(path) => Some(path),
            Kind::Colour(_) | Kind::Groups(_) | Kind::Materials(_) => None,
        }
    }

    /// Weights for the mesh that was read from `path`. Fails if the mesh has not what the mask needs.
    pub fn weights(&self, source: &Source, path: &Path) -> Result<WeightMask, Failure> {
        let mesh = source.data();
        let mut weights = match &self.kind {
            Kind::Colour(channel) => vertex_weights::of_colours(mesh, *channel)
                .ok_or_else(|| Failure::at(path, format!("has no colours of vertices for --mask {}", self.text)))?,
            Kind::Groups(names) => {
                return self.of_faces(mesh, &groups(source, names).map_err(|e| Failure::at(path, e))?);
            }
            Kind::Materials(names) => {
                return self.of_faces(mesh, &materials(mesh, names).map_err(|e| Failure::at(path, e))?);
            }
            Kind::Picture(picture) => of_picture(mesh, picture, path)?,
            Kind::Weights(list) => of_list(mesh, list, path)?,
        };
        if self.inverted {
            weights.iter_mut().for_each(|weight| *weight = 1.0 - *weight);
        }
        Ok(self.mask(&weights))
    }

    /// Weights from picked faces. Inverted, the other faces are the picked ones: in either case those that are not picked stay whole.
    fn of_faces(&self, mesh: &MeshData, picked: &[bool]) -> Result<WeightMask, Failure> {
        let picked: Vec<bool> = picked.iter().map(|picked| *picked != self.inverted).collect();
        Ok(self.mask(&vertex_weights::of_faces(mesh, &picked)))
    }

    fn mask(&self, weights: &[f32]) -> WeightMask {
        WeightMask { from: self.text.clone(), weights: Weights::new(weights) }
    }
}

/// Marks the faces of groups or objects.
fn groups(source: &Source, names: &[String]) -> Result<Vec<bool>, String> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    match source.as_obj() {
        Some(obj) => obj.faces_in(&names).map_err(|e| e.to_string()),
        None => Err("has no groups: only OBJ files have; use material:NAME".to_owned()),
    }
}

/// Marks the faces of materials.
fn materials(mesh: &MeshData, names: &[String]) -> Result<Vec<bool>, String> {
    let index = |name: &String| {
        let found = mesh.materials().iter().position(|material| material.as_slice() == name.as_bytes());
        found.map(|index| index as u32).ok_or_else(|| {
            let all: Vec<_> = mesh.materials().iter().map(|name| one_line(&String::from_utf8_lossy(name))).collect();
            let has = if all.is_empty() { "it has none".to_owned() } else { format!("it has {}", all.join(", ")) };
            format!("has no faces of a material `{}`; {has}", one_line(name))
        })
    };
    let named = names.iter().map(index).collect::<Result<Vec<_>, _>>()?;
    let faces = 0..mesh.faces().len() as u32;
    Ok(faces.map(|face| mesh.face_material(face).is_some_and(|material| named.contains(&material))).collect())
}

/// Weights from a grey picture; colours become their luma. Its numbers are data, so no colour space is taken off.
fn of_picture(mesh: &MeshData, picture: &Path, path: &Path) -> Result<Vec<f32>, Failure> {
    if mesh.faces().items().iter().all(|corner| corner.uv().is_none()) {
        let reason = format!("has no texture coordinates for --mask {}", one_line(&picture.display().to_string()));
        return Err(Failure::at(path, reason));
    }
    let bytes = input::read(picture)?;
    let decoded = image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    let decoded = decoded.map_err(|e| Failure::at(picture, input::plain(&e)))?.decode();
    let grey = decoded.map_err(|e| Failure::at(picture, format!("is no picture that can be read: {e}")))?.into_luma16();
    let pixels: Vec<f32> = grey.as_raw().iter().map(|value| f32::from(*value) / f32::from(u16::MAX)).collect();
    Ok(vertex_weights::of_picture(mesh, GreyPicture { width: grey.width(), height: grey.height(), pixels: &pixels }))
}

/// Weights from a text with one number for each vertex of the file.
fn of_list(mesh: &MeshData, list: &Path, path: &Path) -> Result<Vec<f32>, Failure> {
    let weights = input::numbers(list)?;
    let (found, needed) = (weights.len(), mesh.positions().len());
    if found != needed {
        let reason =
            format!("has {found} weights, but {} has {needed} vertices", one_line(&path.display().to_string()));
        return Err(Failure::at(list, reason));
    }
    match (1..).zip(&weights).find(|(_, weight)| !(0.0..=1.0).contains(*weight)) {
        Some((number, weight)) => Err(Failure::at(list, format!("weight {number} is {weight}, not from 0 to 1"))),
        None => Ok(weights),
    }
}

/// Text with one weight for each vertex of a file, which `weights:FILE` reads. Rounded to steps of 1/255, as masks are kept, it
/// gives the same weights again.
pub fn list(weights: &[f32]) -> String {
    weights.iter().map(|weight| format!("{}\n", (1e4 * weight).round() / 1e4)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_told_apart() {
        let kind = |text: &str| text.parse::<MaskOption>().map(|mask| (mask.inverted, mask.kind));
        assert_eq!(kind("colour:red"), Ok((false, Kind::Colour(ColourChannel::Red))));
        assert_eq!(kind("not:color:gray"), Ok((true, Kind::Colour(ColourChannel::Grey))));
        assert_eq!(kind("group:left eye, lid"), Ok((false, Kind::Groups(vec!["left eye".into(), "lid".into()]))));
        assert_eq!(kind("not:material:skin"), Ok((true, Kind::Materials(vec!["skin".into()]))));
        assert_eq!(kind("weights:a/mask.txt"), Ok((false, Kind::Weights("a/mask.txt".into()))));
        assert_eq!(kind("C:\\mask.png"), Ok((false, Kind::Picture("C:\\mask.png".into()))));
        for (text, word) in [
            ("colour:alpha", "alpha"),
            ("group:", "name"),
            ("material:a,,b", "name"),
            ("weights:", "name"),
            ("", "name"),
        ] {
            assert!(kind(text).unwrap_err().contains(word), "{text}");
        }
    }
}
