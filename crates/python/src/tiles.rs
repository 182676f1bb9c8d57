//! Meshes that are larger than memory, in tiles. Plans, jobs and reports are JSON.

use crate::errors::raised;
use crate::options::{MethodOptions, Weld};
use crate::work;
use planish_files::failure::Failure;
use planish_files::tiles::{self, Cut, Job, Lengths, MapJob, TilesMethod, reach};
use planish_geometry::denoise::Output;
use planish_geometry::map::displacement::{FileFormat, MapKind, TexelFormat};
use planish_geometry::map::manifest::Method;
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// How tiles are denoised, as the package writes it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JobOptions {
    key: String,
    method: MethodOptions,
    /// Width of the halo in rings; that which suits the method if it is `None`.
    halo: Option<u16>,
    lengths: Option<Lengths>,
    weights: Option<PathBuf>,
}

impl JobOptions {
    fn job(json: &str) -> Result<Job, Failure> {
        let options: Self = serde_json::from_str(json).map_err(|e| Failure::Input(format!("options of tiles: {e}")))?;
        let Self { key, method, halo, lengths, weights } = options;
        // Vertices that stay are among the weights, so that no number of one is checked.
        let method = method.denoising(0, None)?;
        let of_round = reach::rounds(&method, halo).filter(|_| weights.is_none());
        let halo = of_round.map_or_else(|| reach::halo(&method, halo), |(halo, _)| halo);
        let job = Job { key, method, halo, lengths, weights };
        job.check()?;
        Ok(job)
    }
}

/// How a map of a mesh in tiles is made, as the package writes it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MapOptions {
    key: String,
    map: String,
    bits: u32,
    lambda: f64,
}

impl MapOptions {
    fn job(json: &str) -> Result<MapJob, Failure> {
        let Self { key, map, bits, lambda } =
            serde_json::from_str(json).map_err(|e| Failure::Input(format!("options of a map: {e}")))?;
        let map = match map.as_str() {
            "scalar" => MapKind::Scalar,
            "vector" => MapKind::VectorObject,
            other => return Err(Failure::Input(format!("`map` is \"scalar\" or \"vector\", not {other:?}"))),
        };
        let texel = match bits {
            8 | 16 => TexelFormat::new(FileFormat::Png, bits),
            _ => TexelFormat::new(FileFormat::Exr, bits).filter(|_| bits == 32),
        };
        let texel = texel.ok_or_else(|| Failure::Input(format!("`bits` is 8, 16 or 32, not {bits}")))?;
        if lambda.is_nan() || lambda.abs() > 1e6 {
            return Err(Failure::Input(format!("`lambda_` is a number up to 1000000, not {lambda}")));
        }
        let job = MapJob { key, map, texel, lambda };
        job.check()?;
        Ok(job)
    }
}

/// Does work without progress that is told; Ctrl-C stops it.
fn run<T: Send>(
    py: Python,
    work: impl FnOnce(&dyn planish_geometry::progress::Progress) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    work::run(py, None, work)
}

fn text(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| raised(Failure::internal(e)))
}

/// Checks that a mesh file can be read in tiles, and written as another file.
#[pyfunction]
pub(crate) fn tiles_check(path: PathBuf, output: PathBuf) -> PyResult<()> {
    tiles::check_output(&path, &output).map_err(raised)
}

/// Spreads a mesh file into tiles in a folder that exists, unless that was done under this key, and returns the plan.
#[pyfunction]
pub(crate) fn tiles_spread(
    py: Python,
    path: PathBuf,
    folder: PathBuf,
    key: String,
    tiles: usize,
    weld: Weld,
) -> PyResult<String> {
    let cut = Cut { key, tiles, welding: weld.rule().map_err(raised)? };
    let plan = run(py, |progress| match tiles::Plan::read(&folder)? {
        Some(plan) if plan.key == cut.key => Ok(plan),
        _ => tiles::spread(&path, &folder, &cut, progress),
    })?;
    text(&plan)
}

/// Checks a job, and says how wide its halo and band are, whether its method is bounded, whether it needs the lengths of the mesh,
/// which method with all settings it is, and for which maps a bake by that method has the displacements of the job.
#[pyfunction]
pub(crate) fn tiles_job(job: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    // Limits hold for heights along normals, and are others for vertices that go anywhere.
    let is_free = job.method.limits.is_none() && job.weights.is_none();
    text(&json!({
        "own_maps": {
            "scalar": is_free && job.method.denoiser.motion().is_none(),
            "vector": is_free && job.method.output() == Output::Free,
        },
        "halo": job.halo.rings,
        "band": job.halo.band,
        "bounded": job.halo.is_bounded,
        "needs_lengths": job.needs_lengths(),
        "rounds": job.rounds().unwrap_or(0),
        "method": job.method,
    }))
}

