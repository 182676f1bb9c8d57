//! Area and triangulation of one polygon in space.

use glam::{DVec2, DVec3};

/// Vector area of a polygon (Newell 1972): normal of its best plane, with twice its area as length.
pub fn newell(points: impl ExactSizeIterator<Item = DVec3> + Clone) -> DVec3 {
    let origin = points.clone().next().unwrap_or(DVec3::ZERO);
    let next = points.clone().cycle().skip(1);
    // Relative to the first point: far from the origin the products of coordinates would cancel.
    points.zip(next).fold(DVec3::ZERO, |sum, (a, b)| sum + (a - origin).cross(b - origin))
}

/// Cuts a polygon (n points) into n − 2 triangles of indices 0..n, which keep its orientation.
///
/// A convex polygon becomes a fan at its first corner, as in most readers. Any other is cut by ear clipping (Meisters 1975) in
/// the plane of the Newell normal, where the ear of the best shape goes first. A polygon that crosses itself may have no
/// valid ear left; it is cut all the same, and each of its corners is in a triangle.
pub fn triangulate(points: &[DVec3], mut emit: impl FnMut([usize; 3])) {
    if points.len() == 3 {
        return emit([0, 1, 2]);
    }
    let normal = newell(points.iter().copied());
    let (u, v) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    // `any_orthonormal_pair` promises no handedness of (u, v, n); counter-clockwise must stay so.
    let v = if u.cross(v).dot(normal) < 0.0 { -v } else { v };
    let flat: Vec<DVec2> = points.iter().map(|p| *p - points[0]).map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
    if is_convex(&flat) {
        return (2..points.len()).for_each(|k| emit([0, k - 1, k]));
    }
    let mut rest: Vec<usize> = (0..points.len()).collect();
    let mut quality: Vec<f64> = (0..rest.len()).map(|k| ear_quality(&flat, &rest, k)).collect();
    while rest.len() > 3 {
        let mut k = best(&quality);
        if quality[k] <= 0.0 {
            // Corners that were blocked by others may have become ears; ears stay ears.
            quality = (0..rest.len()).map(|k| ear_quality(&flat, &rest, k)).collect();
            k = best(&quality);
        }
        emit(ear_at(&rest, k));
        rest.remove(k);
        quality.remove(k);
        for j in [(k + rest.len() - 1) % rest.len(), k % rest.len()] {
            quality[j] = ear_quality(&flat, &rest, j);
        }
    }
    emit([rest[0], rest[1], rest[2]]);
}

/// Index of the largest value, the lowest among equals.
fn best(quality: &[f64]) -> usize {
    (0..quality.len()).rev().max_by(|&j, &k| quality[j].total_cmp(&quality[k])).unwrap_or(0)
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
fn doubled_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Returns true if all corners are convex and all triangles of the fan at the first corner counter-clockwise.
fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    (0..n).all(|k| doubled_area(flat[k], flat[(k + 1) % n], flat[(k + 2) % n]) > 0.0)
        && (2..n).all(|k| doubled_area(flat[0], flat[k - 1], flat[k]) > 0.0)
}

/// Corner `k` of the remaining polygon between its two neighbours.
fn ear_at(rest: &[usize], k: usize) -> [usize; 3] {
    let n = rest.len();
    [rest[(k + n - 1) % n], rest[k], rest[(k + 1) % n]]
}

/// Quality of the ear at `k`: area over the sum of squared edge lengths; negative if the corner is no ear.
fn ear_quality(flat: &[DVec2], rest: &[usize], k: usize) -> f64 {
    let ear = ear_at(rest, k);
    let [a, b, c] = ear.map(|i| flat[i]);
    let area = doubled_area(a, b, c);
    if area <= 0.0 {
        return -1.0;
    }
    let inside =
        |p: DVec2| doubled_area(a, b, p) >= 0.0 && doubled_area(b, c, p) >= 0.0 && doubled_area(c, a, p) >= 0.0;
    let is_elsewhere = |i: &&usize| !ear.contains(i) && ![a, b, c].contains(&flat[**i]);
    if rest.iter().filter(is_elsewhere).any(|&i| inside(flat[i])) {
        return -0.5;
    }
    area / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
        let lifted: Vec<_> = outline.iter().map(|p| DVec3::new(p[0], 5.0, -p[1])).collect();
        let mut out = Vec::new();
        triangulate(&lifted, |t| out.push(t));
        out
    }

    fn signed_areas(outline: &[[f64; 2]]) -> Vec<f64> {
        let at = |i: usize| DVec2::from(outline[i]);
        triangles(outline).iter().map(|&[a, b, c]| doubled_area(at(a), at(b), at(c)) / 2.0).collect()
    }

    #[test]
    fn a_convex_polygon_is_fanned() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        // The fan at the first corner would leave the polygon.
        let dart = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.5, 1.0]];
        let comb = [
            [0.0, 0.0],
            [7.0, 0.0],
            [7.0, 4.0],
            [6.0, 4.0],
            [6.0, 1.0],
            [4.0, 1.0],
            [4.0, 4.0],
            [3.0, 4.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        for (outline, area) in [(&dart[..], 0.5), (&comb[..], 16.0)] {
            let areas = signed_areas(outline);
            assert_eq!(areas.len(), outline.len() - 2);
            assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - area).abs() < 1e-12);
        }
    }

    #[test]
    fn corners_on_a_straight_edge_keep_their_triangle() {
        let edge = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let used: std::collections::BTreeSet<_> = triangles(&edge).into_iter().flatten().collect();
        assert_eq!(used.len(), 5);
        assert!(signed_areas(&edge).iter().all(|a| *a > 0.0));
    }

    #[test]
    fn nonsense_is_cut_up_too() {
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(triangles(&bow).len(), 2);
        assert_eq!(triangles(&[[0.0, 0.0]; 6]).len(), 4);
    }
}
