//! Voxels: the surface of an occupancy grid, as segmented volume images have it.
//!
//! Nodes of a grid of step `step` ē with a random offset are inside or outside: a node is inside if the faces that a line along x
//! crosses before it turn around it more often one way than the other (winding number above 0). The surface between the two is
//! meshed by surface nets with zeros half-way, which leaves steps. The clean mesh has the nearest points of the true surface.

use super::surface_nets::{self, Grid};
use super::{RemeshError, Remeshed, lattice, pair, step};
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::mesh::synthetic_noise::layout_numbers;
use crate::mesh::synthetic_noise::settings::SyntheticNoise;
use crate::mesh::topology::EdgeKind;
use crate::mesh::triangle_tree::TriangleTree;
use glam::{DVec2, DVec3};
use rand::RngExt;

/// Mesh of an occupancy grid and its clean counterpart.
pub(super) fn remeshed(surface: &Surface, noise: &SyntheticNoise) -> Result<Remeshed, RemeshError> {
    let topology = surface.topology();
    if (0..topology.edges().len() as Index).any(|e| topology.edge_kind(e) == EdgeKind::Boundary) {
        return Err(RemeshError::Open);
    }
    let mut random = layout_numbers(noise.seed);
    let offset = DVec3::from_array([(); 3].map(|()| random.random::<f64>()));
    let grid = Grid::around(surface.bounds(), step(surface, noise)?, 1.0, offset)?;
    let (noisy, faces) = surface_nets::surface(&grid, &occupancy(surface, &grid));
    let clean = TriangleTree::new(surface.positions(), surface.triangles()).nearest(&noisy);
    pair(&clean, &noisy, &faces)
}

/// −1 at nodes inside of the surface, 1 at nodes outside.
fn occupancy(surface: &Surface, grid: &Grid) -> Vec<f32> {
    let scaled: Vec<DVec3> = surface.positions().iter().map(|p| (*p - grid.low) / grid.step).collect();
    // Crossings of the lines along x: position, and 1 where a line enters, −1 where it leaves.
    let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); grid.size[1] * grid.size[2]];
    for t in surface.triangles() {
        let corners = t.map(|v| scaled[v as usize]);
        let flat = corners.map(|p| DVec2::new(p.y, p.z));
        let enters = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]) < 0.0;
        lattice::scan(flat, t, |[j, k], weights| {
            let x = corners.iter().zip(weights).map(|(p, weight)| p.x * weight).sum();
            let line = [j, k].map(|x| usize::try_from(x).ok());
            if let [Some(j), Some(k)] = line
                && j < grid.size[1]
                && k < grid.size[2]
            {
                crossings[k * grid.size[1] + j].push((x, if enters { 1 } else { -1 }));
            }
        });
    }
    let mut values = Vec::with_capacity(grid.len());
    for mut line in crossings {
        line.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut line = line.into_iter().peekable();
        let mut winding = 0;
        for i in 0..grid.size[0] {
            while let Some((_, turn)) = line.next_if(|(x, _)| *x <= i as f64) {
                winding += turn;
            }
            values.push(if winding > 0 { -1.0 } else { 1.0 });
        }
    }
    values
}
