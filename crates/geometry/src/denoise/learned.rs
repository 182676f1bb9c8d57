//! Learned filter of the face normals: small networks, one after the other, each of which says which of many filtered normals a face
//! should have.
//!
//! Each stage computes features of every face ([`features`]), asks its network for a mixture of candidate normals, a correction and a
//! gate, and lets the vertices follow the normals ([`vertex_sweeps`]). A closed gate gives the face the normal that it has in the input,
//! so that clean parts stay. The next stage starts from there, with the normals of the last one as its guidance.
//!
//! Cascades of regressions of filtered normals are from Wang, Liu, Tong, *Mesh Denoising via Cascaded Normal Regression*, ACM
//! Transactions on Graphics 35 (6), 2016. The candidates, clusters, gate and training are our own; see
//! `training/README.md` of this crate.

mod around;
mod clusters;
mod features;
mod network;
mod samples;
mod simd;
mod vertex_sweeps;

pub use network::WeightsError;
pub use samples::{FaceSamples, samples};

use super::boundary::{BOUNDARY, Boundary};
use super::face_geometry::FaceGeometry;
use super::guided_normals::PatchGuidance;
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::motion::{MOTION, Motion};
use super::parameters::Parameter;
use super::triangle_mesh::TriangleMesh;
use super::vertex_update::least_squares::MAX_HALVINGS;
use super::vertex_update::undo_flips;
use crate::mesh::jagged::Index;
use crate::mesh::locality::Localised;
use crate::mesh::surface::Surface;
use crate::mesh::union_find::UnionFind;
use crate::progress::{Cancelled, Progress};
use features::{Adjacency, FaceFields, MeshFields, OtherSurface, Scratch, candidate, candidate_count, feature_count};
use glam::{DVec3, Mat3, Vec3};
use network::{BLOCK, Network, Tensors, softmax};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};
use vertex_sweeps::{Sweeps, follow};

/// Outputs of a network beside the shares of the candidates: a correction of the normal, and the gate.
const FURTHER_OUTPUTS: usize = 4;
/// Share of the input's normal from which a face keeps it altogether.
const FROZEN: f32 = 0.8;
/// Sweeps of the vertices between two stages.
const BETWEEN: Sweeps = Sweeps { count: 20, unfold_below: 0.3, unfold_step: 0.4, widened: false };
/// Sweeps after the last stage, of two kinds.
const LAST: [Sweeps; 2] = [
    Sweeps { count: 20, unfold_below: 0.7, unfold_step: 0.6, widened: true },
    Sweeps { count: 30, unfold_below: 0.5, unfold_step: 0.4, widened: false },
];

/// Settings of [`Denoiser::Learned`](super::Denoiser::Learned).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learned {
    /// Where vertices may go: anywhere, or along one normal each.
    pub motion: Motion,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
    /// File with the weights of the networks, for programs that read files; those that are a part of this crate if it is `None`. A file is
    /// read before the method runs, into `loaded`.
    #[serde(default)]
    pub network: Option<String>,
    /// SHA-256 of that file, hexadecimal, once it was read.
    #[serde(default)]
    pub network_sha256: Option<String>,
    /// Weights that are used instead of those of this crate.
    #[serde(skip)]
    pub loaded: Option<Arc<LearnedWeights>>,
}

impl Default for Learned {
    /// Free, at the boundary as well; with the built-in weights.
    fn default() -> Self {
        Self { motion: Motion::Free, boundary: Boundary::Free, network: None, network_sha256: None, loaded: None }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::text_of("network", "/network", "the name of a file", "file with weights of one's own training")
        .optional(),
    Parameter::text_of("network-sha256", "/network_sha256", "a SHA-256 in hexadecimal", "of the file with the weights")
        .optional()
        .internal(),
    MOTION,
    BOUNDARY,
];

impl DenoiseMethod for Learned {
    const INFO: MethodInfo = MethodInfo {
        name: "learned",
        summary: "Small networks that choose among filtered normals: for noise of any kind; clean meshes may change, too",
        reference: Some(Reference {
            cite: "after Wang et al. 2016",
            title: "Mesh denoising via cascaded normal regression. ACM Transactions on Graphics 35 (6)",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        let localised = Localised::of(surface);
        let surface = &localised.surface;
        let topology = surface.topology();
        let is_fixed = |v: Index| self.boundary == Boundary::Fixed && topology.is_boundary(v);
        let fixed = (0..surface.positions().len() as Index).map(is_fixed).collect();
        let mesh = TriangleMesh::of(surface);
        let mut cascade = Cascade::new(surface.positions(), &mesh, fixed);
        let weights = self.loaded.as_deref().unwrap_or_else(|| LearnedWeights::built_in());
        cascade.run(&weights.stages, true, progress)?;
        Ok(localised.restored(&cascade.deltas()))
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.motion)
    }
}

/// Weights of the networks of all stages.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedWeights {
    stages: Vec<Network>,
    fusion: Option<Network>,
}

impl LearnedWeights {
    /// The weights that are a part of this crate.
    pub fn built_in() -> &'static Self {
        static WEIGHTS: OnceLock<LearnedWeights> = OnceLock::new();
        let bytes = include_bytes!("learned/weights.safetensors");
        WEIGHTS.get_or_init(|| LearnedWeights::parse(bytes).expect("a test reads it"))
    }

