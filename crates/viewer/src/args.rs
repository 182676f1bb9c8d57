//! Options of the command line.

mod volume;

use clap::{Parser, ValueEnum};
use planish_files::failure::Failure;
use planish_files::input::Trust;
use planish_geometry::metrics::Heat;
use planish_render::gpu::Backend;
use planish_render::settings::environment::Source;
use planish_render::settings::ground::Show;
use planish_render::settings::shadow::Filter;
use planish_render::settings::{Normals, Overlay, Sampling, Settings, Shading, Size};
use planish_viewer::environment::parse_source;
use planish_viewer::open::Files;
use std::path::{Path, PathBuf};
use volume::VolumeArgs;

/// Shows a mesh and its displacement map in a window, or draws it into a file.
///
/// Exit status: 0 done, 1 failed, 2 bad input or usage.
#[derive(Debug, Parser)]
#[command(name = "planish-viewer", version)]
pub(crate) struct Args {
    /// Mesh to show, or the manifest of a map with its mesh.
    #[arg(value_name = "MESH|MAP.planish.json")]
    pub(crate) input: Option<PathBuf>,

    /// The mesh's map; without one it is baked with the defaults.
    #[arg(long, value_name = "MAP.planish.json", conflicts_with = "heights")]
    map: Option<PathBuf>,

    /// Strength of the map: 0 draws the mesh as it is, 1 denoised [default: what the map says].
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    pub(crate) lambda: Option<f32>,

    /// Draw into this file instead of a window.
    #[arg(long, value_name = "OUT.png")]
    pub(crate) headless: Option<PathBuf>,

    /// Draw λ on its way from 0 to its value and back, as an animated PNG.
    #[arg(long, requires = "headless", conflicts_with_all = ["before_after", "heights"])]
    pub(crate) animate: bool,

    /// Draw the mesh as it is in the left half, and with its map in the right.
    #[arg(long, requires = "headless", conflicts_with = "heights")]
    pub(crate) before_after: bool,

    /// Write a report instead: one HTML file with the mesh before and after, heat maps, histograms and figures, which needs no network.
    #[arg(long, value_name = "OUT.html", conflicts_with_all = ["headless", "timings", "heights", "shading"])]
    pub(crate) report: Option<PathBuf>,

    /// Measure instead of drawing into a file, and print seconds and bytes as JSON.
    #[arg(long, conflicts_with_all = ["headless", "save_settings"])]
    pub(crate) timings: bool,

    /// Start from these settings; other options override them.
    #[arg(long, value_name = "S.json")]
    pub(crate) settings: Option<PathBuf>,

    /// Write the settings of the picture, for --settings.
    #[arg(long, value_name = "S.json", requires = "headless")]
    pub(crate) save_settings: Option<PathBuf>,

    /// Write what happens in the window into this file, one JSON object a line: the time of each frame, and the state.
    #[arg(long, value_name = "OUT.jsonl", conflicts_with = "headless")]
    pub(crate) log: Option<PathBuf>,

    /// Backend that draws.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) backend: Backend,

    /// Base colour (PNG, JPEG) instead of the one that the material names.
    #[arg(long, value_name = "IN.png")]
    texture: Option<PathBuf>,

    /// Tangent-space normals, green up (PNG), instead of those of the map.
    #[arg(long, value_name = "IN.png")]
    normal_map: Option<PathBuf>,

    /// Heights (PNG) that are put on the mesh instead of a map that takes noise off: p + λ (bias + scale · grey) n.
    #[arg(long, value_name = "IN.png")]
    heights: Option<PathBuf>,

    /// Height at texel 0, model units [default: the map's; 0 with --heights].
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    bias: Option<f32>,

    /// Height from texel 0 to texel 1, model units [default: the map's; 1 with --heights].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f32>,

    /// Normals that light the displaced surface.
    #[arg(long, value_enum)]
    normals: Option<Normals>,

    /// Numbers for --shading heat: text, one for each `v` line.
    #[arg(long, value_name = "IN.txt")]
    pub(crate) scalars: Option<PathBuf>,

    /// A clean mesh with the same faces: a heat map shows how far off the picture's surface is.
    #[arg(long, value_name = "CLEAN.obj", conflicts_with = "scalars")]
    pub(crate) clean: Option<PathBuf>,

    /// Error that --clean shows: distance to the clean surface in mean edge lengths, or angle of the normals in degrees.
    #[arg(long, value_enum, default_value = "distance", requires = "clean")]
    pub(crate) error: ErrorKind,

    /// Size of the picture, pixels.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    /// Read files that the mesh or the manifest names wherever they are, not only in its own folder and below.
    #[arg(long)]
    trust: bool,

    /// Shading of the surface.
    #[arg(long, value_name = "MODE")]
    pub(crate) shading: Option<Shading>,

