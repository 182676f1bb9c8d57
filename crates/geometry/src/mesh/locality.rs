//! Numbers of vertices and faces by which near ones are near in memory.
//!
//! Guy M. Morton. A computer oriented geodetic data base and a new technique in file sequencing. IBM, 1966: cells of a grid in the
//! order of their interleaved coordinates.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;

/// A surface whose vertices and faces are numbered along a curve that fills its bounding box.
pub(crate) struct Localised {
    pub(crate) surface: Surface,
    /// Index in the original surface of each vertex. #V
    originals: Vec<Index>,
}

impl Localised {
    /// Renumbers a surface. Each face keeps the order of its corners; those of the same lowest vertex keep their order.
    pub(crate) fn of(surface: &Surface) -> Self {
        let positions = surface.positions();
        let codes = codes(positions);
        let mut originals: Vec<Index> = (0..positions.len() as Index).collect();
        originals.sort_by_key(|&v| codes[v as usize]);
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

/// Morton codes of points, in a grid of 2²¹ cells along the longest side of their bounding box.
fn codes(points: &[DVec3]) -> Vec<u64> {
    let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let longest = (high - low).max_element();
    let scale = if longest > 0.0 { f64::from((1 << 21) - 1) / longest } else { 0.0 };
    let code = |p: &DVec3| {
        let [x, y, z] = ((*p - low) * scale).to_array().map(|x| spread(x as u64));
        x | y << 1 | z << 2
    };
    points.iter().map(code).collect()
}

/// Moves bit k of 21 bits to bit 3k.
fn spread(x: u64) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    STEPS.iter().fold(x, |x, (shift, mask)| (x | x << shift) & mask)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn bits_are_spread_by_three() {
        for x in [0, 1, 0b1011, 0x1f_ffff, 0x15_5555] {
            let slow = (0..21).map(|k| (x >> k & 1) << (3 * k)).sum::<u64>();
            assert_eq!(spread(x), slow);
        }
    }

    #[test]
    fn a_renumbered_surface_is_the_same_and_near_in_memory() {
        let grid = shapes::grid(32);
        // Numbers that jump: every other vertex from the end.
        let count = grid.positions().len() as Index;
        assert_eq!(count % 2, 1);
        let jump = |v: Index| if v % 2 == 0 { v } else { count - 1 - v };
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
