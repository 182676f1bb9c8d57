//! Numbers as people read them.

use planish_geometry::manifest::Report;

/// A length, area or volume with six digits that count, whatever the unit of the model.
pub fn measure(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = x.abs().log10().floor();
    if (-5.0..9.0).contains(&magnitude) {
        let decimals = (5.0 - magnitude).max(0.0) as usize;
        format!("{x:.decimals$}")
    } else {
        format!("{x:.5e}")
    }
}

/// A count with its noun.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Errors of the places in model units, and of the map in quanta, which is what the encoding allows, or in shares of
/// the range where it is far from that.
pub fn errors(r: &Report, range: f64) -> String {
    let map = &r.map_errors;
    let unit = |error: f64| match r.quantum > 0.0 {
        false => "0".to_owned(),
        true if map.max < 100.0 * r.quantum => format!("{:.2} quanta", error / r.quantum),
        true => format!("{:.2} % of the range", 100.0 * error / range),
    };
    let places = format!("max {:.3e}, 99 % below {:.3e}, mean {:.3e}", r.max_error, r.p99_error, r.mean_error);
    format!("{places}; of the map alone max {}, 99 % below {}", unit(map.max), unit(map.p99))
}
