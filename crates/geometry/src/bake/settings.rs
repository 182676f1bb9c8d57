//! Settings of a bake.

use super::{BakeTarget, LayoutChoice};
use crate::denoise::{LastResult, NormalField};
use crate::map::displacement::{MapKind, TexelFormat};
use crate::map::normal_map::Convention;
use crate::map::occlusion::Occlusion;
use crate::map::pages::PageRule;
use crate::map::{Interpolation, Texels, map_size};
use crate::mesh::weld::Welding;
use crate::named;
use serde::{Deserialize, Serialize};

/// Settings of a bake. In JSON, fields that are missing have the values of [`BakeSettings::default`], and unknown fields are an
/// error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BakeSettings {
    /// Denoised surface that the map leads to; in JSON the field `goal`.
    #[serde(rename = "goal")]
    pub target: BakeTarget,
    /// Welding of the model, for the manifest.
    pub welding: Welding,
    /// Normals that the map displaces along; `None` chooses them as [`BakeTarget::displacements`] says.
    pub normals: Option<NormalField>,
    /// Strength λ for the normal map and the clients.
    pub lambda: Lambda,
    /// Kind of the map: heights, or vectors in object or tangent space.
    pub map: MapKind,
    /// Layout of the texels that vertices sample.
    pub layout: LayoutChoice,
    /// Division of the map into pages, each with an image of its own; only in the texture coordinates of the mesh.
    pub pages: PageRule,
    /// Side of the maps, texels; `None` chooses it. The per-vertex layout ignores it for heights and uses the side that it
    /// needs.
    pub side: Option<u32>,
    /// Largest side that may be chosen.
    pub largest_side: LargestSide,
    /// Largest error of a vertex at which [`LayoutChoice::Auto`] keeps the texture coordinates of the mesh.
    pub tolerance: Quanta,
    /// Interpolation of the texels between vertices.
    pub interpolation: Interpolation,
    /// Treatment of the texels that vertices sample.
    pub texels: Texels,
    /// File format and bits of the displacement map.
    pub texel: TexelFormat,
    /// Direction of the green channel in the normal map.
    pub convention: Convention,
    /// Files of the carrier.
    pub carriers: Carriers,
    /// Ambient occlusion map of the denoised surface; `None` bakes none.
    pub occlusion: Option<Occlusion>,
    /// Curvature map of the denoised surface.
    pub curvature: CurvatureMap,
    /// Memory of the last result. Whoever bakes one mesh again and again gives each bake the same one.
    #[serde(skip)]
    pub last_result: LastResult,
}

named! {
    /// Map of the curvature of the denoised surface.
    #[derive(Default)]
    pub enum CurvatureMap {
        /// No map.
        #[default]
        None = "none",
        /// Mean curvature, grey where the surface is flat, bright where it bulges and dark in cavities.
        Mean = "mean",
    }
}

named! {
    /// Files that carry the mesh and the numbers of its map.
    #[derive(Default)]
    pub enum Carriers {
        /// OBJ with MTL, and binary glTF.
        #[default]
        ObjAndGlb = "obj-and-glb",
        /// OBJ with MTL.
        Obj = "obj",
    }
}

/// Length in quanta, the steps between neighbouring values of the encoding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quanta(pub f64);

impl Default for Quanta {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Largest side of a map, texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LargestSide(pub u32);

impl Default for LargestSide {
    fn default() -> Self {
        Self(map_size::LARGEST_SIDE)
    }
}

/// Strength λ of the displacement: 0 gives the mesh as it was, 1 the denoised mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lambda(pub f64);

impl Default for Lambda {
    fn default() -> Self {
        Self(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::Denoiser;
    use crate::map::manifest::Target;
    use glam::DVec3;
    use serde_json::Value;

    /// Settings none of which is the default.
    fn unusual() -> BakeSettings {
        let settings = BakeSettings {
            target: Denoiser::every()[0].clone().into(),
            welding: Welding::Epsilon(0.1),
            normals: Some(NormalField::Tilted),
            lambda: Lambda(0.1),
            map: MapKind::VectorTangent,
            layout: LayoutChoice::Vertex,
            pages: PageRule::Udim,
            side: Some(77),
            largest_side: LargestSide(512),
            tolerance: Quanta(2.5),
            interpolation: Interpolation::Natural,
            texels: Texels::Interpolated,
            texel: TexelFormat::Exr16,
            convention: Convention::DirectX,
            carriers: Carriers::Obj,
            occlusion: Some(Occlusion { rays: 7, distance: Some(0.25) }),
            curvature: CurvatureMap::Mean,
            last_result: LastResult::default(),
        };
        let [default, chosen] = [&BakeSettings::default(), &settings].map(|s| serde_json::to_value(s).unwrap());
        for (field, value) in chosen.as_object().unwrap() {
            assert_ne!(*value, default[field], "{field}");
        }
        settings
    }

    #[test]
    fn every_field_survives_json() {
        for settings in [BakeSettings::default(), unusual()] {
            let text = serde_json::to_string(&settings).unwrap();
            assert_eq!(serde_json::from_str::<BakeSettings>(&text).unwrap(), settings, "{text}");
        }
        let positions = vec![DVec3::new(0.1, -1e-300, 3.0)];
        let target = BakeTarget::Positions { positions, target: Target::new("a.obj".to_owned(), "00".to_owned()) };
        let target = BakeSettings { target, ..BakeSettings::default() };
        let text = serde_json::to_string(&target).unwrap();
        assert_eq!(serde_json::from_str::<BakeSettings>(&text).unwrap(), target, "{text}");
    }

    #[test]
    fn what_is_missing_is_the_default_and_what_is_unknown_is_named() {
        assert_eq!(serde_json::from_str::<BakeSettings>("{}").unwrap(), BakeSettings::default());
        let mut json = serde_json::to_value(unusual()).unwrap();
        json["lamda"] = Value::from(1.0);
        let error = serde_json::from_value::<BakeSettings>(json).unwrap_err().to_string();
        assert!(error.contains("lamda"), "{error}");
        let error =
            serde_json::from_str::<BakeSettings>(r#"{ "goal": { "name": "sun", "iterations": -1 } }"#).unwrap_err();
        assert!(error.to_string().contains("`iterations` of sun: -1 is not a whole number"), "{error}");
    }
}
