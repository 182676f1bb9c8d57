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

/// A count with its noun.
fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
