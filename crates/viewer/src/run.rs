//! Entry of the program: a picture, timings, or the window.

use crate::args::Args;
use crate::drawer::Drawer;
use crate::make_report;
use crate::timings;
use planish_files::bake_files::{self, Job};
use planish_files::failure::Failure;
use planish_files::input;
use planish_files::output::{self, Output};
use planish_files::terminal::{self, Bar, Terminal};
use planish_geometry::bake::BakeSettings;
use planish_geometry::metrics::Triangles;
use planish_geometry::metrics::colormap::Colormap;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::Model;
use planish_render::gpu::renderer::Renderer;
use planish_render::gpu::{Backend, Gpu};
use planish_render::scene::Scene;
use planish_render::settings::volume::VolumeSource;
use planish_render::settings::{Heat, Settings, Shading};
use planish_viewer::app::capture;
use planish_viewer::open::{self, Opened};
use planish_viewer::vertex_error;
use planish_viewer::window::{self, Options};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Does what the command line says.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let begun = Instant::now();
    let settings = settings(args)?;
    let usage = |text: &str| Err(Failure::Input(text.to_owned()));
    if let Some(output) = &args.report {
        return make_report::write(args, output, settings);
    }
    match &args.headless {
        Some(output) => picture(args, output, settings),
        None if args.timings => timings(args, settings, begun),
        None if args.backend == Backend::Software => {
            usage("--backend software draws into a file; name it with --headless OUT.png")
        }
        None if let Some(option) = args.only_for_pictures() => {
            usage(&format!("{option} goes with --headless OUT.png; the window opens what it is given"))
        }
        None => window::run(Options {
            open: args.input.clone(),
            trust: args.trust(),
            backend: args.backend,
            settings,
            log: args.log.clone(),
        }),
    }
}

fn settings(args: &Args) -> Result<Settings, Failure> {
    let settings = match &args.settings {
        Some(path) => Settings::from_json(&input::read(path)?).map_err(|e| Failure::at(path, e))?,
        None => Settings::default(),
    };
    let settings = args.override_settings(settings);
    settings.check().map_err(|e| Failure::Input(e.to_string()))?;
    Ok(settings)
}

/// The scene with its mesh, if it has one, and the settings with what the files say where the command line says nothing.
fn scene(args: &Args, mut settings: Settings, terminal: &Terminal) -> Result<Subject, Failure> {
    if settings.shading == Shading::Heat && args.scalars.is_none() && args.clean.is_none() {
        return Err(Failure::Input("heat shading needs numbers: --scalars IN.txt or --clean CLEAN.obj".to_owned()));
    }
    if settings.shading == Shading::Solid && settings.volume.is_none() {
        return Err(Failure::Input("solid shading needs a volume: --volume distance or --volume FILE".to_owned()));
    }
    let has_file = settings.volume.as_ref().is_some_and(|v| !matches!(v.source, VolumeSource::Distance { .. }));
    if args.input.is_none() && has_file {
        return Ok(Subject { scene: open::open_volume(&settings, args.trust(), terminal)?, settings, mesh: None });
    }
    // What a bake warns of is about its files, and here nobody gets them.
    let Opened { mesh, model, mut scene, map, warnings, .. } = open::open(&args.files()?, &settings, terminal)?;
    warnings.iter().for_each(|text| terminal.warn(text));
    if let Some(map) = map.filter(|_| args.settings.is_none() && args.lambda.is_none()) {
        settings.displace.lambda = map.manifest.displacement.lambda as f32;
    }
    if !scene.textures.all().is_empty() && args.settings.is_none() && args.shading.is_none() {
        settings.shading = Shading::Texture;
    }
    if let Some(path) = &args.clean {
        let clean = Triangles::from(input::source(path, args.trust())?.data());
        let errors = vertex_error::errors(&model, &scene, &settings.displace, &clean, args.error.into());
        let errors = errors.map_err(|e| Failure::at(path, e))?;
        if args.settings.is_none() {
            settings.heat =
                Heat { map: Colormap::Sequential, range: Some(vertex_error::range(&errors)), ..settings.heat };
            settings.shading = args.shading.unwrap_or(Shading::Heat);
        }
        scene.set_scalars(errors).map_err(|e| Failure::at(path, e))?;
    }
    Ok(Subject { scene, settings, mesh: Some((mesh, model)) })
}

/// What is drawn.
struct Subject {
    scene: Scene,
    settings: Settings,
    /// Path and model of the mesh; `None` for a volume alone.
    mesh: Option<(PathBuf, Model)>,
}

/// Draws into a file. The settings go into another one, and either both files are written or none.
fn picture(args: &Args, output: &Path, settings: Settings) -> Result<(), Failure> {
    let terminal = Terminal::new(Bar::Shown);
    let inputs = args.inputs();
    let picture_file = Output::open(output, &inputs)?;
    let settings_file = args.save_settings.as_deref().map(|path| Output::open(path, &inputs)).transpose()?;
    let Subject { scene, settings, .. } = scene(args, settings, &terminal)?;
    terminal.stage("drawing");
    let mut drawer = Drawer::open(&scene, args.backend, &terminal)?;
    let bytes = if args.animate {
        capture::animation(&settings, |settings| drawer.draw(settings), &terminal)?
    } else if args.before_after {
        capture::png(&capture::before_after(&settings, |settings| drawer.draw(settings))?)?
    } else {
        capture::png(&drawer.draw(&settings)?)?
    };
    drawer.warn(&terminal);
    let mut files = vec![(picture_file, bytes)];
    if let Some(file) = settings_file {
        files.push((file, settings.to_json().map_err(Failure::internal)?.into_bytes()));
    }
    terminal.check()?;
    output::write_all(files)
}

/// Prints how long a picture takes; `begun` is when the program started.
fn timings(args: &Args, settings: Settings, begun: Instant) -> Result<(), Failure> {
    let terminal = Terminal::new(Bar::Shown);
    let Subject { scene, settings, mesh } = scene(args, settings, &terminal)?;
    let opening = begun.elapsed();
    let renderer = Renderer::new(Gpu::open(args.backend).map_err(Failure::internal)?);
    let starting = begun.elapsed() - opening;
    let folder = mesh.as_ref().map(|(path, _)| bake_files::folder_beside(path)).transpose()?;
    let job = mesh.as_ref().zip(folder.as_ref()).map(|((input, model), folder)| Job {
        input,
        model,
        folder,
        protected: &[],
        trust: args.trust(),
    });
    let bake = job.as_ref().map(|job| |progress: &dyn Progress| job.run(&BakeSettings::default(), progress).is_ok());
    let bake = bake.as_ref().map(|bake| bake as timings::Bake);
    let timings = timings::measure(&renderer, &scene, &settings, bake, [opening, starting]);
    let timings = timings.map_err(Failure::internal)?;
    renderer.gpu().validation_errors().iter().for_each(|text| terminal.warn(text));
    terminal.check()?;
    let text = serde_json::to_string_pretty(&timings).map_err(Failure::internal)?;
    terminal.clear();
    terminal::print(format!("{text}\n").as_bytes())
}
