//! Makes a ball of bricks for the gallery: a mesh with texture coordinates and a seam, a picture of heights, the normal map
//! that belongs to it, and a colour texture.

use glam::{Vec2, Vec3};
use image::{GrayImage, Luma, Rgb, RgbImage};
use std::error::Error;
use std::f32::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::PathBuf;

const RADIUS: f32 = 6.0;
/// Quads around the ball, and from pole to pole.
const AROUND: u32 = 320;
const DOWN: u32 = 160;
/// Bricks around the ball, and courses.
const BRICKS: Vec2 = Vec2::new(14.0, 14.0);
const WIDTH: u32 = 1024;
const HEIGHT: u32 = 512;
/// Model units from black to white for which the normal map is right.
const SCALE: f32 = 0.35;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: bricks FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("ball.obj"), ball()?)?;
    let uv = |x: u32, y: u32| Vec2::new((x as f32 + 0.5) / WIDTH as f32, 1.0 - (y as f32 + 0.5) / HEIGHT as f32);
    let byte = |x: f32| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    GrayImage::from_fn(WIDTH, HEIGHT, |x, y| Luma([byte(height(uv(x, y)))])).save(folder.join("heights.png"))?;
    let normals = RgbImage::from_fn(WIDTH, HEIGHT, |x, y| Rgb((0.5 * normal(uv(x, y)) + 0.5).to_array().map(byte)));
    normals.save(folder.join("normals.png"))?;
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| Rgb(colour(uv(x, y)).to_array().map(byte)))
        .save(folder.join("colour.png"))?;
    Ok(())
}

/// A sphere whose texture is cut from pole to pole.
fn ball() -> Result<String, std::fmt::Error> {
    let mut text = String::from("# made by planish\n");
    for j in 0..=DOWN {
        for i in 0..=AROUND {
            let uv = Vec2::new(i as f32 / AROUND as f32, 1.0 - j as f32 / DOWN as f32);
            writeln!(text, "vt {} {}", uv.x, uv.y)?;
        }
    }
    let place = |i: u32, j: u32| {
        let (longitude, from_pole) = (TAU * i as f32 / AROUND as f32, PI * j as f32 / DOWN as f32);
        RADIUS * Vec3::new(-from_pole.sin() * longitude.sin(), from_pole.cos(), -from_pole.sin() * longitude.cos())
    };
    writeln!(text, "v 0 {RADIUS} 0")?;
    for (i, j) in (1..DOWN).flat_map(|j| (0..AROUND).map(move |i| (i, j))) {
        let p = place(i, j);
        writeln!(text, "v {} {} {}", p.x, p.y, p.z)?;
    }
    writeln!(text, "v 0 {} 0", -RADIUS)?;
    let vertex = |i: u32, j: u32| match j {
        0 => 1,
        DOWN => 2 + (DOWN - 1) * AROUND,
        _ => 2 + (j - 1) * AROUND + i % AROUND,
    };
    for (i, j) in (0..DOWN).flat_map(|j| (0..AROUND).map(move |i| (i, j))) {
        let corner = |di: u32, dj: u32| {
            let (i, j) = (i + di, j + dj);
            format!("{}/{}", vertex(i, j), 1 + j * (AROUND + 1) + i)
        };
        // At the poles a quad is a triangle.
        let corners = match j {
            0 => vec![corner(0, 0), corner(0, 1), corner(1, 1)],
            _ if j == DOWN - 1 => vec![corner(0, 0), corner(0, 1), corner(1, 0)],
            _ => vec![corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)],
        };
        writeln!(text, "f {}", corners.join(" "))?;
    }
    Ok(text)
}

/// Which brick, and where on it: 0 at its rim, larger inside.
fn brick(uv: Vec2) -> (u32, f32) {
    let row = (uv.y * BRICKS.y).floor();
    let shifted = Vec2::new(uv.x * BRICKS.x + 0.5 * (row % 2.0), uv.y * BRICKS.y);
    let inside = shifted - shifted.floor();
    let column = shifted.x.floor().rem_euclid(BRICKS.x);
    // A brick is twice as long as high.
    let rim = (inside.min(1.0 - inside) * Vec2::new(2.0, 1.0)).min_element();
    (row as u32 * 97 + column as u32 * 31, rim)
}

fn height(uv: Vec2) -> f32 {
    let (number, rim) = brick(uv);
    let rise = ((rim - 0.05) / 0.12).clamp(0.0, 1.0);
    let rise = rise * rise * (3.0 - 2.0 * rise);
    let grain = 0.03 * (uv.x * 260.0).sin() * (uv.y * 170.0 + number as f32).sin();
    0.1 + rise * (0.78 + 0.12 * chance(number) + grain)
}

fn normal(uv: Vec2) -> Vec3 {
    let step = Vec2::new(1.0 / WIDTH as f32, 1.0 / HEIGHT as f32);
    let wrapped = |uv: Vec2| height(Vec2::new(uv.x.rem_euclid(1.0), uv.y.clamp(0.0, 0.999_999)));
    let (x, y) = (Vec2::new(step.x, 0.0), Vec2::new(0.0, step.y));
    let change = Vec2::new(wrapped(uv + x) - wrapped(uv - x), wrapped(uv + y) - wrapped(uv - y));
    // Model units of a texel: circles of latitude get shorter towards the poles.
    let length = Vec2::new(TAU * RADIUS * (PI * uv.y).sin().max(0.05), PI * RADIUS) * step;
    (-0.5 * SCALE * change / length).extend(1.0).normalize()
}

fn colour(uv: Vec2) -> Vec3 {
    let (number, rim) = brick(uv);
    let fired = Vec3::new(0.62, 0.27, 0.19).lerp(Vec3::new(0.79, 0.45, 0.3), chance(number));
    let share = ((rim - 0.06) / 0.05).clamp(0.0, 1.0);
    let grain = 1.0 + 0.05 * (uv.x * 310.0).sin() * (uv.y * 230.0).sin();
    grain * Vec3::new(0.74, 0.71, 0.66).lerp(fired, share)
}

/// A number of 0..1 for each brick.
fn chance(number: u32) -> f32 {
    let mixed = number.wrapping_mul(0x9e37_79b1);
    (mixed ^ (mixed >> 15)).wrapping_mul(0x85eb_ca6b) as f32 / u32::MAX as f32
}
