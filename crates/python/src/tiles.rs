//! Meshes that are larger than memory, in tiles. Plans, jobs and reports are JSON.

use crate::errors::raised;
use crate::options::{MethodOptions, Weld};
use crate::work;
use planish_files::failure::Failure;
use planish_files::tiles::{self, Cut, Job, Lengths, reach};
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
        let halo = reach::halo(&method, halo);
        let job = Job { key, method, halo, lengths, weights };
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
/// and which method with all settings it is.
#[pyfunction]
pub(crate) fn tiles_job(job: &str) -> PyResult<String> {
    let job = JobOptions::job(job).map_err(raised)?;
    text(&json!({
        "halo": job.halo.rings,
        "band": job.halo.band,
        "bounded": job.halo.is_bounded,
        "needs_lengths": job.needs_lengths(),
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
