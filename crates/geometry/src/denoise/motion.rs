//! The setting of where vertices may go, which methods have whose result heights cannot hold as it is.

use super::parameters::Parameter;
use crate::named;

named! {
    /// Where vertices may go.
    ///
    /// How motion along normals follows from free motion is said at [`HeightField`](super::HeightField).
    #[derive(Default)]
    pub enum Motion {
        /// Anywhere.
        #[default]
        Free = "free",
        /// Along one normal for each vertex, so that a height map can hold all of it.
        AlongNormal = "along-normal",
    }
}

/// Parameter of all methods that can keep to what heights hold.
pub(super) const MOTION: Parameter = Parameter::word::<Motion>(
    "motion",
    "/motion",
    "where vertices may go; a bake of heights always takes along-normal",
);
