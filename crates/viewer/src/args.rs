//! The command line.

use clap::Parser;
use planish_viewer::settings::{Settings, Shading, Size};
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

    /// Base colour (PNG), for meshes with texture coordinates.
    #[arg(long, value_name = "IN.png")]
    pub(crate) texture: Option<PathBuf>,

    /// Numbers for --shading heat: text, one for each `v` line.
    #[arg(long, value_name = "IN.txt")]
    pub(crate) scalars: Option<PathBuf>,

    /// Pixels.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    /// What the surface shows.
    #[arg(long, value_name = "MODE")]
    shading: Option<Shading>,

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