    /// Lines on top of the surface.
    #[arg(long, value_enum)]
    overlay: Option<Overlay>,

    /// Interpolation of textures between their texels.
    #[arg(long, value_enum)]
    sampling: Option<Sampling>,

    /// Shadows that lights cast.
    #[arg(long, value_name = "FILTER")]
    shadow: Option<Filter>,

    /// Part of a plane under the model that is drawn.
    #[arg(long, value_name = "WHAT")]
    ground: Option<Show>,

    /// Environment: desert, ice, an equirectangular picture, or a folder with the six faces of a cube map.
    #[arg(long, value_name = "WHICH", value_parser = parse_source)]
    environment: Option<Source>,

    #[command(flatten)]
    volume: VolumeArgs,

    /// Camera: degrees to the right about the up axis, from the front.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    yaw: Option<f32>,

    /// Camera: degrees above the horizon.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pitch: Option<f32>,
}

/// An error that each vertex has.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ErrorKind {
    /// Distance to the clean surface, mean edge lengths.
    Distance,
    /// Angle between the normals, degrees.
    Angle,
}

impl From<ErrorKind> for Heat {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::Distance => Self::Distance,
            ErrorKind::Angle => Self::Angle,
        }
    }
}

impl Args {
    /// Returns the files that are read.
    pub(crate) fn files(&self) -> Result<Files, Failure> {
        let none = || Failure::Input("--headless and --report need a mesh".to_owned());
        let input = self.input.clone().ok_or_else(none)?;
        let is_manifest = input.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        if is_manifest && self.map.is_some() {
            return Err(Failure::Input("give the map once: as the first argument or with --map".to_owned()));
        }
        let (mesh, map) = if is_manifest { (None, Some(input)) } else { (Some(input), self.map.clone()) };
        Ok(Files {
            mesh,
            map,
            heights: self.heights.clone(),
            texture: self.texture.clone(),
            normal_map: self.normal_map.clone(),
            scalars: self.scalars.clone(),
            trust: self.trust(),
            ..Files::default()
        })
    }

    /// Rule on the files that a mesh or a manifest names.
    pub(crate) fn trust(&self) -> Trust {
        if self.trust { Trust::Anywhere } else { Trust::Folder }
    }

    /// Files that are read, so that none is written over.
    pub(crate) fn inputs(&self) -> Vec<&Path> {
        let files =
            [&self.input, &self.map, &self.texture, &self.normal_map, &self.heights, &self.scalars, &self.clean];
        files.into_iter().flatten().map(PathBuf::as_path).chain(self.volume.file()).collect()
    }

    /// The first option that the window has no use for: it reads the files that it is shown.
    pub(crate) fn only_for_pictures(&self) -> Option<&'static str> {
        let files = [
            ("--map", &self.map),
            ("--texture", &self.texture),
            ("--normal-map", &self.normal_map),
            ("--heights", &self.heights),
            ("--scalars", &self.scalars),
            ("--clean", &self.clean),
        ];
        files.into_iter().find(|(_, file)| file.is_some()).map(|(option, _)| option)
    }

    /// Settings with what the command line says about them.
    pub(crate) fn override_settings(&self, mut settings: Settings) -> Settings {
        settings.size = self.size.unwrap_or(settings.size);
        settings.shading = self.shading.unwrap_or(settings.shading);
        settings.overlay = self.overlay.unwrap_or(settings.overlay);
        settings.sampling = self.sampling.unwrap_or(settings.sampling);
        settings.displace.lambda = self.lambda.unwrap_or(settings.displace.lambda);
        settings.displace.bias = self.bias.or(settings.displace.bias);
        settings.displace.scale = self.scale.or(settings.displace.scale);
        settings.displace.normals = self.normals.unwrap_or(settings.displace.normals);
        settings.shadow.filter = self.shadow.unwrap_or(settings.shadow.filter);
        settings.ground.show = self.ground.unwrap_or(settings.ground.show);
        if let Some(source) = &self.environment {
            settings.environment.get_or_insert_default().source = source.clone();
        }
        self.volume.override_view(&mut settings.volume, settings.shading);
        settings.camera.yaw = self.yaw.unwrap_or(settings.camera.yaw);
        settings.camera.pitch = self.pitch.unwrap_or(settings.camera.pitch);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn options_override_settings_and_nothing_else() {
        let args = Args::try_parse_from(["planish-viewer", "a.obj", "--size", "40x30", "--yaw", "-20"]).unwrap();
        let mut expected = Settings { size: Size { width: 40, height: 30 }, ..Settings::default() };
        expected.camera.yaw = -20.0;
        assert_eq!(args.override_settings(Settings::default()), expected);
    }
}
