//! Numbers as people read them.

use planish_geometry::denoise::NormalField;
use planish_geometry::denoise::limits::Outcome;
use planish_geometry::map::manifest::Report;
use planish_geometry::source::model::NormalSource;

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

/// What a map displaces along, in words.
pub fn along(normals: NormalField) -> &'static str {
    match normals {
        NormalField::Source(NormalSource::File) => "those of the file",
        NormalField::Source(NormalSource::Uniform) => "means over the faces",
        NormalField::Source(NormalSource::Area) => "area-weighted",
        NormalField::Source(NormalSource::Angle) => "angle-weighted",
        NormalField::Denoised => "angle-weighted, of the denoised surface",
        NormalField::Tilted => "angle-weighted, of the denoised surface, leaning where needed",
    }
}

/// What limits did.
pub fn limits(outcome: &Outcome) -> String {
    let mut all = vec![format!("{} fixed, {} stopped", outcome.fixed_vertices, outcome.stopped_vertices)];
    if let Some(change) = &outcome.volume {
        let of_method = if change.by_method <= 0.0 { "restored a volume of" } else { "took back a volume of" };
        all.push(format!("{of_method} {}", measure((change.left - change.by_method).abs())));
    }
    all.join(", ")
}

/// A warning where the volume is another one than before.
pub fn volume_not_restored(outcome: &Outcome) -> Option<String> {
    let change = outcome.volume.filter(|change| !change.restored)?;
    Some(format!(
        "the volume is off by {}: no vertex is free to restore it, and --fix and --max-displacement come first",
        measure(change.left)
    ))
}
