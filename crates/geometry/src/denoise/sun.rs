//! Face normals averaged over the faces that look the same way, then vertices that follow.
//!
//! Xianfang Sun, Paul L. Rosin, Ralph R. Martin, Frank C. Langbein. Fast and effective feature-preserving mesh
//! denoising. TVCG 13 (5), 2007.
//!
//! One iteration is nᵢ ← normalise Σⱼ wᵢⱼ nⱼ over the faces that share a vertex with face i, itself included, with
//! wᵢⱼ = max(0, nᵢ · nⱼ − T)².

use super::Boundary;
use super::faces::{Faces, Shapes, filter, lists};
use super::vertex_update::{Updater, VertexUpdate};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
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

/// δ of the vertices that follow the filtered normals. #V×3, model units.
pub(super) fn deltas(surface: &Surface, settings: &Sun, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    let faces = Faces::of(surface);
    let mut updater = Updater::new(surface, &faces, settings.vertex_update);
    let normals = filtered(&faces, surface.positions(), settings, progress)?;
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// The filtered normals. #T×3
fn filtered(
    faces: &Faces,
    positions: &[DVec3],
    settings: &Sun,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let by_vertex = faces.by_vertex();
    let neighbours = lists(faces.len(), |f, list| {
        list.extend(by_vertex.get(f));
        list.push(f);
    });
    let mut normals = Shapes::of(faces, positions).normals;
    let mut next = normals.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        filter(&neighbours, &normals, &mut next, |f, _, g| {
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
