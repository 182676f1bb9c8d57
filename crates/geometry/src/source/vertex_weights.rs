//! Weights of source vertices, 0..=1, from what a mesh has: a channel of its colours, a grey picture in its texture coordinates, or
//! some of its faces.
//!
//! ```
//! use planish_geometry::source::obj::{Obj, ObjError};
//! use planish_geometry::source::vertex_weights::{self, GreyPicture};
//!
//! let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt .25 .5\nvt .75 .5\nf 1/1 2/2 3/1\nf 3/1 2/2 4/2\n";
//! let mesh = Obj::parse(text.to_vec())?;
//! // The first face is picked. Vertices 2 and 3 are corners of the other one, too.
//! assert_eq!(vertex_weights::of_faces(mesh.data(), &[true, false]), [1.0, 0.0, 0.0, 0.0]);
//! let picture = GreyPicture { width: 2, height: 1, pixels: &[0.0, 1.0] };
//! assert_eq!(vertex_weights::of_picture(mesh.data(), picture), [0.0, 1.0, 0.0, 1.0]);
//! # Ok::<(), ObjError>(())
//! ```

use super::MeshData;
use crate::named;
use glam::DVec2;

named! {
    /// Channel of the colours of vertices.
    #[derive(Default)]
    pub enum ColourChannel {
        /// Red.
        Red = "red",
        /// Green.
        Green = "green",
        /// Blue.
        Blue = "blue",
        /// Mean of the three.
        #[default]
        Grey = "grey",
    }
}

/// A grey picture.
#[derive(Clone, Copy, Debug)]
pub struct GreyPicture<'a> {
    /// Number of pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Values, row by row from the top, 0..=1. #rows·#columns
    pub pixels: &'a [f32],
}

impl GreyPicture<'_> {
    /// Value at a texture coordinate, v up: bilinear between the centres of pixels, repeated beyond [0, 1].
    fn at(&self, uv: DVec2) -> f32 {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let p = DVec2::new(uv.x * width, (1.0 - uv.y) * height) - 0.5;
        let low = p.floor();
        let w = p - low;
        let pixel = |x: f64, y: f64| {
            let (column, row) = (x.rem_euclid(width) as usize, y.rem_euclid(height) as usize);
            f64::from(
                self.pixels
                    [row.min(self.height as usize - 1) * self.width as usize + column.min(self.width as usize - 1)],
            )
        };
        let [top, bottom] = [0.0, 1.0].map(|dy| {
            let y = low.y + dy;
            pixel(low.x, y) * (1.0 - w.x) + pixel(low.x + 1.0, y) * w.x
        });
        (top * (1.0 - w.y) + bottom * w.y) as f32
    }
}

/// Weights from the colours of the vertices (#v); `None` if the mesh has no colours.
pub fn of_colours(mesh: &MeshData, channel: ColourChannel) -> Option<Vec<f32>> {
    let weight = |[r, g, b]: &[f32; 3]| match channel {
        ColourChannel::Red => *r,
        ColourChannel::Green => *g,
        ColourChannel::Blue => *b,
        ColourChannel::Grey => (r + g + b) / 3.0,
    };
    (!mesh.colours().is_empty()).then(|| mesh.colours().iter().map(weight).collect())
}

/// Weights from a picture (#v): the lowest at the texture coordinates of a vertex, and 1 for a vertex without any.
///
/// # Panics
/// If the picture is empty or has not as many pixels as it says.
pub fn of_picture(mesh: &MeshData, picture: GreyPicture) -> Vec<f32> {
    assert_eq!(picture.pixels.len(), picture.width as usize * picture.height as usize, "one value for each pixel");
    let mut weights = vec![1.0f32; mesh.positions().len()];
    for corner in mesh.faces().items() {
        if let Some(uv) = corner.uv().map(|uv| mesh.uvs()[uv as usize]).filter(|uv| uv.is_finite()) {
            let weight = &mut weights[corner.position as usize];
            *weight = weight.min(picture.at(uv));
        }
    }
    weights
}

/// Weights from some of the faces, which `picked` marks (#f): 1 for vertices all of whose faces are picked, and 0 for all others, so
/// that no other face changes. #v
///
/// # Panics
/// If there is not one mark for each face.
pub fn of_faces(mesh: &MeshData, picked: &[bool]) -> Vec<f32> {
    assert_eq!(picked.len(), mesh.faces().len(), "one mark for each face");
    let mut weights = vec![1.0; mesh.positions().len()];
    for (face, _) in mesh.faces().iter().zip(picked).filter(|(_, picked)| !**picked) {
        face.iter().for_each(|corner| weights[corner.position as usize] = 0.0);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::obj::Obj;

    fn mesh(text: &str) -> Obj {
        Obj::parse(text.as_bytes().to_vec()).unwrap()
    }

    #[test]
    fn channels_are_read() {
        let obj = mesh("v 0 0 0 1 0.5 0\nv 1 0 0 0 0.25 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
        let of = |channel| of_colours(obj.data(), channel).unwrap();
        assert_eq!(of(ColourChannel::Red), [1.0, 0.0, 0.0]);
        assert_eq!(of(ColourChannel::Green), [0.5, 0.25, 0.0]);
        assert_eq!(of(ColourChannel::Blue), [0.0, 1.0, 0.0]);
        assert_eq!(of(ColourChannel::Grey), [0.5, 1.25 / 3.0, 0.0]);
        assert!(of_colours(mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").data(), ColourChannel::Red).is_none());
    }

    #[test]
    fn pictures_are_sampled_between_their_centres_and_repeat() {
        let picture = GreyPicture { width: 2, height: 2, pixels: &[0.0, 1.0, 0.5, 0.25] };
        for (u, v, expected) in [
            (0.25, 0.75, 0.0),
            (0.75, 0.75, 1.0),
            (0.25, 0.25, 0.5),
            (0.75, 0.25, 0.25),
            (0.5, 0.75, 0.5),
            (0.5, 0.5, 0.4375),
            (1.25, -0.25, 0.0),
            (0.0, 0.75, 0.5),
        ] {
            assert_eq!(picture.at(DVec2::new(u, v)), expected, "{u} {v}");
        }
        for far in [1e300, -1e300, 1e9 + 0.3, f64::MIN_POSITIVE] {
            assert!((0.0..=1.0).contains(&picture.at(DVec2::splat(far))));
        }
    }

    #[test]
    fn a_vertex_on_a_seam_has_its_lowest_weight_and_one_without_coordinates_goes_freely() {
        let obj = mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.75\nvt 0.75 0.75\nf 1/2 2/2 3\nf 3 2/2 1/1\n");
        let picture = GreyPicture { width: 2, height: 1, pixels: &[0.25, 0.75] };
        assert_eq!(of_picture(obj.data(), picture), [0.25, 0.75, 1.0]);
    }

    #[test]
    fn faces_that_are_not_picked_stay_whole() {
        let obj = mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 5 5 5\nf 1 2 3\nf 2 4 3\n");
        assert_eq!(of_faces(obj.data(), &[true, false]), [1.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(of_faces(obj.data(), &[true, true]), [1.0; 5]);
    }
}
