//! The colour bar beside a heat map, as rectangles that both renderers draw.

use crate::colormap::Colormap;
use crate::colour::{Colour, linear_from_srgb, pixel_from_linear};
use crate::settings::{Background, Range, Size};
use image::{Rgba, RgbaImage};

/// Numbers beside the bar.
const TICKS: u32 = 5;

/// Pixels of one colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rectangle {
    /// Column and row of its first pixel.
    pub(crate) place: [u32; 2],
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    pub(crate) colour: Colour,
}

/// A bar with numbers at the right side; nothing in a picture that is too small for it. The ink suits the background.
pub(crate) fn rectangles(size: Size, map: Colormap, range: Range, background: &Background) -> Vec<Rectangle> {
    // Everything is a multiple of one dot of the font.
    let dot = (size.height / 400).max(1);
    let (bar_width, label_width) = (12 * dot, 11 * GLYPH_ADVANCE * dot);
    let bar_height = size.height / 2;
    let mut all = Vec::new();
    if size.width < 4 * label_width || bar_height < 2 * TICKS * GLYPH_HEIGHT * dot {
        return all;
    }
    let left = size.width - label_width - bar_width;
    let top = (size.height - bar_height) / 2;
    for y in 0..bar_height {
        let colour = Colour(pixel_from_linear(map.at(1.0 - (y as f32 + 0.5) / bar_height as f32)));
        all.push(Rectangle { place: [left, top + y], size: [bar_width, 1], colour });
    }
    for tick in 0..TICKS {
        let share = tick as f32 / (TICKS - 1) as f32;
        let y = top + ((1.0 - share) * (bar_height - dot) as f32).round() as u32;
        let colour = ink_over(background, (y as f32 + 0.5) / size.height as f32);
        all.push(Rectangle { place: [left + bar_width, y], size: [3 * dot, dot], colour });
        let origin = [left + bar_width + 6 * dot, y - GLYPH_HEIGHT / 2 * dot];
        let text = label(range.low + share * (range.high - range.low), range);
        all.extend(dots(origin, dot, &text).map(|place| Rectangle { place, size: [dot, dot], colour }));
    }
    all
}

/// Fills the rectangles.
pub(crate) fn draw(image: &mut RgbaImage, rectangles: &[Rectangle]) {
    for &Rectangle { place: [left, top], size: [width, height], colour: Colour([r, g, b]) } in rectangles {
        for y in top..(top + height).min(image.height()) {
            for x in left..(left + width).min(image.width()) {
                image.put_pixel(x, y, Rgba([r, g, b, u8::MAX]));
            }
        }
    }
}

/// Three significant digits.
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

/// Near black or near white, whichever can be read this far down the background, 0..1.
fn ink_over(background: &Background, down: f32) -> Colour {
    let light = background.top.encoded().lerp(background.bottom.encoded(), down).map(linear_from_srgb);
    let luminance = light.dot(glam::Vec3::new(0.2126, 0.7152, 0.0722));
    Colour(if luminance > 0.18 { [40; 3] } else { [230; 3] })
}

/// Where the dots of a text are.
fn dots([left, top]: [u32; 2], dot: u32, text: &str) -> impl Iterator<Item = [u32; 2]> {
    let of_glyph = move |(i, rows): (usize, [u8; GLYPH_HEIGHT as usize])| {
        let left = left + i as u32 * GLYPH_ADVANCE * dot;
        (0..).zip(rows).flat_map(move |(y, row)| {
            let lit = (0..5).filter(move |x| row >> (4 - x) & 1 == 1);
            lit.map(move |x| [left + x * dot, top + y * dot])
        })
    };
    text.chars().filter_map(glyph).enumerate().flat_map(of_glyph).collect::<Vec<_>>().into_iter()
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
        let rectangles = |size| {
            rectangles(size, Colormap::Diverging, Range { low: 0.0, high: 1.0 }, &Background::default())
        };
        assert!(rectangles(Size { width: 40, height: 30 }).is_empty());
        assert!(!rectangles(Size { width: 400, height: 300 }).is_empty());
    }
}
