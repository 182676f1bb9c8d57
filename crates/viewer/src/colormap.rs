//! Colours for numbers.

use crate::colour::{Colour, linear_from_srgb};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A colour map; both are even to the eye and keep their order in grey and for the colour-blind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Colormap {
    /// Blue, neutral grey, red, for numbers with a sign: zero is the grey.
    ///
    /// Kenneth Moreland. Diverging Color Maps for Scientific Visualization. ISVC 2009.
    #[default]
    Diverging,
    /// Viridis (Stéfan van der Walt, Nathaniel Smith), for magnitudes.
    Sequential,
}

impl Colormap {
    /// Evenly spaced samples.
    pub(crate) fn samples(self) -> &'static [Colour] {
        match self {
            Self::Diverging => &COOL_WARM,
            Self::Sequential => &VIRIDIS,
        }
    }

    /// Linear RGB at t; below 0 and above 1 the ends go on.
    pub fn at(self, t: f32) -> Vec3 {
        let samples = self.samples();
        let x = t.clamp(0.0, 1.0) * (samples.len() - 1) as f32;
        let low = (x as usize).min(samples.len() - 2);
        // Between encoded values, because these are the ones that are even to the eye.
        let encoded = samples[low].encoded().lerp(samples[low + 1].encoded(), x - low as f32);
        encoded.map(linear_from_srgb)
    }
}

const COOL_WARM: [Colour; 17] = [
    Colour::hex(0x3b4cc0),
    Colour::hex(0x4e68d7),
    Colour::hex(0x6282ea),
    Colour::hex(0x779af7),
    Colour::hex(0x8db0fe),
    Colour::hex(0xa3c2ff),
    Colour::hex(0xb8d0f9),
    Colour::hex(0xccd9ee),
    Colour::hex(0xdddddd),
    Colour::hex(0xecd3c6),
    Colour::hex(0xf5c4ad),
    Colour::hex(0xf7b194),
    Colour::hex(0xf49a7b),
    Colour::hex(0xec7f63),
    Colour::hex(0xde614c),
    Colour::hex(0xcb3e38),
    Colour::hex(0xb40426),
];

const VIRIDIS: [Colour; 11] = [
    Colour::hex(0x440154),
    Colour::hex(0x482475),
    Colour::hex(0x414487),
    Colour::hex(0x355f8d),
    Colour::hex(0x2a788e),
    Colour::hex(0x21918c),
    Colour::hex(0x22a884),
    Colour::hex(0x44bf70),
    Colour::hex(0x7ad151),
    Colour::hex(0xbddf26),
    Colour::hex(0xfde725),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of linear sRGB.
    fn luminance(colour: Vec3) -> f32 {
        colour.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn zero_is_neutral_and_brightest_in_the_diverging_map() {
        let zero = Colormap::Diverging.at(0.5);
        assert!(zero.max_element() - zero.min_element() < 1e-6, "{zero}");
        for i in 0..=100 {
            // The smoothing of the middle lifts its neighbours by a hair.
            assert!(luminance(Colormap::Diverging.at(i as f32 / 100.0)) < luminance(zero) + 0.01);
        }
    }

    #[test]
    fn sequential_map_only_gets_brighter() {
        let steps = (0..=100).map(|i| luminance(Colormap::Sequential.at(i as f32 / 100.0)));
        assert!(steps.is_sorted());
    }

    #[test]
    fn ends_go_on() {
        for map in [Colormap::Diverging, Colormap::Sequential] {
            assert_eq!((map.at(-3.0), map.at(7.0)), (map.at(0.0), map.at(1.0)));
        }
    }
}
