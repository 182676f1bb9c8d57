//! Laws, tried on random input.

mod bake;
mod manifest;
mod obj;
mod polygon;
mod spelling;
mod topology;
mod weld;

use proptest::prelude::*;

/// Settings of all properties here. Failures are not written to a file: a found bug becomes a named test.
fn cases(cases: u32) -> ProptestConfig {
    // PROPTEST_CASES asks for more.
    let cases = std::env::var("PROPTEST_CASES").map_or(cases, |n| n.parse().unwrap());
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// Few different numbers, so that coincidences happen, both zeros among them.
fn coarse() -> impl Strategy<Value = f64> {
    prop_oneof![8 => (-3..=3_i8).prop_map(|i| f64::from(i) / 2.0), 1 => Just(-0.0)]
}

/// Any finite number, subnormal and huge ones too.
fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
}
