//! The command line.

use clap::Parser;
use planish_viewer::gpu::Backend;
use planish_viewer::settings::{Filter, HeatSource, Normals, Settings, Shading, Size};
use std::path::PathBuf;

/// Draws a mesh.
///
/// Exit status: 0 done, 1 failed, 2 bad input or usage.
#[derive(Debug, Parser)]
#[command(name = "planish-viewer", version)]
pub(crate) struct Args {
    /// Mesh to draw.
    #[arg(value_name = "IN.obj")]
    pub(crate) input: PathBuf,

    /// Draw into this file instead of a window.
    #[arg(long, value_name = "OUT.png")]
    pub(crate) headless: Option<PathBuf>,

    /// Start from these settings; other options override them.
    #[arg(long, value_name = "S.json")]
    pub(crate) settings: Option<PathBuf>,

    /// Write the settings of the picture, for --settings.
    #[arg(long, value_name = "S.json", requires = "headless")]
    pub(crate) save_settings: Option<PathBuf>,

    /// What draws.
    #[arg(long, value_name = "WHAT", default_value = "auto")]
    pub(crate) backend: Backend,

    /// Displacement map: its manifest, as `planish bake` writes it. Without one, a map is baked with the defaults.
    #[arg(long, value_name = "MAP.planish.json")]
    pub(crate) map: Option<PathBuf>,

    /// Strength of the displacement map: 0 draws the mesh as it is, 1 denoised. [default: 1]
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    lambda: Option<f32>,

    /// What the displaced surface is lit with. [default: derived]
    #[arg(long, value_name = "WHICH")]
    normals: Option<Normals>,

    /// Tangent-space normal map (PNG, green up) in place of the baked one.
    #[arg(long, value_name = "IN.png")]
    pub(crate) normal_map: Option<PathBuf>,

    /// Height map (PNG, grey) for --shading bump and displacement.
    #[arg(long, value_name = "IN.png")]
    pub(crate) height_map: Option<PathBuf>,

    /// Base colour (PNG) in place of the materials' own, for meshes with texture coordinates.
    #[arg(long, value_name = "IN.png")]
    pub(crate) texture: Option<PathBuf>,

    /// Numbers for --shading heat: text, one for each `v` line.
    #[arg(long, value_name = "IN.txt")]
    pub(crate) scalars: Option<PathBuf>,

    /// Which numbers --shading heat shows. [default: height, or given with --scalars]
    #[arg(long, value_name = "WHICH")]
    heat: Option<HeatSource>,

    /// Pixels.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    /// What the surface shows. [default: texture]
    #[arg(long, value_name = "MODE")]
    shading: Option<Shading>,

    /// How textures are sampled. [default: trilinear]
    #[arg(long, value_name = "FILTER")]
    filter: Option<Filter>,

    /// Camera: degrees to the right about the up axis, from the front.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    yaw: Option<f32>,

    /// Camera: degrees above the horizon.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pitch: Option<f32>,
}

impl Args {
    /// Settings with what the command line says about them.
    pub(crate) fn override_settings(&self, mut settings: Settings) -> Settings {
        settings.size = self.size.unwrap_or(settings.size);
        settings.shading = self.shading.unwrap_or(settings.shading);
        settings.map.lambda = self.lambda.unwrap_or(settings.map.lambda);
        settings.map.normals = self.normals.unwrap_or(settings.map.normals);
        settings.sampling.filter = self.filter.unwrap_or(settings.sampling.filter);
        let given = self.scalars.is_some().then_some(HeatSource::Given);
        settings.heat.source = self.heat.or(given).unwrap_or(settings.heat.source);
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
