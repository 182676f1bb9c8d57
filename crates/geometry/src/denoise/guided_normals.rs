//! Joint bilateral filter of the face normals, guided by the most consistent patch around each face.
//!
//! Wangyu Zhang, Bailin Deng, Juyong Zhang, Sofien Bouaziz, Ligang Liu. Guided mesh normal filtering. Computer Graphics
//! Forum 34 (7), Pacific Graphics 2015.
//!
//! Each face has a patch: itself and the faces that share a vertex with it. The guidance gᵢ is the mean normal of that
//! patch with face i in it that is most consistent: the least H = max_{j,k} |nⱼ − nₖ| · max_e φ_e / Σ_e φ_e, with
//! φ_e = |n₁ − n₂| over the edges inside the patch (eqs. 6–8). Then nᵢ ← normalise Σⱼ Aⱼ exp(−|cᵢ − cⱼ|² / 2σ_s²)
//! exp(−|gᵢ − gⱼ|² / 2σ_r²) nⱼ over the faces within a radius, and vertices follow before the next iteration.

use super::Boundary;
use super::faces::{Faces, Shapes, filter, lists};
use super::vertex_update::{Updater, VertexUpdate};
use crate::progress::{Cancelled, Progress};
use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::GuidedNormals`](super::Denoiser::GuidedNormals).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidedNormals {
    /// Rounds of filter and vertex update.
    pub iterations: u32,
    /// How far off faces are averaged, in mean distances of the centroids of faces that share an edge, in the input.
    pub radius: f64,
    /// σ_s, in the same unit, measured anew in each round.
    pub sigma_spatial: f64,
    /// σ_r: how far guidance normals may differ and their faces still be averaged.
    pub sigma_range: f64,
    /// How vertices follow, in each round.
    pub vertex_update: VertexUpdate,
}

impl GuidedNormals {
    /// Radius 2, σ_s = 1, σ_r = 0.35, 20 rounds of 10 vertex steps each; the boundary moves.
    pub fn paper() -> Self {
        Self {
            iterations: 20,
            radius: 2.0,
            sigma_spatial: 1.0,
            sigma_range: 0.35,
            vertex_update: VertexUpdate::paper(10, Boundary::Free),
        }
    }
}

impl Default for GuidedNormals {
    /// As in the paper, with vertices that are held.
    fn default() -> Self {
        let paper = Self::paper();
        Self { vertex_update: paper.vertex_update.held(), ..paper }
    }
}

/// δ of the vertices after the last round. #V×3, model units.
pub(super) fn deltas(
    surface: &Surface,
    settings: &GuidedNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let faces = Faces::of(surface);
    let mut updater = Updater::new(surface, &faces, settings.vertex_update);
    let mut shapes = Shapes::of(&faces, surface.positions());
    let neighbours = {
        let around = faces.within(settings.radius * faces.spacing(&shapes), &shapes.centroids);
        lists(faces.len(), |f, list| {
            list.extend(around.get(f));
            list.push(f);
        })
    };
    let patches = Patches::of(&faces);
    let mut guidance = Guidance::new(&patches);
    let mut filtered = shapes.normals.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        guidance.measure(&patches, &shapes);
        let sigma = settings.sigma_spatial * faces.spacing(&shapes);
        let [near, alike] = [sigma, settings.sigma_range].map(|sigma| -0.5 / (sigma * sigma));
        filter(&neighbours, &shapes.normals, &mut filtered, |f, _, g| {
            let distance = shapes.centroids[f].distance_squared(shapes.centroids[g]);
            let difference = guidance.normals[f].distance_squared(guidance.normals[g]);
            shapes.areas[g] * (near * distance + alike * difference).exp()
        });
        updater.follow(&filtered, progress)?;
        shapes.measure(&faces, updater.positions());
        progress.done(f64::from(done) / f64::from(settings.iterations));
    }
    Ok(updater.deltas())
}

/// Each face with those that share a vertex with it.
struct Patches {
    /// Ascending, the face itself at the end.
    members: Ragged<Index>,
    /// Edges with both faces in the patch, as places in `edges`.
    inner: Ragged<Index>,
    /// The two faces at each edge.
    edges: Vec<[Index; 2]>,
}

impl Patches {
    fn of(faces: &Faces) -> Self {
        let touching = faces.by_vertex();
        let members = lists(faces.len(), |f, list| {
            list.extend(touching.get(f));
            list.push(f);
        });
        let of_face = Ragged::group(faces.len(), (0..).zip(&faces.pairs).flat_map(|(e, &[f, g])| [(f, e), (g, e)]));
        // The lower face of an edge brings it in, so that it comes once.
        let inside = |f: Index, g: Index| f == g || touching.get(f).binary_search(&g).is_ok();
        let inner = lists(faces.len(), |f, list: &mut Vec<Index>| {
            for &g in members.get(f) {
                let brought = |e: &&Index| {
                    let [a, b] = faces.pairs[**e as usize];
                    g == a.min(b) && inside(f, a.max(b))
                };
                list.extend(of_face.get(g).iter().filter(brought));
            }
        });
        Self { members, inner, edges: faces.pairs.clone() }
    }
}

/// The most consistent patch at each face.
struct Guidance {
    differences: Vec<f64>,
    patches: Vec<(f64, DVec3)>,
    /// g. #T×3
    normals: Vec<DVec3>,
}

impl Guidance {
    fn new(patches: &Patches) -> Self {
        let count = patches.members.len();
        Self {
            differences: vec![0.0; patches.edges.len()],
            patches: vec![(0.0, DVec3::ZERO); count],
            normals: vec![DVec3::ZERO; count],
        }
    }

    fn measure(&mut self, patches: &Patches, shapes: &Shapes) {
        let normal = |f: Index| shapes.normals[f as usize];
        self.differences.par_iter_mut().zip(&patches.edges).with_min_len(2048).for_each(|(difference, &[f, g])| {
            *difference = normal(f).distance(normal(g));
        });
        let differences = &self.differences;
        self.patches.par_iter_mut().enumerate().with_min_len(256).for_each_init(
            SideBySide::default,
            |normals, (f, out)| {
                normals.clear();
                let mut mean = DVec3::ZERO;
                for &g in patches.members.get(f as Index) {
                    mean += normal(g) * shapes.areas[g as usize];
                    normals.push(normal(g));
                }
                let inner = patches.inner.get(f as Index).iter().map(|&e| differences[e as usize]);
                let (largest, sum) = inner.fold((0.0, 0.0), |(largest, sum), d| (larger(largest, d), sum + d));
                *out = (normals.widest() * largest / (sum + 1e-9), mean.normalize_or_zero());
            },
        );
        let found = &self.patches;
        self.normals.par_iter_mut().enumerate().with_min_len(1024).for_each(|(f, out)| {
            let mut best = (f64::INFINITY, DVec3::ZERO);
            for &g in patches.members.get(f as Index) {
                // Between patches that are equal but for rounding, the first one, whatever the rounding.
                if found[g as usize].0 < best.0 - 1e-9 {
                    best = found[g as usize];
                }
            }
            *out = best.1;
        });
    }
}

/// The normals of a patch, coordinate by coordinate: each is looked at with all others, two at a time.
#[derive(Default)]
struct SideBySide {
    coordinates: [Vec<f64>; 3],
}

impl SideBySide {
    fn clear(&mut self) {
        self.coordinates.iter_mut().for_each(Vec::clear);
    }

    fn push(&mut self, normal: DVec3) {
        self.coordinates.iter_mut().zip(normal.to_array()).for_each(|(all, x)| all.push(x));
    }

    /// The largest distance between two of them.
    fn widest(&mut self) -> f64 {
        if self.coordinates[0].len() % 2 == 1 {
            // The first one once more makes nothing wider.
            self.push(DVec3::from_array([0, 1, 2].map(|axis| self.coordinates[axis][0])));
        }
        let [x, y, z] = &self.coordinates;
        let mut widest = [0.0; 2];
        for k in 0..x.len() {
            let own = [x[k], y[k], z[k]];
            let from = k / 2 * 2;
            // Pairs start at even places, so that the last one ends where the list does.
            let pairs = x[from..].chunks_exact(2).zip(y[from..].chunks_exact(2)).zip(z[from..].chunks_exact(2));
            for ((px, py), pz) in pairs {
                for lane in 0..2 {
                    let [dx, dy, dz] = [own[0] - px[lane], own[1] - py[lane], own[2] - pz[lane]];
                    widest[lane] = larger(widest[lane], dx * dx + dy * dy + dz * dz);
                }
            }
        }
        larger(widest[0], widest[1]).sqrt()
    }
}

/// What [`f64::max`] would say where nothing is NaN, in one instruction.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests;
