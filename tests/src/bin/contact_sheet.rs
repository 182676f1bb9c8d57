//! Puts pictures of one size side by side, row by row: `contact_sheet OUT.png COLUMNS IN.png…`

use image::RgbImage;
use image::imageops::replace;
use std::error::Error;

/// Pixels between two pictures.
const GAP: u32 = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [out, columns, pictures @ ..] = &words[..] else {
        return Err("usage: contact_sheet OUT.png COLUMNS IN.png…".into());
    };
    let columns = columns.parse::<std::num::NonZeroU32>()?.get();
    let pictures: Vec<RgbImage> =
        pictures.iter().map(|name| Ok(image::open(name)?.to_rgb8())).collect::<image::ImageResult<_>>()?;
    let first = pictures.first().ok_or("no pictures")?.dimensions();
    if let Some(odd) = pictures.iter().position(|picture| picture.dimensions() != first) {
        return Err(format!("picture {} is not as large as the first", odd + 1).into());
    }
    let (width, height) = first;
    let rows = (pictures.len() as u32).div_ceil(columns);
    let side = |count: u32, one: u32| count * one + (count - 1) * GAP;
    let mut sheet = RgbImage::from_pixel(side(columns, width), side(rows, height), image::Rgb([255; 3]));
    for (i, picture) in (0..).zip(&pictures) {
        let [left, top] = [i % columns * (width + GAP), i / columns * (height + GAP)];
        replace(&mut sheet, picture, left.into(), top.into());
    }
    Ok(sheet.save(out)?)
}
