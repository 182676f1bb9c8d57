//! Methods that measure the whole mesh before each of their rounds: all tiles take a round, then their lengths are added up, and so on.
//!
//! The halo is as wide as one round looks. Vertices of the halo begin each round where their own tile has put them.

use super::job::Job;
use super::measure::{self, centroid_distances, surface_of};
use super::part::Part;
use super::plan::{Plan, of_tile};
use super::records::{Numbers, NumbersOut, failed, read_json, write_json};
use super::results::{self, Found};
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::denoise::{Denoiser, GuidedRound};
use planish_geometry::mesh::jagged::Index;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::WeldedSurface;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Measurements of the whole mesh after a round that all tiles have taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AfterRound {
    /// Number of the round; 0 is the mesh as it was given.
    pub round: u32,
    /// Mean distance between the centroids of triangles that share an edge, model units.
    pub spacing: f64,
    /// Number of results that differ from that of the vertex's own tile, in this round or in an earlier one.
    pub different: usize,
}

fn file(folder: &Path, tile: usize, job: &Job, what: &str, round: u32) -> PathBuf {
    of_tile(folder, tile, &format!("{}.{what}-{round}", job.key))
}

fn after(folder: &Path, job: &Job, round: u32) -> PathBuf {
    folder.join(format!("tile-all.{}.round-{round}.json", job.key))
}

/// The last round that all tiles have taken.
pub fn last_round(folder: &Path, job: &Job) -> Result<AfterRound, Failure> {
    let rounds = job.rounds().unwrap_or(0);
    let done = (1..=rounds).rev().find(|round| after(folder, job, *round).exists());
    match (done, job.lengths) {
        (Some(round), _) => read_json(&after(folder, job, round)),
        (None, Some(lengths)) => Ok(AfterRound { round: 0, spacing: lengths.mean_centroid_distance, different: 0 }),
        (None, None) => Err(Failure::Internal("the lengths of the mesh are missing".to_owned())),
    }
}

/// Takes the round that follows `last` on a tile. What is done is not done again.
pub fn round(folder: &Path, tile: usize, job: &Job, last: AfterRound, progress: &dyn Progress) -> Result<(), Failure> {
    let round = last.round + 1;
    let path = file(folder, tile, job, "round", round);
    if path.exists() {
        return Ok(());
    }
    let (Denoiser::GuidedNormals(settings), Some(lengths)) = (&job.method.denoiser, job.lengths) else {
        return Err(Failure::Internal("the method has no rounds, or the lengths of the mesh are missing".to_owned()));
    };
    let plan = Plan::of(folder)?;
    let part = Part::read(folder, &plan, tile, job.halo.rings, progress)?;
    let WeldedSurface { weld, surface, .. } = surface_of(&part, plan.welding);
    let before = match last.round {
        0 => surface.positions().to_vec(),
        round => {
            let all = positions(folder, &part, job, round)?;
            weld.first().iter().map(|&v| all[v as usize]).collect()
        }
    };
    let start =
        GuidedRound { positions: &before, spacing_of_input: lengths.mean_centroid_distance, spacing: last.spacing };
    let positions =
        if surface.topology().faces().is_empty() { before } else { settings.round(&surface, start, progress)? };

    let mut across = centroid_distances(&surface, &positions).into_iter().peekable();
    let mut out = NumbersOut::create(file(folder, tile, job, "lengths", round))?;
    for (v, first) in (0..).zip(weld.first()) {
        let own: Vec<f64> =
            std::iter::from_fn(|| across.next_if(|(vertex, _)| *vertex == v)).map(|(_, length)| length).collect();
        if part.rings[*first as usize] == 0 && !own.is_empty() {
            out.index(part.ids[*first as usize])?;
            out.index(own.len() as u32)?;
            own.into_iter().try_for_each(|length| out.number(length))?;
        }
    }
    out.finish()?;
    let mut out = NumbersOut::create(path)?;
    for (source, ring) in part.rings.iter().enumerate().filter(|(_, ring)| **ring <= job.halo.band) {
        out.index(part.ids[source])?;
        out.index((*ring).into())?;
        out.position(positions[weld.vertex_of()[source] as usize])?;
    }
    out.finish()
}

/// Positions of the source vertices of a part after a round, each as its own tile has it. #v×3
fn positions(folder: &Path, part: &Part, job: &Job, round: u32) -> Result<Vec<DVec3>, Failure> {
    let mut positions = part.positions.clone();
    for (tile, sources) in part.sources_by_tile() {
        let mut of_tile = Numbers::open(file(folder, tile.into(), job, "round", round))?;
        for source in sources {
            let id = part.ids[source];
            let found = loop {
                match results::own(&mut of_tile)? {
                    Some(Found { id: found, position, .. }) if found == id => break position,
                    Some(_) => {}
                    None => return Err(Failure::Internal(format!("no tile has vertex {id}"))),
                }
            };
            positions[source] = found;
        }
    }
    Ok(positions)
}

/// Adds up the lengths after the round that follows `last`, when all tiles have taken it, and compares the results that two tiles have
/// for the same vertices. What is only needed for earlier rounds is removed.
pub fn end_round(folder: &Path, job: &Job, last: AfterRound, progress: &dyn Progress) -> Result<AfterRound, Failure> {
    let tiles = Plan::of(folder)?.tiles.len();
    let round = last.round + 1;
    let [spacing] = measure::means((0..tiles).map(|tile| file(folder, tile, job, "lengths", round)))?;
    let different = last.different + differences(folder, tiles, job, round, progress)?;
    let done = AfterRound { round, spacing, different };
    write_json(&after(folder, job, round), &done)?;
    for tile in 0..tiles {
        for what in ["round", "lengths"] {
            let path = file(folder, tile, job, what, last.round);
            if path.exists() {
                std::fs::remove_file(&path).map_err(failed(&path))?;
            }
        }
    }
    Ok(done)
}

/// Number of results in bands around tiles that differ from those of the vertices' own tiles.
fn differences(folder: &Path, tiles: usize, job: &Job, round: u32, progress: &dyn Progress) -> Result<usize, Failure> {
    let each = |take: &mut dyn FnMut(Found)| -> Result<(), Failure> {
        for tile in 0..tiles {
            progress.check()?;
            let mut of_tile = Numbers::open(file(folder, tile, job, "round", round))?;
            while let Some(found) = results::read(&mut of_tile)? {
                take(found);
            }
        }
        Ok(())
    };
    let mut shared: rustc_hash::FxHashMap<Index, Option<DVec3>> = rustc_hash::FxHashMap::default();
    each(&mut |found| {
        if found.ring > 0 {
            shared.insert(found.id, None);
        }
    })?;
    each(&mut |found| {
        if let (0, Some(own)) = (found.ring, shared.get_mut(&found.id)) {
            *own = Some(found.position);
        }
    })?;
    let mut different = 0;
    each(&mut |found| {
        different += usize::from(found.ring > 0 && shared.get(&found.id) != Some(&Some(found.position)));
    })?;
    Ok(different)
}

/// Results of the last round of a tile, by source vertex and ring, for the tile and the band around it.
pub(super) fn after_all(folder: &Path, tile: usize, job: &Job, rounds: u32) -> Result<Vec<Found>, Failure> {
    let mut file = Numbers::open(file(folder, tile, job, "round", rounds))?;
    let mut found = Vec::new();
    while let Some(next) = results::read(&mut file)? {
        found.push(next);
    }
    Ok(found)
}
