//! One value that says everything about a picture: what headless mode loads, and what a reference
//! image is drawn from.
//!
//! Settings are plain data, stored as JSON; the modules beside this one turn them into pictures.
//!
//! ```
//! use planish_render::settings::{Settings, SettingsError, Shading};
//!
//! let settings = Settings::from_json(br##"{ "shading": "flat", "material": { "colour": "#ff0000" } }"##)?;
//! assert_eq!((settings.shading, settings.size.width), (Shading::Flat, 1200));
//! assert_eq!(Settings::from_json(settings.to_json()?.as_bytes())?, settings);
//! let failure = Settings::from_json(br#"{ "size": { "width": 0, "height": 900 } }"#).unwrap_err();
//! assert_eq!(failure.to_string(), "size.width must be 1..16384");
//! # Ok::<(), SettingsError>(())
//! ```

pub mod camera;
mod displace;
pub mod environment;
pub mod ground;
pub mod lights;
mod rules;
pub mod shadow;
mod surface;
pub mod volume;

pub use displace::{Displace, Normals};
pub use rules::SettingsError;
pub use surface::{Checker, Heat, Marble, Material, Overlay, Range, Sampling, Shading};

use crate::colour::Colour;
use camera::Camera;
use environment::Surroundings;
use ground::Ground;
use lights::{Ambient, Light, MAX_LIGHTS};
use rules::require;
use serde::{Deserialize, Serialize};
use shadow::Shadow;
use std::str::FromStr;
use volume::VolumeView;

/// All that a picture depends on, beside the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Size of the picture.
    pub size: Size,
    /// Samples per pixel in each direction, averaged in linear light; on a GPU on top of its own four.
    pub supersampling: u32,
    /// Camera that takes the picture.
    pub camera: Camera,
    /// Displacement of the vertices by the map.
    pub displace: Displace,
    /// Shading of the surface.
    pub shading: Shading,
    /// Lines on top of the surface.
    pub overlay: Overlay,
    /// Interpolation of textures between their texels.
    pub sampling: Sampling,
    /// Material of the surface.
    pub material: Material,
    /// Lights, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// Shadows that the lights cast.
    pub shadow: Shadow,
    /// Ground under the model.
    pub ground: Ground,
    /// Light from all directions.
    pub ambient: Ambient,
    /// Gradient behind the model.
    pub background: Background,
    /// Landscape all around, in place of the ambient light and the background.
    pub environment: Option<Surroundings>,
    /// Volume that is drawn, or that [`Shading::Solid`] takes its colours from.
    pub volume: Option<VolumeView>,
    /// Squares that [`Shading::Checker`] shows.
    pub checker: Checker,
    /// Veins that [`Shading::Marble`] shows.
    pub marble: Marble,
    /// Colours of [`Shading::Height`] and [`Shading::Heat`].
    pub heat: Heat,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: Size::default(),
            supersampling: 3,
            camera: Camera::default(),
            displace: Displace::default(),
            shading: Shading::default(),
            overlay: Overlay::default(),
            sampling: Sampling::default(),
            material: Material::default(),
            lights: Light::key_and_fill(),
            shadow: Shadow::default(),
            ground: Ground::default(),
            ambient: Ambient::default(),
            background: Background::default(),
            environment: None,
            volume: None,
            checker: Checker::default(),
            marble: Marble::default(),
            heat: Heat::default(),
        }
    }
}

/// Width and height in pixels, `WxH` in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Default for Size {
    fn default() -> Self {
        Self { width: 1200, height: 900 }
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split_once('x')
            .and_then(|(w, h)| Some(Self { width: w.parse().ok()?, height: h.parse().ok()? }))
            .ok_or_else(|| "expected WIDTHxHEIGHT, for example 1200x900".to_owned())
    }
}

/// Vertical colour gradient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Background {
    /// Colour of the first row.
    pub top: Colour,
    /// Colour of the last row.
    pub bottom: Colour,
}

impl Default for Background {
    fn default() -> Self {
        Self { top: Colour::hex(0xf6f6f5), bottom: Colour::hex(0xd2d5d9) }
    }
}

impl Settings {
    /// Reads JSON; fields that it leaves out keep their defaults.
    pub fn from_json(json: &[u8]) -> Result<Self, SettingsError> {
        let settings: Self = serde_json::from_slice(json)?;
        settings.check()?;
        Ok(settings)
    }

