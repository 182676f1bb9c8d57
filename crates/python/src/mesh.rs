//! Meshes: denoised, disturbed, compared, baked, inspected and written.

use crate::arrays::{self, Corners, Faces, Indices};
use crate::bundle::Bundle;
use crate::errors::raised;
use crate::options::{MethodOptions, Weld};
use crate::work;
use glam::DVec3;
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use planish_files::bake_files::{self, Job};
use planish_files::denoise_mesh::{self, DenoiseError, DenoisedMesh, WeldedMesh};
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_files::map_files::MapFiles;
use planish_files::output::{Folder, Output};
use planish_files::{info, mesh_output, text};
use planish_geometry::bake::{BakeSettings, BakeTarget};
use planish_geometry::map::manifest::{self, Target};
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::synthetic_noise::{self, Disturbed};
use planish_geometry::mesh::weld::{Weld as Welded, Welding};
use planish_geometry::metrics::{self, Triangles};
use planish_geometry::source::flaws::flaws;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::{Model, WeldedSurface};
use planish_geometry::source::{Arrays, MeshData, Source};
use pyo3::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Positions of a mesh and its displacements (#v×3), and the report as JSON.
type Result3<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, String);

/// Denoises positions and faces, of which the positions are borrowed. `options` is JSON, and `mask` has a weight for each position.
#[pyfunction]
#[pyo3(signature = (vertices, indices, corners, options, weld, mask=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "Python gives them by name")]
pub(crate) fn denoise<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    indices: Indices<'py>,
    corners: Corners<'py>,
    options: &str,
    weld: Weld,
    mask: Option<PyReadonlyArray1<'py, f32>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Result3<'py>> {
    let positions = arrays::points(&vertices, "vertices").map_err(raised)?;
    let faces = Faces::new("faces", &indices, &corners, "vertices", positions.len()).map_err(raised)?;
    let welding = weld.rule().map_err(raised)?;
    let mask = arrays::weights(mask.as_ref()).map_err(raised)?;
    let method = MethodOptions::parse(options).and_then(|o| o.denoising(positions.len(), mask)).map_err(raised)?;
    let (denoised, welded) = work::run(py, progress, |progress| {
        progress.stage("connecting");
        input::check_numbers(positions, faces.indices(), |v| *v, welding, place).map_err(Failure::Input)?;
        let welded = WeldedSurface::new(positions, faces.iter().map(|face| face.iter().copied()), welding);
        progress.check()?;
        let WeldedSurface { weld, surface, .. } = welded;
        if surface.topology().faces().is_empty() {
            return Err(Failure::Input("no face has three different vertices".to_owned()));
        }
        let mesh = WeldedMesh { surface: &surface, weld: &weld, faces: faces.len() };
        Ok((denoise_mesh::denoise(mesh, method, progress).map_err(of_arrays)?, weld))
    })?;
    result(py, &denoised, &welded, &[])
}

/// Names a vertex of an array for the beginning of a message.
fn place(vertex: Index) -> String {
    format!("`vertices[{vertex}]`: ")
}

/// Makes the failure of a mesh that was given as arrays.
fn of_arrays(error: DenoiseError) -> Failure {
    match error {
        DenoiseError::Limits(e) => Failure::Input(e.to_string()),
        DenoiseError::Cancelled => Failure::Interrupted,
        DenoiseError::Infinite { vertex, .. } => Failure::Internal(format!("{}{error}", place(vertex))),
    }
}

/// Makes arrays of a denoised mesh, one row for each source vertex.
fn result<'py>(py: Python<'py>, denoised: &DenoisedMesh, weld: &Welded, notes: &[String]) -> PyResult<Result3<'py>> {
    let DenoisedMesh { positions, deltas, report } = denoised;
    let (vertices, deltas) = py.detach(|| (weld.spread(positions), weld.spread(deltas)));
    let mut notes = notes.to_vec();
    notes.extend(report.limits.as_ref().and_then(text::volume_not_restored));
    let mut report = serde_json::to_value(report).unwrap_or_default();
    report["notes"] = notes.into();
    Ok((arrays::array(py, vertices)?, arrays::array(py, deltas)?, report.to_string()))
}

