//! Settings of a volume: where its values come from, and how they are drawn.
//!
//! ```
//! use planish_render::settings::volume::{Transfer, TransferPreset, VolumeDisplay, VolumeSource, VolumeView};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! // A slice through the middle of the signed distances to a mesh.
//! let json = br#"{ "volume": { "display": "slices", "slices": [null, null, 0.5], "transfer": { "preset": "bands" } } }"#;
//! let view = Settings::from_json(json)?.volume.unwrap();
//! assert_eq!((view.display, view.slices[2]), (VolumeDisplay::Slices, Some(0.5)));
//! assert_eq!(view.source, VolumeSource::Distance { size: 96 });
//! assert_eq!(view.transfer, Transfer::Preset(TransferPreset::Bands));
//! assert!(VolumeView { low: [1.0; 3], ..view }.check().is_err());
//! # Ok::<(), SettingsError>(())
//! ```

mod source;
mod transfer;

pub use source::{MAX_VALUES, Placement, RawVolume, SampleType, VolumeSource};
pub use transfer::{ControlPoint, MAX_POINTS, Transfer, TransferPreset};

use super::Range;
use super::environment::Part;
use super::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};

named! {
/// Display of a volume by itself; a surface with [`Shading::Solid`](super::Shading::Solid) shows the volume in any case.
pub enum VolumeDisplay {
    /// Nothing is drawn.
    Hidden = "hidden",
    /// The slice planes alone, opaque.
    Slices = "slices",
    /// The whole box of the volume, through which the rays of the eye march; slice planes are walls in it.
    #[default]
    Rays = "rays",
}
}

/// A volume, and how it is drawn. Shares of its box run along its own axes, from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VolumeView {
    /// Origin of the values.
    pub source: VolumeSource,
    /// Position of the box.
    pub placement: Placement,
    /// Part of the volume that is drawn: rays, slices alone, or nothing.
    pub display: VolumeDisplay,
    /// Visibility of the mesh.
    pub mesh: Part,
    /// Colour and opacity of the values.
    pub transfer: Transfer,
    /// Values at the ends of the transfer function; `None` takes those of the volume.
    pub range: Option<Range>,
    /// Factor of the opacities of the transfer function, as if the volume were so many times as thick.
    pub density: f32,
    /// Strength of the light on surfaces inside the volume, 0..1; at 0 colours are those of the transfer function.
    pub lighting: f32,
    /// Distance from one sample of a ray to the next, in the shortest sides of a voxel.
    pub step: f32,
    /// Slice plane across each axis, as a share of the box.
    pub slices: [Option<f32>; 3],
    /// Least coordinates of the part of the box that is drawn, as shares of the box.
    pub low: [f32; 3],
    /// Greatest coordinates of the part of the box that is drawn, as shares of the box.
    pub high: [f32; 3],
}

impl Default for VolumeView {
    fn default() -> Self {
        Self {
            source: VolumeSource::default(),
            placement: Placement::default(),
            display: VolumeDisplay::default(),
            mesh: Part::Shown,
            transfer: Transfer::default(),
            range: None,
            density: 1.0,
            lighting: 0.7,
            step: 0.5,
            slices: [None; 3],
            low: [0.0; 3],
            high: [1.0; 3],
        }
    }
}

impl VolumeView {
    /// Refuses numbers that no picture can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.source.check()?;
        self.transfer.check()?;
        let is_share = |x: &f32| (0.0..=1.0).contains(x);
        let ordered = |r: Range| r.low < r.high && (r.high - r.low).is_finite();
        require(&[
            (self.range.is_none_or(ordered), "volume.range", "finite and ascending"),
            ((0.0..=1e4).contains(&self.density), "volume.density", "0..10000"),
            (is_share(&self.lighting), "volume.lighting", "0..1"),
            ((0.05..=10.0).contains(&self.step), "volume.step", "0.05..10"),
            (self.slices.iter().flatten().all(is_share), "volume.slices", "shares of the box, 0..1"),
            (self.low.iter().chain(&self.high).all(is_share), "volume.low and volume.high", "shares of the box, 0..1"),
            (self.low.iter().zip(&self.high).all(|(l, h)| l < h), "volume.low", "below volume.high along each axis"),
        ])
    }
}
