//! The interface of all methods: facts, parameters, published settings and the function.

use super::choice::DenoiseChoice;
use super::motion::Motion;
use super::parameters::Parameter;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Facts about a method that do not depend on its settings.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Name, as in JSON and on the command line.
    pub name: &'static str,
    /// One line on what the method does and what it is good for.
    pub summary: &'static str,
    /// Paper that the method is from; none where there is no single one.
    pub reference: Option<Reference>,
    /// Parameters in groups, own ones first.
    pub parameters: &'static [&'static [Parameter]],
}

/// A paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Reference {
    /// Authors and year, short: `Sun et al. 2007`.
    pub cite: &'static str,
    /// Title and where it was published.
    pub title: &'static str,
}

/// Settings that are a method.
pub(super) trait DenoiseMethod: Default + Clone + PartialEq + Serialize + DeserializeOwned {
    /// Facts about the method.
    const INFO: MethodInfo;

    /// Computes δᵢ = pᵢ − p*ᵢ in the free form, whatever the motion. #V×3, model units; zero where a vertex stays.
    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled>;

    /// Computes δ, and says what the method chose; none where it chooses nothing.
    fn choose(
        &self,
        surface: &Surface,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<DenoiseChoice>), Cancelled> {
        Ok((self.deltas(surface, progress)?, None))
    }

    /// Settings of the paper; none where it names none that fit every mesh.
    fn published() -> Option<Self> {
        None
    }

    /// The setting of where vertices may go, in methods that have one.
    fn motion_mut(&mut self) -> Option<&mut Motion> {
        None
    }
}
