//! Sun's filter: face normals are averaged over neighbours with similar normals, then vertices follow.
//!
//! Xianfang Sun, Paul L. Rosin, Ralph R. Martin, Frank C. Langbein. Fast and effective feature-preserving mesh
//! denoising. TVCG 13 (5), 2007.
//!
//! One iteration is nᵢ ← normalise Σⱼ wᵢⱼ nⱼ over the faces that share a vertex with face i, itself included, with
//! wᵢⱼ = max(0, nᵢ · nⱼ − T)².

use super::boundary::Boundary;
use super::face_geometry::{FaceGeometry, filter_normals};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::motion::Motion;
use super::parameters::Parameter;
use super::triangle_mesh::{TriangleMesh, build_lists};
use super::vertex_update::{self, Updater, VertexUpdate};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Sun`](super::Denoiser::Sun).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Steps of the filter of the normals.
    pub iterations: u32,
    /// T in 0..=1, the cosine of the angle beyond which a neighbour does not count.
    pub threshold: f64,
    /// How vertices follow.
    pub vertex_update: VertexUpdate,
}

impl Sun {
    /// T = 0.5, 20 steps of the normals and 50 of the vertices.
    pub fn paper() -> Self {
        Self { iterations: 20, threshold: 0.5, vertex_update: VertexUpdate::paper(50, Boundary::Fixed) }
    }
}

impl Default for Sun {
    /// As in the paper, with vertices that are held.
    fn default() -> Self {
        let paper = Self::paper();
        Self { vertex_update: paper.vertex_update.held(), ..paper }
    }
}

/// Parameters of the filter; those of the vertex update come on top.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of steps of the normals"),
    Parameter::number(
        "threshold",
        "/threshold",
        [0.0, 1.0],
        "cosine of the angle beyond which a neighbouring face does not count",
    ),
];

impl DenoiseMethod for Sun {
    const INFO: MethodInfo = MethodInfo {
        name: "sun",
        summary: "Averages face normals that point the same way: for sharp edges",
        reference: Some(Reference {
            cite: "Sun et al. 2007",
            title: "Fast and effective feature-preserving mesh denoising. TVCG 13 (5)",
        }),
        parameters: &[PARAMETERS, vertex_update::PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::paper())
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.vertex_update.motion)
    }
}

/// Filters the normals, lets the vertices follow and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &Sun, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    let mesh = TriangleMesh::of(surface);
    let mut updater = Updater::new(surface, &mesh, settings.vertex_update);
    let normals = filtered(&mesh, surface.positions(), settings, progress)?;
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// Filters the face normals. #T×3
fn filtered(
    mesh: &TriangleMesh,
    positions: &[DVec3],
    settings: &Sun,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let geometry = FaceGeometry::of(mesh, positions);
    let by_vertex = mesh.vertex_neighbours(&geometry.centroids);
    let neighbours = build_lists(mesh.face_count(), |f, list| {
        list.extend(by_vertex.get(f));
        list.push(f);
    });
    let mut normals = geometry.normals;
    let mut next = normals.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        filter_normals(&neighbours, &normals, &mut next, |f, _, g| {
            let agreement = (normals[f].dot(normals[g]) - settings.threshold).max(0.0);
            agreement * agreement
        });
        std::mem::swap(&mut normals, &mut next);
        progress.done(f64::from(done) / f64::from(settings.iterations) / 2.0);
    }
    Ok(normals)
}

#[cfg(test)]
mod tests;
