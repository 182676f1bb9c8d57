//! Settings of other programs for a map, with the signs that they need: they add displacements where planish subtracts.

use crate::denoise::NormalField;
use crate::map::displacement::{Encoding, MapKind};
use crate::source::model::NormalSource;
use serde::{Deserialize, Serialize};

/// Settings of programs for the strength λ of the manifest; `None` for a program that cannot use this kind of map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clients {
    /// Settings of a three.js `MeshStandardMaterial`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threejs: Option<ThreeJs>,
    /// Arguments of `applyDisplacementMap` in Babylon.js.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub babylon: Option<MinMax>,
    /// Settings of Blender's Displace modifier, with the colour space of the image set to Non-Color.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blender: Option<Blender>,
    /// Arguments of the statement `disp -mm base gain FILE` in a material library.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mtl: Option<Mtl>,
    /// Magnitude and centre of the displacement in Unreal Engine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unreal: Option<CentreMagnitude>,
    /// Minimum and maximum of the height map in Unity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unity: Option<MinMax>,
}

/// Settings of three.js, which computes p + n · (texel · displacementScale + displacementBias).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ThreeJs {
    /// Scale of the texels, −λ · scale, model units.
    pub displacement_scale: f64,
    /// Height at texel 0, −λ · bias, model units.
    pub displacement_bias: f64,
}

/// Settings of Blender, which computes p + n · strength · (texel − mid_level).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blender {
    /// Strength of the modifier, −λ · scale, model units.
    pub strength: f64,
    /// Midlevel of the modifier, the texel without displacement: −bias / scale; 0 for a flat map.
    pub mid_level: f64,
    /// Direction of the modifier.
    pub direction: BlenderDirection,
}

/// Directions of Blender's Displace modifier, with the names of its Python interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum BlenderDirection {
    /// Heights displace along the normals that Blender computes, which are angle-weighted.
    #[default]
    Normal,
    /// Heights displace along the normals of the carrier, which are others.
    CustomNormal,
    /// Vectors displace: red, green and blue are x, y and z in local space.
    RgbToXyz,
}

/// Arguments of a `disp` statement, by which a client computes p + n · (base + gain · texel).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mtl {
    /// Height at texel 0, −λ · bias, model units.
    pub base: f64,
    /// Scale of the texels, −λ · scale, model units.
    pub gain: f64,
}

/// Settings of a program that computes p + n · (min + (max − min) · texel).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MinMax {
    /// Height at texel 0, −λ · bias, model units.
    pub min: f64,
    /// Height at texel 1, −λ · (bias + scale), model units; smaller than `min` for positive λ.
    pub max: f64,
}

/// Settings of a program without negative magnitudes, which computes p + n · (texel − centre) · magnitude for inverted texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CentreMagnitude {
    /// Magnitude, λ · scale, model units.
    pub magnitude: f64,
    /// Inverted texel without displacement, 1 + bias / scale; 1 for a flat map.
    pub center: f64,
    /// True if the program must be given 1 − texel.
    pub invert: bool,
}

impl Clients {
    /// Computes the settings of each program from λ, bias and scale.
    pub fn new(kind: MapKind, normals: NormalField, encoding: Encoding, lambda: f64) -> Self {
        let (bias, scale) = (f64::from(encoding.bias), f64::from(encoding.scale));
        // Adding zero makes −0 a 0, which reads better.
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