/// Result of adding noise.
#[derive(IntoPyObject)]
pub(crate) enum Noisy<'py> {
    /// Positions of the vertices (#v×3, model units).
    #[pyo3(transparent)]
    Moved(Bound<'py, PyArray2<f64>>),
    /// A noisy mesh and its clean counterpart.
    Remeshed(Mesh, Mesh),
}

/// A mesh that is welded and connected; its file, if it has one, is kept byte for byte.
#[pyclass(frozen, module = "planish._planish")]
pub(crate) struct Mesh {
    model: Arc<Model>,
    /// Path of the file; `None` for arrays.
    path: Option<PathBuf>,
    welding: Welding,
    trust: Trust,
}

#[pymethods]
impl Mesh {
    /// Reads a mesh from a file of any format.
    #[staticmethod]
    #[pyo3(signature = (path, weld, trust, progress=None))]
    fn read(py: Python, path: PathBuf, weld: Weld, trust: bool, progress: Option<&Bound<PyAny>>) -> PyResult<Self> {
        let welding = weld.rule().map_err(raised)?;
        let trust = rule(trust);
        let model = work::run(py, progress, |progress| input::model(&path, welding, trust, progress))?;
        Ok(Self { model: Arc::new(model), path: Some(path), welding, trust })
    }

    /// Makes a mesh of arrays. `uv_indices` has the index of a texture coordinate for each corner; without it each vertex has its
    /// own.
    #[staticmethod]
    #[pyo3(signature = (vertices, indices, corners, weld, uvs=None, uv_indices=None))]
    fn from_arrays(
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        indices: Indices,
        corners: Corners,
        weld: Weld,
        uvs: Option<PyReadonlyArray2<f64>>,
        uv_indices: Option<Indices>,
    ) -> PyResult<Self> {
        let welding = weld.rule().map_err(raised)?;
        let positions = arrays::points(&vertices, "vertices").map_err(raised)?;
        let faces = Faces::new("faces", &indices, &corners, "vertices", positions.len()).map_err(raised)?;
        let uvs = uvs.as_ref().map(|uvs| arrays::pairs(uvs, "uvs")).transpose().map_err(raised)?.unwrap_or_default();
        let uv_faces = uv_indices.as_ref().map(|of| Faces::new("uv_faces", of, &corners, "uvs", uvs.len()));
        let uv_faces = uv_faces.transpose().map_err(raised)?;
        if uv_faces.is_none() && !uvs.is_empty() && uvs.len() != positions.len() {
            let (found, needed) = (uvs.len(), positions.len());
            let reason =
                format!("`uvs` has {found} rows and needs {needed}, one for each vertex, or `uv_faces` with it");
            return Err(raised(Failure::Input(reason)));
        }
        let model = work::run(py, None, |progress| {
            input::check_numbers(positions, faces.indices(), |v| *v, welding, place).map_err(Failure::Input)?;
            let data = MeshData::try_from(Arrays {
                positions: positions.to_vec(),
                faces: faces.iter().map(<[Index]>::to_vec).collect(),
                uvs: uvs.to_vec(),
                corner_uvs: uv_faces.iter().flat_map(Faces::indices).copied().map(Some).collect(),
                ..Arrays::default()
            });
            let data = data.map_err(|e| Failure::Input(e.to_string()))?;
            let model = Model::new(data, welding);
            progress.check()?;
            if model.surface().topology().faces().is_empty() {
                return Err(Failure::Input("no face has three different vertices".to_owned()));
            }
            Ok(model)
        })?;
        Ok(Self { model: Arc::new(model), path: None, welding, trust: Trust::Folder })
    }

