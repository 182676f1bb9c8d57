//! Makes two volumes for the gallery, as bare numbers: `chest.raw`, a density like that of a scan, with soft tissue, lungs, ribs and a spine
//! (16 bits), and `wood.raw`, the rings of a trunk (8 bits).

use glam::{Vec2, Vec3};
use std::error::Error;
use std::path::PathBuf;

/// Values of the chest along each axis: to the left, up and to the front.
const CHEST: [usize; 3] = [144, 160, 112];
/// Half of the box of the chest, in units of the body.
const HALF: Vec3 = Vec3::new(1.08, 1.2, 0.84);
/// Ribs on each side, and the distance between them.
const RIBS: f32 = 8.0;
const RIB_GAP: f32 = 0.22;
/// Densities.
const TISSUE: f32 = 0.4;
const LUNG: f32 = 0.15;
const BONE: f32 = 0.85;

/// Values of the wood along each axis.
const WOOD: [usize; 3] = [128; 3];
/// Rings between the middle of the trunk and the side of the box.
const RINGS: f32 = 9.0;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: volumes FOLDER")?);
    let chest = points(CHEST).flat_map(|p| ((4095.0 * density(HALF * p)) as u16).to_le_bytes());
    std::fs::write(folder.join("chest.raw"), chest.collect::<Vec<u8>>())?;
    std::fs::write(folder.join("wood.raw"), points(WOOD).map(|p| (255.0 * wood(p)) as u8).collect::<Vec<u8>>())?;
    Ok(())
}

/// Middles of the voxels of a box from −1 to 1, the first axis fastest.
fn points(size: [usize; 3]) -> impl Iterator<Item = Vec3> {
    let share = move |i: usize, axis: usize| 2.0 * (i as f32 + 0.5) / size[axis] as f32 - 1.0;
    let rows = (0..size[2]).flat_map(move |z| (0..size[1]).map(move |y| (y, z)));
    rows.flat_map(move |(y, z)| (0..size[0]).map(move |x| Vec3::new(share(x, 0), share(y, 1), share(z, 2))))
}

/// Darkness of wood, 0..1: each ring becomes darker outwards and ends at once. The trunk is not quite round, nor straight.
fn wood(p: Vec3) -> f32 {
    let axis = Vec2::new(0.35 + 0.08 * (2.0 * p.y).sin(), -0.25 + 0.1 * p.y);
    let q = Vec2::new(p.x, p.z) - axis;
    let wave = 0.05 * (3.0 * q.to_angle() + 1.5 * p.y).sin() + 0.03 * (5.0 * p.x + 4.0 * p.y - 3.0 * p.z).sin();
    let ring = RINGS * (q.length() + wave);
    let t = ring - ring.floor();
    // The step back to light takes a tenth of the ring.
    if t < 0.9 { (t / 0.9).powi(3) } else { (1.0 - t) / 0.1 }
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
    let number = (tilted / RIB_GAP).round().clamp(-0.5 * RIBS, 0.5 * RIBS - 1.0);
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
