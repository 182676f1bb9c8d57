//! What the networks see of a face: filtered normals of many scales, and what the noise around it is like.
//!
//! All is in a frame of the face's own, in lengths of the edges around it, so that the features of a mesh that was moved, turned,
//! scaled or mirrored are the same. Most of them are means of normals with Gaussian weights of the distance and of the difference of
//! normals, as in bilateral filters. The means over 25 of them follow Wang et al. 2016, *Mesh Denoising via Cascaded Normal
//! Regression*; wide scales look at clusters of faces instead of faces.

mod bands;
mod fields;
mod search;
mod write;

pub(super) use fields::{Adjacency, FaceFields, MeshFields, OtherSurface};
pub(super) use search::Scratch;

use glam::Vec3;

/// Deviation of the widest Gaussian over faces, in scales of the face; the other two are a half and a quarter of it.
const WIDEST: f32 = 2.8;
/// Reach of the search for faces, in deviations of the widest Gaussian.
const REACH: f32 = 1.7;
/// Largest number of faces that are looked at around a face.
pub(super) const MOST_FACES: usize = 180;
/// Largest number of clusters of each level that are looked at.
const MOST_CLUSTERS: usize = 96;
/// Deviations of the Gaussians over the two levels of clusters, in scales of the face.
const WIDE: [f32; 2] = [5.0, 10.0];
/// Reach of the search for clusters, in deviations.
const WIDE_REACH: f32 = 1.6;
/// Radii of the clusters of the two levels, in scales.
const RADII: [f32; 2] = [1.3, 3.0];
/// Filters over faces at each scale: without regard for normals, or with a Gaussian of the difference of the normals (three widths), of
/// the smoothed normals (three) or of the guidance (four).
const FILTERS: usize = 11;
/// Filters over clusters: without regard for normals, by the guidance (three widths), by the filtered normal of the face (four).
const WIDE_FILTERS: usize = 8;
/// Number of scales over faces.
const SCALES: usize = 3;
/// Number of candidate normals without those that are handed in.
const OWN_CANDIDATES: usize = SCALES * FILTERS + 3 + 2 * WIDE_FILTERS;
/// Differences of normals between scales.
const BANDS: usize = 5;
/// Number of features without those of normals that are handed in.
const OWN_FEATURES: usize =
    3 * OWN_CANDIDATES + SCALES * (FILTERS - 1) + 2 * (WIDE_FILTERS - 1) + 4 + SCALARS + 2 * BANDS;
const SCALARS: usize = 21;
/// Features that come with each further surface: its normal, and how far off it is.
const PER_SURFACE: usize = 4;
/// Fraction of the faces on which the differences between scales are measured: one in so many.
const STRIDE: usize = 4;

/// Number of features if `surfaces` further ones are handed in.
pub(super) fn feature_count(surfaces: usize) -> usize {
    OWN_FEATURES + PER_SURFACE * surfaces
}

/// Number of candidate normals if `surfaces` further ones are handed in.
pub(super) fn candidate_count(surfaces: usize) -> usize {
    OWN_CANDIDATES + surfaces
}

/// Candidate `k` among the `features` of a face, in its frame.
pub(super) fn candidate(features: &[f32], k: usize) -> Vec3 {
    let start = if k < OWN_CANDIDATES { 3 * k } else { OWN_FEATURES + PER_SURFACE * (k - OWN_CANDIDATES) };
    Vec3::from_slice(&features[start..])
}
