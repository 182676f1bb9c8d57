//! Tangent-space normal map of the denoised surface.
//!
//! A displacement map moves vertices, but a client goes on shading with the normals of the noisy mesh; this map gives it
//! those of the denoised one. Tangent frames are MikkTSpace (Mikkelsen 2008), computed from the carrier as clients do
//! it: frames are interpolated without normalising, the bitangent is made per pixel as sign · n × t, and the map is the
//! exact inverse of that.

use super::tangents::Tangent;
use super::{Coverage, gutter, per_texel};
use crate::named;
use crate::normals::{self, FaceWeight};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
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

/// A normal map, 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NormalMap {
    /// RGB, row by row from the top.
    pub texels: Vec<[u8; 3]>,
}

/// Bakes the normals of `denoised` (#V×3, model units) into the [`tangents`](super::tangents::tangents) of `surface` (#T×3) with the normals that
/// its vertices carry (#V×3, unit).
pub fn bake(
    surface: &Surface,
    vertex_normals: &[Vec3],
    tangents: &[[Tangent; 3]],
    denoised: Vec<DVec3>,
    coverage: &Coverage,
    convention: Convention,
    progress: &dyn Progress,
) -> Result<NormalMap, Cancelled> {
    progress.stage("normal map");
    let targets = normals::vertex_normals(&surface.at(denoised), FaceWeight::Angle);
    let mut texels = per_texel(coverage.size(), Vec3::ZERO, progress, || {
        |column, row| {
            let Some(owner) = coverage.owner(column, row) else { return Vec3::ZERO };
            let (t, weights) = coverage.weights(owner, column, row);
            let corners = surface.triangle_corners()[t as usize];
            let vertices = corners.map(|c| surface.topology().vertex(c) as usize);
            let blend = |values: [DVec3; 3]| DMat3::from_cols(values[0], values[1], values[2]) * weights;
            let target = blend(vertices.map(|v| targets[v]));
            let n = blend(vertices.map(|v| vertex_normals[v].as_dvec3()));
            let frames = tangents[t as usize];
            let tangent = blend(frames.map(|f| f.tangent.as_dvec3()));
            // The sign is constant in a triangle: MikkTSpace never joins mirrored faces.
            let frame = DMat3::from_cols(tangent, n.cross(tangent) * f64::from(frames[0].sign), n);
            let local = (frame.inverse() * target).normalize_or(DVec3::Z);
            if local.is_finite() { local.as_vec3() } else { Vec3::Z }
        }
    })?;
    gutter::pull_push(&mut texels, coverage);
    let green = match convention {
        Convention::OpenGl => 1.0,
        Convention::DirectX => -1.0,
    };
    let quantise = |x: f32| (x * 127.5 + 127.5).round() as u8;
    let encode = |n: &Vec3| {
        // Averages of the gutter are shorter than one; nothing in a chart gives nothing around it.
        let n = n.normalize_or(Vec3::Z);
        [quantise(n.x), quantise(n.y * green), quantise(n.z)]
    };
    Ok(NormalMap { texels: texels.iter().map(encode).collect() })
}
