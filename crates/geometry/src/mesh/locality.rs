//! Numbers of vertices and faces by which near ones are near in memory.
//!
//! Elizabeth Cuthill, James McKee. Reducing the bandwidth of sparse symmetric matrices. ACM National Conference 1969: vertices in the order
//! in which a search over the edges finds them.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;

/// A surface whose vertices and faces are numbered in the order in which a search over the edges finds them. It depends on the
/// numbers that they had, but not on how the surface lies in space.
pub(crate) struct Localised {
    pub(crate) surface: Surface,
    /// Index in the original surface of each vertex. #V
    pub(crate) originals: Vec<Index>,
}

impl Localised {
    /// Renumbers a surface. Each face keeps the order of its corners; those of the same lowest vertex keep their order.
    pub(crate) fn of(surface: &Surface) -> Self {
        let positions = surface.positions();
        let originals = found_over_edges(surface.topology());
        let mut new_of = vec![0; originals.len()];
        (0..).zip(&originals).for_each(|(new, &v)| new_of[v as usize] = new);
        let faces = surface.topology().faces();
        let lowest = |f: Index| faces.get(f).iter().map(|&v| new_of[v as usize]).min();
        let mut order: Vec<Index> = (0..faces.len() as Index).collect();
        order.sort_by_cached_key(|&f| lowest(f));
        let renumbered = |&f: &Index| faces.get(f).iter().map(|&v| new_of[v as usize]).collect::<Vec<_>>();
        let faces: Ragged<Index> = order.iter().map(renumbered).collect();
        let moved = originals.iter().map(|&v| positions[v as usize]).collect();
        Self { surface: Surface::new(Topology::new(originals.len(), faces), moved), originals }
    }

    /// Values of the vertices, in the order of the original surface. #V
    pub(crate) fn restored<T: Copy + Default>(&self, values: &[T]) -> Vec<T> {
        let mut restored = vec![T::default(); values.len()];
        self.originals.iter().zip(values).for_each(|(&v, value)| restored[v as usize] = *value);
        restored
    }
}

/// Vertices in the order in which a search over the edges finds them, component by component.
fn found_over_edges(topology: &Topology) -> Vec<Index> {
    let count = topology.vertex_count();
    let mut is_found = vec![false; count];
    let mut found: Vec<Index> = Vec::with_capacity(count);
    for start in 0..count as Index {
        if std::mem::replace(&mut is_found[start as usize], true) {
            continue;
        }
        let mut next = found.len();
        found.push(start);
        while next < found.len() {
            for &w in topology.rings().get(found[next]) {
                if !std::mem::replace(&mut is_found[w as usize], true) {
                    found.push(w);
                }
            }
            next += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use glam::DVec3;

    #[test]
    fn a_renumbered_surface_is_the_same_and_near_in_memory() {
        let grid = shapes::grid(32);
        // Numbers that jump: every other vertex from the end.
        let count = grid.positions().len() as Index;
        assert_eq!(count % 2, 1);
        let jump = |v: Index| if v.is_multiple_of(2) { v } else { count - 1 - v };
        let faces: Ragged<Index> =
            grid.topology().faces().iter().map(|f| f.iter().map(|&v| jump(v)).collect::<Vec<_>>()).collect();
        let mut positions = vec![DVec3::ZERO; count as usize];
        (0..count).for_each(|v| positions[jump(v) as usize] = grid.positions()[v as usize]);
        let scattered = Surface::new(Topology::new(count as usize, faces), positions);
        let localised = Localised::of(&scattered);
        let surface = &localised.surface;
        assert_eq!(localised.restored(surface.positions()), scattered.positions());
        let corners = |surface: &Surface| {
            let mut all: Vec<String> =
                surface.triangles().map(|t| format!("{:?}", t.map(|v| surface.positions()[v as usize]))).collect();
            all.sort();
            all
        };
        assert_eq!(corners(surface), corners(&scattered));
        let distance = |surface: &Surface| {
            let edges = surface.topology().edges();
            edges.iter().map(|[a, b]| f64::from(a.abs_diff(*b))).sum::<f64>() / edges.len() as f64
        };
        assert!(distance(surface) < 0.2 * distance(&scattered), "{} {}", distance(surface), distance(&scattered));
    }
}
