//! Mean curvature of a surface from the angles at its edges.
//!
//! David Cohen-Steiner, Jean-Marie Morvan. Restricted Delaunay triangulations and normal cycle. SCG 2003, section 4.
//!
//! ```
//! use planish_geometry::mesh::{curvature, laplacian, shapes};
//!
//! // The integral of the mean curvature over a sphere of radius r is 4πr.
//! let sphere = shapes::sphere(3);
//! let larger = sphere.at(sphere.positions().iter().map(|p| *p * 2.0).collect());
//! let parts = curvature::mean_curvature(&larger).into_iter().zip(laplacian::mass(&larger));
//! let integral: f64 = parts.map(|(curvature, area)| curvature * area).sum();
//! assert!((integral / (8.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
//! ```

use crate::mesh::jagged::Index;
use crate::mesh::normals::face_normals;
use crate::mesh::surface::Surface;
use crate::mesh::topology::EdgeKind;
use glam::DVec3;
use rayon::prelude::*;

/// Mean curvature H = (κ₁ + κ₂) / 2 at each vertex, one over model units: positive where the surface bulges outwards, negative in
/// cavities, 1/r on a sphere of radius r. It is 0 at vertices without a face. #V
///
/// An edge of length l at which the surface bends by the angle β has the integral ½ l β of H; half of it goes to each end. The
/// area of a vertex is a third of the triangles around it. Edges of the boundary and those of more than two faces do not bend.
pub fn mean_curvature(surface: &Surface) -> Vec<f64> {
    let topology = surface.topology();
    let normals = face_normals(surface);
    let integral = |(edge, ends): (Index, &[Index; 2])| match topology.edge_kind(edge) {
        EdgeKind::Interior => bend(surface, &normals, edge, *ends),
        _ => 0.0,
    };
    let integrals: Vec<f64> = (0..).zip(topology.edges()).map(integral).collect();
    let (mut sums, mut areas) = (vec![0.0; topology.vertex_count()], vec![0.0; topology.vertex_count()]);
    for (ends, integral) in topology.edges().iter().zip(integrals) {
        ends.iter().for_each(|&v| sums[v as usize] += integral / 2.0);
    }
    for t in surface.triangles() {
        let [a, b, c] = t.map(|v| surface.positions()[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        t.iter().for_each(|&v| areas[v as usize] += third);
    }
    let ratio = |(sum, area): (f64, f64)| if sum == 0.0 { 0.0 } else { sum / area };
    let finite = |h: f64| if h.is_finite() { h } else { 0.0 };
    sums.into_par_iter().zip(areas).map(|pair| finite(ratio(pair))).collect()
}

/// Integral of H over an edge between two faces: half its length times the angle between their unit normals (#F×3), positive where
/// the edge bulges.
fn bend(surface: &Surface, normals: &[DVec3], edge: Index, [from, to]: [Index; 2]) -> f64 {
    let topology = surface.topology();
    let &[first, second] = topology.edge_corners().get(edge) else { return 0.0 };
    let [n, m] = [first, second].map(|corner| normals[topology.face(corner) as usize]);
    let along = surface.positions()[to as usize] - surface.positions()[from as usize];
    // The first face runs along the edge in the direction of its own corner.
    let along = if topology.vertex(first) == from { along } else { -along };
    let length = along.length();
    if n == DVec3::ZERO || m == DVec3::ZERO || length == 0.0 {
        return 0.0;
    }
    0.5 * length * n.cross(m).dot(along / length).atan2(n.dot(m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_sphere_has_the_curvature_of_its_radius_and_turned_inside_out_the_opposite() {
        let sphere = shapes::sphere(4);
        let large = sphere.at(sphere.positions().iter().map(|p| 5.0 * *p).collect());
        let mirrored = sphere.at(sphere.positions().iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect());
        for (surface, expected) in [(sphere, 1.0), (large, 0.2), (mirrored, -1.0)] {
            let h = mean_curvature(&surface);
            let mean = h.iter().sum::<f64>() / h.len() as f64;
            assert!((mean / expected - 1.0).abs() < 0.01, "{mean} for {expected}");
            // Single vertices: their ring is no circle, where five instead of six triangles meet least of all.
            assert!(h.iter().all(|h| (h / expected - 1.0).abs() < 0.15));
        }
    }

    #[test]
    fn a_plane_is_flat_and_a_fold_holds_its_angle() {
        let plane = shapes::grid(6);
        assert!(mean_curvature(&plane).iter().all(|h| h.abs() < 1e-12));
        // A valley of 90° along x = ½: H integrates to −½ · length · π/2 over all of it.
        let valley = plane.at(plane.positions().iter().map(|p| p.with_z((p.x - 0.5).abs())).collect());
        let h = mean_curvature(&valley);
        let mut integral = 0.0;
        for t in valley.triangles() {
            let [a, b, c] = t.map(|v| valley.positions()[v as usize]);
            integral += (b - a).cross(c - a).length() / 6.0 * t.map(|v| h[v as usize]).iter().sum::<f64>();
        }
        assert!((integral + std::f64::consts::FRAC_PI_4).abs() < 1e-12, "{integral}");
    }
}