/// Writes the lengths of the edges of a tile.
#[pyfunction]
pub(crate) fn tile_lengths(py: Python, folder: PathBuf, tile: usize) -> PyResult<()> {
    run(py, |progress| tiles::lengths(&folder, tile, progress))
}

/// Adds up the lengths of all tiles.
#[pyfunction]
pub(crate) fn tiles_measure(py: Python, folder: PathBuf) -> PyResult<String> {
    text(&run(py, |_| tiles::measure(&folder))?)
}

/// Denoises a tile, and returns its report. What is done is not done again.
#[pyfunction]
pub(crate) fn tile_denoise(py: Python, folder: PathBuf, tile: usize, job: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    text(&run(py, |progress| tiles::denoise(&folder, tile, &job, progress))?)
}

/// Returns what is known after the last round that all tiles have taken.
#[pyfunction]
pub(crate) fn tiles_last_round(folder: PathBuf, job: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    text(&tiles::last_round(&folder, &job).map_err(raised)?)
}

/// Takes the next round on a tile. What is done is not done again.
#[pyfunction]
pub(crate) fn tile_round(py: Python, folder: PathBuf, tile: usize, job: &str, last: &str) -> PyResult<()> {
    let job = JobOptions::job(job).map_err(raised)?;
    let last = serde_json::from_str(last).map_err(|e| raised(Failure::internal(e)))?;
    run(py, |progress| tiles::round(&folder, tile, &job, last, progress))
}

/// Ends a round that all tiles have taken, and returns what is known then.
#[pyfunction]
pub(crate) fn tiles_end_round(py: Python, folder: PathBuf, job: &str, last: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    let last = serde_json::from_str(last).map_err(|e| raised(Failure::internal(e)))?;
    text(&run(py, |progress| tiles::end_round(&folder, &job, last, progress))?)
}

/// Puts the tiles together, and returns how well they agree.
#[pyfunction]
pub(crate) fn tiles_merge(py: Python, folder: PathBuf, job: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    text(&run(py, |progress| tiles::merge(&folder, &job, progress))?)
}

/// Writes the mesh file with the positions of the tiles.
#[pyfunction]
pub(crate) fn tiles_write(py: Python, path: PathBuf, output: PathBuf, folder: PathBuf) -> PyResult<()> {
    run(py, |progress| tiles::write(&path, &output, Path::new(&folder), progress))
}

/// Checks that a mesh file can be read in tiles, and how a map of it is made.
#[pyfunction]
pub(crate) fn tiles_check_map(path: PathBuf, folder: PathBuf, map: &str) -> PyResult<()> {
    MapOptions::job(map).and_then(|_| tiles::check_folder(&path, &folder)).map_err(raised)
}

/// Takes the denoised positions from a mesh file that was written of tiles, rounded as they are there.
#[pyfunction]
pub(crate) fn tiles_take_positions(py: Python, path: PathBuf, folder: PathBuf) -> PyResult<()> {
    run(py, |progress| tiles::take_positions(&path, &folder, progress))
}

/// Writes what a map holds for the vertices of a tile. What is done is not done again.
#[pyfunction]
pub(crate) fn tile_heights(py: Python, folder: PathBuf, tile: usize, map: &str) -> PyResult<()> {
    let job = MapOptions::job(map).map_err(raised)?;
    run(py, |progress| tiles::heights(&folder, tile, &job, progress))
}

/// Writes the page of a tile. What is done is not done again.
#[pyfunction]
pub(crate) fn tile_page(py: Python, folder: PathBuf, tile: usize, map: &str) -> PyResult<()> {
    let job = MapOptions::job(map).map_err(raised)?;
    run(py, |progress| tiles::page(&folder, tile, &job, progress))
}

/// Writes the bundle of a mesh in tiles, and returns the path of the manifest and what that says of the map. `mesh` is the file with the
/// denoised mesh and its SHA-256, or `None` if a bake by the method has these displacements.
#[pyfunction]
pub(crate) fn tiles_bundle(
    py: Python,
    path: PathBuf,
    folders: (PathBuf, PathBuf),
    jobs: (String, String),
    sha256: &str,
    mesh: Option<(PathBuf, String)>,
) -> PyResult<String> {
    let map = MapOptions::job(&jobs.1).map_err(raised)?;
    let method = match mesh {
        Some((path, sha256)) => TilesMethod::Mesh { path, sha256 },
        None => {
            let job = JobOptions::job(&jobs.0).map_err(raised)?;
            TilesMethod::Method(Box::new(Method::Denoiser(job.method)))
        }
    };
    let folders = (folders.0.as_path(), folders.1.as_path());
    let (manifest, name) = run(py, |progress| tiles::bundle(&path, folders, &map, &method, sha256, progress))?;
    let pages: Vec<&str> = manifest.page_entries().iter().map(|page| page.file.as_str()).collect();
    text(&json!({
        "manifest": folders.1.join(name),
        "pages": pages,
        "displacement": manifest.displacement,
        "report": manifest.report,
    }))
}
