//! The vertex shader's Rust twin: p' = p − λ · height · n, in single precision.

use crate::displacement::Displacement;
use crate::obj::Obj;
use crate::ragged::Index;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Below this many diagonals from the origin coordinates keep enough digits in single precision.
const NEAR: f64 = 8.0;

/// What is subtracted from positions before they go to single precision: nothing, or the centre of the bounds where
/// the mesh lies so far out (UTM coordinates, say) that its detail would be rounded away. Model units.
pub fn origin([low, high]: [DVec3; 2]) -> DVec3 {
    let centre = (low + high) / 2.0;
    if centre.length() > NEAR * low.distance(high) { centre } else { DVec3::ZERO }
}

/// A vertex as a shader gets it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaderVertex {
    /// Relative to the origin, model units.
    pub position: Vec3,
    /// Unit, or zero where there is none.
    pub normal: Vec3,
    /// Where it samples the map; none where no face gives it texture coordinates.
    pub uv: Option<Vec2>,
}

impl ShaderVertex {
    /// The displaced position, relative to the origin. A vertex that samples nowhere stays.
    pub fn displaced(&self, map: &Displacement, lambda: f32) -> Vec3 {
        match self.uv {
            Some(uv) => self.position - self.normal * (lambda * map.height_at(uv)),
            None => self.position,
        }
    }
}

/// The vertices of a carrier, one for each `v` line: its normal is the one its corners name, its place in the texture
/// the one in `dominant` (pairs of `v` and `vt` index from 0, ascending) or else the one its first corner names.
pub fn carrier_vertices(carrier: &Obj, dominant: &[[Index; 2]], origin: DVec3) -> Vec<ShaderVertex> {
    let mut vertices = positions(carrier, origin);
    let uv = |vt: Index| carrier.uvs()[vt as usize].as_vec2();
    for corner in carrier.faces().items() {
        let vertex = &mut vertices[corner.position as usize];
        if let Some(n) = corner.normal() {
            vertex.normal = carrier.normals()[n as usize].as_vec3();
        }
        if vertex.uv.is_none() {
            vertex.uv = corner.uv().map(uv);
        }
    }
    for &[v, vt] in dominant {
        vertices[v as usize].uv = Some(uv(vt));
    }
    vertices
}

/// The same for the mesh that was baked, whose own `vn` lines are not what it is displaced along: normals (#v) are
/// given.
pub fn source_vertices(source: &Obj, normals: &[Vec3], dominant: &[[Index; 2]], origin: DVec3) -> Vec<ShaderVertex> {
    let mut vertices = carrier_vertices(source, dominant, origin);
    for (vertex, normal) in vertices.iter_mut().zip(normals) {
        vertex.normal = *normal;
    }
    vertices
}

fn positions(obj: &Obj, origin: DVec3) -> Vec<ShaderVertex> {
    let vertex = |p: &DVec3| ShaderVertex { position: (*p - origin).as_vec3(), ..ShaderVertex::default() };
    obj.positions().iter().map(vertex).collect()
}

/// Displaced positions in the file's coordinates. #v×3, model units.
pub fn displaced(vertices: &[ShaderVertex], map: &Displacement, lambda: f32, origin: DVec3) -> Vec<DVec3> {
    vertices.par_iter().map(|v| v.displaced(map, lambda).as_dvec3() + origin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_far_meshes_are_recentred() {
        assert_eq!(origin([DVec3::splat(-1.0), DVec3::splat(3.0)]), DVec3::ZERO);
        let far = DVec3::new(500_000.0, 4_500_000.0, 250.0);
        assert_eq!(origin([far - 1.0, far + 1.0]), far);
    }
}
