//! Samples for training: the features of faces, and the normals that these should have.

use super::features::{Scratch, feature_count};
use super::{Cascade, LearnedWeights};
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::{DVec3, Vec3};
use half::f16;

/// Features of some faces, and their true normals in the frames of the faces.
#[derive(Clone, Debug, Default)]
pub struct FaceSamples {
    /// Features as the next network sees them. #samples×#features
    pub features: Vec<f16>,
    /// True unit normals in the frames of the faces. #samples×3
    pub normals: Vec<[f32; 3]>,
}

/// Runs the stages that there are on a noisy surface, and gives what the next one would see of the faces for which `is_wanted` holds,
/// with their normals in `clean`, a surface with the same faces. With displacements δ of another method (#V×3, model units), the next
/// one is the network that mixes that surface in.
///
/// Faces that are hardly more than a line in the clean surface have no sample if there is noise.
pub fn samples(
    clean: &Surface,
    noisy: &Surface,
    weights: &LearnedWeights,
    other: Option<&[DVec3]>,
    is_wanted: impl Fn(usize) -> bool,
    progress: &dyn Progress,
) -> Result<FaceSamples, Cancelled> {
    /// Least area of a face in squared mean edges.
    const LEAST_AREA: f64 = 1e-4;
    let mesh = TriangleMesh::of(noisy);
    let mut cascade = Cascade::new(noisy.positions(), &mesh, vec![false; noisy.positions().len()]);
    cascade.run(&weights.stages, false, progress)?;
    let truth = FaceGeometry::of(&mesh, clean.positions());
    // Without noise the thinnest face has the right normal, and should keep it.
    let is_clean = clean.positions() == noisy.positions();
    let least = if is_clean { 0.0 } else { LEAST_AREA * clean.mean_edge().powi(2) };
    let others: Vec<_> = other.iter().map(|deltas| cascade.other(deltas)).collect();
    let mut found = FaceSamples::default();
    cascade.with_fields(&others, |fields| {
        let mut row = vec![0.0; feature_count(others.len())];
        let mut scratch = Scratch::default();
        for face in (0..mesh.face_count()).filter(|f| truth.areas[*f] > least && is_wanted(*f)) {
            let frame = fields.write(face, &mut scratch, &mut row);
            let normal: Vec3 = truth.normals[face].as_vec3();
            found.features.extend(row.iter().map(|x| f16::from_f32(x.clamp(-20.0, 20.0))));
            found.normals.push((frame.transpose() * normal).to_array());
        }
    });
    Ok(found)
}
