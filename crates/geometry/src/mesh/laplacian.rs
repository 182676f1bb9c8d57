//! Discrete Laplace operators, negative semi-definite: (L x)ᵢ points from xᵢ towards its neighbours.
//!
//! ```
//! use planish_geometry::mesh::{laplacian, shapes};
//!
//! // The energy −Σ ⟨pᵢ, (L p)ᵢ⟩ of the positions p of a surface is twice its area, and its masses are the area.
//! let sphere = shapes::dented_sphere(2);
//! let pulls = laplacian::cotangent(&sphere).times(sphere.positions());
//! let energy: f64 = pulls.iter().zip(sphere.positions()).map(|(pull, p)| -pull.dot(*p)).sum();
//! assert!((energy / (2.0 * sphere.area()) - 1.0).abs() < 1e-12);
//! assert!((laplacian::mass(&sphere).iter().sum::<f64>() / sphere.area() - 1.0).abs() < 1e-12);
//! ```

use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rayon::prelude::*;

/// Uniform Laplacian: the mean of the neighbours minus the vertex itself; zero at isolated vertices. #V×3
pub fn uniform(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    (0..positions.len() as Index).into_par_iter().map(|v| uniform_at(topology, positions, v)).collect()
}

/// Uniform Laplacian at one vertex.
pub(crate) fn uniform_at(topology: &Topology, positions: &[DVec3], v: Index) -> DVec3 {
    let ring = topology.rings().get(v);
    if ring.is_empty() {
        return DVec3::ZERO;
    }
    let p = positions[v as usize];
    // Differences first: far from the origin the sum of positions would round them away.
    ring.iter().map(|&n| positions[n as usize] - p).sum::<DVec3>() / ring.len() as f64
}

/// Cotangent matrix (Pinkall & Polthier 1993, eq. 4): wᵢⱼ = (cot αᵢⱼ + cot βᵢⱼ)/2 off the diagonal, −Σⱼ wᵢⱼ on it.
/// #V×#V, no unit. Polygons count as their triangles; triangles without area add nothing.
pub fn cotangent(surface: &Surface) -> Csr {
    let corner_terms = |t: [Index; 3]| {
        [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|[at, i, j]| {
            let [p, a, b] = [at, i, j].map(|k| surface.positions()[t[k] as usize]);
            let (a, b) = (a - p, b - p);
            let doubled_area = a.cross(b).length();
            let cotangent = if doubled_area > 0.0 { a.dot(b) / doubled_area } else { 0.0 };
            (t[i], t[j], cotangent / 2.0)
        })
    };
    let triplets =
        surface.triangles().flat_map(corner_terms).flat_map(|(i, j, w)| [(i, j, w), (j, i, w), (i, i, -w), (j, j, -w)]);
    Csr::from_triplets(surface.positions().len(), triplets)
}

/// Lumped mass: a third of the area of the triangles around a vertex (barycentric cells). #V, square model units.
pub fn mass(surface: &Surface) -> Vec<f64> {
    let mut mass = vec![0.0; surface.positions().len()];
    for t in surface.triangles() {
        let [a, b, c] = t.map(|v| surface.positions()[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        for v in t {
            mass[v as usize] += third;
        }
    }
    mass
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn constants_are_in_the_null_space_and_the_matrix_is_symmetric() {
        let matrix = cotangent(&shapes::dented_sphere(2));
        for (i, row) in (0..).zip(matrix.rows()) {
            assert!(row.iter().map(|e| e.1).sum::<f64>().abs() < 1e-13);
            for &(j, w) in row {
                let mirrored = matrix.row(j).iter().find(|e| e.0 == i).map(|e| e.1);
                // The same two terms, added in the order of the triangles on both sides.
                assert_eq!(mirrored, Some(w));
            }
        }
    }

    #[test]
    fn linear_functions_are_harmonic_on_a_plane() {
        let mut grid = shapes::grid(6);
        let skewed = grid.positions().iter().map(|p| DVec3::new(p.x + 0.2 * p.y * p.y, p.y + 0.1 * p.x, 0.0));
        grid = grid.at(skewed.collect());
        let lx = cotangent(&grid).times(grid.positions());
        for (v, lx) in (0..).zip(lx) {
            if !grid.topology().is_boundary(v) {
                assert!(lx.length() < 1e-14, "{lx}");
            }
        }
    }

    #[test]
    fn masses_add_up_to_the_area() {
        let sphere = shapes::dented_sphere(3);
        let gap = mass(&sphere).iter().sum::<f64>() - sphere.area();
        assert!(gap.abs() < 1e-12, "{gap:e}");
    }

    #[test]
    fn a_sphere_has_mean_curvature_one() {
        // L p = −2 H n · mass; at the scale of the mesh, first order in the distortion of the cells.
        let sphere = shapes::sphere(4);
        let lp = cotangent(&sphere).times(sphere.positions());
        let total: f64 = lp.iter().zip(sphere.positions()).map(|(l, p)| -l.dot(*p)).sum();
        assert!((total / (2.0 * sphere.area()) - 1.0).abs() < 1e-3, "{total}");
    }
}
