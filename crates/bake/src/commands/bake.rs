//! `planish bake`

use super::{count, measure};
use crate::args::{BakeArgs, FormatArg, MapArg, SpaceArg};
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::{self, Folder};
use planish_geometry::atlas::AtlasError;
use planish_geometry::bundle::{
    self, BakeError, Belongings, Bundle, Carriers, Fallback, Goal, Lambda, LargestSide, LayoutChoice, Names, Quanta,
    Settings,
};
use planish_geometry::displacement::{FileFormat, MapKind, TexelFormat};
use planish_geometry::manifest::{self, HeightsLoss, Layout, Report, Target, UvSource};
use planish_geometry::materials;
use planish_geometry::model::{Model, NormalSource};
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Baked<'a> {
    source: String,
    files: Vec<String>,
    size_reason: Option<String>,
    layout_reason: Option<String>,
    manifest: &'a planish_geometry::manifest::Manifest,
}

pub(crate) fn run(args: &BakeArgs, console: &Console) -> Result<(), Failure> {
    let texel = texel(args)?;
    let map = map_kind(args)?;
    let layout = args.layout.into();
    if layout == LayoutChoice::Vertex && args.size.0.is_some() {
        let reason = "--size does not go with --layout vertex, whose size follows from the number of vertices";
        return Err(Failure::Input(reason.to_owned()));
    }
    if layout == LayoutChoice::Unwrap && !bundle::CAN_UNWRAP {
        let reason =
            "--layout unwrap is not in this planish; build it with: cargo install --path crates/bake --features unwrap";
        return Err(Failure::Input(reason.to_owned()));
    }
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
        map,
        layout,
        side: args.size.0,
        largest_side: LargestSide(args.max_size),
        tolerance: Quanta(args.tolerance),
        interpolation: args.interpolation.into(),
        texels: args.texels.into(),
        texel,
        convention: args.normal_convention.into(),
        carriers: if args.no_glb { Carriers::Obj } else { Carriers::ObjAndGlb },
    };
    let libraries = libraries(input, &model, console);
    let textures = libraries.iter().flat_map(|(_, bytes)| materials::textures(bytes)).map(|name| beside(input, &name));
    let textures: Vec<PathBuf> = textures.collect();
    let textured = !textures.is_empty();
    let mut inputs: Vec<PathBuf> = textures.into_iter().chain(libraries.iter().map(|(path, _)| path.clone())).collect();
    inputs.extend([input].into_iter().chain(&args.target).chain(args.method.masks()).cloned());
    let libraries: Vec<Vec<u8>> = libraries.into_iter().map(|l| l.1).collect();
    let relocate = |texture: &str| {
        let place = beside(input, texture);
        // What is not there stays as it was written: the user may know why.
        if place.is_file() { from_folder(&place, folder.path()) } else { texture.to_owned() }
    };
    let texture = |name: &str| std::fs::read(beside(input, name)).ok();
    let belongings = Belongings { libraries: &libraries, relocate: &relocate, texture: &texture };
    let bundle = bundle::bake(&model, &names, belongings, &settings, console).map_err(|e| explain(e, &model, input))?;
    console.stage("writing");
    bundle.files.iter().try_for_each(|f| output::spare(&folder.path().join(&f.name), &inputs))?;
    let written = folder.write(bundle.files.iter().map(|f| (Path::new(&f.name), f.bytes.as_slice())))?;
    for warning in warnings(&bundle) {
        console.warn(&warning);
    }
    if layout == LayoutChoice::Unwrap && textured && !model.obj().uvs().is_empty() {
        console.warn("the textures of its materials do not fit the carrier, whose texture coordinates are new");
    }
    let report = Baked {
        source: input.display().to_string(),
        files: written.iter().map(|p| p.display().to_string()).collect(),
        size_reason: bundle.choice.map(|choice| choice.to_string()),
        layout_reason: bundle.fallback.as_ref().map(ToString::to_string),
        manifest: &bundle.manifest,
    };
    console.report(&report, || text(&report));
    Ok(())
}

fn goal(args: &BakeArgs, model: &Model, folder: &Path) -> Result<Goal, Failure> {
    let Some(path) = &args.target else { return args.method.denoising(model.obj()).map(Goal::Denoiser) };
    let obj = input::obj(path)?;
    let (found, needed) = (obj.positions().len(), model.obj().positions().len());
    if found != needed {
        let reason = format!("has {found} `v` lines, but {} has {needed}", args.input.display());
        return Err(Failure::at(path, reason));
    }
    let target = Target::new(from_folder(path, folder), manifest::sha256(obj.bytes()));
    Ok(Goal::to(model, &obj, target))
}

/// The format that was asked for, whole or in part.
fn texel(args: &BakeArgs) -> Result<TexelFormat, Failure> {
    let format = args.format.map_or_else(
        || if args.bits == Some(32) { FileFormat::Exr } else { FileFormat::Png },
        |format: FormatArg| format.into(),
    );
    let bits = args.bits.unwrap_or(if format == FileFormat::Exr { 32 } else { 16 });
    TexelFormat::new(format, bits).ok_or_else(|| {
        let of = |f: fn(&TexelFormat) -> String, fits: &dyn Fn(&TexelFormat) -> bool| {
            let mut all: Vec<String> = TexelFormat::ALL.iter().filter(|t| fits(t)).map(f).collect();
            all.dedup();
            all.join(" or ")
        };
        let bits_of_file = of(|t| t.bits().to_string(), &|t| t.file() == format);
        let files_of_bits = of(|t| t.file().to_string().to_lowercase(), &|t| t.bits() == bits);
        Failure::Input(format!(
            "{format} has no {bits}-bit texels: use --bits {bits_of_file}, or --format {files_of_bits}"
        ))
    })
}

