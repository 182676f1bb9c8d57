//! Drawing and measuring for `--report`.

use crate::args::{Args, ErrorKind};
use crate::drawer::draw;
use glam::{DVec3, Vec3};
use image::RgbaImage;
use planish_files::bake_files;
use planish_files::failure::Failure;
use planish_files::input;
use planish_files::output::Output;
use planish_files::terminal::{Bar, Terminal};
use planish_files::text::shown;
use planish_geometry::map::displacement::MapKind;
use planish_geometry::map::manifest::Manifest;
use planish_geometry::metrics::Triangles;
use planish_geometry::metrics::colormap::Colormap;
use planish_geometry::progress::Progress as _;
use planish_geometry::source::model::Model;
use planish_render::scene::Scene;
use planish_render::settings::{Displace, Heat, Settings, Shading};
use planish_viewer::app::bake_config::BakeConfig;
use planish_viewer::app::capture;
use planish_viewer::app::vertex_numbers::VertexNumbers;
use planish_viewer::open::{self, Opened};
use planish_viewer::report::{self, HeatMap, Histogram, Report};
use planish_viewer::vertex_error;
use std::path::Path;

/// Draws and measures the mesh with its map, and writes the page.
pub(crate) fn write(args: &Args, output: &Path, mut settings: Settings) -> Result<(), Failure> {
    let terminal = Terminal::new(Bar::Shown);
    let file = Output::open(output, &args.inputs())?;
    // A report needs the map, whatever its strength.
    let baking = Settings { displace: Displace { lambda: 1.0, ..settings.displace }, ..settings.clone() };
    let Opened { mesh, model, scene, map, baked, warnings } = open::open(&args.files()?, &baking, &terminal)?;
    warnings.iter().for_each(|text| terminal.warn(text));
    let map = map.ok_or_else(|| Failure::Input("--report needs a map".to_owned()))?;
    if args.settings.is_none() && args.lambda.is_none() {
        settings.displace.lambda = map.manifest.displacement.lambda as f32;
    }
    if !scene.textures.all().is_empty() && args.settings.is_none() {
        settings.shading = Shading::Texture;
    }
    let mut subject = Subject { args, scene, settings, terminal: &terminal };
    terminal.stage("drawing");
    let moves = report::moves(&subject.scene);
    let mut report = Report {
        name: mesh.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        summary: report::summary_of(&subject.scene, &map.manifest),
        before: capture::png(&subject.before()?)?,
        after: capture::png(&subject.draw(&subject.settings)?)?,
        figures: report::figures(&map.manifest),
        command: command(args, &mesh, &map.manifest)?,
        ..Report::default()
    };
    report.heat_maps.push(subject.heights()?);
    // A map that was opened does not say where its noise was found.
    let deviations = baked.map_or_else(Vec::new, |baked| baked.bundle.deviations);
    if let Some(noise) = VertexNumbers::of_noise(&deviations, model.surface().mean_edge()) {
        report.heat_maps.push(subject.noise(&noise)?);
    }
    report.histograms.extend(histograms(&subject, &moves));
    if let Some(path) = &args.clean {
        subject.compare(&model, path, &mut report)?;
    }
    terminal.check()?;
    file.write(report.page().as_bytes())?;
    Ok(())
}

/// A mesh with its map, to be drawn in several ways.
struct Subject<'a> {
    args: &'a Args,
    scene: Scene,
    settings: Settings,
    terminal: &'a Terminal,
}

