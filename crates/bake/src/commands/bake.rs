//! `planish bake`

use super::{count, measure};
use crate::args::{BakeArgs, FormatArg};
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::{self, Folder};
use planish_geometry::atlas::AtlasError;
use planish_geometry::bundle::{self, BakeError, Bundle, Goal, Lambda, Names, Settings};
use planish_geometry::displacement::Bits;
use planish_geometry::manifest::{self, Report, Target};
use planish_geometry::materials;
use planish_geometry::model::Model;
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Baked<'a> {
    source: String,
    files: Vec<String>,
    size_reason: Option<String>,
    seam_vertices: usize,
    manifest: &'a planish_geometry::manifest::Manifest,
}

pub(crate) fn run(args: &BakeArgs, console: &Console) -> Result<(), Failure> {
    let bits = texel_bits(args)?;
    let input = &args.input;
    let stem = input.file_stem().map(|s| s.to_string_lossy().into_owned());
    let stem = stem.ok_or_else(|| Failure::at(input, "names no file"))?;
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}-planish")));
    let model = super::model(input, args.method.weld, console)?;
    let folder = Folder::open(&folder)?;
    let names = names(input, folder.path(), stem);
    let goal = goal(args, &model, folder.path())?;
    let settings = Settings {
        goal,
        welding: args.method.weld,
        normals: args.normals.into(),
        lambda: Lambda(args.lambda),
        side: args.size.0,
        interpolation: args.interpolation.into(),
        texels: args.texels.into(),
        bits,
        convention: args.normal_convention.into(),
    };
    let libraries = libraries(input, &model, console);
    let textures = libraries.iter().flat_map(|(_, bytes)| materials::textures(bytes)).map(|name| beside(input, &name));
    let mut inputs: Vec<PathBuf> = textures.chain(libraries.iter().map(|(path, _)| path.clone())).collect();
    inputs.extend([input].into_iter().chain(&args.target).cloned());
    let libraries: Vec<Vec<u8>> = libraries.into_iter().map(|l| l.1).collect();
    let relocate = |texture: &str| {
        let place = beside(input, texture);
        // What is not there stays as it was written: the user may know why.
        if place.is_file() { from_folder(&place, folder.path()) } else { texture.to_owned() }
    };
    let bundle = bundle::bake(&model, &names, &libraries, relocate, &settings, console)
        .map_err(|e| explain(e, &model, input))?;
    console.stage("writing");
    bundle.files.iter().try_for_each(|f| output::spare(&folder.path().join(&f.name), &inputs))?;
    let written = folder.write(bundle.files.iter().map(|f| (Path::new(&f.name), f.bytes.as_slice())))?;
    for warning in warnings(&bundle) {
        console.warn(&warning);
    }
    let report = Baked {
        source: input.display().to_string(),
        files: written.iter().map(|p| p.display().to_string()).collect(),
        size_reason: bundle.choice.map(|choice| choice.to_string()),
        seam_vertices: seam_vertices(&model, &bundle),
        manifest: &bundle.manifest,
    };
    console.report(&report, || text(&report));
    Ok(())
}

fn goal(args: &BakeArgs, model: &Model, folder: &Path) -> Result<Goal, Failure> {
    let Some(path) = &args.target else { return args.method.denoiser().map(Goal::Denoiser) };
    let obj = input::obj(path)?;
    let (found, needed) = (obj.positions().len(), model.obj().positions().len());
    if found != needed {
        let reason = format!("has {found} `v` lines, but {} has {needed}", args.input.display());
        return Err(Failure::at(path, reason));
    }
    let positions = model.weld().first().iter().map(|&line| obj.positions()[line as usize]).collect();
    let target = Target::new(from_folder(path, folder), manifest::sha256(obj.bytes()));
    Ok(Goal::Target { positions, target })
}

fn texel_bits(args: &BakeArgs) -> Result<Bits, Failure> {
    match (args.format, args.bits) {
        (None, bits) => Ok(bits.unwrap_or_default()),
        (Some(FormatArg::Exr), None | Some(Bits::ThirtyTwo)) => Ok(Bits::ThirtyTwo),
        (Some(FormatArg::Png), None) => Ok(Bits::default()),
        (Some(FormatArg::Png), Some(bits @ (Bits::Eight | Bits::Sixteen))) => Ok(bits),
        (Some(FormatArg::Png), Some(Bits::ThirtyTwo)) => {
            Err(Failure::Input("a PNG has no 32-bit texels: use --format exr, or --bits 16".to_owned()))
        }
        (Some(FormatArg::Exr), Some(bits)) => {
            let bits = u32::from(bits);
            Err(Failure::Input(format!("an EXR has no {bits}-bit integer texels: use --bits 32, or --format png")))
        }
    }
}

/// The carrier is called like the source, unless that is where it would go.
fn names(input: &Path, folder: &Path, stem: String) -> Names {
    let taken = output::same_file(&folder.join(format!("{stem}.obj")), input);
    let carrier = if taken { format!("{stem}.planish") } else { stem.clone() };
    Names { source: from_folder(input, folder), stem, carrier }
}

/// A path as seen from a folder, with slashes.
fn from_folder(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().or_else(|_| std::path::absolute(p)).unwrap_or_else(|_| p.to_path_buf());
    let relative = pathdiff::diff_paths(absolute(path), absolute(folder));
    relative.unwrap_or_else(|| path.to_path_buf()).to_string_lossy().replace('\\', "/")
}

