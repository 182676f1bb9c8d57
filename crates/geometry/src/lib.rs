//! Mesh denoising and displacement maps: values in, values out. No files, no printing, no clock, no GPU.
//!
//! Denoised positions of a mesh that is given as arrays:
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::shapes;
//! use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
//!
//! // A sphere whose vertices err along their normals by a fifth of an edge.
//! let clean = shapes::sphere(3);
//! let noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 3 };
//! let noisy = synthetic_noise::noisy(&clean, &noise);
//! let faces: Vec<[u32; 3]> = clean.triangles().collect();
//!
//! let denoised = planish_geometry::denoise(noisy.positions(), &faces)?;
//!
//! // Mean angle between the face normals and those of the clean sphere, degrees.
//! let error = |positions: &[DVec3]| {
//!     let (clean, other) = (clean.face_vectors(), clean.at(positions.to_vec()).face_vectors());
//!     clean.iter().zip(&other).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / clean.len() as f64
//! };
//! assert!(error(noisy.positions()) > 15.0);
//! assert!(error(&denoised) < 4.0);
//! # Ok::<(), planish_geometry::source::ArrayError>(())
//! ```
//!
//! Denoising moves vertex i from pᵢ to p*ᵢ; its *displacement* is δᵢ = pᵢ − p*ᵢ, and its *height* hᵢ = ⟨δᵢ, nᵢ⟩ is the part of δᵢ
//! along the unit normal nᵢ, positive outside the denoised surface. A displacement map stores the heights as a texture, and the
//! *carrier* is the mesh that is drawn with it: a vertex shader computes p' = p − λ · (bias + scale · texel) · n, which is the
//! noisy mesh at λ = 0 and the denoised one at λ = 1.
//!
//! | module | contents |
//! | --- | --- |
//! | [`mesh`] | surfaces: topology, welding, normals, texture coordinates, test shapes and synthetic noise |
//! | [`source`] | meshes as they come: OBJ files, arrays, materials, and the [`Model`] made of them |
//! | [`mod@denoise`] | methods, their settings and limits, and the heights that represent their results |
//! | [`map`] | displacement and normal maps: rasterising, fitting, encoding, manifest, and the displacement of a vertex |
//! | [`bake`](mod@bake) | the whole bake, from a model to the bytes of all files, and its error report |
//! | [`metrics`] | angles and distances between a result and the clean mesh, and colours that show them |
//!
//! From OBJ text to a height map:
//!
//! ```
//! use planish_geometry::denoise::{Denoiser, Laplacian};
//! use planish_geometry::source::model::{Model, NormalSource};
//! use planish_geometry::source::obj::Obj;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::map::{self, Coverage, Interpolation, Size, TextureLayout};
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::mesh::normals;
//!
//! // A pyramid over a square: its tip is lifted by one.
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\n\
//!             vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n\
//!             f 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let (surface, atlas) = (model.surface(), model.atlas()?);
//!
//! let one_full_step = Denoiser::Laplacian(Laplacian { iterations: 1, step: 1.0, ..Laplacian::default() });
//! let deltas = one_full_step.deltas(surface, &Silent)?;
//! let normals = model.displacement_normals(NormalSource::Angle)?;
//! let heights = normals::heights(&deltas, &normals);
//! assert_eq!(heights, [0.0, 0.0, 0.0, 0.0, 1.0]); // the boundary stays, the tip goes down to the square
//!
//! let coverage = Coverage::new(surface, &atlas, Size::square(65), &Silent)?;
//! let layout = TextureLayout { surface, atlas: &atlas, coverage: &coverage };
//! let map = map::interpolate_heights(layout, &heights, Interpolation::Barycentric, &Silent)?;
//! assert_eq!(map.texels[32 * 65 + 32], 1.0); // the texel in the middle
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`bake::bake`] does all of this and returns the files that `planish bake` writes.
//!
//! A *vertex* belongs to the surface after welding ([`mesh::weld`]). A *uv vertex* is one texture coordinate, and a *wedge* is a pair
//! of both ([`mesh::atlas`]). Numbers are in f64, and in f32 from the encoding of maps on ([`map::displacement`],
//! [`map::displace`]), as on the GPU. The same input gives the same bits on any number of threads.