    /// Path of the file; None for a mesh that was given as arrays.
    #[getter]
    fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Name of the format of the file.
    #[getter]
    fn format(&self) -> &'static str {
        self.model.source().format().name()
    }

    /// Positions of the source vertices (#v×3, model units), copied.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, self.model.data().positions().to_vec())
    }

    /// Source vertices of all corners, face after face (#c), and the number of corners of each face (#f).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>) {
        let faces = self.model.data().faces();
        let corners: Vec<i64> = faces.items().iter().map(|corner| corner.position.into()).collect();
        let counts: Vec<i64> = faces.iter().map(|face| face.len() as i64).collect();
        (corners.into_pyarray(py), counts.into_pyarray(py))
    }

    /// Texture coordinates (#vt×2, v up).
    #[getter]
    fn uvs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array_of_pairs(py, self.model.data().uvs().to_vec())
    }

    /// Texture coordinate of each corner, face after face (#c); -1 where a corner has none.
    #[getter]
    fn uv_indices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let corners = self.model.data().faces().items().iter();
        let uvs: Vec<i64> = corners.map(|corner| corner.uv().map_or(-1, i64::from)).collect();
        uvs.into_pyarray(py)
    }

    /// Denoises the mesh. `options` is JSON, and `mask` has a weight for each source vertex.
    #[pyo3(signature = (options, mask=None, progress=None))]
    fn denoise<'py>(
        &self,
        py: Python<'py>,
        options: &str,
        mask: Option<PyReadonlyArray1<'py, f32>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Result3<'py>> {
        let Self { model, path, .. } = self;
        let mask = arrays::weights(mask.as_ref()).map_err(raised)?;
        let method = MethodOptions::parse(options).and_then(|o| o.denoising(model.data().positions().len(), mask));
        let method = method.map_err(raised)?;
        let denoised = work::run(py, progress, |progress| {
            let mesh = WeldedMesh { surface: model.surface(), weld: model.weld(), faces: model.data().faces().len() };
            denoise_mesh::denoise(mesh, method, progress).map_err(|e| match path {
                Some(path) => e.at(path, model.source()),
                None => of_arrays(e),
            })
        })?;
        let mut notes: Vec<String> = flaws(model).iter().map(ToString::to_string).collect();
        notes.extend(model.source().file().map_or(&[][..], MeshFile::notes).iter().cloned());
        result(py, &denoised, model.weld(), &notes)
    }

    /// Writes the mesh, with other positions (#v×3, model units) if they are given, and returns a report as JSON. All else stays
    /// byte for byte in the format of the mesh.
    #[pyo3(signature = (path, vertices=None, update_normals=false))]
    fn write(
        &self,
        py: Python,
        path: PathBuf,
        vertices: Option<PyReadonlyArray2<f64>>,
        update_normals: bool,
    ) -> PyResult<String> {
        let source = self.model.source();
        let positions = match &vertices {
            Some(array) => arrays::points(array, "vertices").map_err(raised)?,
            None => source.data().positions(),
        };
        self.check_count(positions).map_err(raised)?;
        let report = work::run(py, None, |_| {
            let inputs: Vec<&Path> = self.path.as_deref().into_iter().collect();
            let output = Output::open(&path, &inputs)?;
            let normals = update_normals.then(|| self.model.updated_file_normals(&self.vertex_positions(positions)));
            let file = mesh_output::write(&path, source, positions, normals.as_deref())?;
            let written = output.write(&file.bytes)?;
            let input = self.path.as_deref().unwrap_or(&path);
            let notes = mesh_output::warnings(&path, input, source, &file, self.model.surface().mean_edge());
            let output = written.display().to_string();
            Ok(json!({ "output": output, "rounding": file.rounding, "lost": file.lost, "notes": notes }))
        })?;
        Ok(report.to_string())
    }

    /// Bakes a displacement map. `options` are those of the command line, `method` is JSON. With `target` (#v×3, model units) the map
    /// leads there instead. `folder` is where the files will lie, for a mesh from a file. `mask` has a weight for each source vertex.
    #[pyo3(signature = (options, method, name, folder=None, target=None, mask=None, progress=None))]
    #[allow(clippy::too_many_arguments, reason = "Python gives them by keyword")]
    fn bake(
        &self,
        py: Python,
        options: Vec<String>,
        method: &str,
        name: &str,
        folder: Option<PathBuf>,
        target: Option<PyReadonlyArray2<f64>>,
        mask: Option<PyReadonlyArray1<f32>>,
        progress: Option<&Bound<PyAny>>,
    ) -> PyResult<Bundle> {
        let settings = planish::bake_settings(options).map_err(raised)?;
        let model = &*self.model;
        let goal = match &target {
            Some(array) => {
                let positions = arrays::points(array, "target").map_err(raised)?;
                self.check_count(positions).map_err(raised)?;
                self.target(positions)
            }
            None => {
                let mask = arrays::weights(mask.as_ref()).map_err(raised)?;
                let method = MethodOptions::parse(method);
                let method = method.and_then(|o| o.denoising(model.data().positions().len(), mask));
                BakeTarget::Method(method.map_err(raised)?)
            }
        };
        let settings = BakeSettings { target: goal, welding: self.welding, ..settings };
        let Some(input) = &self.path else {
            let baked = work::run(py, progress, |progress| bake_files::bake_arrays(model, name, &settings, progress))?;
            return Ok(Bundle::new(baked, None));
        };
        let folder = folder.map_or_else(|| bake_files::default_folder(input), Ok).map_err(raised)?;
        let baked = work::run(py, progress, |progress| {
            // Names in the manifest depend on where the folder is; it goes again if it is new.
            let made = Folder::open(&folder)?;
            let job = Job { input, model, folder: made.path(), protected: &[], trust: self.trust };
            job.run(&settings, progress)
        })?;
        Ok(Bundle::new(baked, Some(folder)))
    }

    /// Adds synthetic noise. `options` are those of the command line. Returns the noisy positions (#v×3, model units) or, for kinds of
    /// noise that make a mesh of their own, that mesh and its clean counterpart; and the settings of the noise as JSON.
    fn noise<'py>(&self, py: Python<'py>, options: Vec<String>) -> PyResult<(Noisy<'py>, String)> {
        let noise = planish::synthetic_noise(options).map_err(raised)?;
        let model = &*self.model;
        let made = work::run(py, None, |_| {
            let disturbed = synthetic_noise::disturb(model.surface(), &noise);
            match disturbed.map_err(|e| Failure::Input(e.to_string()))? {
                Disturbed::Moved(displacements) => {
                    let moved: Vec<DVec3> =
                        model.surface().positions().iter().zip(&displacements).map(|(p, d)| *p + *d).collect();
                    if let Some(v) = moved.iter().position(|p| !p.is_finite()) {
                        let place = place(model.weld().first()[v]);
                        return Err(Failure::Input(format!("{place}the noise moves this vertex to infinity")));
                    }
                    Ok(Err(model.weld().spread(&moved)))
                }
                Disturbed::Remeshed(pair) => Ok(Ok((Self::of(&pair.noisy)?, Self::of(&pair.clean)?))),
            }
        })?;
        let report = json!({ "kind": noise.kind, "seed": noise.seed, "settings": noise.to_json() });
        let noisy = match made {
            Err(positions) => Noisy::Moved(arrays::array(py, positions)?),
            Ok((noisy, clean)) => Noisy::Remeshed(noisy, clean),
        };
        Ok((noisy, report.to_string()))
    }

    /// Measures this mesh against a clean one with the same vertices and faces; returns JSON.
    fn compared(&self, py: Python, clean: &Self) -> PyResult<String> {
        let comparison = work::run(py, None, |_| {
            let [clean, this] = [clean, self].map(|mesh| Triangles::from(mesh.model.data()));
            metrics::compare(&clean, &this).map_err(|e| Failure::Input(e.to_string()))
        })?;
        Ok(json!(comparison).to_string())
    }

    /// Describes the mesh and its defects; returns JSON.
    fn info(&self, py: Python) -> PyResult<String> {
        let path = self.path.as_deref().unwrap_or(Path::new(""));
        let info = work::run(py, None, |progress| info::inspect(path, &self.model, self.trust, progress))?;
        Ok(json!(info).to_string())
    }
}

