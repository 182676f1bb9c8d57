//! Tangent-space normal map of the denoised surface.
//!
//! A displacement map moves vertices, but a client goes on shading with the normals of the noisy mesh; this map gives it
//! those of the denoised one. Tangent frames are MikkTSpace (Mikkelsen 2008), computed from the carrier as clients do
//! it: frames are interpolated without normalising, the bitangent is made per pixel as sign · n × t, and the map is the
//! exact inverse of that.
//!
//! ```
//! use glam::{DVec2, DVec3, Vec3};
//! use planish_geometry::map::normal_map::{self, Convention, SharedTexels, TangentFrames};
//! use planish_geometry::map::{Coverage, Size, TextureLayout, tangents};
//! use planish_geometry::mesh::{atlas::Atlas, shapes};
//! use planish_geometry::progress::Silent;
//!
//! // A flat square, which denoising has tilted: it rises by 3 where u grows by 4.
//! let square = shapes::grid(1);
//! let uvs: Vec<DVec2> = square.positions().iter().map(|p| p.truncate()).collect();
//! let atlas = Atlas::new(&square, &uvs, square.topology().faces().items().iter().map(|&v| Some(v)))?;
//! let coverage = Coverage::new(&square, &atlas, Size::square(8), &Silent)?;
//! let layout = TextureLayout { surface: &square, atlas: &atlas, coverage: &coverage };
//! let normals = [Vec3::Z; 4];
//! let frames = TangentFrames { normals: &normals, tangents: &tangents::tangents(&square, &atlas, &normals) };
//! let tilted: Vec<DVec3> = square.positions().iter().map(|p| *p + DVec3::Z * 0.75 * p.x).collect();
//! let map = normal_map::bake(layout, frames, tilted, (Convention::OpenGl, SharedTexels::First), &Silent)?;
//! // The normal (−0.6, 0, 0.8), in 8 bits.
//! assert!(map.texels.iter().all(|texel| *texel == [51, 128, 230]), "{:?}", map.texels[0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::tangents::Tangent;
use super::{TextureLayout, gutter, per_texel};
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
use glam::{DMat3, DVec3, Vec3};

named! {
    /// Direction of the green channel of a normal map.
    #[derive(Default)]
    pub enum Convention {
        /// Green points up (+Y): Blender, glTF, three.js, Unity.
        #[default]
        OpenGl = "opengl",
        /// Green points down (−Y): Unreal, Direct3D tools.
        DirectX = "directx",
    }
}

/// Normals of texels in which charts overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SharedTexels {
    /// The texel has the normal of the first triangle: for overlaps that rounding makes along the outlines of charts.
    First,
    /// The texel has the normal of the carrier, (0, 0, 1) in tangent space, because it belongs to no triangle alone.
    Flat,
}

/// A normal map with 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NormalMap {
    /// Red, green and blue of each texel, row by row from the top.
    pub texels: Vec<[u8; 3]>,
}

/// Tangent frames in which a normal map is expressed.
#[derive(Clone, Copy, Debug)]
pub struct TangentFrames<'a> {
    /// Normals that the vertices carry. #V×3, unit
    pub normals: &'a [Vec3],
    /// [`tangents`](super::tangents::tangents) of the surface with these normals. #T×3
    pub tangents: &'a [[Tangent; 3]],
}

/// Bakes the angle-weighted normals of the denoised surface, whose positions are `denoised` (#V×3, model units), in the
/// tangent frames of the noisy one, which is that of the layout.
pub fn bake(
    layout: TextureLayout,
    frames: TangentFrames,
    denoised: Vec<DVec3>,
    (convention, shared): (Convention, SharedTexels),
    progress: &dyn Progress,
) -> Result<NormalMap, Cancelled> {
    progress.stage("normal map");
    let TextureLayout { surface, coverage, .. } = layout;
    let targets = normals::vertex_normals(&surface.at(denoised), FaceWeight::Angle);
    let mut texels = per_texel(coverage.size(), Vec3::ZERO, progress, || {
        |column, row| match coverage.owner(column, row) {
            Some(_) if shared == SharedTexels::Flat && coverage.is_shared(column, row) => Vec3::Z,
            Some(owner) => frames.express(surface, &targets, coverage.weights(owner, column, row)),
            None => Vec3::ZERO,
        }
    })?;
    gutter::pull_push(&mut texels, coverage);
    let green = match convention {
        Convention::OpenGl => 1.0,
        Convention::DirectX => -1.0,
    };
    let quantise = |x: f32| (x * 127.5 + 127.5).round() as u8;
    let encode = |n: &Vec3| {
        // Averages of the gutter are shorter than one, and zero around a chart without normals.
        let n = n.normalize_or(Vec3::Z);
        [quantise(n.x), quantise(n.y * green), quantise(n.z)]
    };
    Ok(NormalMap { texels: texels.iter().map(encode).collect() })
}

impl TangentFrames<'_> {
    /// Normal of the target (#V×3) at barycentric coordinates of a triangle, in the interpolated tangent frame there. Unit
    fn express(&self, surface: &Surface, targets: &[DVec3], (triangle, weights): (Index, DVec3)) -> Vec3 {
        let corners = surface.triangle_corners()[triangle as usize];
        let vertices = corners.map(|c| surface.topology().vertex(c) as usize);
        let blend = |values: [DVec3; 3]| DMat3::from_cols(values[0], values[1], values[2]) * weights;
        let target = blend(vertices.map(|v| targets[v]));
        let n = blend(vertices.map(|v| self.normals[v].as_dvec3()));
        let frames = self.tangents[triangle as usize];
        let tangent = blend(frames.map(|f| f.tangent.as_dvec3()));
        // The sign is constant in a triangle: MikkTSpace never joins mirrored faces.
        let frame = DMat3::from_cols(tangent, n.cross(tangent) * f64::from(frames[0].sign), n);
        let local = (frame.inverse() * target).normalize_or(DVec3::Z);
        if local.is_finite() { local.as_vec3() } else { Vec3::Z }
    }
}
