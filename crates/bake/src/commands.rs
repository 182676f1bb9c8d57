//! One file for each command.

pub(crate) mod apply;
pub(crate) mod bake;
pub(crate) mod bench_quality;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod denoise;
pub(crate) mod info;
pub(crate) mod noise;

use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use planish_geometry::denoise::limits::{LimitsError, Outcome};
use planish_geometry::model::Model;
use planish_geometry::progress::Progress as _;
use planish_geometry::weld::Welding;
use std::path::Path;

/// Share of a mesh's size above which an explicit welding distance can only be a mistake.
const LARGEST_WELD: f64 = 0.01;

/// Reads and welds a mesh.
fn model(path: &Path, welding: Welding, console: &Console) -> Result<Model, Failure> {
    console.stage("reading");
    let obj = input::obj(path)?;
    console.check()?;
    if let Welding::Epsilon(epsilon) = welding {
        let bounds = obj
            .positions()
            .iter()
            .fold([glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY], |[l, h], p| [l.min(*p), h.max(*p)]);
        let diagonal = bounds[0].distance(bounds[1]);
        if epsilon > LARGEST_WELD * diagonal {
            let limit = LARGEST_WELD * diagonal;
            return Err(Failure::at(
                path,
                format!("--weld {epsilon} is more than a hundredth of the mesh (at most {limit:.3e})"),
            ));
        }
    }
    console.stage("connecting");
    let model = Model::new(obj, welding);
    console.check()?;
    if model.surface().topology().faces().is_empty() {
        return Err(Failure::at(path, "no face has three different vertices"));
    }
    Ok(model)
}

/// A length, area or volume with six digits that count, whatever the unit of the model.
fn measure(x: f64) -> String {
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

/// Limits that a mesh cannot have, with the way out.
fn limits_do_not_fit(error: &LimitsError, mesh: &Path) -> Failure {
    match error {
        LimitsError::Open { .. } => Failure::at(mesh, format!("{error}; --preserve-volume needs --fix for these")),
        LimitsError::NoSuchLine { .. } | LimitsError::NotALength(_) => Failure::at(mesh, error),
    }
}

/// What limits did.
fn limits(outcome: &Outcome) -> String {
    let mut all = vec![format!("{} fixed, {} stopped", outcome.fixed_vertices, outcome.stopped_vertices)];
    if let Some(change) = &outcome.volume {
        let of_method = if change.by_method <= 0.0 { "restored a volume of" } else { "took back a volume of" };
        all.push(format!("{of_method} {}", measure((change.left - change.by_method).abs())));
    }
    all.join(", ")
}

/// A warning where the volume is another one than before.
fn volume_not_restored(outcome: &Outcome) -> Option<String> {
    let change = outcome.volume.filter(|change| !change.restored)?;
    Some(format!(
        "the volume is off by {}: no vertex is free to restore it, and --fix and --max-displacement come first",
        measure(change.left)
    ))
}

/// A count with its noun.
fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
