//! The result of a bake.

use crate::errors::raised;
use crate::work;
use numpy::{IntoPyArray as _, PyArrayDyn, PyArrayMethods as _};
use planish_files::bake_files::Baked;
use planish_files::failure::Failure;
use planish_files::output::{self, Folder};
use planish_geometry::map::displacement::Displacement;
use planish_geometry::map::manifest::PageEntry;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// Displacement map, normal map, carrier and manifest, in memory.
#[pyclass(frozen, module = "planish._planish")]
pub(crate) struct Bundle {
    baked: Baked,
    /// Folder that the names in the files are relative to; `None` if the files name none but themselves.
    folder: Option<PathBuf>,
}

impl Bundle {
    pub(crate) fn new(baked: Baked, folder: Option<PathBuf>) -> Self {
        Self { baked, folder }
    }

    fn bytes(&self, name: &str) -> Result<&[u8], Failure> {
        let found = self.baked.bundle.files.iter().find(|file| file.name == name);
        found.map(|file| file.bytes.as_slice()).ok_or_else(|| Failure::Input(format!("there is no file `{name}`")))
    }

    /// Entry of a page, by its index; `None` for the one image of a map without pages.
    fn page(&self, page: usize) -> Result<Option<&PageEntry>, Failure> {
        let pages = self.baked.bundle.manifest.page_entries();
        match pages.get(page) {
            None if page == 0 => Ok(None),
            None => Err(Failure::Input(format!("`page` is {page}, and the map has {} pages", pages.len().max(1)))),
            entry => Ok(entry),
        }
    }

    fn decoded(&self, page: usize) -> Result<Displacement, Failure> {
        let entry = &self.baked.bundle.manifest.displacement;
        let (file, size) = self.page(page)?.map_or((&entry.file, entry.size()), |page| (&page.file, page.size()));
        Displacement::decode(self.bytes(file)?, entry.map, size, entry.encoding()).map_err(Failure::internal)
    }
}

#[pymethods]
impl Bundle {
    /// Names of the files; the manifest is the last.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.baked.bundle.files.iter().map(|file| file.name.as_str()).collect()
    }

    /// Content of a file.
    fn file<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, self.bytes(name).map_err(raised)?))
    }

    /// Manifest as JSON.
    #[getter]
    fn manifest(&self) -> PyResult<String> {
        serde_json::to_string(&self.baked.bundle.manifest).map_err(|e| raised(Failure::internal(e)))
    }

    /// Warnings about a bake that succeeded, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.baked.warnings.clone()
    }

    /// Heights bias + scale · texel as the map or a page of it has them (H×W, model units, row 0 on top), or vectors (H×W×3).
    #[pyo3(signature = (page=0))]
    fn heights<'py>(&self, py: Python<'py>, page: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let map = py.detach(|| self.decoded(page)).map_err(raised)?;
        let (bias, scale) = (f64::from(map.encoding().bias), f64::from(map.encoding().scale));
        let (size, planes) = (map.size(), map.planes());
        let texels = 0..planes.first().map_or(0, Vec::len);
        let heights: Vec<f64> = py.detach(|| {
            let height = |texel: &f32| bias + scale * f64::from(*texel);
            texels.flat_map(|t| planes.iter().map(move |plane| height(&plane[t]))).collect()
        });
        let mut shape = vec![size.height as usize, size.width as usize];
        shape.extend((planes.len() > 1).then_some(planes.len()));
        heights.into_pyarray(py).reshape(shape)
    }

    /// Normal map of the map or of a page of it (H×W×3, 0 to 255, row 0 on top); None if the bake has none.
    #[pyo3(signature = (page=0))]
    fn normal_map<'py>(&self, py: Python<'py>, page: usize) -> PyResult<Option<Bound<'py, PyArrayDyn<u8>>>> {
        let page = self.page(page).map_err(raised)?;
        let entry = page.map_or(&self.baked.bundle.manifest.normal_map, |page| &page.normal_map);
        let Some(entry) = entry else { return Ok(None) };
        let bytes = self.bytes(&entry.file).map_err(raised)?;
        let image = py.detach(|| image::load_from_memory(bytes)).map_err(|e| raised(Failure::internal(e)))?;
        let image = image.into_rgb8();
        let shape = vec![image.height() as usize, image.width() as usize, 3];
        image.into_raw().into_pyarray(py).reshape(shape).map(Some)
    }

    /// Writes all files or none, and returns their paths.
    #[pyo3(signature = (folder=None))]
    fn write(&self, py: Python, folder: Option<PathBuf>) -> PyResult<Vec<PathBuf>> {
        let folder = match (folder, &self.folder) {
            (Some(to), Some(of)) if to != *of && !output::same_file(&to, of) => {
                let (to, of) = (to.display(), of.display());
                let reason = format!("the files were made for the folder {of}, not {to}: give the folder to `bake`");
                return Err(raised(Failure::Input(reason)));
            }
            (Some(folder), _) => folder,
            (None, Some(folder)) => folder.clone(),
            (None, None) => return Err(raised(Failure::Input("`folder` is missing".to_owned()))),
        };
        work::run(py, None, |_| self.baked.write(Folder::open(&folder)?))
    }
}
