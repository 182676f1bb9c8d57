//! Distance between a picture and its reference.

use image::RgbaImage;

/// Bound of the root of the mean square of the differences of all channels, levels of 255. Other versions of a driver
/// round otherwise and cover other pixels at silhouettes.
const RMS: f64 = 1.5;
/// Bound of the difference that a thousandth of the pixels exceeds.
const RARELY: u8 = 32;
/// Side of the squares whose means are bounded, pixels. In pictures of 160×120 pixels such a square is less than a
/// thousandth: only its mean shows that something is wrong in one place.
const SIDE: u32 = 4;
/// Bound of the mean difference in every square, levels. A silhouette of which each pixel lost one of four samples
/// between white and black stays below it.
const SQUARE: f64 = 16.0;

/// Says in which respect two pictures of one size are not alike.
pub(crate) fn alike(picture: &RgbaImage, reference: &RgbaImage) -> Result<(), String> {
    let rms = root_mean_square(picture, reference);
    if rms > RMS {
        return Err(format!("root mean square of the differences {rms:.2} > {RMS}"));
    }
    let largest = largest_differences(picture, reference);
    let mut sorted = largest.clone();
    sorted.sort_unstable();
    let rarely = sorted[sorted.len() * 999 / 1000];
    if rarely > RARELY {
        return Err(format!("99.9th percentile of the differences of the pixels {rarely} > {RARELY}"));
    }
    let (mean, [x, y]) = worst_square(&largest, picture.width());
    if mean > SQUARE {
        return Err(format!("mean difference {mean:.1} > {SQUARE} in the square of {SIDE}×{SIDE} pixels at {x}, {y}"));
    }
    Ok(())
}

fn root_mean_square(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let squares = a.iter().zip(b.iter()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// Largest difference of a channel, for each pixel.
fn largest_differences(a: &RgbaImage, b: &RgbaImage) -> Vec<u8> {
    let largest = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| (0..4).map(|c| a.0[c].abs_diff(b.0[c])).max();
    a.pixels().zip(b.pixels()).map(|pair| largest(pair).unwrap_or(0)).collect()
}

/// Largest mean over a square, and its first pixel.
fn worst_square(differences: &[u8], width: u32) -> (f64, [u32; 2]) {
    let height = differences.len() as u32 / width;
    let mean = |x: u32, y: u32| {
        let pixels = (0..SIDE * SIDE).map(|i| [x + i % SIDE, y + i / SIDE]);
        let sum: u32 = pixels.map(|[x, y]| u32::from(differences[(y * width + x) as usize])).sum();
        f64::from(sum) / f64::from(SIDE * SIDE)
    };
    let corners = (0..=height - SIDE).flat_map(|y| (0..=width - SIDE).map(move |x| [x, y]));
    corners.map(|[x, y]| (mean(x, y), [x, y])).fold((0.0, [0; 2]), |a, b| if b.0 > a.0 { b } else { a })
}

/// A picture with shapes, as large as the references.
fn picture() -> RgbaImage {
    RgbaImage::from_fn(160, 120, |x, y| image::Rgba([(x + y) as u8 / 2, 90, if x > y { 200 } else { 60 }, 255]))
}

/// The picture with `levels` added at these pixels.
fn wrong_at(pixels: impl Iterator<Item = [u32; 2]>, levels: u8) -> RgbaImage {
    let mut image = picture();
    for [x, y] in pixels {
        image.get_pixel_mut(x, y).0[..3].iter_mut().for_each(|c| *c = c.saturating_add(levels));
    }
    image
}

#[test]
fn a_wrong_block_is_noticed_wherever_it_lies() {
    for [left, top] in [[0, 0], [77, 50], [156, 116], [33, 101]] {
        let wrong = wrong_at((0..16).map(|i| [left + i % 4, top + i / 4]), 50);
        assert!(root_mean_square(&wrong, &picture()) < RMS, "the mean of the whole picture does not see it");
        let said = alike(&wrong, &picture()).unwrap_err();
        assert!(said.contains(&format!("at {left}, {top}")), "{said}");
    }
}

#[test]
fn a_wrong_line_is_noticed() {
    // A thousandth of the pixels, no two of them in one square.
    let wrong = wrong_at((0..24).map(|i| [5 * i + 2, 3 * i + 9]), 40);
    assert!(root_mean_square(&wrong, &picture()) < RMS && worst_square_of(&wrong) < SQUARE);
    assert!(alike(&wrong, &picture()).unwrap_err().contains("99.9th"));
}

fn worst_square_of(wrong: &RgbaImage) -> f64 {
    worst_square(&largest_differences(wrong, &picture()), wrong.width()).0
}

#[test]
fn rounding_and_single_samples_at_silhouettes_are_allowed() {
    let everywhere = (0..120).flat_map(|y| (0..160).map(move |x| [x, y]));
    assert_eq!(alike(&wrong_at(everywhere, 1), &picture()), Ok(()));
    // One of four samples between neighbouring shapes, at a few pixels in a row.
    assert_eq!(alike(&wrong_at((0..4).map(|i| [40 + i, 40]), 60), &picture()), Ok(()));
}
