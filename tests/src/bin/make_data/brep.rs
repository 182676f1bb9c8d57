//! A solid built from its boundary: points, curves between them, faces inside loops of curves.
//!
//! A curve is sampled once and shared by the two faces that meet there, which makes the mesh
//! closed by construction and puts its vertices exactly onto the sharp edges.

use crate::chart::Chart;
use crate::developable::Developable;
use crate::planar_mesh::fill;
use glam::{DVec2, DVec3};
use spade::InsertionError;
use std::collections::BTreeMap;

/// Vertices along a curve, both ends included.
pub(crate) type Curve = Vec<usize>;

/// A boundary representation that is meshed face by face; each face becomes a chart.
#[derive(Debug)]
pub(crate) struct Brep {
    edge_length: f64,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) charts: Vec<Chart>,
}

impl Brep {
    pub(crate) fn new(edge_length: f64) -> Self {
        Self { edge_length, positions: Vec::new(), charts: Vec::new() }
    }

    pub(crate) fn point(&mut self, x: f64, y: f64, z: f64) -> usize {
        self.positions.push(DVec3::new(x, y, z));
        self.positions.len() - 1
    }

    pub(crate) fn line(&mut self, from: usize, to: usize) -> Curve {
        let [a, b] = [from, to].map(|v| self.positions[v]);
        self.curve(from, to, a.distance(b), |t| a.lerp(b, t))
    }

    /// Counter-clockwise arc, seen from above, around a vertical axis.
    pub(crate) fn arc(&mut self, centre: DVec2, from: usize, to: usize) -> Curve {
        let [a, b] = [from, to].map(|v| self.positions[v].truncate() - centre);
        let angle = a.perp_dot(b).atan2(a.dot(b)).rem_euclid(std::f64::consts::TAU);
        let z = self.positions[from].z;
        self.curve(from, to, angle * a.length(), |t| (centre + DVec2::from_angle(angle * t).rotate(a)).extend(z))
    }

    /// Curve `place`(0..1) of the given length, sampled at about the edge length.
    pub(crate) fn curve(&mut self, from: usize, to: usize, length: f64, place: impl Fn(f64) -> DVec3) -> Curve {
        let pieces = (length / self.edge_length).round().max(1.0) as usize;
        let first = self.positions.len();
        self.positions.extend((1..pieces).map(|k| place(k as f64 / pieces as f64)));
        let inner = first..self.positions.len();
        std::iter::once(from).chain(inner).chain(std::iter::once(to)).collect()
    }

    /// Circle cut into arcs at the given directions, which run counter-clockwise.
    pub(crate) fn ring(&mut self, centre: DVec2, radius: f64, z: f64, cuts: &[DVec2]) -> Vec<Curve> {
        let point = |cut: &DVec2| (centre + *cut * radius).extend(z);
        let first = self.positions.len();
        self.positions.extend(cuts.iter().map(point));
        let n = cuts.len();
        (0..n).map(|k| self.arc(centre, first + k, first + (k + 1) % n)).collect()
    }

    /// Round wall between two rings with the same cuts; `surface` knows the direction to the
    /// middle of each piece.
    pub(crate) fn wall(
        &mut self,
        group: usize,
        [low, high]: [&[Curve]; 2],
        surfaces: &[Developable],
    ) -> Result<(), InsertionError> {
        let seams: Vec<Curve> = low.iter().zip(high).map(|(low, high)| self.line(low[0], high[0])).collect();
        for (k, surface) in surfaces.iter().enumerate() {
            let boundary = [&low[k], &seams[(k + 1) % seams.len()], &high[k], &seams[k]];
            self.face(group, surface, &[&boundary])?;
        }
        Ok(())
    }

    /// Meshes the part of a surface inside loops of curves; each curve starts where the one before
    /// it ends, either way round.
    pub(crate) fn face(
        &mut self,
        group: usize,
        surface: &Developable,
        loops: &[&[&Curve]],
    ) -> Result<(), InsertionError> {
        let loops: Vec<Curve> = loops.iter().map(|curves| join(curves)).collect();
        let flat = |&v: &usize| surface.flatten(self.positions[v]);
        let flat_loops: Vec<Vec<DVec2>> = loops.iter().map(|vertices| vertices.iter().map(flat).collect()).collect();
        let filling = fill(&flat_loops, self.edge_length)?;
        let first = self.positions.len();
        self.positions.extend(filling.inner.iter().map(|&p| surface.lift(p)));
        let vertices = loops.into_iter().flatten().chain(first..self.positions.len()).collect();
        let uvs = flat_loops.into_iter().flatten().chain(filling.inner).collect();
        self.charts.push(Chart { group, vertices, uvs, triangles: filling.triangles });
        Ok(())
    }
}

/// One closed loop, without repeating its first vertex.
fn join(curves: &[&Curve]) -> Curve {
    let mut ends: BTreeMap<usize, usize> = BTreeMap::new();
    for curve in curves {
        for end in [curve[0], curve[curve.len() - 1]] {
            *ends.entry(end).or_default() += 1;
        }
    }
    assert!(ends.values().all(|&uses| uses == 2), "curves that do not close a loop");
    let [first, last] = [curves[0][0], curves[0][curves[0].len() - 1]];
    let next = curves[1 % curves.len()];
    let ends_at_next = |v: usize| next[0] == v || next[next.len() - 1] == v;
    // Two curves share both ends: either way round will do.
    let mut at = if ends_at_next(last) { first } else { last };
    let mut joined = Vec::new();
    for curve in curves {
        if curve[0] == at {
            joined.extend(&curve[..curve.len() - 1]);
            at = curve[curve.len() - 1];
        } else {
            joined.extend(curve[1..].iter().rev());
            at = curve[0];
        }
    }
    joined
}
