//! Puts the denoised tiles together.

use super::denoise;
use super::job::Job;
use super::plan::Plan;
use super::records::{Numbers, NumbersOut};
use super::results::{Found, own, read};
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::progress::Progress;
use rustc_hash::FxHashMap;
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::{Path, PathBuf};

/// How well tiles agree at their borders, where two of them have denoised the same vertices. Lengths are in model units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Borders {
    /// Number of source vertices that more than one tile has denoised.
    pub vertices: usize,
    /// Number of those whose results differ.
    pub different: usize,
    /// Largest distance between two results of a vertex.
    pub gap: f64,
    /// Root of the mean square of that distance.
    pub rms_gap: f64,
    /// Largest step between neighbouring vertices that comes of the border: the gap, or what is left of it where results of tiles
    /// go over into each other. A single vertex may be an outlier for one tile and not for the other.
    pub jump: f64,
    /// Root of the mean square of that step.
    pub rms_jump: f64,
}

/// A vertex that several tiles have denoised.
#[derive(Clone, Copy, Debug, Default)]
struct Shared {
    own: DVec3,
    sum: DVec3,
    weight: f64,
    gap: f64,
    jump: f64,
}

/// File of the denoised position of each source vertex. #v×3
pub(super) fn positions(folder: &Path) -> PathBuf {
    folder.join("denoised")
}

/// Puts the results of all tiles together. Where the method is bounded each vertex is as its own tile has it, and the others are
/// compared with that; else they are blended, with weights that fall from ring to ring.
pub fn merge(folder: &Path, job: &Job, progress: &dyn Progress) -> Result<Borders, Failure> {
    progress.stage("merging");
    let plan = Plan::of(folder)?;
    (0..plan.tiles.len()).try_for_each(|tile| denoise::done(folder, tile, job))?;
    let shared = shared(folder, &plan, job, progress)?;
    let mut tiles = Vec::with_capacity(plan.tiles.len());
    let mut next = BinaryHeap::new();
    for tile in 0..plan.tiles.len() {
        let mut file = Numbers::open(denoise::result(folder, tile, &job.key))?;
        let first = own(&mut file)?;
        next.extend(first.as_ref().map(|found| Reverse((found.id, tile))));
        tiles.push((file, first));
    }
    let mut out = NumbersOut::create(positions(folder))?;
    for v in 0..plan.vertices as Index {
        let found = match next.pop() {
            Some(Reverse((id, tile))) if id == v => {
                let (file, found) = &mut tiles[tile];
                let this = std::mem::replace(found, own(file)?);
                next.extend(found.as_ref().map(|found| Reverse((found.id, tile))));
                this
            }
            _ => None,
        };
        let found = found.ok_or_else(|| Failure::Internal(format!("no tile has vertex {v}")))?;
        let blended = shared.get(&v).filter(|_| !job.halo.is_bounded).filter(|shared| shared.gap > 0.0);
        out.position(blended.map_or(found.position, |shared| shared.sum / shared.weight))?;
    }
    out.finish()?;
    let (gap, rms_gap) = largest_and_rms(shared.values().map(|shared| shared.gap).collect());
    let (jump, rms_jump) = match job.halo.is_bounded {
        true => (gap, rms_gap),
        false => largest_and_rms(shared.values().map(|shared| shared.jump).collect()),
    };
    let different = shared.values().filter(|shared| shared.gap > 0.0).count();
    Ok(Borders { vertices: shared.len(), different, gap, rms_gap, jump, rms_jump })
}

/// Largest of some lengths, and the root of their mean square; 0 of none.
fn largest_and_rms(mut lengths: Vec<f64>) -> (f64, f64) {
    // Whatever order they came in, the sum is the same.
    lengths.sort_unstable_by(f64::total_cmp);
    let squares = lengths.iter().map(|length| length * length).sum::<f64>();
    (lengths.last().copied().unwrap_or(0.0), (squares / lengths.len().max(1) as f64).sqrt())
}

/// Vertices that are in a band around a tile, with what all tiles make of them.
fn shared(folder: &Path, plan: &Plan, job: &Job, progress: &dyn Progress) -> Result<FxHashMap<Index, Shared>, Failure> {
    let mut shared: FxHashMap<Index, Shared> = FxHashMap::default();
    let each = |take: &mut dyn FnMut(&Found)| -> Result<(), Failure> {
        for tile in 0..plan.tiles.len() {
            progress.check()?;
            let mut file = Numbers::open(denoise::result(folder, tile, &job.key))?;
            while let Some(found) = read(&mut file)? {
                take(&found);
            }
        }
        Ok(())
    };
    each(&mut |found| {
        if found.ring > 0 {
            shared.entry(found.id).or_default();
        }
    })?;
    each(&mut |found| {
        if let (0, Some(shared)) = (found.ring, shared.get_mut(&found.id)) {
            *shared = Shared { own: found.position, sum: found.position, weight: 1.0, gap: 0.0, jump: 0.0 };
        }
    })?;
    let rings = f64::from(job.halo.band) + 1.0;
    each(&mut |found| {
        if let (1.., Some(shared)) = (found.ring, shared.get_mut(&found.id)) {
            let weight = 1.0 - f64::from(found.ring) / rings;
            shared.sum += weight * found.position;
            shared.weight += weight;
            let gap = shared.own.distance(found.position);
            shared.gap = shared.gap.max(gap);
            // The share of the other tile is w / (1 + w), and w falls by one part of the rings from ring to ring.
            shared.jump = shared.jump.max(gap / rings / (1.0 + weight).powi(2));
        }
    })?;
    Ok(shared)
}

/// Number of tiles that a job has done.
pub fn done(folder: &Path, job: &Job) -> Result<usize, Failure> {
    let tiles = Plan::of(folder)?.tiles.len();
    Ok((0..tiles).filter(|tile| denoise::is_done(folder, *tile, job)).count())
}
