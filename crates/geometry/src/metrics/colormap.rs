//! Colour maps, which show numbers as colours.
//!
//! ```
//! use planish_geometry::metrics::colormap::Colormap;
//!
//! // From blue over grey to red.
//! let [low, middle, high] = [0.0, 0.5, 1.0].map(|t| Colormap::Diverging.bytes(t));
//! assert!(low[2] > 2 * low[0] && high[0] > 2 * high[2]);
//! assert!(middle.iter().all(|channel| channel.abs_diff(221) <= 1), "{middle:?}");
//! ```

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A colour map for pictures and vertex colours. Both maps are perceptually uniform, and readable in grey and for colour-blind
/// people.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colormap {
    /// Blue, neutral grey and red for numbers with a sign, where 0 is the grey.
    ///
    /// Reference: Kenneth Moreland. Diverging Color Maps for Scientific Visualization. ISVC 2009.
    #[default]
    Diverging,
    /// Viridis (Stéfan van der Walt, Nathaniel Smith) for magnitudes.
    Sequential,
}

impl Colormap {
    /// All colour maps.
    pub const ALL: [Self; 2] = [Self::Diverging, Self::Sequential];

    /// Evenly spaced samples of the colour map in encoded sRGB, `0xrrggbb`.
    pub fn samples(self) -> &'static [u32] {
        match self {
            Self::Diverging => &COOL_WARM,
            Self::Sequential => &VIRIDIS,
        }
    }

    /// Colour at t in encoded sRGB, each channel 0..=1; t below 0 counts as 0 and above 1 as 1.
    pub fn encoded(self, t: f32) -> Vec3 {
        let samples = self.samples();
        let x = t.clamp(0.0, 1.0) * (samples.len() - 1) as f32;
        let low = (x as usize).min(samples.len() - 2);
        // Encoded values are blended, because these are perceptually uniform.
        encoded(samples[low]).lerp(encoded(samples[low + 1]), x - low as f32)
    }

    /// Colour at t in encoded sRGB, 8 bits a channel.
    pub fn bytes(self, t: f32) -> [u8; 3] {
        self.encoded(t).to_array().map(|c| (c * 255.0).round() as u8)
    }
}

fn encoded(rgb: u32) -> Vec3 {
    let [_, r, g, b] = rgb.to_be_bytes();
    Vec3::new(r.into(), g.into(), b.into()) / 255.0
}

const COOL_WARM: [u32; 17] = [
    0x3b4cc0, 0x4e68d7, 0x6282ea, 0x779af7, 0x8db0fe, 0xa3c2ff, 0xb8d0f9, 0xccd9ee, 0xdddddd, 0xecd3c6, 0xf5c4ad,
    0xf7b194, 0xf49a7b, 0xec7f63, 0xde614c, 0xcb3e38, 0xb40426,
];

const VIRIDIS: [u32; 11] =
    [0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725];

#[cfg(test)]
mod tests {
    use super::*;

    /// Approximate luminance of a colour, which is enough for comparisons.
    fn luma(colour: Vec3) -> f32 {
        colour.map(|c| c.powf(2.2)).dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn zero_is_neutral_and_brightest_in_the_diverging_map() {
        let zero = Colormap::Diverging.encoded(0.5);
        assert!(zero.max_element() - zero.min_element() < 1e-6, "{zero}");
        for i in 0..=100 {
            // The published map is smoothed in the middle, which makes the neighbours of zero slightly brighter.
            assert!(luma(Colormap::Diverging.encoded(i as f32 / 100.0)) < luma(zero) + 0.01);
        }
    }

    #[test]
    fn sequential_map_only_gets_brighter() {
        let steps = (0..=100).map(|i| luma(Colormap::Sequential.encoded(i as f32 / 100.0)));
        assert!(steps.is_sorted());
    }

    #[test]
    fn ends_go_on() {
        for map in [Colormap::Diverging, Colormap::Sequential] {
            assert_eq!((map.encoded(-3.0), map.encoded(7.0)), (map.encoded(0.0), map.encoded(1.0)));
        }
    }
}
