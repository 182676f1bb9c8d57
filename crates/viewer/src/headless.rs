//! Files in, a picture out.

use crate::args::Args;
use crate::failure::Failure;
use crate::files::{at, read, write};
use crate::load::{self, Needs};
use image::{ImageFormat, RgbaImage};
use planish_viewer::gpu::{Backend, Gpu, GpuError};
use planish_viewer::painter::Painter;
use planish_viewer::scene::Scene;
use planish_viewer::settings::{HeatSource, Settings, Shading};
use planish_viewer::software;
use std::io::{Cursor, Write as _};

/// Does what the command line says.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let output = args.headless.as_deref().ok_or(Failure::NoWindow)?;
    let settings = match &args.settings {
        Some(path) => Settings::from_json(&read(path)?).map_err(at(path))?,
        None => Settings::default(),
    };
    let settings = args.override_settings(settings);
    settings.check().map_err(|e| Failure::Usage(e.to_string()))?;
    if settings.shading == Shading::Heat && settings.heat.source == HeatSource::Given && args.scalars.is_none() {
        return Err(Failure::Usage("heat shading of given numbers needs them: --scalars IN.txt".to_owned()));
    }
    let scene = load::scene(args, Needs::of(&settings))?;

    let mut png = Cursor::new(Vec::new());
    let failed = |reason: String| Failure::Output { path: output.to_owned(), reason };
    draw(args.backend, scene, &settings)?.write_to(&mut png, ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    write(output, png.get_ref())?;
    if let Some(path) = &args.save_settings {
        write(path, settings.to_json().map_err(|e| failed(e.to_string()))?.as_bytes())?;
    }
    Ok(())
}

fn draw(backend: Backend, scene: Scene, settings: &Settings) -> Result<RgbaImage, Failure> {
    let gpu = match backend {
        Backend::Software => return Ok(software::render(&scene, settings)),
        _ => Gpu::open(backend),
    };
    match gpu {
        Err(e @ (GpuError::NoAdapter(_) | GpuError::Unusable { .. })) if backend == Backend::Auto => {
            // If nobody listens, the picture is the same.
            let _ = writeln!(std::io::stderr(), "planish-viewer: {e}; the software renderer draws instead");
            Ok(software::render(&scene, settings))
        }
        gpu => Ok(Painter::on(backend, gpu?, scene)?.picture(settings)?),
    }
}
