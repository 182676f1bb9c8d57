//! Which settings a picture can be drawn with.

use super::{Pattern, Range, Settings, ShadowFilter};
use crate::camera::{Camera, Projection};
use crate::lights::{Light, LightKind, MAX_LIGHTS};
use thiserror::Error;

/// Why a text is not the settings of a picture.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// Not JSON, an unknown field or a value of the wrong kind.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// A number out of its range.
    #[error("{name} must be {expected}")]
    OutOfRange {
        /// The field.
        name: &'static str,
        /// What it may be.
        expected: &'static str,
    },
}

/// Names the first field that is out of its range.
pub(super) fn check(settings: &Settings) -> Result<(), SettingsError> {
    let rules = [picture(settings).as_slice(), &surface(settings), &light(settings), &around(settings)].concat();
    match rules.into_iter().find(|(holds, ..)| !holds) {
        Some((_, name, expected)) => Err(SettingsError::OutOfRange { name, expected }),
        None => Ok(()),
    }
}

/// Whether it holds, for which field, and what the field must be.
type Rule = (bool, &'static str, &'static str);

fn amount(x: f32) -> bool {
    (0.0..=1e3).contains(&x)
}

fn share(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

fn picture(settings: &Settings) -> [Rule; 6] {
    let Camera { yaw, pitch, distance, projection, .. } = settings.camera;
    let field_of_view = match projection {
        Projection::Perspective { field_of_view } => field_of_view,
        Projection::Orthographic => 90.0,
    };
    let pixels = 1..=16_384;
    [
        (pixels.contains(&settings.size.width), "size.width", "1..16384"),
        (pixels.contains(&settings.size.height), "size.height", "1..16384"),
        ((1..=8).contains(&settings.supersampling), "supersampling", "1..8"),
        (yaw.is_finite() && pitch.is_finite(), "camera.yaw and camera.pitch", "finite"),
        ((0.01..=1e3).contains(&distance), "camera.distance", "0.01..1000"),
        ((1.0..=150.0).contains(&field_of_view), "field_of_view", "1..150 degrees"),
    ]
}

fn surface(settings: &Settings) -> [Rule; 12] {
    let Settings { map, relief, material, sampling, checker, heat, overlay, .. } = settings;
    let ordered = |r: Range| r.low < r.high && (r.high - r.low).is_finite();
    let frequency = match material.pattern {
        Pattern::Plain => 1.0,
        Pattern::Noise { frequency, .. } => frequency,
    };
    let moderate = |x: f32| x.abs() <= 1e3;
    [
        // As the manifest has it: anything near it is a mistake.
        (map.lambda.abs() <= 1e6, "map.lambda", "-1000000..1000000"),
        (moderate(relief.lambda), "relief.lambda", "-1000..1000"),
        (moderate(relief.bias) && moderate(relief.scale), "relief.bias and relief.scale", "-1000..1000"),
        (moderate(relief.bump), "relief.bump", "-1000..1000"),
        (amount(material.specular), "material.specular", "0..1000"),
        ((1.0..=1e4).contains(&material.exponent), "material.exponent", "1..10000"),
        (amount(frequency), "material.pattern.noise.frequency", "0..1000"),
        ([2, 4, 8, 16].contains(&sampling.anisotropy), "sampling.anisotropy", "2, 4, 8 or 16"),
        ((0.0..=1e5).contains(&checker.squares), "checker.squares", "0..100000"),
        (heat.range.is_none_or(ordered), "heat.range", "finite and ascending"),
        (share(heat.relief), "heat.relief", "0..1"),
        ((0.1..=100.0).contains(&overlay.width), "overlay.width", "0.1..100 pixels"),
    ]
}

fn light(settings: &Settings) -> [Rule; 4] {
    let distance = |d: f32| (1e-3..=1e3).contains(&d);
    let placed = |l: &Light| match l.kind {
        LightKind::Directional => true,
        LightKind::Point { distance: d } => distance(d),
        LightKind::Spot { distance: d, angle, softness } => {
            distance(d) && (1.0..=170.0).contains(&angle) && share(softness)
        }
    };
    let usable = |l: &Light| l.azimuth.is_finite() && l.elevation.is_finite() && amount(l.intensity);
    [
        (settings.lights.len() <= MAX_LIGHTS, "lights", "at most four"),
        (settings.lights.iter().all(usable), "each light", "finite, its intensity 0..1000"),
        (
            settings.lights.iter().all(placed),
            "each light.kind",
            "at a distance of 0.001..1000 radii, its angle 1..170 degrees, its softness 0..1",
        ),
        (amount(settings.ambient.intensity), "ambient.intensity", "0..1000"),
    ]
}

fn around(settings: &Settings) -> [Rule; 9] {
    let Settings { shadows, ground, environment, .. } = settings;
    let filter = match shadows.filter {
        ShadowFilter::Off | ShadowFilter::Hard => true,
        ShadowFilter::Pcf { side } => [3, 5, 7].contains(&side),
        ShadowFilter::Soft { light_size } => amount(light_size),
    };
    [
        (filter, "shadows.filter", "pcf of side 3, 5 or 7, or soft with a light_size of 0..1000"),
        ((16..=16_384).contains(&shadows.map_size), "shadows.map_size", "16..16384"),
        (share(shadows.slope_bias), "shadows.slope_bias", "0..1"),
        (share(shadows.least_bias), "shadows.least_bias", "0..1"),
        ((0.1..=1e3).contains(&ground.extent), "ground.extent", "0.1..1000"),
        (ground.gap.abs() <= 1e3, "ground.gap", "-1000..1000"),
        (environment.turn.is_finite(), "environment.turn", "finite"),
        (amount(environment.intensity), "environment.intensity", "0..1000"),
        (share(environment.reflection), "environment.reflection", "0..1"),
    ]
}
