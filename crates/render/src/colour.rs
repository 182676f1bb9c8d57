//! sRGB colours as people write them, and the way to linear light and back.
//!
//! ```
//! use planish_render::colour::{Colour, ColourError};
//!
//! let grey = Colour::try_from("#808080".to_owned())?;
//! // Half of the stored number is a fifth of the light.
//! assert!((grey.linear().x - 0.2159).abs() < 1e-4);
//! assert_eq!(String::from(grey), "#808080");
//! let failure = Colour::try_from("grey".to_owned()).unwrap_err();
//! assert_eq!(failure.to_string(), "`grey` is not a colour of the form #rrggbb");
//! # Ok::<(), ColourError>(())
//! ```

use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;
use thiserror::Error;

/// An opaque sRGB colour; in text `#rrggbb`, as in every colour picker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// The colour white, `#ffffff`.
    pub const WHITE: Self = Self::hex(0xff_ff_ff);

    /// The colour written `0xrrggbb`.
    pub const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self([r, g, b])
    }

    /// Returns the colour as linear RGB, 0..1.
    pub fn linear(self) -> Vec3 {
        Vec3::from(self.0.map(linear_from_byte))
    }

    /// The stored, encoded values, 0..1.
    pub(crate) fn encoded(self) -> Vec3 {
        Vec3::from(self.0.map(|c| f32::from(c) / 255.0))
    }
}

/// A colour that is not `#rrggbb`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}` is not a colour of the form #rrggbb")]
pub struct ColourError(String);

impl TryFrom<String> for Colour {
    type Error = ColourError;

    fn try_from(text: String) -> Result<Self, ColourError> {
        text.strip_prefix('#')
            .filter(|digits| digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|digits| u32::from_str_radix(digits, 16).ok())
            .map(Self::hex)
            .ok_or(ColourError(text))
    }
}

impl From<Colour> for String {
    fn from(Colour([r, g, b]): Colour) -> Self {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Linear light of an encoded sRGB channel (IEC 61966-2-1). Both 0..1.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encoded sRGB channel of linear light; what lies outside 0..1 is clamped.
pub(crate) fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light of an 8-bit sRGB channel.
pub(crate) fn linear_from_byte(byte: u8) -> f32 {
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));
    TABLE[usize::from(byte)]
}

/// The pixel that shows this linear RGB.
pub(crate) fn pixel_from_linear(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| (srgb_from_linear(c) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_linear_light() {
        for byte in 0..=255 {
            assert_eq!(pixel_from_linear(Colour([byte; 3]).linear()), [byte; 3]);
        }
    }

    #[test]
    fn text_round_trips_and_nonsense_is_refused() {
        let colour = Colour::try_from("#0a1Bff".to_owned()).unwrap();
        assert_eq!((colour, String::from(colour)), (Colour([10, 27, 255]), "#0a1bff".to_owned()));
        for text in ["", "#", "0a1bff", "#0a1bf", "#0a1bfff", "#0a1bfg", "#+a1bff", "#é1bff"] {
            assert_eq!(Colour::try_from(text.to_owned()), Err(ColourError(text.to_owned())));
        }
    }
}
