//! Signed distance to a surface, at points and on grids.
//!
//! Distances are exact; inside is where the surface winds more than half a time around the point, so that a scan with small holes has an
//! inside too. Across a hole the sign changes where the distance is not zero.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{shapes, signed_distance::SignedDistance};
//!
//! let cube = SignedDistance::new(&shapes::cube());
//! assert_eq!(cube.at(&[DVec3::splat(0.5), DVec3::new(0.5, 0.5, 3.0)]), [-0.5, 2.0]);
//! ```

use crate::mesh::surface::Surface;
use crate::mesh::triangle_tree::TriangleTree;
use crate::mesh::winding_number::WindingNumber;
use crate::progress::{Cancelled, Parts, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// Search trees of a surface that give signed distances.
#[derive(Clone, Debug)]
pub struct SignedDistance {
    triangles: TriangleTree,
    winding_number: WindingNumber,
}

/// Points of a grid along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Number of points along each axis.
    pub size: [u32; 3],
    /// The point with the least coordinates, model units.
    pub first: DVec3,
    /// Distance between neighbours, model units.
    pub step: f64,
}

impl SignedDistance {
    /// Builds the search trees of a surface.
    pub fn new(surface: &Surface) -> Self {
        Self {
            triangles: TriangleTree::new(surface.positions(), surface.triangles()),
            winding_number: WindingNumber::new(surface),
        }
    }

    /// Distance of each point (#P×3) to the surface, negative inside, whichever way the faces are turned; NaN without triangles.
    /// #P, model units
    pub fn at(&self, points: &[DVec3]) -> Vec<f64> {
        let mut distances = self.triangles.distances(points);
        distances.par_iter_mut().zip(points).for_each(|(distance, point)| {
            if self.winding_number.at(*point).abs() > 0.5 {
                *distance = -*distance;
            }
        });
        distances
    }

    /// Distances at the points of a grid, the first axis fastest, rounded to single precision.
    pub fn on_grid(&self, grid: Grid, progress: &dyn Progress) -> Result<Vec<f32>, Cancelled> {
        let [nx, ny, nz] = grid.size;
        let sheets = Parts::new(progress, nz as usize);
        let mut values = Vec::with_capacity(nx as usize * ny as usize * nz as usize);
        for z in 0..nz {
            let point = |(x, y)| grid.first + grid.step * DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            let points: Vec<DVec3> = (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y))).map(point).collect();
            let sheet = sheets.run(|| self.at(&points))?;
            values.extend(sheet.into_iter().map(|d| d as f32));
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::progress::Silent;

    const GRID: Grid = Grid { size: [13, 12, 11], first: DVec3::new(-1.53, -1.41, -1.37), step: 0.27 };

    fn points() -> Vec<DVec3> {
        let index = (0..11).flat_map(|z| (0..12).flat_map(move |y| (0..13).map(move |x| [x, y, z].map(f64::from))));
        index.map(|i| GRID.first + GRID.step * DVec3::from(i)).collect()
    }

    #[test]
    fn a_box_has_the_distances_of_its_formula() {
        let cells = shapes::gridded_box(7);
        let low_corner = DVec3::new(0.8, 1.1, 1.6);
        let cells = cells.at(cells.positions().iter().map(|p| *p - low_corner).collect());
        let found = SignedDistance::new(&cells).on_grid(GRID, &Silent).unwrap();
        let half = DVec3::new(0.5, 1.0, 1.5);
        for (p, found) in points().into_iter().zip(found) {
            let q = (p - (half - low_corner)).abs() - half;
            let expected = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
            assert!((f64::from(found) - expected).abs() < 1e-6, "{p}: {found} {expected}");
        }
    }

    #[test]
    fn a_sphere_has_the_distances_of_its_formula_whichever_way_it_is_turned_and_with_a_hole() {
        let sphere = shapes::sphere(4);
        let faces: Vec<Vec<u32>> = sphere.triangles().map(Vec::from).collect();
        let count = sphere.positions().len();
        let with = |faces: Vec<Vec<u32>>| {
            Surface::new(Topology::new(count, faces.into_iter().collect()), sphere.positions().to_vec())
        };
        let turned = with(faces.iter().map(|f| f.iter().rev().copied().collect()).collect());
        // Three of 5120 triangles.
        let holed = with([&faces[..100], &faces[101..900], &faces[902..]].concat());
        for surface in [&sphere, &turned, &holed] {
            let found = SignedDistance::new(surface).at(&points());
            for (p, found) in points().into_iter().zip(found) {
                // Chords of length 0.07 leave 6e-4 to the radius, and a hole as much as its width.
                assert!(
                    (found - (p.length() - 1.0)).abs() < if found.abs() < 0.1 { 0.05 } else { 0.01 },
                    "{p}: {found}"
                );
            }
        }
    }

    #[test]
    fn same_bits_on_any_number_of_threads_and_cancelled_when_asked() {
        let distance = SignedDistance::new(&shapes::dented_sphere(3));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| distance.on_grid(GRID, &Silent).unwrap())
        };
        assert_eq!(on(1), on(3));
        struct Never;
        impl Progress for Never {
            fn cancelled(&self) -> bool {
                true
            }
        }
        assert_eq!(distance.on_grid(GRID, &Never), Err(Cancelled));
    }
}
