//! Denoises one tile.

use super::job::Job;
use super::measure::{Lengths, centroid_distances, surface_of};
use super::part::Part;
use super::plan::{Plan, of_tile};
use super::reach;
use super::records::{Numbers, NumbersOut, failed, write_json};
use super::{anchor, measure, rounds};
use crate::denoise_mesh::{self, DenoiseError, WeldedMesh};
use crate::failure::Failure;
use crate::text::shown;
use planish_geometry::denoise::Denoiser;
use planish_geometry::denoise::limits::{Limits, WeightMask, Weights};
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::topology::{EdgeKind, Topology};
use planish_geometry::mesh::weld::{Weld, Welding};
use planish_geometry::progress::Progress;
use planish_geometry::source::model::WeldedSurface;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Figures of a tile. Lengths are in model units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TileReport {
    /// Index of the tile.
    pub tile: usize,
    /// Number of its source vertices.
    pub vertices: usize,
    /// Number of source vertices with the halo.
    pub with_halo: usize,
    /// Sum of the lengths of the displacements in the tile.
    pub displacement: f64,
    /// Largest length of a displacement in the tile.
    pub max_displacement: f64,
    /// Mean edge length of the part.
    pub mean_edge: f64,
    /// Number of edges in the part whose faces disagree about the outside.
    pub misoriented_edges: usize,
    /// Standard deviation of the noise along the normals that the method `auto` assumed in the tile, the median over the vertices that have
    /// any; `None` for other methods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// Measurements and choice of the method `auto` for the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<serde_json::Value>,
}

/// Denoises a tile and writes its result to the folder; what is there already is not done again.
pub fn denoise(folder: &Path, tile: usize, job: &Job, progress: &dyn Progress) -> Result<TileReport, Failure> {
    let path = job.report(folder, tile);
    if let Ok(json) = std::fs::read(&path)
        && let Ok(report) = serde_json::from_slice(&json)
    {
        return Ok(report);
    }
    job.check()?;
    let plan = Plan::of(folder)?;
    let report = match job.rounds() {
        Some(rounds) => after_rounds(folder, &plan, tile, job, (rounds, progress))?,
        None => denoise_part(folder, &plan, tile, job, progress)?,
    };
    write_json(&path, &report)?;
    Ok(report)
}

/// File of the denoised positions of a tile and of the band around it.
pub(super) fn result(folder: &Path, tile: usize, key: &str) -> PathBuf {
    of_tile(folder, tile, &format!("{key}.result"))
}

fn denoise_part(
    folder: &Path,
    plan: &Plan,
    tile: usize,
    job: &Job,
    progress: &dyn Progress,
) -> Result<TileReport, Failure> {
    let mut part = Part::read(folder, plan, tile, job.halo.rings, progress)?;
    let mut method = job.method.clone();
    if let Some(path) = &job.weights {
        let from = "weights".to_owned();
        method.limits.mask = Some(WeightMask { from, weights: Weights::new(&weights(path, plan, &part)?) });
    }
    let with_halo = part.ids.len();
    if reach::needs_centroid_distance(&method.denoiser) {
        let known = job.lengths.ok_or_else(|| Failure::Internal("the lengths of the mesh are missing".to_owned()))?;
        measured_in(&mut method.denoiser, known, &mut part, plan);
    }
    let reach = match (method.limits.max_displacement.take(), job.lengths) {
        (Some(most), Some(lengths)) => Some((most, lengths.mean_edge)),
        (Some(_), None) => return Err(Failure::Internal("the lengths of the mesh are missing".to_owned())),
        (None, _) => None,
    };
    let WeldedSurface { weld, surface, .. } = surface_of(&part, plan.welding);
    let mut report = TileReport {
        tile,
        vertices: plan.tiles[tile],
        with_halo,
        displacement: 0.0,
        max_displacement: 0.0,
        mean_edge: measure::mean_edge(&surface, surface.positions().len() - (part.ids.len() - with_halo)),
        misoriented_edges: misoriented(&surface),
        sigma: None,
        choice: None,
    };
    let (positions, deltas) = if surface.topology().faces().is_empty() {
        (surface.positions().to_vec(), vec![glam::DVec3::ZERO; surface.positions().len()])
    } else {
        let mesh = WeldedMesh { surface: &surface, weld: &weld, faces: part.faces.len() };
        let mut denoised = denoise_mesh::denoise(mesh, method, progress).map_err(|e| of_tile_error(&e, &part))?;
        if let Some((most, mean_edge)) = reach {
            clamp(&mut denoised.deltas, most, mean_edge)?;
            denoised.positions = surface.moved_by(&denoised.deltas);
        }
        report.sigma = denoised.report.choice.as_ref().map(|choice| {
            let own = weld.first().iter().zip(&choice.deviations);
            median(
                own.filter(|(v, sigma)| part.rings[**v as usize] == 0 && **sigma > 0.0)
                    .map(|(_, sigma)| *sigma)
                    .collect(),
            )
        });
        report.choice = denoised.report.choice.map(|choice| serde_json::to_value(choice).unwrap_or_default());
        (denoised.positions, denoised.deltas)
    };
    let mut out = NumbersOut::create(result(folder, tile, &job.key))?;
    for (v, (id, ring)) in part.ids.iter().zip(&part.rings).enumerate().filter(|(_, (_, ring))| **ring <= job.halo.band)
    {
        let vertex = weld.vertex_of()[v] as usize;
        out.index(*id)?;
        out.index((*ring).into())?;
        out.position(positions[vertex])?;
        if *ring == 0 {
            let length = deltas[vertex].length();
            report.displacement += length;
            report.max_displacement = report.max_displacement.max(length);
        }
    }
    out.finish()?;
    Ok(report)
}

