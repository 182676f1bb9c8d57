//! How often a surface winds around a point: 1 inside a closed surface that faces outwards, 0 outside, and something between where it has
//! holes.
//!
//! Alec Jacobson, Ladislav Kavan, Olga Sorkine-Hornung. Robust inside-outside segmentation using generalized winding numbers. TOG 32(4),
//! 2013. Gavin Barill, Neil G. Dickson, Ryan Schmidt, David I. W. Levin, Alec Jacobson. Fast winding numbers for soups and clouds.
//! TOG 37(4), 2018.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{shapes, winding_number::WindingNumber};
//!
//! let cube = WindingNumber::new(&shapes::cube());
//! assert!((cube.at(DVec3::splat(0.5)) - 1.0).abs() < 1e-9);
//! assert!(cube.at(DVec3::new(0.5, 0.5, 3.0)).abs() < 0.01);
//! ```

use crate::mesh::surface::Surface;
use glam::DVec3;
use std::f64::consts::TAU;

/// Triangles of a leaf at most.
const LEAF: usize = 8;

/// Distance in radii of a cluster of triangles from which it is taken for a single dipole.
const FAR: f64 = 3.0;

/// Hierarchy of the triangles of a surface, which gives winding numbers at any point.
#[derive(Clone, Debug)]
pub struct WindingNumber {
    /// Corners of the triangles, in the order of the leaves. #T
    triangles: Vec<[DVec3; 3]>,
    /// Clusters; the first one holds all triangles, and the children of a cluster come after it.
    clusters: Vec<Cluster>,
}

#[derive(Clone, Debug)]
struct Cluster {
    /// Middle of the triangles, by their areas.
    centre: DVec3,
    /// Distance of the furthest corner from the middle.
    radius: f64,
    /// Sum of the areas times the unit normals.
    area_vector: DVec3,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    /// Range of triangles.
    Leaf(usize, usize),
    /// Indices of clusters.
    Children([usize; 2]),
}

impl WindingNumber {
    /// Builds the hierarchy of all triangles of a surface.
    pub fn new(surface: &Surface) -> Self {
        let corners = surface.triangles().map(|t| t.map(|v| surface.positions()[v as usize]));
        let mut tree = Self { triangles: corners.collect(), clusters: Vec::new() };
        if !tree.triangles.is_empty() {
            tree.build(0, tree.triangles.len());
        }
        tree
    }

    /// Adds the cluster of a range of triangles, which it sorts, and returns its index.
    fn build(&mut self, start: usize, end: usize) -> usize {
        let triangles = &mut self.triangles[start..end];
        let (mut area_vector, mut weighted, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for t in triangles.iter() {
            let vector = (t[1] - t[0]).cross(t[2] - t[0]) / 2.0;
            area_vector += vector;
            // From one of the corners, so that coordinates far from the origin lose nothing.
            weighted += vector.length() * (middle(t) - t[0] + (t[0] - triangles[0][0]));
            total += vector.length();
            (low, high) = (low.min(middle(t)), high.max(middle(t)));
        }
        let centre = triangles[0][0] + if total > 0.0 { weighted / total } else { DVec3::ZERO };
        let radius = triangles.iter().flatten().map(|p| p.distance(centre)).fold(0.0, f64::max);
        let index = self.clusters.len();
        self.clusters.push(Cluster { centre, radius, area_vector, content: Content::Leaf(start, end) });
        if end - start > LEAF {
            let extent = high - low;
            let axis = if extent.max_element() == extent.x { 0 } else { 1 + usize::from(extent.z > extent.y) };
            // A stable order, for the same bits everywhere.
            self.triangles[start..end].sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
            let half = start.midpoint(end);
            let children = [self.build(start, half), self.build(half, end)];
            self.clusters[index].content = Content::Children(children);
        }
        index
    }

    /// Winding number of the surface around a point (model units).
    pub fn at(&self, point: DVec3) -> f64 {
        if self.clusters.is_empty() {
            return 0.0;
        }
        let (mut twice_turns, mut open) = (0.0, vec![0]);
        while let Some(i) = open.pop() {
            let Cluster { centre, radius, area_vector, content } = &self.clusters[i];
            let offset = *centre - point;
            let distance = offset.length();
            if distance > FAR * radius {
                twice_turns += offset.dot(*area_vector) / (distance * distance * distance * TAU);
                continue;
            }
            match content {
                Content::Leaf(start, end) => {
                    let angles = self.triangles[*start..*end].iter().map(|t| half_solid_angle(t.map(|p| p - point)));
                    twice_turns += angles.sum::<f64>() * 2.0 / TAU;
                }
                Content::Children(children) => open.extend(children),
            }
        }
        twice_turns / 2.0
    }
}

fn middle([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// Half of the solid angle of a triangle seen from the origin, positive where it faces away.
///
/// Adriaan van Oosterom, Jan Strackee. The solid angle of a plane triangle. IEEE TBME 30(2), 1983.
fn half_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    a.dot(b.cross(c)).atan2(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn exact(surface: &Surface, point: DVec3) -> f64 {
        let corners = surface.triangles().map(|t| t.map(|v| surface.positions()[v as usize] - point));
        corners.map(half_solid_angle).sum::<f64>() * 2.0 / (2.0 * TAU)
    }

    fn points() -> impl Iterator<Item = DVec3> {
        (0..300).map(|i| {
            let k = f64::from(i);
            DVec3::new((k * 0.37).sin(), (k * 0.71).cos(), (k * 0.19).sin()) * 1.4
        })
    }

    #[test]
    fn closed_surfaces_are_wound_once_around_their_inside() {
        let sphere = shapes::sphere(4);
        let tree = WindingNumber::new(&sphere);
        for p in points().filter(|p| (p.length() - 1.0).abs() > 0.01) {
            let expected = if p.length() < 1.0 { 1.0 } else { 0.0 };
            assert!((exact(&sphere, p) - expected).abs() < 1e-9, "{p}");
            assert!((tree.at(p) - expected).abs() < 0.02, "{p}: {}", tree.at(p));
        }
    }

    #[test]
    fn dipoles_are_near_the_exact_number_of_an_open_surface_far_from_the_origin() {
        let sheet = shapes::bumpy_sheet(40);
        let moved = sheet.at(sheet.positions().iter().map(|p| *p + 1e6).collect());
        let (tree, far) = (WindingNumber::new(&sheet), WindingNumber::new(&moved));
        for p in points() {
            let expected = exact(&sheet, p);
            for found in [tree.at(p), far.at(p + 1e6)] {
                assert!((found - expected).abs() < 0.01, "{p}: {found} {expected}");
            }
        }
    }
}
