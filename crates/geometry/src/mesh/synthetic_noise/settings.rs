//! Kinds of synthetic noise and their settings.

use super::white::Direction;
use crate::named;
use glam::DVec3;
use rand_distr::{Distribution, UnitSphere};
use serde_json::{Map, Value, json};

named! {
    /// Kind of synthetic noise, by the way in which it disturbs a mesh.
    #[derive(Default)]
    pub enum SyntheticKind {
        /// Gaussian noise, independent from vertex to vertex.
        #[default]
        White = "white",
        /// Gaussian noise at a share of the vertices; the others stay.
        Impulsive = "impulsive",
        /// Gaussian noise that neighbours share, as matching and filtering leave it, and a little white noise.
        Correlated = "correlated",
        /// Coordinates rounded to a grid, as files with few digits have them.
        Rounded = "rounded",
        /// Errors along the rays of a camera, which grow with the square of the depth.
        Camera = "camera",
        /// White noise that grows from nothing at one end of the mesh to twice σ at the other.
        Fade = "fade",
        /// White noise on one side of a line across the mesh; the other side is clean.
        Partial = "partial",
        /// White noise in lengths of the edges around each vertex, which is weaker where the mesh is finer.
        Local = "local",
        /// Few vertices that stick out by several edges; the others stay.
        Spikes = "spikes",
        /// The surface as one depth camera sees it, as a mesh of its own.
        RangeImage = "range-image",
        /// Depth images from all sides, fused in a grid and meshed anew.
        Fusion = "fusion",
        /// The surface of voxels, meshed anew; the mesh must be closed.
        Voxels = "voxels",
    }
}

named! {
    /// Setting of a kind of synthetic noise, which is a field of [`SyntheticNoise`].
    pub enum NoiseSetting {
        /// Standard deviation of the noise, in mean edge lengths.
        Sigma = "sigma",
        /// Direction in which vertices move.
        Direction = "direction",
        /// Fraction of the vertices that move; with partial noise, of the area that is noisy.
        Share = "share",
        /// Length of a spike, in mean edge lengths.
        Length = "length",
        /// Distance over which the correlation of the noise falls to 1/e, in edges or pixels.
        Correlation = "correlation",
        /// Direction from the mesh to the eye, or in which the noise grows.
        Towards = "towards",
        /// Distance of the eye from the centre of the mesh, in radii of the sphere around its bounding box.
        Distance = "distance",
        /// Width of a pixel at the centre of the mesh, or of a voxel, in mean edge lengths.
        Step = "step",
    }
}

impl SyntheticKind {
    /// Settings that the kind has; the others have no effect on it.
    pub fn settings(self) -> &'static [NoiseSetting] {
        use NoiseSetting as S;
        match self {
            Self::White | Self::Local => &[S::Sigma, S::Direction],
            Self::Impulsive => &[S::Sigma, S::Direction, S::Share],
            Self::Correlated => &[S::Sigma, S::Correlation],
            Self::Rounded => &[S::Sigma],
            Self::Camera => &[S::Sigma, S::Correlation, S::Towards, S::Distance],
            Self::Fade => &[S::Sigma, S::Direction, S::Towards],
            Self::Partial => &[S::Sigma, S::Direction, S::Share, S::Towards],
            Self::Spikes => &[S::Share, S::Length],
            Self::RangeImage => &[S::Sigma, S::Correlation, S::Towards, S::Distance, S::Step],
            Self::Fusion => &[S::Sigma, S::Correlation, S::Distance, S::Step],
            Self::Voxels => &[S::Step],
        }
    }

    /// Returns true if the noise moves the vertices of the mesh, and false if it makes a mesh with vertices of its own.
    pub fn keeps_connectivity(self) -> bool {
        !matches!(self, Self::RangeImage | Self::Fusion | Self::Voxels)
    }
}

/// Settings of synthetic noise. A kind reads those of [`SyntheticKind::settings`] and the seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SyntheticNoise {
    /// Kind of the noise.
    pub kind: SyntheticKind,
    /// Standard deviation of the noise, in mean edge lengths.
    pub sigma: f64,
    /// Direction of the displacements.
    pub direction: Direction,
    /// Fraction of the vertices that move, or of the area that is noisy, 0..=1.
    pub share: f64,
    /// Length of a spike, in mean edge lengths.
    pub length: f64,
    /// Distance over which the correlation of the noise falls to 1/e, in edges or pixels. The time to make the noise grows with the
    /// square of it.
    pub correlation: f64,
    /// Direction from the mesh to the eye of the camera, in which noise fades in, or to the noisy part; random if `None` or
    /// zero.
    pub towards: Option<DVec3>,
    /// Distance of the eye from the centre of the bounding box, in half diagonals of the box; at least [`Self::NEAREST`].
    pub distance: f64,
    /// Width of a pixel at the centre of the mesh, or of a voxel, in mean edge lengths; above 0.
    pub step: f64,
    /// Seed of the random numbers: the same seed gives the same noise.
    pub seed: u64,
}

impl SyntheticNoise {
    /// Smallest distance of the eye, in half diagonals of the bounding box: nearer than that, the far side of the mesh is many times as
    /// deep as the near one. Smaller distances count as this one.
    pub const NEAREST: f64 = 1.1;

    /// Returns noise of a kind with the settings that are usual for it.
    pub fn of_kind(kind: SyntheticKind, seed: u64) -> Self {
        let sigma = match kind {
            // Fewer vertices or neighbours that move together disturb the faces less.
            SyntheticKind::Impulsive => 0.5,
            SyntheticKind::Correlated => 0.35,
            SyntheticKind::Rounded => 0.1,
            _ => 0.2,
        };
        let share = match kind {
            SyntheticKind::Impulsive => 0.2,
            SyntheticKind::Spikes => 0.002,
            _ => 0.5,
        };
        // Depth images are filtered little: their noise reaches a pixel or two.
        let correlation = if kind == SyntheticKind::Correlated { 3.0 } else { 1.0 };
        let direction = Direction::default();
        Self { kind, sigma, direction, share, length: 4.0, correlation, towards: None, distance: 2.5, step: 1.0, seed }
    }

    /// Unit vector that [`Self::towards`] stands for: the direction that was given, or the random one of the seed.
    pub fn unit_towards(&self) -> DVec3 {
        let random = || UnitSphere.sample(&mut super::layout_numbers(self.seed)).into();
        self.towards.and_then(DVec3::try_normalize).unwrap_or_else(random)
    }

    /// Settings that the kind has, with their values, by the names of [`NoiseSetting`]; a random direction is the one that the
    /// seed gives.
    pub fn to_json(&self) -> Map<String, Value> {
        let value = |setting: &NoiseSetting| match setting {
            NoiseSetting::Sigma => json!(self.sigma),
            NoiseSetting::Direction => json!(self.direction),
            NoiseSetting::Share => json!(self.share),
            NoiseSetting::Length => json!(self.length),
            NoiseSetting::Correlation => json!(self.correlation),
            NoiseSetting::Towards => json!(self.unit_towards().to_array()),
            NoiseSetting::Distance => json!(self.distance),
            NoiseSetting::Step => json!(self.step),
        };
        self.kind.settings().iter().map(|setting| (setting.name().to_owned(), value(setting))).collect()
    }
}
