//! Transfer functions: from values to colours and opacities.

use crate::colour::Colour;
use crate::settings::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};

/// Largest number of control points of a transfer function.
pub const MAX_POINTS: usize = 32;

/// Colour and opacity of a value; both are linear between one control point and the next, and constant beyond the ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlPoint {
    /// Value, 0 at the lower end of the range and 1 at the upper one.
    pub at: f32,
    /// Colour of the value.
    pub colour: Colour,
    /// Fraction of the light that a layer of a hundredth of the box's diagonal absorbs, 0..1.
    pub opacity: f32,
}

/// Transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transfer {
    /// One of planish's own.
    Preset(TransferPreset),
    /// Control points of one's own, in ascending order. Two at one value make a step.
    Points(Vec<ControlPoint>),
}

impl Default for Transfer {
    fn default() -> Self {
        Self::Preset(TransferPreset::default())
    }
}

named! {
/// Transfer function of planish's own.
pub enum TransferPreset {
    /// Shells at even distances, warm inside and cold outside: for signed distances.
    #[default]
    Bands = "bands",
    /// Low values are clear, middle ones soft tissue, and high ones solid: for densities.
    Bone = "bone",
    /// White, and denser the higher the value.
    Fog = "fog",
}
}

impl TransferPreset {
    /// Returns the control points.
    pub fn points(self) -> Vec<ControlPoint> {
        let point = |at: f32, colour: u32, opacity: f32| ControlPoint { at, colour: Colour::hex(colour), opacity };
        match self {
            Self::Bands => {
                // The surface itself lies at 0.5. Colours change in steps half-way between the shells, so that slices have bands.
                const EDGES: [f32; 6] = [0.125, 0.275, 0.425, 0.575, 0.725, 0.875];
                let shells = [
                    (0.2, 0x7a1f1a, 0.35),
                    (0.35, 0xe08a3a, 0.3),
                    (0.5, 0xf4efe6, 0.3),
                    (0.65, 0x58a6c9, 0.16),
                    (0.8, 0x24508f, 0.1),
                ];
                let shell = |(edges, (at, colour, opacity)): (&[f32], (f32, u32, f32))| {
                    [(edges[0], 0.0), (at - 0.02, 0.0), (at, opacity), (at + 0.02, 0.0), (edges[1], 0.0)]
                        .map(|(at, opacity)| point(at, colour, opacity))
                };
                EDGES.windows(2).zip(shells).flat_map(shell).collect()
            }
            Self::Bone => vec![
                point(0.0, 0x30100c, 0.0),
                point(0.25, 0x8a3b2a, 0.0),
                point(0.35, 0xc4745a, 0.04),
                point(0.5, 0xd99a7a, 0.05),
                point(0.6, 0xe8d3b4, 0.5),
                point(0.75, 0xf3e9d6, 0.9),
                point(1.0, 0xfffaf0, 0.97),
            ],
            Self::Fog => vec![point(0.0, 0xaeb8c2, 0.0), point(1.0, 0xffffff, 0.12)],
        }
    }
}

impl Transfer {
    /// Returns the control points.
    pub fn points(&self) -> Vec<ControlPoint> {
        match self {
            Self::Preset(preset) => preset.points(),
            Self::Points(points) => points.clone(),
        }
    }

    /// Refuses a list that is no function.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        let points = self.points();
        let is_share = |x: f32| (0.0..=1.0).contains(&x);
        require(&[
            ((1..=MAX_POINTS).contains(&points.len()), "volume.transfer.points", "1 to 32 control points"),
            (
                points.iter().all(|p| is_share(p.at) && is_share(p.opacity)),
                "volume.transfer.points",
                "with `at` and `opacity` in 0..1",
            ),
            (points.is_sorted_by(|a, b| a.at <= b.at), "volume.transfer.points", "in ascending order"),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid() {
        for &preset in TransferPreset::ALL {
            Transfer::Preset(preset).check().unwrap();
        }
    }
}