    /// Writes all fields as JSON.
    pub fn to_json(&self) -> Result<String, SettingsError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Refuses numbers that no picture can be drawn with, and names the field.
    pub fn check(&self) -> Result<(), SettingsError> {
        let pixels = 1..=16_384;
        require(&[
            (pixels.contains(&self.size.width), "size.width", "1..16384"),
            (pixels.contains(&self.size.height), "size.height", "1..16384"),
            ((1..=8).contains(&self.supersampling), "supersampling", "1..8"),
        ])?;
        self.camera.check()?;
        self.displace.check()?;
        self.material.check()?;
        require(&[
            (self.lights.len() <= MAX_LIGHTS, "lights", "at most four"),
            (
                self.lights.iter().all(Light::is_valid),
                "each light",
                "finite, its intensity 0..1000, its distance 0.01..1000, its angle 1..170",
            ),
        ])?;
        self.ambient.check()?;
        self.checker.check()?;
        self.marble.check()?;
        self.heat.check()?;
        self.shadow.check()?;
        self.ground.check()?;
        self.environment.as_ref().map_or(Ok(()), Surroundings::check)?;
        self.volume.as_ref().map_or(Ok(()), VolumeView::check)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camera::{Projection, UpAxis};
    use lights::LightKind;
    use serde_json::Value;
    use volume::{RawVolume, Transfer, TransferPreset, VolumeSource};

    #[test]
    fn a_file_round_trips() {
        let settings = Settings {
            size: Size { width: 17, height: 5 },
            camera: Camera { yaw: 0.1, up: UpAxis::Z, projection: Projection::Orthographic, ..Camera::default() },
            shading: Shading::Heat,
            heat: Heat { range: Some(Range { low: -0.3, high: 1e-7 }), ..Heat::default() },
            lights: Vec::new(),
            ..Settings::default()
        };
        for settings in [settings, Settings::default()] {
            let json = settings.to_json().unwrap();
            assert_eq!(Settings::from_json(json.as_bytes()).unwrap(), settings);
        }
    }

    #[test]
    fn what_is_left_out_keeps_its_default() {
        let settings = Settings::from_json(br#"{ "camera": { "yaw": 90 } }"#).unwrap();
        let camera = Camera { yaw: 90.0, ..Camera::default() };
        assert_eq!(settings, Settings { camera, ..Settings::default() });
    }

    #[test]
    fn misspelt_and_impossible_settings_are_refused_by_name() {
        for (json, name) in [
            (r#"{ "sizes": 3 }"#, "sizes"),
            (r#"{ "size": { "width": 0, "height": 9 } }"#, "size.width"),
            (r#"{ "supersampling": 99 }"#, "supersampling"),
            (r#"{ "camera": { "projection": { "perspective": { "field_of_view": 180 } } } }"#, "field_of_view"),
            (r#"{ "shadow": { "kernel": 4 } }"#, "shadow.kernel"),
            (r#"{ "shadow": { "filter": "soft" } }"#, "soft"),
            (r#"{ "ground": { "size": 0 } }"#, "ground.size"),
            (r#"{ "environment": { "roughness": 2 } }"#, "environment.roughness"),
            (r#"{ "environment": { "source": "moon" } }"#, "moon"),
            (r#"{ "volume": { "source": { "distance": { "size": 100000 } } } }"#, "volume.source.distance.size"),
            (r#"{ "volume": { "low": [0, 0.5, 0], "high": [1, 0.5, 1] } }"#, "volume.low"),
            (r#"{ "volume": { "slices": [null, 1.5, null] } }"#, "volume.slices"),
            (r#"{ "volume": { "transfer": { "preset": "mist" } } }"#, "mist"),
            (r#"{ "volume": { "transfer": { "points": [] } } }"#, "volume.transfer.points"),
            (
                r##"{ "volume": { "transfer": { "points": [{ "at": 0.5, "colour": "#000000", "opacity": 1 },
                    { "at": 0.4, "colour": "#000000", "opacity": 1 }] } } }"##,
                "ascending",
            ),
            (r#"{ "heat": { "range": { "low": 1, "high": 1 } } }"#, "heat.range"),
            (r#"{ "material": { "colour": "red" } }"#, "red"),
        ] {
            let message = Settings::from_json(json.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(name), "{json}: {message}");
        }
    }

    /// Settings with every optional part.
    fn everything() -> Settings {
        let mut settings = Settings::default();
        settings.lights[0].kind = LightKind::Spot { distance: 2.0, angle: 30.0 };
        settings.lights[1].kind = LightKind::Point { distance: 2.0 };
        settings.displace.bias = Some(0.5);
        settings.displace.scale = Some(0.5);
        settings.heat.range = Some(Range { low: 0.0, high: 1.0 });
        settings.environment = Some(Surroundings::default());
        let raw = RawVolume { file: "a.raw".into(), size: [4, 5, 6], sample: <_>::default(), spacing: [1.0; 3] };
        settings.volume = Some(VolumeView {
            source: VolumeSource::Raw(raw),
            transfer: Transfer::Points(TransferPreset::Bone.points()),
            range: Some(Range { low: 0.0, high: 1.0 }),
            slices: [Some(0.5); 3],
            ..VolumeView::default()
        });
        settings
    }

    /// Paths of all numbers of a JSON value.
    fn numbers(value: &Value, path: &str, into: &mut Vec<String>) {
        match value {
            Value::Number(_) => into.push(path.to_owned()),
            Value::Array(all) => all.iter().enumerate().for_each(|(i, v)| numbers(v, &format!("{path}/{i}"), into)),
            Value::Object(all) => all.iter().for_each(|(k, v)| numbers(v, &format!("{path}/{k}"), into)),
            _ => {}
        }
    }

    #[test]
    fn every_number_but_angles_and_heights_has_a_range() {
        let json = serde_json::to_value(everything()).unwrap();
        let mut paths = Vec::new();
        numbers(&json, "", &mut paths);
        assert!(paths.len() > 40, "{paths:?}");
        let unbounded = ["yaw", "pitch", "rotation", "azimuth", "elevation", "bias", "scale"];
        for path in paths {
            let mut huge = json.clone();
            *huge.pointer_mut(&path).unwrap() = Value::from(1e30);
            let refused = Settings::from_json(huge.to_string().as_bytes()).is_err();
            let bounded = !unbounded.iter().any(|name| path.ends_with(&format!("/{name}")));
            // The upper end of a range of colours may be anywhere above the lower one.
            assert_eq!(refused, bounded && !path.ends_with("/range/high"), "{path}");
        }
    }

    #[test]
    fn words_are_those_of_json() {
        assert_eq!(serde_json::to_value(Shading::ALL).unwrap(), serde_json::to_value(Shading::NAMES).unwrap());
        assert_eq!(serde_json::to_value(Shading::NormalMap).unwrap(), Shading::NormalMap.name());
    }
}
