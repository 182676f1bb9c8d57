//! Surfaces that unroll into the plane without stretch: their flat coordinates are lengths.

use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_SQRT_2;

/// A surface with a flat domain; the domain's normal u × v is the outward one. Round surfaces have
/// vertical axes and are flattened about the direction `toward`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Developable {
    /// The plane across the unit normal `u` × `v`.
    Plane { u: DVec3, v: DVec3, origin: DVec3 },
    /// A vertical wall around a solid.
    Shaft { centre: DVec2, radius: f64, toward: DVec2 },
    /// A vertical wall around a hole.
    Bore { centre: DVec2, radius: f64, toward: DVec2 },
    /// z = `apex` + `rise` · distance to the axis, where `rise` is 1 (a funnel) or −1 (a tip).
    Cone { centre: DVec2, apex: f64, rise: f64, toward: DVec2 },
}

impl Developable {
    pub(crate) fn plane(origin: DVec3, normal: DVec3, u: DVec3) -> Self {
        Self::Plane { u, v: normal.cross(u), origin }
    }

    /// Flat place of a point of the surface. Rounded, since the last bit of an angle differs
    /// between machines and decides how points on one circle are triangulated.
    pub(crate) fn flatten(&self, p: DVec3) -> DVec2 {
        let angle = |centre: DVec2, toward: DVec2| {
            let from_axis = p.truncate() - centre;
            toward.perp_dot(from_axis).atan2(toward.dot(from_axis))
        };
        let flat = match *self {
            Self::Plane { u, v, origin } => DVec2::new((p - origin).dot(u), (p - origin).dot(v)),
            Self::Shaft { centre, radius, toward } => DVec2::new(radius * angle(centre, toward), p.z),
            Self::Bore { centre, radius, toward } => DVec2::new(-radius * angle(centre, toward), p.z),
            Self::Cone { centre, toward, .. } => {
                let slant = (p.truncate() - centre).length() / FRAC_1_SQRT_2;
                DVec2::from_angle(angle(centre, toward) * FRAC_1_SQRT_2) * slant
            }
        };
        flat.map(|x| (x * 1e9).round() / 1e9)
    }

    /// The point of the surface at a flat place.
    pub(crate) fn lift(&self, flat: DVec2) -> DVec3 {
        let around = |centre: DVec2, toward: DVec2, angle: f64, radius: f64| {
            centre + DVec2::from_angle(angle).rotate(toward) * radius
        };
        match *self {
            Self::Plane { u, v, origin } => origin + flat.x * u + flat.y * v,
            Self::Shaft { centre, radius, toward } => around(centre, toward, flat.x / radius, radius).extend(flat.y),
            Self::Bore { centre, radius, toward } => around(centre, toward, -flat.x / radius, radius).extend(flat.y),
            Self::Cone { centre, apex, rise, toward } => {
                let radius = flat.length() * FRAC_1_SQRT_2;
                let angle = flat.y.atan2(flat.x) / FRAC_1_SQRT_2;
                around(centre, toward, angle, radius).extend(apex + rise * radius)
            }
        }
    }
}