impl Subject<'_> {
    fn draw(&self, settings: &Settings) -> Result<RgbaImage, Failure> {
        self.terminal.check()?;
        draw(&self.scene, settings, self.args.backend, self.terminal)
    }

    /// Displacement at λ = 0.
    fn no_displacement(&self) -> Displace {
        Displace { lambda: 0.0, ..self.settings.displace }
    }

    /// Draws the mesh as it is.
    fn before(&self) -> Result<RgbaImage, Failure> {
        self.draw(&Settings { displace: self.no_displacement(), ..self.settings.clone() })
    }

    /// Draws the heights of the map on the mesh as it is.
    fn heights(&self) -> Result<HeatMap, Failure> {
        let settings = Settings { shading: Shading::Height, displace: self.no_displacement(), ..self.settings.clone() };
        Ok(HeatMap {
            title: "Height of the noise".to_owned(),
            caption: "How far the noise lifted each vertex, or pushed it in, in units of the model.".to_owned(),
            picture: capture::png(&self.draw(&settings)?)?,
        })
    }

    /// Draws the noise that was found, on the mesh as it is.
    fn noise(&mut self, noise: &VertexNumbers) -> Result<HeatMap, Failure> {
        self.scene.set_scalars(noise.numbers.to_vec()).map_err(Failure::internal)?;
        let heat = Heat { map: VertexNumbers::COLORMAP, range: Some(noise.range), ..self.settings.heat };
        let displace = self.no_displacement();
        let settings = Settings { shading: Shading::Heat, heat, displace, ..self.settings.clone() };
        Ok(HeatMap {
            title: "Where the noise is".to_owned(),
            caption: "Standard deviation of the noise that was found, in mean edge lengths. The darkest colour is no noise, or a place where none could be measured."
                .to_owned(),
            picture: capture::png(&self.draw(&settings)?)?,
        })
    }

    /// Adds the error against a clean mesh, before and after, in the same colours.
    fn compare(&mut self, model: &Model, path: &Path, report: &mut Report) -> Result<(), Failure> {
        let clean = Triangles::from(input::source(path, self.args.trust())?.data());
        let (words, unit) = match self.args.error {
            ErrorKind::Distance => ("distance from the clean mesh", "mean edge lengths"),
            ErrorKind::Angle => ("angle to the clean mesh", "degrees"),
        };
        let states = [("before", self.no_displacement()), ("after", self.settings.displace)];
        let mut range = None;
        for (when, displace) in states {
            let errors = vertex_error::errors(model, &self.scene, &displace, &clean, self.args.error.into());
            let errors = errors.map_err(|e| Failure::at(path, e))?;
            let range = *range.get_or_insert_with(|| vertex_error::range(&errors));
            let finite: Vec<f64> = errors.iter().filter(|x| x.is_finite()).map(|x| f64::from(*x)).collect();
            let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
            report.figures.push((format!("Mean {words}, {when}"), format!("{} {unit}", report::rounded(mean))));
            self.scene.set_scalars(errors).map_err(Failure::internal)?;
            let heat = Heat { map: Colormap::Sequential, range: Some(range), ..self.settings.heat };
            let settings = Settings { shading: Shading::Heat, heat, displace, ..self.settings.clone() };
            report.heat_maps.push(HeatMap {
                title: format!("Error {when}"),
                caption: format!("The {words} in {unit}: {}.", shown(path)),
                picture: capture::png(&self.draw(&settings)?)?,
            });
        }
        Ok(())
    }
}

/// Angle by which each triangle turns, degrees; only for those with an area. #T or fewer
fn turns(subject: &Subject) -> Vec<f64> {
    let mesh = subject.scene.mesh();
    let Some(binding) = &subject.scene.displacement else { return Vec::new() };
    let displaced = binding.displaced(&subject.settings.displace);
    let normal = |positions: &[Vec3], corners: [u32; 3]| {
        let [a, b, c] = corners.map(|v| positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    };
    let turn = |corners: [u32; 3]| {
        let [n, m] = [normal(&mesh.positions, corners), normal(&displaced, corners)];
        (n != DVec3::ZERO && m != DVec3::ZERO).then(|| n.cross(m).length().atan2(n.dot(m)).to_degrees())
    };
    mesh.triangles.iter().filter_map(|t| turn(t.positions)).collect()
}

fn histograms(subject: &Subject, moves: &[f32]) -> impl Iterator<Item = Histogram> {
    let is_scalar = subject.scene.displacement.as_ref().is_some_and(|binding| binding.map.kind() == MapKind::Scalar);
    let (title, caption) = if is_scalar {
        ("Heights", "How far the noise lifted the vertices, or pushed them in.")
    } else {
        ("Displacements", "How far the map moves the vertices.")
    };
    let heights = Histogram::new(title, caption, "units of the model", moves.iter().map(|x| f64::from(*x)));
    let turned = "How far denoising turns the faces, which is what light shows.";
    heights.into_iter().chain(Histogram::new("Turned faces", turned, "degrees", turns(subject)))
}

/// Command that bakes the map, as it is typed.
fn command(args: &Args, mesh: &Path, manifest: &Manifest) -> Result<String, Failure> {
    let Some(path) = args.files()?.map else {
        return Ok(BakeConfig::default().command(mesh, &bake_files::default_folder(mesh)?));
    };
    let source = args.files()?.mesh.unwrap_or_else(|| path.with_file_name(&manifest.source.file));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(BakeConfig::of(manifest, &path).command(&source, folder))
}