pub mod bake;
pub mod denoise;
pub mod map;
pub mod mesh;
pub mod metrics;
pub mod named;
pub mod progress;
pub mod source;

use denoise::Denoiser;
use glam::DVec3;
use mesh::weld::Welding;
use progress::Silent;
use source::model::Model;
use source::{ArrayError, Arrays, MeshData};

/// Denoises a triangle mesh by the method [`Auto`](denoise::Auto), which measures the noise and needs no parameters.
///
/// `positions` are those of the vertices (#V×3, model units), and `faces` holds the indices of three vertices for each triangle
/// (#F×3), counter-clockwise seen from outside. The result has one denoised position for each input position, in the same
/// order (#V×3, model units). Vertices with equal positions are welded, so they stay together; vertices without a face stay.
///
/// Use a [`Denoiser`] with a [`Model`] to choose the method, to see its progress or to stop it.
///
/// # Errors
/// If an array is empty, a position is not finite, or a face names a vertex that does not exist; the error names the array and
/// the index.
///
/// ```
/// use planish_geometry::mesh::shapes;
/// use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
///
/// let clean = shapes::grid(16);
/// let noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 };
/// let noisy = synthetic_noise::noisy(&clean, &noise);
/// let faces: Vec<[u32; 3]> = noisy.triangles().collect();
/// let denoised = planish_geometry::denoise(noisy.positions(), &faces)?;
///
/// // The clean mesh lies in the plane z = 0.
/// let roughness = |positions: &[glam::DVec3]| positions.iter().map(|p| p.z.abs()).sum::<f64>();
/// assert!(roughness(&denoised) < roughness(noisy.positions()));
/// # Ok::<(), planish_geometry::source::ArrayError>(())
/// ```
pub fn denoise(positions: &[DVec3], faces: &[[u32; 3]]) -> Result<Vec<DVec3>, ArrayError> {
    let faces = faces.iter().map(|face| face.to_vec()).collect();
    let data = MeshData::try_from(Arrays { positions: positions.to_vec(), faces, ..Arrays::default() })?;
    let model = Model::new(data, Welding::Exact);
    let denoised = Denoiser::default().denoised(model.surface(), &Silent);
    Ok(model.weld().spread(&denoised.expect("`Silent` never asks to stop")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::shapes;
    use mesh::synthetic_noise::{self, Direction, Noise};

    fn noisy() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 };
        let surface = synthetic_noise::noisy(&shapes::sphere(2), &noise);
        (surface.positions().to_vec(), surface.triangles().collect())
    }

    #[test]
    fn positions_come_back_in_their_order_whatever_is_welded() {
        let (positions, faces) = noisy();
        let joined = denoise(&positions, &faces).unwrap();
        assert_ne!(joined, positions);
        // Every other face names copies of the vertices, which lie behind all others.
        let copies: Vec<DVec3> = positions.iter().chain(&positions).copied().collect();
        let copy = positions.len() as u32;
        let cut: Vec<[u32; 3]> = (0..).zip(&faces).map(|(f, face)| face.map(|v| v + copy * (f % 2))).collect();
        let denoised = denoise(&copies, &cut).unwrap();
        assert_eq!(denoised, [joined.as_slice(), joined.as_slice()].concat());
    }

    #[test]
    fn arrays_that_are_no_mesh_are_refused_by_name_and_index() {
        let (mut positions, faces) = noisy();
        let message = |positions: &[DVec3], faces: &[[u32; 3]]| denoise(positions, faces).unwrap_err().to_string();
        assert_eq!(message(&positions, &[]), "`faces` is empty");
        let beyond = positions.len() as u32;
        let error = message(&positions, &[[0, 1, beyond]]);
        assert!(error.contains(&format!("`faces[0]` names element {beyond} of `positions`")), "{error}");
        positions[7].y = f64::NAN;
        assert_eq!(message(&positions, &faces), "`positions[7]` is not finite");
    }
}
