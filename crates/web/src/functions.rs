//! Functions that the page calls.

use crate::request::Request;
use planish_files::bake_files::{self, Job};
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_files::map_files::MapFiles;
use planish_files::{bake_report, disk, mesh_output, method_list};
use planish_geometry::bake::BakeSettings;
use planish_geometry::denoise::Denoiser;
use planish_geometry::map::manifest::Manifest;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::format::Format;
use planish_geometry::source::model::Model;
use serde::Serialize;
use std::path::{Path, PathBuf};
use wasm_bindgen::prelude::wasm_bindgen;

#[wasm_bindgen]
extern "C" {
    /// Is told the stage of the work and the fraction of it that is done.
    #[wasm_bindgen(js_name = planishProgress)]
    fn tell(stage: &str, fraction: f64);

    /// Writes to the console of the browser.
    #[wasm_bindgen(js_namespace = console)]
    fn error(text: &str);
}

/// Lets a fault of the library say in the console what it is.
#[wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|panic| error(&panic.to_string())));
}

/// Progress that the page is told.
struct Told;

impl Progress for Told {
    fn stage(&self, name: &'static str) {
        tell(name, 0.0);
    }
    fn done(&self, fraction: f64) {
        tell("", fraction);
    }
}

/// Version of planish.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// All methods and their parameters as JSON, as `planish methods --json` prints them, without what the browser cannot do: a direct solver.
#[wasm_bindgen]
pub fn methods() -> String {
    let mut methods = method_list::json(&Denoiser::every());
    let parameters =
        methods.as_array_mut().into_iter().flatten().filter_map(|method| method["parameters"].as_array_mut());
    for parameter in parameters.flatten().filter(|parameter| parameter["name"] == "solver") {
        if let Some(words) = parameter["words"].as_array_mut() {
            words.retain(|word| word["name"] != "direct");
        }
    }
    methods.to_string()
}

/// Name of the method that needs no parameters.
#[wasm_bindgen]
pub fn default_method() -> String {
    Denoiser::default().name().to_owned()
}

/// Returns true if a file of this name is a mesh, by its extension.
#[wasm_bindgen]
pub fn is_mesh(name: &str) -> bool {
    input::format_of(Path::new(name)).is_some()
}

/// Facts about a mesh that the page shows before it is baked.
#[derive(Serialize)]
struct Opened {
    vertices: usize,
    faces: usize,
    format: Format,
}

/// Reads a mesh from memory. Returns counts and the format as JSON.
#[wasm_bindgen]
pub fn open(path: &str) -> Result<String, String> {
    let model = model(path)?;
    let (data, format) = (model.data(), model.source().format());
    Ok(json(&Opened { vertices: data.positions().len(), faces: data.faces().len(), format }))
}

/// Mesh as binary glTF without materials, for a look at it while it is baked.
#[wasm_bindgen]
pub fn preview(path: &str) -> Result<Vec<u8>, String> {
    let source = input::source(Path::new(path), Trust::Folder).map_err(words)?;
    Ok(source.written_as(Format::Glb, source.data().positions(), None).bytes)
}

/// Result of a bake.
#[derive(Serialize)]
struct Baked<'a> {
    /// Folder of the files, in memory.
    folder: &'a str,
    /// Names of the files; the manifest is the last.
    files: Vec<&'a str>,
    manifest: &'a Manifest,
    /// Report that the command line prints.
    report: String,
    warnings: &'a [String],
}

/// Bakes a mesh in memory with the settings of a request (JSON), in place of what was baked from it before. The files lie in
/// memory, in the folder that the command line takes if it is given none. Returns their names, manifest, report and warnings as JSON.
#[wasm_bindgen]
pub fn bake(path: &str, request: &str) -> Result<String, String> {
    let input = Path::new(path);
    let request = Request::parse(request).map_err(words)?;
    let folder = bake_files::folder_beside(input).map_err(words)?;
    disk::remove(&folder);
    let model = model(path)?;
    let job = Job { input, model: &model, folder: &folder, protected: &[], trust: Trust::Folder };
    let target = job.method(request.denoising().map_err(words)?).map_err(words)?;
    let baked = job.run(&BakeSettings { target, ..request.bake }, &Told).map_err(words)?;
    let shown = |name: &str| folder.join(name).display().to_string();
    let written: Vec<String> = baked.bundle.files.iter().map(|file| shown(&file.name)).collect();
    let result = json(&Baked {
        folder: &folder.display().to_string(),
        files: baked.bundle.files.iter().map(|file| file.name.as_str()).collect(),
        manifest: &baked.bundle.manifest,
        report: bake_report::text(path, &baked.bundle, &written),
        warnings: &baked.warnings,
    });
    for file in baked.bundle.files {
        disk::put(&folder.join(&file.name), file.bytes);
    }
    Ok(result)
}

/// Displaces the mesh that was baked with the strength λ, and writes it in its own format under the name `output`, as `planish apply`
/// does.
#[wasm_bindgen]
pub fn apply(manifest: &str, output: &str, lambda: f64) -> Result<Vec<u8>, String> {
    let output = Path::new(output);
    let displaced = || {
        let files = MapFiles::read(Path::new(manifest), Trust::Folder)?;
        let mesh: PathBuf = files.mesh_for(output);
        let source = files.mesh_at(&mesh)?;
        let positions = files.displaced(&source, &mesh, lambda)?;
        mesh_output::write(output, &source, &positions, None)
    };
    displaced().map(|written| written.bytes).map_err(words)
}

/// Texels of a map of heights, 0 to 1, row by row from the top: browsers cut images of 16 bits to 8.
#[wasm_bindgen]
pub fn texels(manifest: &str) -> Result<Vec<f32>, String> {
    let images = MapFiles::read(Path::new(manifest), Trust::Folder).and_then(|files| files.decoded_images());
    let images = images.map_err(words)?;
    Ok(images.first().and_then(|map| map.planes().first()).cloned().unwrap_or_default())
}

/// Puts a file into memory.
#[wasm_bindgen]
pub fn put(path: &str, bytes: Vec<u8>) {
    disk::put(Path::new(path), bytes);
}

/// Takes all files out of memory.
#[wasm_bindgen]
pub fn clear() {
    disk::clear();
}

/// Reads a file from memory.
#[wasm_bindgen]
pub fn read(path: &str) -> Result<Vec<u8>, String> {
    input::read(Path::new(path)).map_err(words)
}

fn model(path: &str) -> Result<Model, String> {
    input::model(Path::new(path), Welding::Exact, Trust::Folder, &Told).map_err(words)
}

/// The line that the command line prints after `error: `.
#[allow(clippy::needless_pass_by_value, reason = "for `map_err`")]
fn words(failure: Failure) -> String {
    failure.to_string()
}

fn json(value: &impl Serialize) -> String {
    // Numbers and words always have a form in JSON.
    serde_json::to_string(value).unwrap_or_default()
}
