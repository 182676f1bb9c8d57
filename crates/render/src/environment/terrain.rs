//! Looks around from a position above a landscape of heights.
//!
//! Column by column, outwards from the eye: the ground is seen where its elevation exceeds all that lies nearer, so that each
//! column costs one walk, however many pixels it has.

use super::equirect::{Equirect, direction_from_uv};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Distance at which walks begin, metres; they end at [`FAR`].
const NEAR: f32 = 0.2;
const FAR: f32 = 12e3;
/// Steps of a walk; each is 1 % longer than the one before.
const STEPS: usize = 1_100;
/// Parts of a pixel's height that are told apart, so that crests are smooth against the sky.
const PARTS: usize = 4;

/// A landscape with a sky.
pub(super) trait Landscape: Sync {
    /// Height of the eye, metres.
    fn eye(&self) -> f32;
    /// Height of the ground at a position, metres, without what is finer than `footprint` metres.
    fn height(&self, position: Vec2, footprint: f32) -> f32;
    /// Radiance of the ground at a position, seen along a unit direction from the eye.
    fn ground(&self, position: Vec2, footprint: f32, direction: Vec3) -> Vec3;
    /// Radiance of the sky.
    fn sky(&self, direction: Vec3) -> Vec3;
}

/// Unit normal of the ground.
pub(super) fn normal(landscape: &impl Landscape, position: Vec2, footprint: f32) -> Vec3 {
    let step = footprint.max(4e-3);
    let at = |x: f32, z: f32| landscape.height(position + Vec2::new(x, z), footprint);
    let here = at(0.0, 0.0);
    Vec3::new(here - at(step, 0.0), step, here - at(0.0, step)).normalize()
}

/// Fraction of the sun's disc that is visible from the ground: 0 in shadow, 1 in the open, between them in the penumbra.
pub(super) fn sunlit(landscape: &impl Landscape, position: Vec2, to_sun: Vec3, footprint: f32) -> f32 {
    const STEPS: usize = 16;
    const REACH: f32 = 300.0;
    let flat = Vec2::new(to_sun.x, to_sun.z);
    let slope = to_sun.y / flat.length();
    let flat = flat.normalize();
    let first = footprint.max(0.3);
    let start = landscape.height(position, first);
    let mut seen = 1.0f32;
    for step in 0..STEPS {
        if seen <= 0.0 {
            break;
        }
        let distance = first * (REACH / first).max(1.0).powf(step as f32 / (STEPS - 1) as f32);
        let clearance =
            start + distance * slope - landscape.height(position + distance * flat, first.max(0.05 * distance));
        // Twice the sun's disc, half a degree: air and sand scatter.
        seen = seen.min(0.5 + clearance / (0.02 * distance));
    }
    let seen = seen.clamp(0.0, 1.0);
    seen * seen * (3.0 - 2.0 * seen)
}

/// The whole sphere, as seen from above the origin; x right, y up, z ahead.
pub(super) fn panorama(landscape: &impl Landscape, height: usize) -> Equirect {
    let width = 2 * height;
    let columns: Vec<Vec<Vec3>> =
        (0..width).into_par_iter().map(|column| draw_column(landscape, column, width, height)).collect();
    let texels = (0..width * height).map(|i| columns[i % width][i / width]).collect();
    Equirect::new(width, texels).unwrap_or_else(|| Equirect::from_fn(1, |d| landscape.sky(d)))
}

/// Draws one column of the panorama, from the zenith down.
fn draw_column(landscape: &impl Landscape, column: usize, width: usize, height: usize) -> Vec<Vec3> {
    let u = (column as f32 + 0.5) / width as f32;
    let at = |part: usize| direction_from_uv(Vec2::new(u, (part as f32 + 0.5) / (height * PARTS) as f32));
    let ahead = direction_from_uv(Vec2::new(u, 0.5));
    let ahead = Vec2::new(ahead.x, ahead.z);
    let distances = walk(landscape, ahead, height);
    let angle = std::f32::consts::PI / height as f32;

    let colour = |direction: Vec3, distance: Option<f32>| match distance {
        None => landscape.sky(direction),
        // Across the view a pixel is as wide as its angle says, along it much longer; between the two.
        Some(distance) => {
            let footprint = distance * angle * (1.0 + distance / landscape.eye().max(1.0)).sqrt();
            landscape.ground(distance * ahead, footprint, direction)
        }
    };
    let pixel = |row: usize| {
        let parts = &distances[row * PARTS..(row + 1) * PARTS];
        let middle = direction_from_uv(Vec2::new(u, (row as f32 + 0.5) / height as f32));
        match (parts[0], parts[PARTS - 1]) {
            (None, None) => colour(middle, None),
            // One surface all through: once is enough.
            (Some(far), Some(near)) if far < 1.5 * near => colour(middle, Some(0.5 * (far + near))),
            _ => (0..PARTS).map(|k| colour(at(row * PARTS + k), parts[k])).sum::<Vec3>() / PARTS as f32,
        }
    };
    (0..height).map(pixel).collect()
}

/// Level distance at which each part of each row meets the ground, from the zenith down.
fn walk(landscape: &impl Landscape, ahead: Vec2, height: usize) -> Vec<Option<f32>> {
    let count = height * PARTS;
    // The tangent of the elevation at the middle of a part.
    let slope = |part: usize| ((0.5 - (part as f32 + 0.5) / count as f32) * std::f32::consts::PI).tan();
    let eye = landscape.eye();
    let mut distances = vec![None; count];
    let mut next = count;
    let mut before = (0.0, f32::NEG_INFINITY);
    for step in 0..=STEPS {
        let distance = NEAR * (FAR / NEAR).powf(step as f32 / STEPS as f32);
        let ground = landscape.height(distance * ahead, 0.005 * distance);
        // The earth is round.
        let drop = distance * distance / (2.0 * 6_360e3);
        let seen = (ground - drop - eye) / distance;
        while next > 0 && slope(next - 1) < seen {
            next -= 1;
            let target_slope = slope(next);
            let (near, nearer_slope) = before;
            let share = if nearer_slope.is_finite() && nearer_slope < target_slope {
                (target_slope - nearer_slope) / (seen - nearer_slope)
            } else {
                1.0
            };
            // Below the first step the ground is level.
            let met =
                if nearer_slope.is_finite() { near + share * (distance - near) } else { ground.min(eye - 0.1) - eye };
            distances[next] = Some(if met < 0.0 { met / target_slope } else { met });
        }
        before = (distance, seen);
    }
    distances
}
