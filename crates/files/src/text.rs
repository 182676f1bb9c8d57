//! Numbers and reports as text for people.
//!
//! ```
//! use planish_files::text;
//! use std::path::Path;
//!
//! assert_eq!(text::count(1, "vertex", "vertices"), "1 vertex");
//! assert_eq!(text::count(12, "vertex", "vertices"), "12 vertices");
//! assert_eq!(text::measure(1234.5678), "1234.57");
//! // A name cannot begin a new line.
//! assert_eq!(text::shown(Path::new("scan\nerror: 7.obj")), r"scan\nerror: 7.obj");
//! ```

use glam::IVec2;
use planish_geometry::denoise::NormalField;
use planish_geometry::denoise::limits::Outcome;
use planish_geometry::map::manifest::Report;
use planish_geometry::source::model::NormalSource;

/// Returns a path as text in one line, for messages and reports: control characters are escaped, so that a name can neither
/// begin a new line nor send commands to a terminal.
pub fn shown(path: &std::path::Path) -> String {
    if path.as_os_str().is_empty() {
        return "\"\"".to_owned();
    }
    escaped(&path.to_string_lossy(), &[])
}

/// Returns text as one line, with control characters escaped: a name in a report for people.
pub fn one_line(text: &str) -> String {
    escaped(text, &[])
}

/// Escapes control characters, and those that change the direction of text, but for those in `kept`.
pub fn escaped(text: &str, kept: &[char]) -> String {
    let is_harmful = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{2028}' | '\u{2029}')
    };
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if is_harmful(c) && !kept.contains(&c) {
            out.extend(c.escape_debug());
        } else {
            out.push(c);
        }
    }
    out
}

/// Returns the text of an operating system error without its number.
pub fn plain(e: &std::io::Error) -> String {
    let text = e.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// Formats a length, area or volume with six significant digits, whatever the unit of the model.
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

/// Formats a count with its noun in the singular or the plural.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Formats the errors of a map: of the displaced positions in model units, and of the map alone in quanta, the steps of its
/// encoding. Errors far above a quantum are given in per cent of `range`, the range of the map.
pub fn errors(r: &Report, range: f64) -> String {
    let map = &r.map_errors;
    let unit = |error: f64| match r.quantum > 0.0 {
        false => "0".to_owned(),
        true if map.max < 100.0 * r.quantum => format!("{:.2} quanta", error / r.quantum),
        true => format!("{:.2} % of the range", 100.0 * error / range),
    };
    let positions = format!("max {:.3e}, 99 % below {:.3e}, mean {:.3e}", r.max_error, r.p99_error, r.mean_error);
    format!("{positions}; of the map alone max {}, 99 % below {}", unit(map.max), unit(map.p99))
}

/// Returns a note if the texture coordinates of a mesh lie in another tile than [0, 1]², which is told by its lower left corner.
pub fn in_tile(tile: IVec2) -> Option<String> {
    let corner = format!("({}, {})", tile.x, tile.y);
    let note = "maps repeat there, and programs that do not repeat them subtract this corner";
    (tile != IVec2::ZERO).then(|| format!("the UVs lie in the tile from {corner}: {note}"))
}

/// Describes the normals that a map displaces along.
pub fn along(normals: NormalField) -> &'static str {
    match normals {
        NormalField::Source(NormalSource::File) => "from the file",
        NormalField::Source(NormalSource::Uniform) => "mean of the face normals",
        NormalField::Source(NormalSource::Area) => "area-weighted",
        NormalField::Source(NormalSource::Angle) => "angle-weighted",
        NormalField::Denoised => "angle-weighted, of the denoised surface",
        NormalField::Tilted => "angle-weighted, of the denoised surface, tilted where needed",
    }
}

/// Describes how limits were kept: vertices that were fixed or stopped, and the volume that was restored.
pub fn limits(outcome: &Outcome) -> String {
    let mut all = vec![format!("{} fixed, {} stopped", outcome.fixed_vertices, outcome.stopped_vertices)];
    if outcome.weighted_vertices > 0 {
        all.push(format!("{} held back by the mask", outcome.weighted_vertices));
    }
    if let Some(change) = &outcome.volume {
        let of_method = if change.by_method <= 0.0 { "restored a volume of" } else { "took back a volume of" };
        all.push(format!("{of_method} {}", measure((change.left - change.by_method).abs())));
    }
    all.join(", ")
}

/// Returns a warning if the volume could not be restored.
pub fn volume_not_restored(outcome: &Outcome) -> Option<String> {
    let change = outcome.volume.filter(|change| !change.restored)?;
    Some(format!(
        "the volume is off by {}: no vertex is free to restore it, and --fix and --max-displacement come first",
        measure(change.left)
    ))
}
