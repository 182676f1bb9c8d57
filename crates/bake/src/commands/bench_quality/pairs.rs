//! Pairs of a clean and a noisy mesh in a folder, and the results of other programs for them.

use crate::failure::Failure;
use crate::input;
use planish_geometry::denoise::Denoiser;
use std::path::{Path, PathBuf};

/// Columns of the manifest with results for the settings of the papers, by method.
const COLUMNS: [(&str, &str); 7] = [
    ("laplacian", "Ea_lap_it3"),
    ("taubin", "Ea_taubin_it10"),
    ("bilateral", "Ea_bmd"),
    ("sun", "Ea_sun"),
    ("bilateral-normals", "Ea_bnf"),
    ("guided-normals", "Ea_gnf"),
    ("l0", "Ea_l0abs"),
];

/// Column with the Ea of the noisy mesh.
const NOISY: &str = "Ea_noisy";
/// Column with the Ea of meshes that the authors of methods published, learned methods among them: `METHOD(…)=DEGREES`.
const PUBLISHED: &str = "Ea_PUB";

/// A clean mesh, a noisy mesh, and the results of other programs.
pub(super) struct Pair {
    pub(super) name: String,
    pub(super) clean: PathBuf,
    pub(super) noisy: PathBuf,
    /// Names of columns with their cells, in the order of the file.
    cells: Vec<(String, String)>,
}

impl Pair {
    /// Ea in degrees that the program of the method's authors reached with the same settings, if it is known.
    pub(super) fn reference(&self, denoiser: &Denoiser) -> Option<f64> {
        let (_, column) = COLUMNS.iter().find(|(method, _)| *method == denoiser.name())?;
        let default = Denoiser::every().into_iter().find(|method| method.name() == denoiser.name())?;
        let same = *denoiser == default.paper().unwrap_or(default);
        let cell = self.cells.iter().find(|(head, _)| head == column).filter(|_| same);
        cell.and_then(|(_, cell)| cell.parse().ok())
    }

    /// Column and Ea in degrees of the best result of a program without learning.
    pub(super) fn best(&self) -> Option<(&str, f64)> {
        let classical =
            self.cells.iter().filter(|(head, _)| head.starts_with("Ea_") && head != NOISY && head != PUBLISHED);
        let figures = classical.filter_map(|(head, cell)| Some((head.as_str(), cell.parse::<f64>().ok()?)));
        figures.filter(|(_, ea)| *ea > 0.0).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Method and Ea in degrees of the mesh that its authors published.
    pub(super) fn published(&self) -> Option<(&str, f64)> {
        let (_, cell) = self.cells.iter().find(|(head, _)| head == PUBLISHED)?;
        let (method, ea) = cell.rsplit_once('=')?;
        Some((method.split('(').next().unwrap_or(method), ea.parse().ok()?))
    }
}

/// Finds the pairs of a folder that have a clean mesh: all of them if `names` is empty, or those that it names.
pub(super) fn find(folder: &Path, names: &[String]) -> Result<Vec<Pair>, Failure> {
    let manifest = folder.join("MANIFEST.tsv");
    let mut pairs = if manifest.is_file() { from_manifest(folder, &manifest)? } else { by_name(folder)? };
    if let Some(unknown) = names.iter().find(|name| pairs.iter().all(|pair| pair.name != **name)) {
        let known: Vec<&str> = pairs.iter().map(|pair| pair.name.as_str()).collect();
        return Err(Failure::at(folder, format!("has no pair {unknown}, but {}", known.join(", "))));
    }
    pairs.retain(|pair| names.is_empty() || names.contains(&pair.name));
    if pairs.is_empty() {
        return Err(Failure::at(folder, "has no MANIFEST.tsv with pairs, and no NAME_clean.obj with a NAME_noisy.obj"));
    }
    Ok(pairs)
}

/// Reads the pairs of a table.
fn from_manifest(folder: &Path, manifest: &Path) -> Result<Vec<Pair>, Failure> {
    let bytes = input::read(manifest)?;
    let mut reader = csv::ReaderBuilder::new().delimiter(b'\t').quoting(false).from_reader(bytes.as_slice());
    let failed = |e: &csv::Error| Failure::at(manifest, e);
    let heads = reader.headers().map_err(|e| failed(&e))?.clone();
    let column = |name: &str| {
        heads.iter().position(|head| head == name).ok_or_else(|| Failure::at(manifest, format!("has no column {name}")))
    };
    let [name, clean, noisy] = [column("name")?, column("clean")?, column("noisy")?];
    let mut pairs = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| failed(&e))?;
        if &row[clean] != "-" {
            pairs.push(Pair {
                name: row[name].to_owned(),
                clean: folder.join(&row[clean]),
                noisy: folder.join(&row[noisy]),
                cells: heads.iter().zip(&row).map(|(head, cell)| (head.to_owned(), cell.to_owned())).collect(),
            });
        }
    }
    Ok(pairs)
}

/// Finds pairs of files by their names.
fn by_name(folder: &Path) -> Result<Vec<Pair>, Failure> {
    let failed = |e: std::io::Error| Failure::at(folder, input::plain(&e));
    let mut pairs = Vec::new();
    for entry in folder.read_dir().map_err(failed)? {
        let clean = entry.map_err(failed)?.path();
        let name = clean.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix("_clean.obj"));
        if let Some(name) = name {
            let (name, noisy) = (name.to_owned(), folder.join(format!("{name}_noisy.obj")));
            if noisy.is_file() {
                pairs.push(Pair { name, clean, noisy, cells: Vec::new() });
            }
        }
    }
    pairs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(pairs)
}