fn map_kind(args: &BakeArgs) -> Result<MapKind, Failure> {
    match (args.map, args.space) {
        (MapArg::Scalar, None) => Ok(MapKind::Scalar),
        (MapArg::Scalar, Some(_)) => Err(Failure::Input("--space goes with --map vector".to_owned())),
        (MapArg::Vector, None | Some(SpaceArg::Object)) => Ok(MapKind::VectorObject),
        (MapArg::Vector, Some(SpaceArg::Tangent)) => Ok(MapKind::VectorTangent),
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
            "has no texture coordinates (no face names a `vt`): use --layout vertex, which needs none, --layout unwrap, or unwrap it first (in Blender: Edit Mode, U, Smart UV Project)",
        ),
        BakeError::Atlas(AtlasError::NonFinite { uv }) => {
            let lines = model.obj().non_finite_uvs();
            let line = lines.iter().find(|l| l.0 == uv).or(lines.first()).map_or(0, |l| l.1);
            Failure::at(input, format!("line {line}: a texture coordinate that a face uses is not finite"))
        }
        BakeError::NoTangents => {
            Failure::at(input, "has no texture coordinates, and --space tangent needs some; use --space object")
        }
        BakeError::Limits(e) => super::limits_do_not_fit(&e, input),
        BakeError::Normals(e) => Failure::at(input, format!("{e}; use --normals angle")),
        #[cfg(feature = "unwrap")]
        e @ BakeError::Unwrap(_) => Failure::at(input, e),
        BakeError::NoRoom { .. } => Failure::at(input, format!("{error}; use a larger --size or --max-size")),
        e @ (BakeError::NotFinite | BakeError::Gltf(_)) => Failure::at(input, e),
        other => Failure::Internal(format!("{}: {other}", input.display())),
    }
}

fn warnings(bundle: &Bundle) -> Vec<String> {
    let m = &bundle.manifest;
    let r = &m.report;
    let mut out = r.layout.problems();
    if let Some(reason) = &bundle.fallback {
        out.push(format!("one texel for each vertex, because {reason}"));
    }
    if m.normal_map.is_none() && bundle.fallback != Some(Fallback::NoUvs) && m.displacement.layout == Layout::Vertex {
        out.push("no normal map: the texture coordinates of the mesh have no room for one".to_owned());
    }
    out.extend(r.limits.as_ref().and_then(super::volume_not_restored));
    let vertices = |n| count(n, "vertex", "vertices");
    if r.vertices_without_normal > 0 {
        let n = vertices(r.vertices_without_normal);
        out.push(format!("{n} without a normal (their faces cancel): they stay where they are"));
    }
    if let Some(heights) = r.heights.filter(HeightsLoss::is_much) {
        out.push(format!("{heights}; use --map vector"));
    }
    if r.unresolved_vertices > 0 {
        let (n, side) = (vertices(r.unresolved_vertices), m.displacement.width);
        let tolerance = r.tolerance_quanta;
        let cure = r.suggestion.as_ref().map(|s| format!("; {s}")).unwrap_or_default();
        out.push(format!("{n} off by more than {tolerance} quanta at {side}{cure}"));
    }
    out
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
    if let Some(choice) = &m.choice {
        line("auto", choice.to_string());
    }
    line(
        "map",
        format!(
            "{} × {}, {}: {} = {} + {} · texel",
            map.width,
            map.height,
            map.texel,
            if map.map == MapKind::Scalar { "height" } else { "offset" },
            measure(map.bias),
            measure(map.scale)
        ),
    );
    if let Some(reason) = &baked.size_reason {
        line("size", reason.clone());
    }
    if let Some(limits) = &r.limits {
        line("limits", super::limits(limits));
    }
    if let Some(heights) = &r.heights {
        line("normals", format!("{}; {heights}", along(m.normals)));
    }
    line("error", errors(r, map.scale));
    match &r.own_uvs {
        Some(own) => {
            let n = count(own.seam_vertices, "vertex", "vertices");
            line("seams", format!("gap {} between the wedges of a vertex, {n} with several", r.seam_gap));
            let text = format!(
                "{}, {:.1} % covered, {} unresolved",
                if map.uvs == UvSource::Mesh { "the mesh's own" } else { "a new atlas, in the carrier" },
                100.0 * r.layout.coverage,
                count(r.unresolved_vertices, "vertex", "vertices")
            );
            line("layout", text);
        }
        None => {
            line("seams", format!("gap {} between the wedges of a vertex", r.seam_gap));
            line("layout", "one texel for each vertex".to_owned());
        }
    }
    for file in &baked.files {
        line("wrote", file.clone());
    }
    out
}

/// What a map displaces along, in words.
pub(super) fn along(normals: NormalSource) -> &'static str {
    match normals {
        NormalSource::File => "those of the file",
        NormalSource::Uniform => "means over the faces",
        NormalSource::Area => "area-weighted",
        NormalSource::Angle => "angle-weighted",
        NormalSource::Denoised => "angle-weighted, of the denoised surface",
    }
}

/// Errors of the places in model units, and of the map in quanta, which is what the encoding allows, or in shares of
/// the range where it is far from that.
pub(super) fn errors(r: &Report, range: f64) -> String {
    let map = &r.map_errors;
    let unit = |error: f64| match r.quantum > 0.0 {
        false => "0".to_owned(),
        true if map.max < 100.0 * r.quantum => format!("{:.2} quanta", error / r.quantum),
        true => format!("{:.2} % of the range", 100.0 * error / range),
    };
    let places = format!("max {:.3e}, 99 % below {:.3e}, mean {:.3e}", r.max_error, r.p99_error, r.mean_error);
    format!("{places}; of the map alone max {}, 99 % below {}", unit(map.max), unit(map.p99))
}