/// Writes the result of a tile that has taken all of its rounds.
fn after_rounds(
    folder: &Path,
    plan: &Plan,
    tile: usize,
    job: &Job,
    (rounds, progress): (u32, &dyn Progress),
) -> Result<TileReport, Failure> {
    let part = Part::read(folder, plan, tile, job.halo.band, progress)?;
    let WeldedSurface { surface, .. } = surface_of(&part, plan.welding);
    let mut report = TileReport {
        tile,
        vertices: plan.tiles[tile],
        with_halo: part.ids.len(),
        displacement: 0.0,
        max_displacement: 0.0,
        mean_edge: measure::mean_edge(&surface, surface.positions().len()),
        misoriented_edges: misoriented(&surface),
        sigma: None,
        choice: None,
    };
    let mut out = NumbersOut::create(result(folder, tile, &job.key))?;
    for (found, p) in rounds::after_all(folder, tile, job, rounds)?.into_iter().zip(&part.positions) {
        // Rounded as displacements are.
        let delta = *p - found.position;
        out.index(found.id)?;
        out.index(found.ring.into())?;
        out.position(*p - delta)?;
        if found.ring == 0 {
            report.displacement += delta.length();
            report.max_displacement = report.max_displacement.max(delta.length());
        }
    }
    out.finish()?;
    Ok(report)
}

/// Gives settings in the mean distance of a part that are those in the mean distance of the whole mesh.
fn measured_in(denoiser: &mut Denoiser, known: Lengths, part: &mut Part, plan: &Plan) {
    if let Denoiser::BilateralNormals(settings) = denoiser {
        let WeldedSurface { surface, .. } = surface_of(part, plan.welding);
        let edges = centroid_distances(&surface, surface.positions()).len();
        let mean = anchor::add(part, edges, plan.bounds[0].distance(plan.bounds[1]));
        // A quotient by a power of two is exact.
        settings.sigma_spatial = settings.sigma_spatial * known.mean_centroid_distance / mean;
    }
}

/// Weights of the source vertices of a part.
fn weights(path: &Path, plan: &Plan, part: &Part) -> Result<Vec<f32>, Failure> {
    let size = std::fs::metadata(path).map_err(failed(path))?.len();
    if size != 4 * plan.vertices as u64 {
        let needed = plan.vertices;
        return Err(Failure::Input(format!("`mask` has {} weights, and the mesh has {needed} vertices", size / 4)));
    }
    let mut file = Numbers::open(path.to_path_buf())?;
    let (mut weights, mut ids) = (Vec::with_capacity(part.ids.len()), part.ids.iter().peekable());
    for v in 0..plan.vertices as u32 {
        let weight = f32::from_bits(file.index()?);
        weights.extend(ids.next_if(|id| **id == v).map(|_| weight));
    }
    Ok(weights)
}

/// Shortens displacements to `most` mean edge lengths of the whole mesh, as limits do.
fn clamp(deltas: &mut [glam::DVec3], most: f64, mean_edge: f64) -> Result<(), Failure> {
    // A square whose mean edge length is that one, exactly, and which has as many vertices.
    let mut positions = vec![glam::DVec3::ZERO; deltas.len().max(4)];
    for (position, [x, y]) in positions.iter_mut().zip([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) {
        *position = glam::DVec3::new(x, y, 0.0) * mean_edge;
    }
    let weld = Weld::new(&positions, Welding::None);
    let square = Surface::new(Topology::new(positions.len(), [vec![0, 1, 2, 3]].into_iter().collect()), positions);
    let limits = Limits { max_displacement: Some(most), ..Limits::default() };
    limits.on(&square, &weld).map_err(|e| Failure::Input(e.to_string()))?.clamp(deltas);
    Ok(())
}

/// Median; 0 of nothing.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

fn misoriented(surface: &Surface) -> usize {
    let topology = surface.topology();
    (0..topology.edges().len() as u32).filter(|e| topology.edge_kind(*e) == EdgeKind::Misoriented).count()
}

fn of_tile_error(error: &DenoiseError, part: &Part) -> Failure {
    match error {
        DenoiseError::Limits(e) => Failure::Input(e.to_string()),
        DenoiseError::Cancelled => Failure::Interrupted,
        DenoiseError::Infinite { vertex, .. } => {
            let id = part.ids[*vertex as usize];
            Failure::Internal(format!("vertex {id} (counted from 0): {error}"))
        }
    }
}

/// Reads whether a job has done a tile.
pub(super) fn is_done(folder: &Path, tile: usize, job: &Job) -> bool {
    job.report(folder, tile).exists()
}

/// Fails if a tile has not been denoised.
pub(super) fn done(folder: &Path, tile: usize, job: &Job) -> Result<(), Failure> {
    if is_done(folder, tile, job) {
        return Ok(());
    }
    Err(Failure::Input(format!("{}: tile {tile} has not been denoised", shown(folder))))
}
