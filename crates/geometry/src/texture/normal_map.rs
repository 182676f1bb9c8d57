//! Tangent-space normal map of the denoised surface.
//!
//! A displacement map moves vertices, but a client goes on shading with the normals of the noisy mesh; this map gives it
//! those of the denoised one. Tangent frames are MikkTSpace (Mikkelsen 2008), computed from the carrier as clients do
//! it: frames are interpolated without normalising, the bitangent is made per pixel as sign · n × t, and the map is the
//! exact inverse of that.

use super::{Coverage, gutter, per_texel};
use crate::atlas::Atlas;
use crate::normals::{self, FaceWeight};
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::surface::Surface;
use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Which way green points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Convention {
    /// Up in the texture (+Y): Blender, glTF, three.js, Unity.
    #[default]
    OpenGl,
    /// Down (−Y): Unreal, Direct3D tools.
    DirectX,
}

/// A normal map, 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NormalMap {
    /// RGB, row by row from the top.
    pub texels: Vec<[u8; 3]>,
}

/// Bakes the normals of `denoised` (#V×3, model units) into the [`tangents`] of `surface` (#T×3) with the normals that
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
        let n = if *n == Vec3::ZERO { Vec3::Z } else { *n };
        [quantise(n.x), quantise(n.y * green), quantise(n.z)]
    };
    Ok(NormalMap { texels: texels.iter().map(encode).collect() })
}

/// Tangent at a corner and the side on which the bitangent lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangent {
    /// Unit, along increasing u.
    pub tangent: Vec3,
    /// 1 or −1: the bitangent is sign · n × t, along increasing v (up).
    pub sign: f32,
}

/// MikkTSpace tangents at the corners of each triangle. #T×3
pub fn tangents(surface: &Surface, atlas: &Atlas, vertex_normals: &[Vec3]) -> Vec<[Tangent; 3]> {
    let [low, high] = surface.bounds();
    // Far from the origin single precision would leave nothing of an edge.
    let centre = (low + high) / 2.0;
    let mut frames = Frames {
        surface,
        atlas,
        vertex_normals,
        centre,
        tangents: vec![[Tangent::default(); 3]; surface.triangle_corners().len()],
    };
    // The error type has no values.
    let _ = bevy_mikktspace::generate_tangents(&mut frames);
    frames.tangents
}

struct Frames<'a> {
    surface: &'a Surface,
    atlas: &'a Atlas,
    vertex_normals: &'a [Vec3],
    centre: DVec3,
    tangents: Vec<[Tangent; 3]>,
}

impl Frames<'_> {
    fn corner(&self, face: usize, k: usize) -> Index {
        self.surface.triangle_corners()[face][k]
    }
}

impl Geometry for Frames<'_> {
    fn num_faces(&self) -> usize {
        self.tangents.len()
    }
    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }
    fn position(&self, face: usize, k: usize) -> [f32; 3] {
        (self.surface.at_corner(self.corner(face, k)) - self.centre).as_vec3().to_array()
    }
    fn normal(&self, face: usize, k: usize) -> [f32; 3] {
        self.vertex_normals[self.surface.topology().vertex(self.corner(face, k)) as usize].to_array()
    }
    fn tex_coord(&self, face: usize, k: usize) -> [f32; 2] {
        self.atlas.at_corner(self.corner(face, k)).unwrap_or_default().as_vec2().to_array()
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, k: usize) {
        let [x, y, z, sign] = space.unwrap_or_default().tangent_encoded();
        self.tangents[face][k] = Tangent { tangent: Vec3::new(x, y, z), sign };
    }
}
