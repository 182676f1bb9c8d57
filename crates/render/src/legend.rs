//! The colour bar beside a heat map.

use crate::colour::linear_from_byte;
use crate::draw_parameters::heat_range;
use crate::scene::Scene;
use crate::settings::{Range, Settings, Shading};
use image::{Rgba, RgbaImage};
use planish_geometry::metrics::colormap::Colormap;

/// Number of labels beside the bar.
const TICKS: u32 = 5;

/// Draws the colour bar of a heat map on a picture of a scene; other pictures have none.
pub(crate) fn add(image: &mut RgbaImage, scene: &Scene, settings: &Settings) {
    if matches!(settings.shading, Shading::Height | Shading::Heat)
        && let Some(range) = heat_range(scene, settings)
    {
        draw(image, settings.heat.map, range);
    }
}

/// Draws a bar with numbers at the right side; leaves a picture alone that is too small for it.
fn draw(image: &mut RgbaImage, map: Colormap, range: Range) {
    // Everything is a multiple of one dot of the font.
    let dot = (image.height() / 400).max(1);
    let (bar_width, label_width) = (12 * dot, 11 * GLYPH_ADVANCE * dot);
    let bar_height = image.height() / 2;
    if image.width() < 4 * label_width || bar_height < 2 * TICKS * GLYPH_HEIGHT * dot {
        return;
    }
    let left = image.width() - label_width - bar_width;
    let top = (image.height() - bar_height) / 2;
    for y in 0..bar_height {
        let [r, g, b] = map.bytes(1.0 - (y as f32 + 0.5) / bar_height as f32);
        fill(image, [left, top + y], [bar_width, 1], Rgba([r, g, b, u8::MAX]));
    }
    for tick in 0..TICKS {
        let share = tick as f32 / (TICKS - 1) as f32;
        let y = top + ((1.0 - share) * (bar_height - dot) as f32).round() as u32;
        let ink = ink_over(*image.get_pixel(left + bar_width, y));
        fill(image, [left + bar_width, y], [3 * dot, dot], ink);
        let origin = [left + bar_width + 6 * dot, y - GLYPH_HEIGHT / 2 * dot];
        write(image, origin, dot, ink, &label(range.low + share * (range.high - range.low), range));
    }
}

/// Formats a number with three significant digits.
fn label(x: f32, range: Range) -> String {
    let widest = range.low.abs().max(range.high.abs());
    // What is left of a zero after rounding.
    if x.abs() <= 1e-6 * widest {
        return "0".to_owned();
    }
    let exponent = x.abs().log10().floor() as i32;
    match exponent {
        -3..3 => format!("{x:.*}", (2 - exponent) as usize),
        3..6 => format!("{x:.0}"),
        _ => format!("{x:.2e}"),
    }
}

/// Chooses near black or near white, whichever can be read on a colour.
fn ink_over(Rgba([r, g, b, _]): Rgba<u8>) -> Rgba<u8> {
    let luminance = 0.2126 * linear_from_byte(r) + 0.7152 * linear_from_byte(g) + 0.0722 * linear_from_byte(b);
    let grey = if luminance > 0.18 { 40 } else { 230 };
    Rgba([grey, grey, grey, u8::MAX])
}

fn fill(image: &mut RgbaImage, [left, top]: [u32; 2], [width, height]: [u32; 2], colour: Rgba<u8>) {
    for y in top..(top + height).min(image.height()) {
        for x in left..(left + width).min(image.width()) {
            image.put_pixel(x, y, colour);
        }
    }
}

fn write(image: &mut RgbaImage, [left, top]: [u32; 2], dot: u32, ink: Rgba<u8>, text: &str) {
    for (i, rows) in text.chars().filter_map(glyph).enumerate() {
        let left = left + i as u32 * GLYPH_ADVANCE * dot;
        for (y, row) in (0..).zip(rows) {
            for x in (0..5).filter(|x| row >> (4 - x) & 1 == 1) {
                fill(image, [left + x * dot, top + y * dot], [dot, dot], ink);
            }
        }
    }
}

const GLYPH_HEIGHT: u32 = 7;
const GLYPH_ADVANCE: u32 = 6;

/// Rows from the top, five dots each.
fn glyph(c: char) -> Option<[u8; GLYPH_HEIGHT as usize]> {
    Some(match c {
        '0' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        '2' => [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
        '3' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
        '4' => [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
        '6' => [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
        '7' => [0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b01000, 0b01000],
        '8' => [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
        '9' => [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
        '-' => [0b00000, 0b00000, 0b00000, 0b01110, 0b00000, 0b00000, 0b00000],
        '.' => [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100],
        'e' => [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_three_significant_digits() {
        let range = Range { low: -12.0, high: 12.0 };
        for (x, text) in [
            (0.0, "0"),
            (1e-9, "0"),
            (-0.012_34, "-0.0123"),
            (1.0, "1.00"),
            (12.34, "12.3"),
            (123_456.0, "123456"),
            (2.5e-5, "2.50e-5"),
            (-3e9, "-3.00e9"),
        ] {
            assert_eq!(label(x, range), text);
        }
    }

    #[test]
    fn every_character_of_a_label_has_a_glyph() {
        assert!("0123456789-.e".chars().all(|c| glyph(c).is_some()));
    }

    #[test]
    fn small_pictures_are_left_alone() {
        let mut image = RgbaImage::new(40, 30);
        draw(&mut image, Colormap::Diverging, Range { low: 0.0, high: 1.0 });
        assert!(image.iter().all(|byte| *byte == 0));
    }
}