    /// Weights without any stage: the filter then leaves everything alone, which is where training begins.
    pub fn none() -> Self {
        Self { stages: Vec::new(), fusion: None }
    }

    /// The first `count` stages alone.
    pub fn truncated(&self, count: usize) -> Self {
        Self { stages: self.stages.iter().take(count).cloned().collect(), fusion: None }
    }

    /// Reads weights from the bytes of a safetensors file with tensors of halves: `stageK.*`, and `fusion.*` for the network that
    /// mixes in a surface that was denoised in another way.
    pub fn parse(bytes: &[u8]) -> Result<Self, WeightsError> {
        let tensors = Tensors::parse(bytes)?;
        let network = |name: &str, others: usize| {
            tensors.network(name, feature_count(others), candidate_count(others) + FURTHER_OUTPUTS)
        };
        let mut stages = Vec::new();
        while tensors.contains(&format!("stage{}.mean", stages.len())) {
            stages.push(network(&format!("stage{}", stages.len()), 0)?);
        }
        let fusion = tensors.contains("fusion.mean").then(|| network("fusion", 1)).transpose()?;
        Ok(Self { stages, fusion })
    }
}

/// Displacements δ = p − p* of the filter with the built-in weights from `positions`; vertices that are `fixed` (#V) stay. #V×3, model
/// units
pub(super) fn filtered(
    positions: &[DVec3],
    mesh: &TriangleMesh,
    fixed: Vec<bool>,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let mut cascade = Cascade::new(positions, mesh, fixed);
    cascade.run(&LearnedWeights::built_in().stages, true, progress)?;
    Ok(cascade.deltas())
}

/// Centroid and mean side length of the triangles of each vertex's connected component, model units; a length of 1 where there is none.
/// #V
fn own_frames(mesh: &TriangleMesh, positions: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut sets = UnionFind::new(positions.len());
    for [a, b, c] in &mesh.triangles {
        sets.join(*a, *b);
        sets.join(*b, *c);
    }
    let component = sets.into_lowest();
    let mut sums = vec![(DVec3::ZERO, 0.0, 0.0); positions.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let (corners, sides, count) = &mut sums[component[t[0] as usize] as usize];
        *corners += a + b + c;
        *sides += a.distance(b) + b.distance(c) + c.distance(a);
        *count += 3.0;
    }
    let frame = |c: &Index| match sums[*c as usize] {
        (corners, sides, count) if (sides / count).is_normal() => (corners / count, sides / count),
        _ => (positions[*c as usize], 1.0),
    };
    component.iter().map(frame).collect()
}

/// Result of the learned filter and another method together.
pub(super) struct Fused {
    /// Displacements δ = p − p*. #V×3, model units
    pub(super) deltas: Vec<DVec3>,
    /// Mean share of the other method's normals in those of the faces that do not keep their own, 0..=1.
    pub(super) others_share: f64,
}

/// Runs the filter and lets its last network mix in what another method found: displacements `deltas` (#V×3, model units). `None` if
/// the weights have no such network.
pub(super) fn fused(
    positions: &[DVec3],
    mesh: &TriangleMesh,
    fixed: Vec<bool>,
    deltas: &[DVec3],
    progress: &dyn Progress,
) -> Result<Option<Fused>, Cancelled> {
    let weights = LearnedWeights::built_in();
    let Some(fusion) = &weights.fusion else { return Ok(None) };
    let mut cascade = Cascade::new(positions, mesh, fixed);
    cascade.run(&weights.stages, false, progress)?;
    let other = cascade.other(deltas);
    let others_share = cascade.advance(fusion, &[other], &LAST, progress)?;
    Ok(Some(Fused { deltas: cascade.deltas(), others_share }))
}