/// A file that the source's materials name.
fn beside(input: &Path, texture: &str) -> PathBuf {
    input.parent().unwrap_or(Path::new("")).join(texture.replace('\\', "/"))
}

/// The material libraries that can be read, with their places.
fn libraries(input: &Path, model: &Model, console: &Console) -> Vec<(PathBuf, Vec<u8>)> {
    let found = input::libraries(input, model.obj());
    for library in found.iter().filter(|l| l.bytes.is_none()) {
        console.warn(&format!("{} cannot be read; the carrier will lack its materials", library.path.display()));
    }
    found.into_iter().filter_map(|l| Some((l.path, l.bytes?))).collect()
}

fn explain(error: BakeError, model: &Model, input: &Path) -> Failure {
    match error {
        BakeError::Cancelled(_) => Failure::Interrupted,
        BakeError::Atlas(AtlasError::NoUvs) => Failure::at(
            input,
            "has no texture coordinates (no face names a `vt`); unwrap it first (in Blender: Edit Mode, U, Smart UV Project), or use `planish denoise`, which needs none",
        ),
        BakeError::Atlas(AtlasError::NonFinite { uv }) => {
            let lines = model.obj().non_finite_uvs();
            let line = lines.iter().find(|l| l.0 == uv).or(lines.first()).map_or(0, |l| l.1);
            Failure::at(input, format!("line {line}: a texture coordinate that a face uses is not finite"))
        }
        BakeError::Normals(e) => Failure::at(input, format!("{e}; use --normals angle")),
        BakeError::NotFinite => Failure::at(input, BakeError::NotFinite),
        other => Failure::Internal(format!("{}: {other}", input.display())),
    }
}

fn warnings(bundle: &Bundle) -> Vec<String> {
    let r = &bundle.manifest.report;
    let side = bundle.manifest.displacement.width;
    let mut out = Vec::new();
    let mut warn = |n: usize, text: String| {
        if n > 0 {
            out.push(text);
        }
    };
    let vertices = |n| count(n, "vertex", "vertices");
    warn(
        r.overlapping_texels,
        format!(
            "charts overlap in {}: faces that share texels get one height; give them places of their own",
            count(r.overlapping_texels, "texel", "texels")
        ),
    );
    warn(
        r.out_of_range_vertices,
        format!("{} outside [0, 1]: the map is clamped at its border there", vertices(r.out_of_range_vertices)),
    );
    warn(
        r.unmapped_vertices,
        format!("{} without texture coordinates: they stay where they are", vertices(r.unmapped_vertices)),
    );
    warn(
        r.vertices_without_normal,
        format!(
            "{} without a normal (their faces cancel): they stay where they are",
            vertices(r.vertices_without_normal)
        ),
    );
    warn(
        r.unresolved_vertices,
        format!(
            "{} off by more than a quantum at {side}: the layout crowds them; try a larger --size, or a looser layout",
            vertices(r.unresolved_vertices)
        ),
    );
    out
}

/// Vertices with several wedges; the manifest lists each of their `v` lines.
fn seam_vertices(model: &Model, bundle: &Bundle) -> usize {
    let pairs = bundle.manifest.dominant_uv.pairs();
    let mut vertices: Vec<_> = pairs.iter().map(|pair| model.weld().vertex_of()[pair[0] as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.len()
}

fn text(baked: &Baked) -> String {
    let m = baked.manifest;
    let (map, r) = (&m.displacement, &m.report);
    let mut out = String::new();
    let mut line = |head: &str, text: String| {
        let _ = writeln!(out, "{head:9} {text}");
    };
    line(
        "source",
        format!(
            "{}: {}, {}",
            baked.source,
            count(m.source.vertices, "vertex", "vertices"),
            count(m.source.faces, "face", "faces")
        ),
    );
    line(
        "map",
        format!(
            "{} × {}, {} bits: height = {} + {} · texel",
            map.width,
            map.height,
            u32::from(map.bits),
            measure(map.bias),
            measure(map.scale)
        ),
    );
    if let Some(reason) = &baked.size_reason {
        line("size", reason.clone());
    }
    line("error", errors(r, map.scale));
    line(
        "seams",
        format!(
            "gap {} between the wedges of a vertex, {} with several",
            r.seam_gap,
            count(baked.seam_vertices, "vertex", "vertices")
        ),
    );
    line(
        "layout",
        format!(
            "{:.1} % covered, {} unresolved",
            100.0 * r.coverage,
            count(r.unresolved_vertices, "vertex", "vertices")
        ),
    );
    for file in &baked.files {
        line("wrote", file.clone());
    }
    out
}

/// Errors in quanta, which is what the encoding allows, or as shares of the range where they are far from that.
fn errors(r: &Report, range: f64) -> String {
    let unit = |error: f64| match r.quantum > 0.0 {
        false => String::new(),
        true if r.max_error < 100.0 * r.quantum => format!(" ({:.2} quanta)", error / r.quantum),
        true => format!(" ({:.2} % of the range)", 100.0 * error / range),
    };
    let text = |error: f64| format!("{error:.3e}{}", unit(error));
    format!("max {}, 99 % below {}, mean {}", text(r.max_error), text(r.p99_error), text(r.mean_error))
}
