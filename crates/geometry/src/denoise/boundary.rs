//! The setting of what happens at the boundary of an open mesh, which most methods have.

use super::parameters::Parameter;
use crate::named;

named! {
    /// What happens at the boundary of an open mesh, that is, at vertices on an edge with one face only.
    #[derive(Default)]
    pub enum Boundary {
        /// Boundary vertices stay.
        #[default]
        Fixed = "fixed",
        /// Boundary vertices move like all others, which shrinks outlines and the edges of holes.
        Free = "free",
    }
}

/// Parameter of all methods that have a setting for the boundary.
pub(super) const BOUNDARY: Parameter =
    Parameter::word::<Boundary>("boundary", "/boundary", "what happens at the boundary of an open mesh");