/// A mesh on its way through the stages. Each connected component is in mean edge lengths of its own around its centre.
struct Cascade<'a> {
    mesh: &'a TriangleMesh,
    adjacency: Adjacency,
    patches: PatchGuidance,
    /// Mean edge of the component of each vertex, model units. #V
    units: Vec<f64>,
    /// Vertices that stay. #V
    fixed: Vec<bool>,
    input: Vec<DVec3>,
    input_faces: FaceGeometry,
    positions: Vec<DVec3>,
    /// Normals that the last stage gave the faces; none before the first one. #T×3
    normals: Option<Vec<Vec3>>,
}

impl<'a> Cascade<'a> {
    /// A mesh before the first stage; vertices that are `fixed` (#V) will stay.
    fn new(positions: &[DVec3], mesh: &'a TriangleMesh, fixed: Vec<bool>) -> Self {
        let frames = own_frames(mesh, positions);
        let input: Vec<DVec3> =
            positions.iter().zip(&frames).map(|(p, (centre, unit))| (*p - *centre) / *unit).collect();
        let units = frames.into_iter().map(|(_, unit)| unit).collect();
        let input_faces = FaceGeometry::of(mesh, &input);
        Self {
            mesh,
            adjacency: Adjacency::of(mesh, &input_faces.centroids),
            patches: PatchGuidance::of(mesh, &input_faces.centroids),
            units,
            fixed,
            input_faces,
            positions: input.clone(),
            input,
            normals: None,
        }
    }

    /// Runs the stages; after the last one the vertices follow farther if it `ends` there.
    fn run(&mut self, stages: &[Network], ends: bool, progress: &dyn Progress) -> Result<(), Cancelled> {
        for (k, network) in (1..).zip(stages) {
            let sweeps: &[Sweeps] = if ends && k == stages.len() { &LAST } else { &[BETWEEN] };
            self.advance(network, &[], sweeps, progress)?;
            progress.done(k as f64 / stages.len() as f64);
        }
        Ok(())
    }

    /// The surface of these displacements δ from the input. #V×3, model units
    fn other(&self, deltas: &[DVec3]) -> OtherSurface {
        let positions: Vec<DVec3> =
            self.input.iter().zip(deltas).zip(&self.units).map(|((p, d), unit)| *p - *d / *unit).collect();
        let FaceGeometry { normals, centroids, .. } = FaceGeometry::of(self.mesh, &positions);
        let [normals, centroids] = [normals, centroids].map(|list| list.iter().map(|x| x.as_vec3()).collect());
        OtherSurface { normals, centroids }
    }

    /// Displacements δ = p − p* from the current positions to the input. #V×3, model units
    fn deltas(&self) -> Vec<DVec3> {
        self.input.iter().zip(&self.positions).zip(&self.units).map(|((p, x), unit)| (*p - *x) * *unit).collect()
    }

    /// Runs a network and lets the vertices follow. Returns the mean share of the `others` in the normals of the faces that change.
    fn advance(
        &mut self,
        network: &Network,
        others: &[OtherSurface],
        sweeps: &[Sweeps],
        progress: &dyn Progress,
    ) -> Result<f64, Cancelled> {
        let found = self.with_fields(others, |fields| predicted_normals(fields, network, others.len(), progress))?;
        // Where all faces keep their normals, so do the vertices their places, bit for bit.
        let is_frozen = |f: &Index| found[*f as usize].normal.is_none();
        let mut fixed = self.fixed.clone();
        for (v, fixed) in (0..).zip(&mut fixed) {
            if self.mesh.vertex_faces.get(v).iter().all(is_frozen) {
                *fixed = true;
                self.positions[v as usize] = self.input[v as usize];
            }
        }
        let normal = |(found, input): (&Found, &DVec3)| found.normal.map_or(*input, Vec3::as_dvec3);
        let normals: Vec<DVec3> = found.iter().zip(&self.input_faces.normals).map(normal).collect();
        let before = self.positions.clone();
        for sweeps in sweeps {
            follow(self.mesh, &fixed, &normals, *sweeps, &mut self.positions, progress)?;
        }
        undo_flips(self.mesh, &normals, &before, &mut self.positions, MAX_HALVINGS);
        self.normals = Some(normals.iter().map(|n| n.as_vec3()).collect());
        let changed = found.iter().filter(|found| found.normal.is_some());
        let (sum, count) = changed.fold((0.0, 0.0), |(sum, count), f| (sum + f64::from(f.others_share), count + 1.0));
        Ok(if count > 0.0 { sum / count } else { 1.0 })
    }

