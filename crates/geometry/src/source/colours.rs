//! Colours of vertices: files have them encoded as sRGB, and glTF linear.

/// Linear value of a channel that is encoded as sRGB, 0..=1 (IEC 61966-2-1).
pub(crate) fn to_linear(x: f32) -> f32 {
    let x = f64::from(x.clamp(0.0, 1.0));
    (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}

/// Channel encoded as sRGB, by its linear value, 0..=1.
pub(crate) fn from_linear(x: f32) -> f32 {
    let x = f64::from(x.clamp(0.0, 1.0));
    (if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=u8::MAX {
            let x = f32::from(byte) / 255.0;
            assert_eq!((from_linear(to_linear(x)) * 255.0).round() as u8, byte);
        }
        assert_eq!([to_linear(0.0), to_linear(1.0), from_linear(0.0), from_linear(1.0)], [0.0, 1.0, 0.0, 1.0]);
        assert!((to_linear(0.5) - 0.214_041_14).abs() < 1e-6);
    }
}
