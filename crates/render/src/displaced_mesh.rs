//! A displacement map that is bound to a mesh: the baked one, which is subtracted, or any picture of heights, which is added.
//!
//! ```
//! use glam::Vec3;
//! use planish_geometry::map::displace::ShaderVertex;
//! use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat};
//! use planish_geometry::map::per_vertex;
//! use planish_render::displaced_mesh::{DisplacementBinding, Sign};
//! use planish_render::{mesh::Mesh, settings::Displace};
//!
//! // Two vertices, which noise has lifted by 1 and by 3.
//! let mesh = Mesh { positions: vec![Vec3::ZERO, Vec3::X], ..Mesh::default() };
//! let encoding = Encoding::covering(1.0, 3.0, TexelFormat::Png16);
//! let map = Displacement::encode(&[per_vertex::bake(&[1.0, 3.0], &[0, 1])], MapKind::Scalar, encoding);
//! let vertex = |i: u32| ShaderVertex {
//!     position: mesh.positions[i as usize],
//!     normal: Vec3::Z,
//!     sample_at: Some(SampleAt::Texel(i)),
//!     ..ShaderVertex::default()
//! };
//! let binding = DisplacementBinding::new(&mesh, map, vec![vertex(0), vertex(1)], Sign::Subtract);
//! let half = Displace { lambda: 0.5, ..Displace::default() };
//! assert_eq!(binding.displaced(&half), [Vec3::new(0.0, 0.0, -0.5), Vec3::new(1.0, 0.0, -1.5)]);
//! assert_eq!(binding.heights(&half), [1.0, 3.0]);
//! ```

use crate::mesh::{Facing, Mesh};
use crate::settings::Displace;
use glam::Vec3;
use planish_geometry::map::displace::ShaderVertex;
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt};
use planish_geometry::mesh::jagged::Ragged;
use rayon::prelude::*;
use std::borrow::Cow;

/// Direction in which heights move a vertex along its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// p − λ · height · n: the map says how far noise lifted each vertex.
    #[default]
    Subtract,
    /// p + λ · height · n: the map says how far to lift each vertex.
    Add,
}

/// A map and where each vertex samples it.
#[derive(Clone, Debug)]
pub struct DisplacementBinding {
    /// Decoded displacement map.
    pub map: Displacement,
    /// One for each position of the mesh, with the same coordinates. #V
    pub vertices: Vec<ShaderVertex>,
    /// Direction in which heights move a vertex along its normal.
    pub sign: Sign,
    /// The other two corners of the triangles around each vertex, counter-clockwise. #V
    pub(crate) rings: Ragged<[u32; 2]>,
}

impl DisplacementBinding {
    /// Prepares normals of the displaced surface.
    pub fn new(mesh: &Mesh, map: Displacement, vertices: Vec<ShaderVertex>, sign: Sign) -> Self {
        let around = |t: [u32; 3]| (0..3).map(move |k| (t[k], [t[(k + 1) % 3], t[(k + 2) % 3]]));
        // Backs at the same place would cancel the normals of their fronts.
        let fronts = mesh.triangles.iter().filter(|t| t.facing != Facing::Back);
        let rings = Ragged::group(mesh.positions.len(), fronts.flat_map(|t| around(t.positions)));
        Self { map, vertices, sign, rings }
    }

    /// λ with its sign for p − λ · height · n.
    pub(crate) fn signed_lambda(&self, displace: &Displace) -> f32 {
        match self.sign {
            Sign::Subtract => displace.lambda,
            Sign::Add => -displace.lambda,
        }
    }

    /// Bias and scale, model units: those of the map unless the settings say otherwise.
    pub(crate) fn bias_and_scale(&self, displace: &Displace) -> [f32; 2] {
        let Encoding { bias, scale, .. } = self.map.encoding();
        [displace.bias.unwrap_or(bias), displace.scale.unwrap_or(scale)]
    }

    /// Whether texture coordinates say where heights are.
    pub(crate) fn in_uv(&self) -> bool {
        self.map.kind() == MapKind::Scalar && self.vertices.iter().any(|v| matches!(v.sample_at, Some(SampleAt::Uv(_))))
    }

    /// Height difference between texel 1 and texel 0 along the normal at this λ, model units.
    pub(crate) fn lift(&self, displace: &Displace) -> f32 {
        -self.signed_lambda(displace) * self.bias_and_scale(displace)[1]
    }

    /// The furthest that a vertex may move, model units.
    pub(crate) fn reach(&self, displace: &Displace) -> f32 {
        let [bias, scale] = self.bias_and_scale(displace);
        let coordinates = self.map.planes().len() as f32;
        displace.lambda.abs() * bias.abs().max((bias + scale).abs()) * coordinates.sqrt()
    }

    fn map_with(&self, displace: &Displace) -> Cow<'_, Displacement> {
        let Encoding { bias, scale, .. } = self.map.encoding();
        let range = self.bias_and_scale(displace);
        if range == [bias, scale] {
            Cow::Borrowed(&self.map)
        } else {
            Cow::Owned(self.map.with_range(range[0], range[1]))
        }
    }

    /// Returns the displaced positions, #V×3, model units.
    pub fn displaced(&self, displace: &Displace) -> Vec<Vec3> {
        let map = self.map_with(displace);
        let lambda = self.signed_lambda(displace);
        self.vertices.par_iter().map(|v| v.displaced(&map, lambda)).collect()
    }

    /// Returns the height, or the length of the vector, that the map has at each vertex; #V, model units.
    pub fn heights(&self, displace: &Displace) -> Vec<f32> {
        let map = self.map_with(displace);
        self.vertices.par_iter().map(|v| v.height(&map)).collect()
    }

    /// Angle-weighted normals of a surface with these positions (#V×3); zero where no triangle has an area. #V×3, unit.
    ///
    /// Grit Thürmer, Charles A. Wüthrich. Computing vertex normals from polygonal facets. JGT 3(1), 1998. Twin of
    /// `cs_normals` in `shaders/normals.wgsl`.
    pub(crate) fn normals(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let normal = |(&ring, &p): (&&[[u32; 2]], &Vec3)| {
            let sum = ring.iter().map(|&[a, b]| {
                let [a, b] = [positions[a as usize] - p, positions[b as usize] - p];
                let across = a.cross(b);
                let length = across.length();
                if length > 0.0 { across * (length.atan2(a.dot(b)) / length) } else { Vec3::ZERO }
            });
            sum.fold(Vec3::ZERO, |sum, n| sum + n).normalize_or_zero()
        };
        let rings: Vec<&[[u32; 2]]> = self.rings.iter().collect();
        rings.par_iter().zip(positions).map(normal).collect()
    }
}
