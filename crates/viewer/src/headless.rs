//! Files in, a picture out, or a window.

use crate::args::Args;
use image::{ImageFormat, RgbaImage};
use planish_geometry::progress::Silent;
use planish_viewer::gpu::{Backend, Gpu, NoGpu};
use planish_viewer::open::{self, BadFile, Opened};
use planish_viewer::renderer::Renderer;
use planish_viewer::scene::Scene;
use planish_viewer::settings::{Settings, Shading};
use planish_viewer::software;
use planish_viewer::window::{self, NoWindow, Options};
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
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
    let settings = settings(args)?;
    match &args.headless {
        Some(output) => picture(args, output, settings),
        None if args.backend == Backend::Software => {
            Err(Failure::Usage("--backend software draws into a file; name it with --headless OUT.png".to_owned()))
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

fn picture(args: &Args, output: &Path, mut settings: Settings) -> Result<(), Failure> {
    if settings.shading == Shading::Heat && args.scalars.is_none() {
        return Err(Failure::Usage("heat shading needs numbers: --scalars IN.txt".to_owned()));
    }
    let Opened { scene, manifest, .. } = open::open(&args.files()?, &settings, &Silent)?;
    // What is not said is what the files say.
    if let Some(manifest) = manifest.filter(|_| args.settings.is_none() && args.lambda.is_none()) {
        settings.displace.lambda = manifest.displacement.lambda as f32;
    }
    if scene.texture.is_some() && args.settings.is_none() && args.shading.is_none() {
        settings.shading = Shading::Texture;
    }

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
    if backend == Backend::Software {
        return Ok(software::render(scene, settings));
    }
    match Gpu::open(backend) {
        Ok(gpu) => {
            let renderer = Renderer::new(gpu);
            let picture = renderer.image(scene, settings);
            for complaint in renderer.gpu().complaints() {
                warn(&complaint);
            }
            Ok(picture)
        }
        Err(NoGpu::NoAdapter { .. }) if backend == Backend::Auto => Ok(software::render(scene, settings)),
        Err(e) => Err(e.into()),
    }
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
