//! The command `planish bake`.

use crate::args::{BakeArgs, MapArg, MapArgs, MethodArgs, SpaceArg};
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Folder;
use planish_files::bake_files::{self, Baked, Job};
use planish_files::bake_report;
use planish_files::input::Trust;
use planish_geometry::bake::{
    self, BakeSettings, BakeTarget, Carriers, CurvatureMap, Lambda, LargestSide, LayoutChoice, Quanta,
};
use planish_geometry::denoise::LastResult;
use planish_geometry::map::displacement::{FileFormat, MapKind, TexelFormat};
use planish_geometry::map::manifest::Manifest;
use planish_geometry::map::occlusion::Occlusion;
use planish_geometry::map::pages::PageRule;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Report of the command.
#[derive(Serialize)]
struct Wrote<'a> {
    source: String,
    files: Vec<String>,
    size_reason: Option<String>,
    layout_reason: Option<String>,
    manifest: &'a Manifest,
}

pub(crate) fn run(args: &BakeArgs, console: &Console) -> Result<(), Failure> {
    let settings = settings(&args.map, args.welding.weld)?;
    let input = &args.input;
    let default = || bake_files::default_folder(input);
    let folder = args.output.clone().map_or_else(default, Ok)?;
    let (baked, folder) = bake(input, &folder, &settings, &Goal::of(args), args.trust.rule(), console)?;
    console.stage("writing");
    let written = baked.write(folder)?;
    baked.warnings.iter().for_each(|warning| console.warn(warning));
    let bundle = &baked.bundle;
    let report = Wrote {
        source: input.display().to_string(),
        files: written.iter().map(|p| p.display().to_string()).collect(),
        size_reason: bundle.choice.map(|choice| choice.to_string()),
        layout_reason: bundle.fallback.as_ref().map(ToString::to_string),
        manifest: &bundle.manifest,
    };
    console.report(&report, || bake_report::text(&report.source, bundle, &report.files))
}

/// The denoised surface that a bake aims at: that of a method, or a mesh.
pub(super) struct Goal<'a> {
    pub(super) method: &'a MethodArgs,
    /// Mesh that was denoised by other means, instead of the method.
    pub(super) target: Option<&'a PathBuf>,
}

impl<'a> Goal<'a> {
    fn of(args: &'a BakeArgs) -> Self {
        Self { method: &args.method, target: args.target.as_ref() }
    }
}

/// Bakes a mesh into memory, for a folder that exists afterwards and is removed again unless something is written to it.
pub(super) fn bake(
    input: &Path,
    folder: &Path,
    settings: &BakeSettings,
    goal: &Goal,
    trust: Trust,
    progress: &dyn Progress,
) -> Result<(Baked, Folder), Failure> {
    let model = super::model(input, settings.welding, trust, progress)?;
    let folder = Folder::open(folder)?;
    let protected: Vec<PathBuf> = goal.method.masks().chain(goal.target).cloned().collect();
    let job = Job { input, model: &model, folder: folder.path(), protected: &protected, trust };
    let target = match goal.target {
        Some(path) => job.target(path)?,
        None => job.method(goal.method.denoising(model.source(), input)?)?,
    };
    let baked = job.run(&BakeSettings { target, ..settings.clone() }, progress)?;
    Ok((baked, folder))
}

/// Settings of a bake by the default method. Fails if options contradict each other.
pub(crate) fn settings(args: &MapArgs, welding: Welding) -> Result<BakeSettings, Failure> {
    check_layout(args)?;
    Ok(BakeSettings {
        target: BakeTarget::default(),
        welding,
        normals: args.normals.0,
        lambda: Lambda(args.lambda),
        map: map_kind(args)?,
        layout: args.layout,
        pages: args.pages,
        side: args.size.0,
        largest_side: LargestSide(args.max_size),
        tolerance: Quanta(args.tolerance),
        interpolation: args.interpolation,
        texels: args.texels,
        texel: texel(args)?,
        convention: args.normal_convention,
        carriers: if args.no_glb { Carriers::Obj } else { Carriers::ObjAndGlb },
        occlusion: args.ao.then_some(Occlusion { rays: args.ao_rays, distance: args.ao_distance }),
        curvature: if args.curvature { CurvatureMap::Mean } else { CurvatureMap::None },
        last_result: LastResult::default(),
    })
}

/// Fails if the layout does not go with the size, or is not built in.
fn check_layout(args: &MapArgs) -> Result<(), Failure> {
    let layout = args.layout;
    if layout == LayoutChoice::Vertex && args.size.0.is_some() {
        let reason = "--size does not go with --layout vertex, whose size follows from the number of vertices";
        return Err(Failure::Input(reason.to_owned()));
    }
    if args.pages != PageRule::None && matches!(layout, LayoutChoice::Vertex | LayoutChoice::Unwrap) {
        let (pages, layout) = (args.pages.name(), layout.name());
        return Err(Failure::Input(format!(
            "--pages {pages} does not go with --layout {layout}, which makes one image"
        )));
    }
    if layout == LayoutChoice::Unwrap && !bake::CAN_UNWRAP {
        let reason =
            "--layout unwrap is not in this planish; build it with: cargo install --path crates/bake --features unwrap";
        return Err(Failure::Input(reason.to_owned()));
    }
    Ok(())
}

/// Returns the format of the texels; `--format` and `--bits` may give a part of it or all.
fn texel(args: &MapArgs) -> Result<TexelFormat, Failure> {
    let format = args.format.unwrap_or(if args.bits == Some(32) { FileFormat::Exr } else { FileFormat::Png });
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

/// Returns the kind of map.
fn map_kind(args: &MapArgs) -> Result<MapKind, Failure> {
    match (args.map, args.space) {
        (MapArg::Scalar, None) => Ok(MapKind::Scalar),
        (MapArg::Scalar, Some(_)) => Err(Failure::Input("--space goes with --map vector".to_owned())),
        (MapArg::Vector, None | Some(SpaceArg::Object)) => Ok(MapKind::VectorObject),
        (MapArg::Vector, Some(SpaceArg::Tangent)) => Ok(MapKind::VectorTangent),
    }
}
