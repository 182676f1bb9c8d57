//! Files in, a picture out, or a window.

use crate::args::Args;
use crate::terminal::Terminal;
use crate::timings;
use image::{ImageFormat, RgbaImage};
use planish_files::output;
use planish_geometry::colormap::Colormap;
use planish_geometry::metrics::Triangles;
use planish_geometry::obj::Obj;
use planish_viewer::errors;
use planish_viewer::gpu::{Backend, Gpu, NoGpu};
use planish_viewer::open::{self, BadFile, Opened};
use planish_viewer::painter::Painter;
use planish_viewer::renderer::Renderer;
use planish_viewer::scene::Scene;
use planish_viewer::settings::{Heat, Settings, Shading};
use planish_viewer::software;
use planish_viewer::window::{self, NoWindow, Options};
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// Why there is no picture.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// A file that cannot be read or makes no sense.
    #[error(transparent)]
    Input(#[from] BadFile),
    /// Options that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A file that cannot be written.
    #[error("{}: {reason}", path.display())]
    Output { path: PathBuf, reason: String },
    /// No adapter, and the processor is not asked for.
    #[error(transparent)]
    NoGpu(#[from] NoGpu),
    /// No display, or no adapter that draws to it.
    #[error(transparent)]
    NoWindow(#[from] NoWindow),
}

impl Failure {
    /// Exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Output { .. } | Self::NoWindow(_) | Self::NoGpu(_) => 1,
            Self::Input(_) | Self::Usage(_) => 2,
        }
    }
}

/// Does what the command line says.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let begun = Instant::now();
    let settings = settings(args)?;
    match &args.headless {
        Some(output) => picture(args, output, settings),
        None if args.timings => {
            let (scene, settings) = scene(args, settings)?;
            let opening = begun.elapsed();
            let renderer = Renderer::new(Gpu::open(args.backend)?);
            let starting = begun.elapsed() - opening;
            let timings = timings::measure(&renderer, &scene, &settings, opening, starting)?;
            renderer.gpu().complaints().iter().for_each(|text| warn(text));
            let text = serde_json::to_string_pretty(&timings).map_err(|e| Failure::Usage(e.to_string()))?;
            writeln!(std::io::stdout(), "{text}")
                .map_err(|e| Failure::Output { path: "standard output".into(), reason: e.to_string() })
        }
        None if args.backend == Backend::Software => {
            Err(Failure::Usage("--backend software draws into a file; name it with --headless OUT.png".to_owned()))
        }
        None if let Some(option) = args.only_for_pictures() => {
            Err(Failure::Usage(format!("{option} goes with --headless OUT.png; the window opens what it is given")))
        }
        None => Ok(window::run(Options {
            open: args.input.clone(),
            backend: args.backend,
            settings,
            log: args.log.clone(),
        })?),
    }
}

fn settings(args: &Args) -> Result<Settings, Failure> {
    let bad_settings = |path: &Path, e: &dyn ToString| BadFile { path: path.to_owned(), reason: e.to_string() };
    let settings = match &args.settings {
        Some(path) => Settings::from_json(&open::read(path)?).map_err(|e| bad_settings(path, &e))?,
        None => Settings::default(),
    };
    let settings = args.override_settings(settings);
    settings.check().map_err(|e| Failure::Usage(e.to_string()))?;
    Ok(settings)
}

/// The scene, and the settings with what the files say where the command line says nothing.
fn scene(args: &Args, mut settings: Settings) -> Result<(Scene, Settings), Failure> {
    if settings.shading == Shading::Heat && args.scalars.is_none() && args.clean.is_none() {
        return Err(Failure::Usage("heat shading needs numbers: --scalars IN.txt or --clean CLEAN.obj".to_owned()));
    }
    let Opened { model, mut scene, manifest, warnings, .. } = open::open(&args.files()?, &settings, &Terminal::new())?;
    warnings.iter().for_each(|text| warn(text));
    if let Some(manifest) = manifest.filter(|_| args.settings.is_none() && args.lambda.is_none()) {
        settings.displace.lambda = manifest.displacement.lambda as f32;
    }
    if !scene.textures.all().is_empty() && args.settings.is_none() && args.shading.is_none() {
        settings.shading = Shading::Texture;
    }
    if let Some(path) = &args.clean {
        let bad = |reason: &dyn ToString| BadFile { path: path.clone(), reason: reason.to_string() };
        let clean = Triangles::from(Obj::parse(open::read(path)?).map_err(|e| bad(&e))?.data());
        let errors = errors::errors(&model, &scene, &settings.displace, &clean, args.error.into());
        let errors = errors.map_err(|e| bad(&e))?;
        if args.settings.is_none() {
            settings.heat = Heat { map: Colormap::Sequential, range: Some(errors::range(&errors)), ..settings.heat };
            settings.shading = args.shading.unwrap_or(Shading::Heat);
        }
        scene.set_scalars(errors).map_err(|e| bad(&e))?;
    }
    Ok((scene, settings))
}

fn picture(args: &Args, output: &Path, settings: Settings) -> Result<(), Failure> {
    for place in std::iter::once(output).chain(args.save_settings.as_deref()) {
        output::spare(place, &args.inputs()).map_err(|e| Failure::Usage(e.to_string()))?;
    }
    let (scene, settings) = scene(args, settings)?;
    let mut png = Cursor::new(Vec::new());
    let failed = |reason: String| Failure::Output { path: output.to_owned(), reason };
    let picture = draw(&scene, &settings, args.backend)?;
    picture.write_to(&mut png, ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    write(output, png.get_ref())?;
    if let Some(path) = &args.save_settings {
        write(path, settings.to_json().map_err(|e| failed(e.to_string()))?.as_bytes())?;
    }
    Ok(())
}

fn draw(scene: &Scene, settings: &Settings, backend: Backend) -> Result<RgbaImage, Failure> {
    let renderer = match backend {
        Backend::Software => None,
        _ => match Gpu::open(backend) {
            Ok(gpu) => Some(Renderer::new(gpu)),
            Err(NoGpu::NoAdapter { .. }) if backend == Backend::Auto => None,
            Err(e) => return Err(e.into()),
        },
    };
    let Some(renderer) = renderer else { return Ok(software::render(scene, settings)) };
    let mut painter = match Painter::new(backend, renderer, scene) {
        Err(e @ NoGpu::TooLarge { .. }) if backend == Backend::Auto => {
            warn(&e.to_string());
            return Ok(software::render(scene, settings));
        }
        painter => painter?,
    };
    let picture = painter.picture(settings)?;
    for complaint in painter.renderer().gpu().complaints() {
        warn(&complaint);
    }
    Ok(picture)
}

/// If nobody listens, the picture is there all the same.
fn warn(text: &str) {
    let _ = writeln!(std::io::stderr(), "planish-viewer: warning: {text}");
}

/// Writes beside the file and renames, so that no reader ever sees half a file.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let attempt = || {
        let builder = &mut tempfile::Builder::new();
        // A picture is no secret: the permissions of any new file, less the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder)?;
        file.write_all(bytes)?;
        file.persist(path).map(drop).map_err(|e| e.error)
    };
    attempt().map_err(|e: std::io::Error| Failure::Output { path: path.to_owned(), reason: e.to_string() })
}