impl Mesh {
    /// Fails if there is not one position for each source vertex.
    fn check_count(&self, positions: &[DVec3]) -> Result<(), Failure> {
        let (found, needed) = (positions.len(), self.model.data().positions().len());
        if found == needed {
            return Ok(());
        }
        Err(Failure::Input(format!("there are {found} positions, and the mesh has {needed} vertices")))
    }

    /// Positions of the vertices (#V×3) from those of the source vertices (#v×3).
    fn vertex_positions(&self, positions: &[DVec3]) -> Vec<DVec3> {
        self.model.weld().first().iter().map(|&v| positions[v as usize]).collect()
    }

    /// Goal of a bake that leads to these positions (#v×3, model units), under the checksum of the mesh that has them.
    fn target(&self, positions: &[DVec3]) -> BakeTarget {
        let bytes =
            self.model.source().written_as(planish_geometry::source::format::Format::Obj, positions, None).bytes;
        let target = Target::new("target.obj".to_owned(), manifest::sha256(&bytes));
        BakeTarget::Positions { positions: self.vertex_positions(positions), target }
    }

    /// Makes a mesh of a surface.
    fn of(surface: &Surface) -> Result<Self, Failure> {
        let (positions, faces) = (surface.positions().to_vec(), surface.topology().faces().clone());
        let data = MeshData::try_from(Arrays { positions, faces, ..Arrays::default() });
        let model = Model::new(data.map_err(|e| Failure::Input(e.to_string()))?, Welding::Exact);
        Ok(Self { model: Arc::new(model), path: None, welding: Welding::Exact, trust: Trust::Folder })
    }
}

