//! Rays against a surface.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{ray_tree::RayTree, shapes};
//!
//! // From above, the first that a ray into the unit cube meets is its top.
//! let tree = RayTree::new(&shapes::cube());
//! let hit = tree.first_hit(DVec3::new(0.2, 0.7, 5.0), DVec3::NEG_Z).unwrap();
//! assert!((hit.point - DVec3::new(0.2, 0.7, 1.0)).length() < 1e-6);
//! assert_eq!(hit.normal, DVec3::Z);
//! ```

use crate::mesh::surface::Surface;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::fmt;
use std::time::Duration;

/// Bounding-volume hierarchy of triangles, which tells whether a ray meets one, and where.
///
/// Triangles are kept in single precision, in a box about the origin whose longest half side is 1. The nodes are not compressed: those of
/// eight children round, and pass over what is nearer than 1e-4 to the start of a ray.
pub struct RayTree {
    /// Hierarchy over the triangles; `None` without any.
    tree: Option<Bvh2>,
    /// Triangles in the order of the hierarchy.
    triangles: Vec<RtTriangle>,
    /// Unit normal of each triangle, in the same order; zero where it has no area.
    normals: Vec<Vec3A>,
    /// Centre of the bounding box, model units.
    centre: DVec3,
    /// Length of a model unit in the box.
    scale: f64,
}

/// Point at which a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Point on the surface, model units.
    pub point: DVec3,
    /// Unit normal of the triangle, by the order of its corners; zero if it has no area.
    pub normal: DVec3,
}

/// Distance by which a ray starts above its surface, in a box of half side 1, so that rounding to single precision (6e-8) never makes it
/// meet the triangle that it starts on.
const LIFT: f64 = 4e-6;

impl fmt::Debug for RayTree {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("RayTree").field("triangles", &self.triangles.len()).finish_non_exhaustive()
    }
}

impl RayTree {
    /// Builds the hierarchy of all triangles of a surface, in an order that depends on their positions alone.
    pub fn new(surface: &Surface) -> Self {
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
            return Self { tree: None, triangles: Vec::new(), normals: Vec::new(), centre, scale };
        }
        let tree = build_bvh2_from_tris(&all, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&i| RtTriangle::from(&all[i as usize])).collect();
        let normal = |&i: &u32| all[i as usize].compute_normal();
        let normals = tree.primitive_indices.iter().map(normal).collect();
        Self { tree: Some(tree), triangles, normals, centre, scale }
    }

    /// Returns the first point at which a ray from any point (model units) into a unit direction meets a triangle, from either side;
    /// `None` if it meets none. The point is as exact as single precision in the box of the surface.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let tree = self.tree.as_ref()?;
        // A start far away would take up the digits: the ray begins where it is nearest to the centre, less what the box can reach.
        let to_centre = (self.centre - origin).dot(direction);
        let skipped = (to_centre - 2.0 / self.scale).max(0.0);
        let start = ((origin + direction * skipped - self.centre) * self.scale).as_vec3();
        let single = direction.as_vec3();
        if !start.is_finite() || !single.is_finite() {
            return None;
        }
        let ray = Ray::new(start.into(), single.into(), 0.0, f32::INFINITY);
        let mut hit = RayHit::none();
        tree.ray_traverse(ray, &mut hit, |ray, i| self.triangles[i].intersect(ray)).then(|| Hit {
            point: origin + direction * (skipped + f64::from(hit.t) / self.scale),
            normal: self.normals[hit.primitive_id as usize].as_dvec3(),
        })
    }

    /// Returns true if a ray from a point of the surface (model units) into a unit direction meets a triangle within a distance
    /// (model units, may be infinite), from either side. It starts a little above the point, along the unit normal of the face.
    pub fn meets(&self, point: DVec3, normal: DVec3, direction: DVec3, distance: f64) -> bool {
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
    fn the_first_triangle_in_the_way_is_hit_from_near_and_far() {
        let cube = shapes::cube();
        let cube = cube.at(cube.positions().iter().map(|p| 3.0 * *p + 1e6).collect());
        let tree = RayTree::new(&cube);
        let towards = DVec3::new(0.3, -0.2, -1.0).normalize();
        let top = DVec3::new(1.0, 2.0, 3.0) + 1e6;
        for distance in [0.01, 1.0, 1e3, 1e6] {
            let hit = tree.first_hit(top - distance * towards, towards).unwrap();
            assert!((hit.point - top).length() < 1e-5, "{distance}: {hit:?}");
            assert_eq!(hit.normal, DVec3::Z);
        }
        let inside = tree.first_hit(top + towards, towards).unwrap();
        assert!(inside.point.z < 1e6 + 1e-5 && inside.normal == DVec3::NEG_Z, "{inside:?}");
        assert_eq!(tree.first_hit(top - towards, -towards), None, "it lies behind");
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
