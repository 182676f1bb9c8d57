//! Light from all around: background, mirror image and ambient light.
//!
//! An environment is a cube map, whatever it was made from. Its directions are left-handed, as those of every GPU's cube
//! maps are: x right, y up, z ahead, seen from the eye at yaw 0 and pitch 0.
//!
//! ```
//! use glam::Vec3;
//! use planish_render::environment::{Environment, cube::CubeMap};
//!
//! // A blue sky over ground without light: a surface that faces up is blue, and one that faces down stays dark.
//! let blue = Vec3::new(0.2, 0.4, 1.0);
//! let sky = CubeMap::from_fn(32, |direction| if direction.y > 0.0 { blue } else { Vec3::ZERO });
//! let environment = Environment::new(sky);
//! assert!(environment.irradiance.at(Vec3::Y).distance(blue) < 0.1);
//! assert!(environment.irradiance.at(Vec3::NEG_Y).length() < 0.1);
//! // A rough mirror blurs the horizon.
//! let [smooth, rough] = [0, environment.levels.len() - 1].map(|i| environment.levels[i].at(Vec3::new(1.0, 0.3, 0.0)));
//! assert!(smooth.distance(blue) < 1e-6, "{smooth}");
//! assert!(rough.z > 0.0 && rough.z < 0.95, "{rough}");
//! ```

pub mod cube;
pub mod equirect;
mod gradient_noise;
mod harmonics;
mod prefilter;
pub(crate) mod sample;
mod scenes;
mod sky;
mod terrain;

pub use harmonics::Irradiance;
pub use scenes::Sun;

use crate::settings::environment::Scene;
use cube::CubeMap;

/// The largest number that a half float holds: no radiance is stored that exceeds it.
pub const MAX_RADIANCE: f32 = 65_504.0;

/// Light from all around, ready to be looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Blurred for roughness 0, …, 1 in even steps; each level is half the size of the one before.
    pub levels: Vec<CubeMap>,
    /// Irradiance of surfaces, without the sun of a [`Scene`].
    pub irradiance: Irradiance,
    /// The sun of a [`Scene`], which levels show and irradiance leaves to a light that casts shadows.
    pub sun: Option<Sun>,
}

impl Environment {
    /// Blurs a cube map for all roughnesses and projects its irradiance onto spherical harmonics.
    pub fn new(radiance: CubeMap) -> Self {
        Self { irradiance: Irradiance::new(&radiance), levels: prefilter::levels(radiance), sun: None }
    }

    /// Draws a landscape on faces of size² texels.
    pub fn generated(scene: Scene, size: usize) -> Self {
        let (map, sun) = scene.draw(2 * size);
        let radiance = CubeMap::from_equirect(&map, size);
        let irradiance = Irradiance::new(&radiance);
        let radiance = radiance.map(|direction, light| light + sun.at(direction));
        Self { irradiance, levels: prefilter::levels(radiance), sun: Some(sun) }
    }
}
