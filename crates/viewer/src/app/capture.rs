//! Capture of the view to disk: screenshots and turntables.

use image::{ImageFormat, RgbaImage};
use planish_files::failure::Failure;
use planish_files::output::{Folder, Output};
use planish_geometry::progress::Progress;
use planish_render::settings::Settings;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The first name `NAME.view.N.png` beside a mesh that no file has.
pub fn screenshot(mesh: &Path) -> PathBuf {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let named = |n: u32| mesh.with_file_name(format!("{stem}.view.{n:03}.png"));
    (1..).map(named).find(|path| !path.exists()).unwrap_or_else(|| named(0))
}

/// The folder of a turntable: `NAME-turntable` beside the mesh.
pub fn turntable_folder(mesh: &Path) -> PathBuf {
    mesh.with_file_name(format!("{}-turntable", mesh.file_stem().unwrap_or_default().to_string_lossy()))
}

/// Writes one picture to a PNG file.
pub fn save(picture: &RgbaImage, path: &Path) -> Result<PathBuf, Failure> {
    Output::open(path, &[])?.write(&png(picture)?)
}

/// Encodes a picture as the bytes of a PNG file.
pub fn png(picture: &RgbaImage) -> Result<Vec<u8>, Failure> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(Failure::internal)?;
    Ok(bytes.into_inner())
}

/// Writes `count` pictures `0000.png`, … once around the model; all of them or none.
pub fn turntable(
    settings: &Settings,
    count: u32,
    folder: &Path,
    draw: impl Fn(&Settings) -> Result<RgbaImage, Failure>,
    progress: &dyn Progress,
) -> Result<Vec<PathBuf>, Failure> {
    let folder = Folder::open(folder)?;
    progress.stage("turning");
    let mut files = Vec::new();
    for i in 0..count {
        progress.check()?;
        let mut rotated = settings.clone();
        rotated.camera.yaw += 360.0 * i as f32 / count as f32;
        files.push((PathBuf::from(format!("{i:04}.png")), png(&draw(&rotated)?)?));
        progress.done(f64::from(i + 1) / f64::from(count));
    }
    progress.check()?;
    folder.write(files.iter().map(|(name, bytes)| (name.as_path(), bytes.as_slice())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planish_geometry::progress::Silent;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn screenshots_never_replace_one_another() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = folder.path().join("a.obj");
        for n in ["a.view.001.png", "a.view.002.png"] {
            let path = screenshot(&mesh);
            assert!(path.ends_with(n), "{}", path.display());
            save(&RgbaImage::new(2, 2), &path).unwrap();
        }
    }

    #[test]
    fn a_turntable_turns_once_and_leaves_nothing_when_it_is_stopped() {
        struct StopAfter(AtomicU32, u32);
        impl Progress for StopAfter {
            fn cancelled(&self) -> bool {
                self.0.fetch_add(1, Ordering::Relaxed) >= self.1
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("turn");
        let draw = |s: &Settings| Ok(RgbaImage::from_pixel(1, 1, image::Rgba([s.camera.yaw as u8, 0, 0, 255])));
        let settings = Settings::default();
        let stop = StopAfter(AtomicU32::new(0), 2);
        assert_eq!(turntable(&settings, 4, &out, draw, &stop), Err(Failure::Interrupted));
        assert!(!out.exists());
        let written = turntable(&settings, 4, &out, draw, &Silent).unwrap();
        let yaws = written.iter().map(|p| image::open(p).unwrap().into_rgba8().get_pixel(0, 0).0[0]);
        assert_eq!(
            yaws.collect::<Vec<_>>(),
            [30, 120, 210, 255],
            "30° and then quarter turns; 300° ends at the last grey"
        );
    }
}