fn rule(trust: bool) -> Trust {
    if trust { Trust::Anywhere } else { Trust::Folder }
}

/// Displaces a mesh by its map, as the vertex shader would. Returns the mesh, its displaced positions (#v×3, model units) and the
/// strength λ.
#[pyfunction]
#[pyo3(signature = (manifest, mesh=None, lambda_=None, trust=false))]
pub(crate) fn apply<'py>(
    py: Python<'py>,
    manifest: PathBuf,
    mesh: Option<PathBuf>,
    lambda_: Option<f64>,
    trust: bool,
) -> PyResult<(Mesh, Bound<'py, PyArray2<f64>>, f64)> {
    let trust = rule(trust);
    if let Some(strength) = lambda_.filter(|l| !(-1e6..=1e6).contains(l)) {
        let reason = format!("`lambda_` is a number between -1000000 and 1000000, not {strength}");
        return Err(raised(Failure::Input(reason)));
    }
    let (source, path, displaced, lambda) = work::run(py, None, |_| {
        let files = MapFiles::read(&manifest, trust)?;
        let path = mesh.unwrap_or_else(|| files.carrier());
        let source: Source = if path == files.carrier() { files.carrier_mesh()? } else { input::source(&path, trust)? };
        let lambda = lambda_.unwrap_or(files.manifest.displacement.lambda);
        let displaced = files.displaced(&source, &path, lambda)?;
        Ok((source, path, displaced, lambda))
    })?;
    let model = py.detach(|| Model::new(source, Welding::Exact));
    let mesh = Mesh { model: Arc::new(model), path: Some(path), welding: Welding::Exact, trust };
    Ok((mesh, arrays::array(py, displaced)?, lambda))
}
