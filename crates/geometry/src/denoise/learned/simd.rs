//! Single-precision arithmetic that compilers turn into vector instructions, with the same bits on every processor.
//!
//! Sums run in sixteen lanes of a fixed order, products and sums are rounded one by one, and nothing depends on how wide the registers
//! of a processor are.

/// Number of lanes of a sum.
pub(super) const LANES: usize = 16;

/// Runs `work` with the widest vector instructions of this processor. What it calls must be inlined to profit.
#[inline(always)]
pub(super) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    // WebAssembly has one width, chosen when it is compiled.
    #[cfg(target_family = "wasm")]
    return work();
    #[cfg(not(target_family = "wasm"))]
    pulp::Arch::new().dispatch(work)
}

/// Exponential function for arguments up to 0, to a relative error of 10⁻⁷ (2 + |x|); arguments below −80 count as −80.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    /// 1.5·2²³: adding it leaves the nearest integer in the last bits of the mantissa.
    const SHIFT: f32 = 12_582_912.0;
    let t = if x > -80.0 { x } else { -80.0 } * std::f32::consts::LOG2_E;
    let shifted = t + SHIFT;
    let f = (t - (shifted - SHIFT)) * std::f32::consts::LN_2;
    let series = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
    let exponent = shifted.to_bits().wrapping_sub(SHIFT.to_bits()).wrapping_add(127);
    series * f32::from_bits(exponent << 23)
}

/// Sum of the lanes, by halves.
#[inline(always)]
pub(super) fn total(lanes: [f32; LANES]) -> f32 {
    let (mut eight, mut four) = ([0.0; 8], [0.0; 4]);
    for k in 0..8 {
        eight[k] = lanes[k] + lanes[k + 8];
    }
    for k in 0..4 {
        four[k] = eight[k] + eight[k + 4];
    }
    (four[0] + four[2]) + (four[1] + four[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_right_to_single_precision() {
        for k in 0..=8000 {
            let x = -f64::from(k) / 100.0;
            let relative = f64::from(exp(x as f32)) / f64::from(x as f32).exp() - 1.0;
            assert!(relative.abs() < 1e-7 * (2.0 - x), "{x}: {relative}");
        }
        assert_eq!((exp(0.0), exp(f32::NEG_INFINITY)), (1.0, exp(-80.0)));
    }
}
