//! A rubber duck as a signed distance field: broad smooth regions, and small features that a
//! denoiser must not lose: bill, eyes, wing feathers, tail, a tuft on the head.
//!
//! y is up, the duck looks along +z, its length is about 2. The head is turned a little, since a
//! perfectly symmetric scan would be suspicious.

use crate::sdf::{ellipsoid, round_cone, smooth_difference, smooth_intersection, smooth_union, sphere};
use glam::{DMat3, DVec3, dvec3};

/// The box that holds the duck.
pub(crate) const BOUNDS: [DVec3; 2] = [dvec3(-1.1, -0.75, -1.5), dvec3(1.1, 1.85, 1.4)];

/// What a point of the duck is made of; indices into [`parts`].
pub(crate) const PART_NAMES: [&str; 3] = ["body", "bill", "eyes"];

/// Signed distance to the whole duck.
pub(crate) fn distance(p: DVec3) -> f64 {
    let [body, bill, eyes] = parts(p);
    smooth_union(smooth_union(body, bill, 0.06), eyes, 0.03)
}

/// Signed distances to body, bill and eyes. A surface point belongs to the nearest.
pub(crate) fn parts(p: DVec3) -> [f64; 3] {
    let head = head_from_world(p);
    let mirrored_head = dvec3(head.x.abs(), head.y, head.z);
    let torso = torso(p);
    let body = smooth_union(torso, skull(head, mirrored_head), 0.22);
    [body, bill(head, mirrored_head), eye(mirrored_head)]
}

/// Turned to its left by the angle of the 7-24-25 triangle, which needs no sine.
fn head_from_world(p: DVec3) -> DVec3 {
    let (cos, sin) = (24.0 / 25.0, 7.0 / 25.0);
    let q = p - dvec3(0.0, 0.98, 0.42);
    dvec3(cos * q.x - sin * q.z, q.y, sin * q.x + cos * q.z)
}

fn torso(p: DVec3) -> f64 {
    let q = dvec3(p.x.abs(), p.y, p.z);
    let hull = ellipsoid(q - dvec3(0.0, 0.0, -0.08), dvec3(0.72, 0.56, 0.92));
    let breast = sphere(q - dvec3(0.0, 0.08, 0.32), 0.58);
    let body = smooth_union(hull, breast, 0.25);
    let body = smooth_union(body, tail(q), 0.16);
    let flat_bottom = -(q.y + 0.46);
    let body = smooth_intersection(body, flat_bottom, 0.12);
    smooth_union(body, wing(q), 0.06)
}

/// Three feathers, the middle one longest, turned up.
fn tail(q: DVec3) -> f64 {
    let root = round_cone(q, [dvec3(0.0, 0.05, -0.6), dvec3(0.0, 0.36, -1.05)], [0.34, 0.15]);
    let middle = feather(q, dvec3(0.0, 0.42, -1.06), dvec3(0.0, 0.6, -0.8), 0.3, 0.12);
    let side = feather(q, dvec3(0.13, 0.37, -1.0), dvec3(0.22, 0.56, -0.8), 0.26, 0.1);
    smooth_union(root, smooth_union(middle, side, 0.03), 0.08)
}

/// A flat ellipsoid that points along `along`, its broad side turned up.
fn feather(q: DVec3, centre: DVec3, along: DVec3, length: f64, width: f64) -> f64 {
    let z = along.normalize();
    let x = DVec3::Y.cross(z).normalize();
    let local = DMat3::from_cols(x, z.cross(x), z).transpose() * (q - centre);
    ellipsoid(local, dvec3(width, 0.1, length))
}

/// Three feathers in a fan, one over the other, lifted off the body at their tips.
fn wing(q: DVec3) -> f64 {
    let shoulder = ellipsoid(q - dvec3(0.6, 0.18, 0.16), dvec3(0.14, 0.24, 0.3));
    let blade = |tip: DVec3, width: f64| {
        let root = dvec3(0.62, 0.16, 0.2);
        let z = (root - tip).normalize();
        let x = dvec3(1.0, 0.0, 0.35).cross(z).normalize();
        let y = z.cross(x);
        let local = DMat3::from_cols(x, y, z).transpose() * (q - root.midpoint(tip));
        ellipsoid(local, dvec3(width, 0.11, 0.5 * root.distance(tip) + 0.1))
    };
    let top = blade(dvec3(0.77, 0.42, -0.68), 0.15);
    let middle = blade(dvec3(0.78, 0.2, -0.62), 0.14);
    let low = blade(dvec3(0.77, 0.0, -0.48), 0.13);
    let fan = smooth_union(smooth_union(top, middle, 0.035), low, 0.035);
    smooth_union(shoulder, fan, 0.1)
}

fn skull(head: DVec3, mirrored: DVec3) -> f64 {
    let ball = ellipsoid(head, dvec3(0.48, 0.46, 0.47));
    let cheek = sphere(mirrored - dvec3(0.2, -0.13, 0.19), 0.25);
    let skull = smooth_union(ball, cheek, 0.12);
    let curl = |points: [DVec3; 2], radii: [f64; 2]| round_cone(head, points, radii);
    let low = curl([dvec3(0.0, 0.4, 0.02), dvec3(0.0, 0.56, -0.02)], [0.1, 0.065]);
    let high = curl([dvec3(0.0, 0.56, -0.02), dvec3(0.0, 0.63, -0.14)], [0.065, 0.035]);
    let tuft = smooth_union(low, high, 0.04);
    smooth_union(skull, tuft, 0.07)
}

/// Two flat halves, the upper broader and turned up at the tip, with the mouth between them.
fn bill(head: DVec3, mirrored: DVec3) -> f64 {
    let reach = (head.z - 0.5).max(0.0);
    let upper = mirrored - dvec3(0.0, -0.045 + 0.5 * reach * reach, 0.5);
    let lower = mirrored - dvec3(0.0, -0.195 + 0.3 * reach * reach, 0.46);
    let upper = ellipsoid(upper, dvec3(0.25, 0.105, 0.34));
    let lower = ellipsoid(lower, dvec3(0.185, 0.09, 0.27));
    let nostril = sphere(mirrored - dvec3(0.075, 0.075, 0.62), 0.04);
    let upper = smooth_difference(upper, nostril, 0.03);
    smooth_union(upper, lower, 0.05)
}

fn eye(mirrored: DVec3) -> f64 {
    ellipsoid(mirrored - dvec3(0.2, 0.17, 0.375), dvec3(0.09, 0.12, 0.09))
}
