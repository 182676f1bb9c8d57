//! A scene as arrays for the GPU.

use crate::gpu::types::{Extra, Vertex, Wedge};
use crate::mesh::{Facing, Side};
use crate::scene::Scene;
use glam::{Vec2, Vec4};
use planish_geometry::map::displacement::SampleAt;
use planish_geometry::map::tangents::Tangent;
use std::ops::Range;

/// Bits of a corner that hold its wedge; above them two for the side and two for flags of the triangle. `WEDGE_BITS` in
/// `shaders/surface.wgsl`.
const WEDGE_BITS: u32 = 28;
/// Bits of a corner below its flags. `FLAG_BITS` in `shaders/surface.wgsl`.
const FLAG_BITS: u32 = 30;

/// Contents of the buffers of bind group 2.
pub(crate) struct RenderMesh {
    /// One entry per vertex, #V.
    pub(crate) vertices: Vec<Vertex>,
    /// One entry per vertex, #V.
    pub(crate) extras: Vec<Extra>,
    /// Distinct combinations of vertex, normal, texture coordinate and tangent frame.
    pub(crate) wedges: Vec<Wedge>,
    /// Corners of the triangles, #T×3; triangles of one run are contiguous.
    pub(crate) corners: Vec<u32>,
    /// Ranges of corners that are drawn alike.
    pub(crate) runs: Vec<Run>,
    /// Start index of each ring, then the triangles around the vertices; see `shaders/normals.wgsl`.
    pub(crate) rings: Vec<u32>,
}

/// Textures and sides with which triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Look {
    /// Index of the texture in the scene's list; `None` where the triangles have none.
    pub(crate) texture: Option<u32>,
    /// Index of the normal map in the scene's list; `None` where the triangles have none.
    pub(crate) normal_map: Option<u32>,
    /// Whether the outer side alone is drawn.
    pub(crate) one_sided: bool,
}

/// Corners that are drawn with one look.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) look: Look,
    pub(crate) corners: Range<u32>,
}

impl RenderMesh {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mesh = scene.mesh();
        let vertices = (0..mesh.positions.len()).map(|v| vertex(scene, v)).collect();
        let extras = extras(scene, mesh.scalars.as_deref());
        let mut wedges = Wedges { all: Vec::new(), first: vec![NONE; mesh.positions.len()], next: Vec::new() };
        let mut corners = Vec::with_capacity(3 * mesh.triangles.len());
        let look = |t: &usize| Look {
            texture: scene.textures.of_triangle(*t),
            normal_map: scene.normal_maps.of_triangle(*t),
            one_sided: mesh.triangles[*t].facing != Facing::Both,
        };
        let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
        // Stable: within a look the order of the file.
        order.sort_by_key(look);
        for t in order.iter().copied() {
            let triangle = &mesh.triangles[t];
            let Look { texture, normal_map, .. } = look(&t);
            // TEXTURED, MAPPED, TURNED
            let flags = [texture.is_some(), normal_map.is_some(), triangle.facing == Facing::Back];
            let flags: u32 = (0..).zip(flags).map(|(bit, is_set)| u32::from(is_set) << bit).sum();
            for k in 0..3 {
                let vertex = triangle.positions[k];
                let wedge = wedges.number(Wedge {
                    normal: mesh.normals[triangle.normals[k] as usize],
                    vertex,
                    tangent: mesh.tangents.get(t).map_or(Vec4::ZERO, |frames| frame(frames[k])),
                    uv: triangle.uvs.map_or(Vec2::ZERO, |uvs| mesh.uvs[uvs[k] as usize]),
                    has_uv: if triangle.uvs.is_some() { 1.0 } else { 0.0 },
                    open: scene.open_at_vertex(vertex),
                });
                let side = match triangle.sides[k] {
                    Side::Edge => 0,
                    Side::Seam => 1,
                    Side::Diagonal => 2,
                };
                let flags_here = (flags >> (2 * k)) & 3;
                corners.push(flags_here << FLAG_BITS | side << WEDGE_BITS | wedge);
            }
        }
        let runs = runs(order.iter().map(look));
        let rings = scene.displacement.as_ref().map_or_else(Vec::new, |binding| {
            let (rings, count) = (&binding.rings, mesh.positions.len() as u32);
            let ends = (0..count).map(|v| rings.range(v).end as u32);
            let starts = std::iter::once(0).chain(ends).map(|pairs| count + 1 + 2 * pairs);
            starts.chain(rings.items().as_flattened().iter().copied()).collect()
        });
        Self { vertices, extras, wedges: wedges.all, corners, runs, rings }
    }
}

fn runs(looks: impl Iterator<Item = Look>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (look, first) in looks.zip((0..).step_by(3)) {
        match runs.last_mut() {
            Some(run) if run.look == look => run.corners.end = first + 3,
            _ => runs.push(Run { look, corners: first..first + 3 }),
        }
    }
    runs
}

fn frame(tangent: Tangent) -> Vec4 {
    tangent.tangent.extend(tangent.sign)
}

fn vertex(scene: &Scene, v: usize) -> Vertex {
    let mut vertex = Vertex { position: scene.mesh().positions[v], ..Vertex::default() };
    if let Some(binding) = &scene.displacement {
        let of_map = &binding.vertices[v];
        vertex.normal = of_map.normal;
        match of_map.sample_at {
            None => {}
            Some(SampleAt::Uv(_)) => vertex.place = 1,
            Some(SampleAt::Texel(texel)) => (vertex.place, vertex.texel) = (2, texel),
        }
    }
    vertex
}

/// Data of the vertices that only some shadings read, with these scalars for heat maps in place of those of the scene. #V
pub(crate) fn extras(scene: &Scene, scalars: Option<&[f32]>) -> Vec<Extra> {
    let extra = |v: usize| {
        let number = scalars.map(|scalars| scalars[v]).filter(|x| x.is_finite());
        let mut extra = Extra {
            number: number.unwrap_or(0.0),
            has_number: if number.is_some() { 1.0 } else { 0.0 },
            ..Extra::default()
        };
        if let Some(binding) = &scene.displacement {
            let of_map = &binding.vertices[v];
            extra.tangent = frame(of_map.tangent);
            if let Some(SampleAt::Uv(uv)) = of_map.sample_at {
                extra.uv = uv;
            }
        }
        extra
    };
    (0..scene.mesh().positions.len()).map(extra).collect()
}

const NONE: u32 = u32::MAX;

/// Wedges in the order in which they are met; those of a vertex are chained.
struct Wedges {
    all: Vec<Wedge>,
    /// One entry per vertex, #V.
    first: Vec<u32>,
    next: Vec<u32>,
}

impl Wedges {
    fn number(&mut self, wedge: Wedge) -> u32 {
        let mut link = self.first[wedge.vertex as usize];
        while link != NONE && self.all[link as usize] != wedge {
            link = self.next[link as usize];
        }
        if link == NONE {
            link = self.all.len() as u32;
            self.all.push(wedge);
            self.next.push(std::mem::replace(&mut self.first[wedge.vertex as usize], link));
        }
        link
    }
}