    /// Prepares the features of the faces as they are now.
    fn with_fields<R>(&self, others: &[OtherSurface], work: impl FnOnce(&FaceFields) -> R) -> R {
        let geometry = FaceGeometry::of(self.mesh, &self.positions);
        let (patch_normals, patch_scores) = self.patches.of_geometry(&geometry);
        let guidance = match &self.normals {
            Some(normals) => normals.clone(),
            None => patch_normals.iter().map(|n| n.as_vec3()).collect(),
        };
        work(&FaceFields::new(MeshFields {
            triangles: &self.mesh.triangles,
            adjacency: &self.adjacency,
            positions: &self.positions,
            geometry: &geometry,
            input: &self.input_faces,
            guidance: &guidance,
            patch_scores: &patch_scores,
            others,
        }))
    }
}

/// Answer of a network for a face.
#[derive(Clone, Copy, Default)]
struct Found {
    /// Unit normal that it should have; `None` if it should keep that of the input.
    normal: Option<Vec3>,
    /// Share of the other surfaces in it.
    others_share: f32,
}

/// Answers of a network for all faces. #T
fn predicted_normals(
    fields: &FaceFields,
    network: &Network,
    others: usize,
    progress: &dyn Progress,
) -> Result<Vec<Found>, Cancelled> {
    let width = network.inputs();
    let mut normals = vec![Found::default(); fields.len()];
    let blocks = normals.par_chunks_mut(BLOCK).enumerate().with_min_len(8);
    blocks.try_for_each_init(
        || (Scratch::default(), vec![0.0; BLOCK * width], <[Vec<f32>; 2]>::default()),
        |(scratch, rows, spare), (block, out)| {
            progress.check()?;
            rows.fill(0.0);
            let mut frames = [Mat3::ZERO; BLOCK];
            let mut candidates = Vec::with_capacity(BLOCK * candidate_count(others));
            for (k, row) in rows.chunks_exact_mut(width).take(out.len()).enumerate() {
                frames[k] = fields.write(block * BLOCK + k, scratch, row);
                candidates.extend((0..candidate_count(others)).map(|c| candidate(row, c)));
            }
            let mut outputs = network.outputs(rows, spare);
            let found = outputs.chunks_exact_mut(network.padded_outputs());
            for (k, (normal, outputs)) in out.iter_mut().zip(found).enumerate() {
                let face = block * BLOCK + k;
                let candidates = &candidates[k * candidate_count(others)..][..candidate_count(others)];
                *normal = mixed(outputs, candidates, others, frames[k], fields.input_normal(face));
            }
            Ok(())
        },
    )?;
    Ok(normals)
}

/// 1 / (1 + exp(−x)).
fn logistic(x: f32) -> f32 {
    let small = simd::exp(-x.abs());
    if x < 0.0 { small / (1.0 + small) } else { 1.0 / (1.0 + small) }
}

/// Answer that the outputs of a network give for a face with these candidates, the last of which are of `others`, and this frame.
fn mixed(outputs: &mut [f32], candidates: &[Vec3], others: usize, frame: Mat3, input: Vec3) -> Found {
    let (shares, rest) = outputs.split_at_mut(candidates.len());
    softmax(shares);
    let mean: Vec3 = shares.iter().zip(candidates).map(|(share, n)| *n * *share).sum();
    let found = frame * (mean + 0.5 * Vec3::from_slice(rest)).normalize_or_zero();
    let kept = logistic(2.0 * rest[3]);
    let others_share = shares[candidates.len() - others..].iter().sum();
    let normal = if kept > FROZEN { None } else { (found * (1.0 - kept) + input * kept).try_normalize() };
    Found { normal, others_share }
}

#[cfg(test)]
mod tests;
