//! Rays against a surface.

use crate::mesh::surface::Surface;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::Ray;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::time::Duration;

/// Bounding-volume hierarchy of triangles, which tells whether a ray meets one.
///
/// Triangles are kept in single precision, in a box about the origin whose longest half side is 1. The nodes are not compressed: those of
/// eight children round, and pass over what is nearer than 1e-4 to the start of a ray.
pub(crate) struct RayTree {
    /// Hierarchy over the triangles; `None` without any.
    tree: Option<Bvh2>,
    /// Triangles in the order of the hierarchy.
    triangles: Vec<RtTriangle>,
    /// Centre of the bounding box, model units.
    centre: DVec3,
    /// Length of a model unit in the box.
    scale: f64,
}

/// Distance by which a ray starts above its surface, in a box of half side 1, so that rounding to single precision (6e-8) never makes it
/// meet the triangle that it starts on.
const LIFT: f64 = 4e-6;

impl RayTree {
    /// Builds the hierarchy of all triangles of a surface, in an order that depends on their positions alone.
    pub(crate) fn new(surface: &Surface) -> Self {
        let [low, high] = surface.bounds();
        let half = (high - low).max_element() / 2.0;
        let (centre, scale) =
            if half > 0.0 && half.is_finite() { ((low + high) / 2.0, 1.0 / half) } else { (low, 1.0) };
        let in_box = |v| Vec3A::from(((surface.positions()[v as usize] - centre) * scale).as_vec3());
        let all: Vec<Triangle> = surface
            .triangles()
            .map(|t| {
                let [v0, v1, v2] = t.map(in_box);
                Triangle { v0, v1, v2 }
            })
            .filter(|t| t.v0.is_finite() && t.v1.is_finite() && t.v2.is_finite())
            .collect();
        if all.is_empty() {
            return Self { tree: None, triangles: Vec::new(), centre, scale };
        }
        let tree = build_bvh2_from_tris(&all, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&i| RtTriangle::from(&all[i as usize])).collect();
        Self { tree: Some(tree), triangles, centre, scale }
    }

    /// Returns true if a ray from a point of the surface (model units) into a unit direction meets a triangle within a distance
    /// (model units, may be infinite), from either side. It starts a little above the point, along the unit normal of the face.
    pub(crate) fn meets(&self, point: DVec3, normal: DVec3, direction: DVec3, distance: f64) -> bool {
        let Some(tree) = &self.tree else { return false };
        let origin = ((point - self.centre) * self.scale + normal * LIFT).as_vec3();
        let direction = direction.as_vec3();
        if !origin.is_finite() || !direction.is_finite() {
            return false;
        }
        let ray = Ray::new(origin.into(), direction.into(), 0.0, (distance * self.scale) as f32);
        !tree.ray_traverse_miss(ray, |ray, i| self.triangles[i].intersect(ray))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    #[test]
    fn rays_meet_what_is_in_their_way_and_near_enough() {
        let shifted = shapes::cube();
        let cube = shifted.at(shifted.positions().iter().map(|p| 3.0 * *p + 1e6).collect());
        let tree = RayTree::new(&cube);
        let floor = DVec3::new(1.0, 1.3, 0.0) + 1e6;
        for (distance, expected) in [(f64::INFINITY, true), (3.1, true), (2.9, false), (0.0, false)] {
            assert_eq!(tree.meets(floor, DVec3::Z, DVec3::Z, distance), expected, "{distance}");
        }
        assert!(!tree.meets(floor, DVec3::NEG_Z, DVec3::NEG_Z, f64::INFINITY), "nothing lies outside");
    }

    #[test]
    fn a_flat_face_right_above_the_start_is_met() {
        let below_the_top = DVec3::new(0.4, 0.6, 1.0 - 2e-5);
        assert!(RayTree::new(&shapes::cube()).meets(below_the_top, DVec3::Z, DVec3::Z, f64::INFINITY));
    }

    #[test]
    fn no_surface_is_met_by_nothing() {
        let none = Surface::new(Topology::new(2, Vec::new().into_iter().collect()), vec![DVec3::ZERO, DVec3::ONE]);
        assert!(!RayTree::new(&none).meets(DVec3::ZERO, DVec3::Z, DVec3::Z, f64::INFINITY));
        let single = shapes::grid(1);
        let point = single.at(vec![DVec3::ONE; single.positions().len()]);
        assert!(!RayTree::new(&point).meets(DVec3::ZERO, DVec3::Z, DVec3::Z, f64::INFINITY));
    }
}
