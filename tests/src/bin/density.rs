//! Makes a density like that of a scan of a chest for the gallery: soft tissue with lungs, ribs and a spine, as bare numbers of 16 bits.

use glam::{Vec2, Vec3};
use std::error::Error;
use std::path::PathBuf;

/// Values along each axis: to the left, up and to the front.
const SIZE: [usize; 3] = [144, 160, 112];
/// Half of the box, in units of the body.
const HALF: Vec3 = Vec3::new(1.08, 1.2, 0.84);
/// Ribs on each side, and the distance between them.
const RIBS: i32 = 8;
const RIB_GAP: f32 = 0.22;
/// Densities.
const TISSUE: f32 = 0.4;
const LUNG: f32 = 0.15;
const BONE: f32 = 0.85;

fn main() -> Result<(), Box<dyn Error>> {
    let file = PathBuf::from(std::env::args().nth(1).ok_or("usage: density OUT.raw")?);
    let share = |i: usize, axis: usize| 2.0 * (i as f32 + 0.5) / SIZE[axis] as f32 - 1.0;
    let rows = (0..SIZE[2]).flat_map(|z| (0..SIZE[1]).map(move |y| (y, z)));
    let points = rows.flat_map(|(y, z)| (0..SIZE[0]).map(move |x| HALF * Vec3::new(share(x, 0), share(y, 1), share(z, 2))));
    let bytes: Vec<u8> = points.flat_map(|p| ((4095.0 * density(p)) as u16).to_le_bytes()).collect();
    std::fs::write(file, bytes)?;
    Ok(())
}

/// Density at a point of the body, 0..1.
fn density(p: Vec3) -> f32 {
    let mut density = TISSUE * inside(body(p));
    let lung = ellipsoid(Vec3::new(p.x.abs() - 0.42, p.y, p.z), Vec3::new(0.3, 0.75, 0.4));
    density += (LUNG - density) * inside(lung).min(inside(body(p)));
    let bone = rib(p).min(spine(p)).min(breastbone(p));
    density + (BONE - density).max(0.0) * inside(bone)
}

/// 1 where a signed distance is negative, 0 where it is positive, over the width of a voxel or two.
fn inside(distance: f32) -> f32 {
    let t = (0.5 - distance / 0.04).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn ellipsoid(p: Vec3, radii: Vec3) -> f32 {
    ((p / radii).length() - 1.0) * radii.min_element()
}

fn body(p: Vec3) -> f32 {
    // Flatter at the ends than an ellipsoid.
    let radii = Vec3::new(1.0, 1.15, 0.75);
    let q = (p / radii).abs().powf(2.6);
    ((q.x + q.y + q.z).powf(1.0 / 2.6) - 1.0) * 0.75
}

/// Ribs run from the spine forwards and downwards, each wider than the one above, and end before the breastbone if they are low.
fn rib(p: Vec3) -> f32 {
    let tilted = p.y + 0.28 * (p.z + 0.5);
    let number = (tilted / RIB_GAP).round().clamp(-0.5 * RIBS as f32, 0.5 * RIBS as f32 - 1.0);
    let height = number * RIB_GAP;
    let wide = 0.82 - 0.35 * (height - 0.1).max(0.0) - 0.12 * (-height - 0.3).max(0.0);
    let radii = Vec2::new(wide, 0.56 * (0.3 + 0.7 * wide / 0.82));
    let around = ((Vec2::new(p.x, p.z) / radii).length() - 1.0) * radii.min_element();
    let front = if number < -2.0 { p.z - (0.2 - 0.25 * (-2.0 - number)) } else { -1.0 };
    Vec2::new(around, tilted - height).length().max(front) - 0.045
}

/// Vertebrae with gaps between them, and a process behind each.
fn spine(p: Vec3) -> f32 {
    let from_disc = (p.y / 0.165 - (p.y / 0.165).round()).abs() * 0.165;
    let q = Vec2::new(p.x, p.z + 0.42);
    let vertebra = (q.length() - 0.125).max(from_disc - 0.062);
    let process = Vec2::new(p.x, from_disc).length().max((p.z + 0.6).abs() - 0.1) - 0.03;
    vertebra.min(process).max(p.y.abs() - 1.05)
}

fn breastbone(p: Vec3) -> f32 {
    let q = Vec3::new(p.x, p.y - 0.18, p.z - 0.53 + 0.2 * (p.y - 0.3).max(0.0)).abs();
    (q - Vec3::new(0.09, 0.42, 0.03)).max(Vec3::ZERO).length() - 0.025
}
