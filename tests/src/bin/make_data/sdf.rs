//! Signed distances of a few solids, ways to blend them, and what remeshing asks of a field.
//!
//! Inigo Quilez. Distance functions. <https://iquilezles.org/articles/distfunctions/>.
//!
//! Distances are negative inside. Only `+ − × ÷ √` are used, which IEEE 754 rounds the same way
//! on every machine: the meshes must come out equal bit for bit.

use glam::DVec3;

/// Step of the central differences that make gradients.
const GRADIENT_STEP: f64 = 1e-5;

pub(crate) fn sphere(p: DVec3, radius: f64) -> f64 {
    p.length() - radius
}

/// First-order distance to an ellipsoid: exact on the surface, too small far away.
pub(crate) fn ellipsoid(p: DVec3, radii: DVec3) -> f64 {
    let scaled = (p / radii).length();
    let slope = (p / (radii * radii)).length();
    // At the very centre both vanish; the distance there is the smallest radius.
    if slope < 1e-12 { -radii.min_element() } else { scaled * (scaled - 1.0) / slope }
}

/// Distance to the hull of two spheres.
pub(crate) fn round_cone(p: DVec3, [a, b]: [DVec3; 2], [radius_a, radius_b]: [f64; 2]) -> f64 {
    let axis = b - a;
    let length2 = axis.length_squared();
    let taper = radius_a - radius_b;
    let slant2 = length2 - taper * taper;
    let from_a = p - a;
    let y = from_a.dot(axis);
    let z = y - length2;
    let x2 = (from_a * length2 - axis * y).length_squared();
    let y2 = y * y * length2;
    let z2 = z * z * length2;
    let k = taper.signum() * taper * taper * x2;
    if z.signum() * slant2 * z2 > k {
        (x2 + z2).sqrt() / length2 - radius_b
    } else if y.signum() * slant2 * y2 < k {
        (x2 + y2).sqrt() / length2 - radius_a
    } else {
        ((x2 * slant2 / length2).sqrt() + y * taper) / length2 - radius_a
    }
}

/// Union whose crease is filled over a band of width `k`.
pub(crate) fn smooth_union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// `a` without `b`, the new edge rounded over a band of width `k`.
pub(crate) fn smooth_difference(a: f64, b: f64, k: f64) -> f64 {
    -smooth_union(-a, b, k)
}

/// Intersection whose edge is rounded over a band of width `k`.
pub(crate) fn smooth_intersection(a: f64, b: f64, k: f64) -> f64 {
    -smooth_union(-a, -b, k)
}

/// Gradient of a field by central differences.
pub(crate) fn gradient(field: &impl Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    let along = |axis: DVec3| {
        let step = axis * GRADIENT_STEP;
        (field(p + step) - field(p - step)) / (2.0 * GRADIENT_STEP)
    };
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

/// Nearby point of the zero set: Newton steps along the gradient, none longer than `reach`.
pub(crate) fn project(field: &impl Fn(DVec3) -> f64, mut p: DVec3, reach: f64) -> DVec3 {
    for _ in 0..6 {
        let slope = gradient(field, p);
        let step = -slope * (field(p) / slope.length_squared().max(1e-12));
        p += step.clamp_length_max(reach);
    }
    p
}

/// Largest absolute normal curvature of the level set through `p`, measured over ± `span`.
pub(crate) fn max_curvature(field: &impl Fn(DVec3) -> f64, p: DVec3, span: f64) -> f64 {
    let (s, t) = gradient(field, p).normalize_or(DVec3::Y).any_orthonormal_pair();
    let bend = |direction: DVec3| {
        let normal = |q| gradient(field, q).normalize_or_zero();
        let turn = normal(p + direction * span) - normal(p - direction * span);
        turn / (2.0 * span)
    };
    let (bend_s, bend_t) = (bend(s), bend(t));
    let (ss, st, tt) = (bend_s.dot(s), 0.5 * (bend_s.dot(t) + bend_t.dot(s)), bend_t.dot(t));
    let mean = 0.5 * (ss + tt);
    mean.abs() + (0.25 * (ss - tt) * (ss - tt) + st * st).sqrt()
}
