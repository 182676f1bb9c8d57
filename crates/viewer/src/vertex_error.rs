//! Error of each vertex of the displaced surface against a clean mesh, for heat maps.

use glam::{DVec3, Vec3};
use planish_geometry::metrics::{self, CompareError, Heat, Triangles};
use planish_geometry::source::model::Model;
use planish_render::input;
use planish_render::scene::Scene;
use planish_render::settings::{Displace, Range};
use std::borrow::Cow;

/// The error of each vertex of a scene as it is displaced, degrees or mean edge lengths. #V, not a number at vertices without
/// a face.
///
/// `model` is what the scene was made of; `clean` has the same faces as its file.
pub fn errors(
    model: &Model,
    scene: &Scene,
    displace: &Displace,
    clean: &Triangles,
    what: Heat,
) -> Result<Vec<f32>, CompareError> {
    let positions = scene
        .displacement
        .as_ref()
        .map_or(Cow::Borrowed(&scene.mesh().positions), |binding| Cow::Owned(binding.displaced(displace)));
    let origin = input::origin(model);
    let positions_in_f64: Vec<DVec3> = positions.iter().map(|p: &Vec3| p.as_dvec3() + origin).collect();
    let result = Triangles::from(model.data()).at(model.weld().spread(&positions_in_f64));
    let heat = metrics::heat(clean, &result, what)?;
    Ok(model.weld().first().iter().map(|&line| heat[line as usize] as f32).collect())
}

/// Range of a heat map of errors: from 0 to the 99th percentile, so that one bad vertex does not leave all others in one colour.
pub fn range(errors: &[f32]) -> Range {
    let mut sorted: Vec<f64> = errors.iter().filter(|x| x.is_finite()).map(|x| f64::from(*x)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let high = metrics::percentile(&sorted, 0.99) as f32;
    // Where nothing is off there is no colour but the first.
    Range { low: 0.0, high: if high > 0.0 { high } else { 1.0 } }
}
