//! `planish bake`

use super::count;
use crate::args::{BakeArgs, FormatArg};
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Folder;
use planish_geometry::atlas::AtlasError;
use planish_geometry::bundle::{self, BakeError, Bundle, Lambda, Names, Settings};
use planish_geometry::displacement::Bits;
use planish_geometry::manifest::Report;
use planish_geometry::model::Model;
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Baked<'a> {
    files: Vec<String>,
    size_reason: Option<String>,
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
    let settings = Settings {
        method: args.method.denoiser(),
        welding: args.method.weld,
        normals: args.normals.into(),
        lambda: Lambda(args.lambda),
        side: args.size.0,
        interpolation: args.interpolation.into(),
        bits,
        convention: args.normal_convention.into(),
    };
    let libraries = libraries(input, &model, console);
    let relocate = |texture: &str| relocate(input, folder.path(), texture);
    let bundle = bundle::bake(&model, &names, &libraries, relocate, &settings, console)
        .map_err(|e| explain(e, &model, input))?;
    console.stage("writing");
    let written = folder.write(bundle.files.iter().map(|f| (f.name.as_str(), f.bytes.as_slice())))?;
    for warning in warnings(&bundle) {
        console.warn(&warning);
    }
    let report = Baked {
        files: written.iter().map(|p| p.display().to_string()).collect(),
        size_reason: bundle.choice.map(|choice| choice.to_string()),
        manifest: &bundle.manifest,
    };
    console.report(&report, || text(&report));
    Ok(())
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
    let same_file = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    let taken = same_file(&folder.join(format!("{stem}.obj")), input);
    let carrier = if taken { format!("{stem}.planish") } else { stem.clone() };
    Names { source: from_folder(input, folder), stem, carrier }
}

/// A path as seen from a folder, with slashes.
fn from_folder(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().or_else(|_| std::path::absolute(p)).unwrap_or_else(|_| p.to_path_buf());
    let relative = pathdiff::diff_paths(absolute(path), absolute(folder));
    relative.unwrap_or_else(|| path.to_path_buf()).to_string_lossy().replace('\\', "/")
}

/// The name of a texture in the source's materials, as seen from the carrier.
fn relocate(input: &Path, folder: &Path, texture: &str) -> String {
    let place = input.parent().unwrap_or(Path::new("")).join(texture.replace('\\', "/"));
    // What is not there stays as it was written: the user may know why.
    if place.is_file() { from_folder(&place, folder) } else { texture.to_owned() }
}

fn libraries(input: &Path, model: &Model, console: &Console) -> Vec<Vec<u8>> {
    let found = input::libraries(input, model.obj());
    for library in found.iter().filter(|l| l.bytes.is_none()) {
        console.warn(&format!("{} cannot be read; the carrier will lack its materials", library.path.display()));
    }
    found.into_iter().filter_map(|l| l.bytes).collect()
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
    let total = bundle.manifest.source.vertices;
    if r.unresolved_vertices * 100 > total {
        out.push(format!("{} less than two texels from another one at {side}: a larger --size or a looser layout makes the map more exact", vertices(r.unresolved_vertices)));
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
    line("source", format!("{}: {} vertices, {} faces", m.source.file, m.source.vertices, m.source.faces));
    line(
        "map",
        format!(
            "{} × {}, {} bits: height = {:.6} + {:.6} · texel",
            map.width,
            map.height,
            u32::from(map.bits),
            map.bias,
            map.scale
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
            count(m.dominant_uv.seam_vertices.len(), "vertex", "vertices")
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

/// Errors as shares of the range, which is what one sees, and in quanta, which is what the encoding allows.
fn errors(r: &Report, range: f64) -> String {
    let share = |error: f64| if range > 0.0 { 100.0 * error / range } else { 0.0 };
    format!(
        "max {:.3e} ({:.2} % of the range), 99 % below {:.3e} ({:.2} %), mean {:.3e} ({:.3} %); quantum {:.3e}",
        r.max_error,
        share(r.max_error),
        r.p99_error,
        share(r.p99_error),
        r.mean_error,
        share(r.mean_error),
        r.quantum
    )
}
