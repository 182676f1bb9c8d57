//! The numbers that other programs want, signs folded in: they add where planish subtracts.

use crate::denoise::NormalField;
use crate::map::displacement::{Encoding, MapKind};
use crate::source::model::NormalSource;
use serde::{Deserialize, Serialize};

/// Settings of programs at the λ that was asked for. Those that cannot use a kind of map are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clients {
    /// three.js `MeshStandardMaterial`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threejs: Option<ThreeJs>,
    /// Babylon.js `applyDisplacementMap`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub babylon: Option<MinMax>,
    /// Blender's Displace modifier, image as Non-Color.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blender: Option<Blender>,
    /// `disp -mm base gain FILE`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mtl: Option<Mtl>,
    /// Unreal Engine: displacement as magnitude and centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unreal: Option<CentreMagnitude>,
    /// Unity: height map as minimum and maximum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unity: Option<MinMax>,
}

/// p + n · (texel · displacementScale + displacementBias)
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ThreeJs {
    /// −λ · scale
    pub displacement_scale: f64,
    /// −λ · bias
    pub displacement_bias: f64,
}

/// p + n · strength · (texel − mid_level)
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blender {
    /// −λ · scale
    pub strength: f64,
    /// −bias / scale; 0 for a flat map.
    pub mid_level: f64,
    /// Of the modifier.
    pub direction: BlenderDirection,
}

/// Names as in Blender's Python.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum BlenderDirection {
    /// Along the normals that Blender computes, which are angle-weighted: heights.
    #[default]
    Normal,
    /// Along the normals of the carrier: heights along others.
    CustomNormal,
    /// Red, green and blue are x, y and z, in local space: vectors.
    RgbToXyz,
}

/// p + n · (base + gain · texel)
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mtl {
    /// −λ · bias
    pub base: f64,
    /// −λ · scale
    pub gain: f64,
}

/// p + n · (min + (max − min) · texel)
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MinMax {
    /// −λ · bias
    pub min: f64,
    /// −λ · (bias + scale); smaller than `min`, for the way goes inwards.
    pub max: f64,
}

/// p + n · (inverted texel − centre) · magnitude, for a program that knows no negative magnitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CentreMagnitude {
    /// λ · scale
    pub magnitude: f64,
    /// 1 + bias / scale; 1 for a flat map.
    pub center: f64,
    /// Feed it 1 − texel.
    pub invert: bool,
}

impl Clients {
    /// Folds λ and the signs into bias and scale.
    pub fn new(kind: MapKind, normals: NormalField, encoding: Encoding, lambda: f64) -> Self {
        let (bias, scale) = (f64::from(encoding.bias), f64::from(encoding.scale));
        // Adding zero turns −0 into 0, which reads better.
        let (base, gain) = (-lambda * bias + 0.0, -lambda * scale + 0.0);
        let middle = if scale > 0.0 { -bias / scale + 0.0 } else { 0.0 };
        let blender = |direction| Some(Blender { strength: gain, mid_level: middle, direction });
        match kind {
            MapKind::Scalar => {
                let ends = MinMax { min: base, max: -lambda * (bias + scale) + 0.0 };
                Self {
                    threejs: Some(ThreeJs { displacement_scale: gain, displacement_bias: base }),
                    babylon: Some(ends),
                    blender: blender(match normals {
                        NormalField::Source(NormalSource::Angle) => BlenderDirection::Normal,
                        _ => BlenderDirection::CustomNormal,
                    }),
                    mtl: Some(Mtl { base, gain }),
                    unreal: Some(CentreMagnitude { magnitude: -gain, center: 1.0 - middle, invert: true }),
                    unity: Some(ends),
                }
            }
            MapKind::VectorObject => Self { blender: blender(BlenderDirection::RgbToXyz), ..Self::default() },
            MapKind::VectorTangent => Self::default(),
        }
    }
}
