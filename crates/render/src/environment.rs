//! Light from all around: background, mirror image and ambient light.
//!
//! An environment is a cube map, whatever it was made from. Its directions are left-handed, as those of every GPU's cube
//! maps are: x right, y up, z ahead, seen from the eye at yaw 0 and pitch 0.

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
