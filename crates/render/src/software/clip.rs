//! Clipping a triangle in homogeneous coordinates.
//!
//! Ivan E. Sutherland, Gary W. Hodgman. Reentrant polygon clipping. CACM 17(1), 1974.

use glam::Vec4;

/// Distance by which a triangle may reach outside the picture, in half widths; keeps the raster's integers small.
const GUARD: f32 = 16.0;

/// Planes of the clipped volume: a point inside has no negative product with any of them. The near plane comes first, then the guard band.
const PLANES: [Vec4; 5] = [
    Vec4::new(0.0, 0.0, 1.0, 0.0),
    Vec4::new(1.0, 0.0, 0.0, GUARD),
    Vec4::new(-1.0, 0.0, 0.0, GUARD),
    Vec4::new(0.0, 1.0, 0.0, GUARD),
    Vec4::new(0.0, -1.0, 0.0, GUARD),
];

/// A convex polygon; each plane adds at most one corner to a triangle.
#[derive(Clone, Copy)]
pub(super) struct Polygon {
    corners: [Vec4; 3 + PLANES.len()],
    len: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [Vec4::ZERO; 3 + PLANES.len()], len: 0 };

    fn push(&mut self, corner: Vec4) {
        self.corners[self.len] = corner;
        self.len += 1;
    }

    /// The triangles about its first corner.
    pub(super) fn fan(self) -> impl Iterator<Item = [Vec4; 3]> {
        (2..self.len).map(move |i| [self.corners[0], self.corners[i - 1], self.corners[i]])
    }
}

/// The part of a triangle that can be drawn; nothing if a corner is not finite.
pub(super) fn clip(triangle: [Vec4; 3]) -> Polygon {
    let mut polygon = Polygon::EMPTY;
    if triangle.iter().all(|corner| corner.is_finite()) {
        triangle.into_iter().for_each(|corner| polygon.push(corner));
    }
    PLANES.into_iter().fold(polygon, cut)
}

fn cut(polygon: Polygon, plane: Vec4) -> Polygon {
    let corners = &polygon.corners[..polygon.len];
    if corners.iter().all(|corner| corner.dot(plane) >= 0.0) {
        return polygon;
    }
    let mut inside = Polygon::EMPTY;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (height_a, height_b) = (a.dot(plane), b.dot(plane));
        if height_a >= 0.0 {
            inside.push(a);
        }
        // Always from the inside out: both neighbours of an edge get the same point.
        if height_a >= 0.0 && height_b < 0.0 {
            inside.push(a.lerp(b, height_a / (height_a - height_b)));
        } else if height_a < 0.0 && height_b >= 0.0 {
            inside.push(b.lerp(a, height_b / (height_b - height_a)));
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: Vec4 = Vec4::new(0.1, 0.2, 0.5, 1.0);
    const BEHIND: Vec4 = Vec4::new(0.3, -0.1, -0.7, -0.6);
    const ASIDE: Vec4 = Vec4::new(-90.0, 0.0, 0.4, 1.0);

    #[test]
    fn all_that_is_left_is_inside() {
        for triangle in [
            [INSIDE, BEHIND, ASIDE],
            [BEHIND, BEHIND + Vec4::X, ASIDE],
            [ASIDE, -ASIDE, INSIDE],
            [Vec4::new(80.0, 90.0, 0.3, 1.0), Vec4::new(-80.0, 90.0, 0.2, 2.0), Vec4::new(0.0, -99.0, 0.1, 1.0)],
        ] {
            let polygon = clip(triangle);
            for corner in &polygon.corners[..polygon.len] {
                assert!(PLANES.iter().all(|plane| corner.dot(*plane) > -1e-5), "{corner}");
            }
        }
    }

    #[test]
    fn nothing_is_left_of_what_is_behind_or_not_a_number() {
        assert_eq!(clip([BEHIND; 3]).fan().count(), 0);
        assert_eq!(clip([INSIDE, Vec4::NAN, ASIDE]).fan().count(), 0);
    }

    #[test]
    fn neighbours_are_cut_at_the_same_point() {
        let on_edge = |triangle| {
            let polygon = clip(triangle);
            let corners = &polygon.corners[..polygon.len];
            corners.iter().map(|c| c.to_array().map(f32::to_bits)).collect::<Vec<_>>()
        };
        let (left, right) = (on_edge([INSIDE, BEHIND, INSIDE - Vec4::X]), on_edge([BEHIND, INSIDE, INSIDE + Vec4::X]));
        let shared = left.iter().filter(|corner| right.contains(corner)).count();
        assert_eq!(shared, 2);
    }
}
