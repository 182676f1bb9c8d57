//! Capture of the view to disk: screenshots, before and after side by side, animations of λ, and turntables.

use image::{ImageFormat, Rgba, RgbaImage};
use planish_files::failure::Failure;
use planish_files::output::{Folder, Output};
use planish_geometry::progress::Progress;
use planish_render::settings::Settings;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The first name `NAME.view.N.png` beside a mesh that no file has.
pub fn screenshot(mesh: &Path) -> PathBuf {
    numbered(mesh, "view")
}

/// The first name `NAME.lambda.N.png` beside a mesh that no file has.
pub fn animation_file(mesh: &Path) -> PathBuf {
    numbered(mesh, "lambda")
}

/// The first name `NAME.before-after.N.png` beside a mesh that no file has.
pub fn before_after_file(mesh: &Path) -> PathBuf {
    numbered(mesh, "before-after")
}

fn numbered(mesh: &Path, what: &str) -> PathBuf {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let named = |n: u32| mesh.with_file_name(format!("{stem}.{what}.{n:03}.png"));
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

/// Draws the mesh as it is on the left and with its map on the right, with a white line between them.
pub fn before_after(
    settings: &Settings,
    mut draw: impl FnMut(&Settings) -> Result<RgbaImage, Failure>,
) -> Result<RgbaImage, Failure> {
    let mut picture = draw(settings)?;
    let before = draw(&at_lambda(settings, 0.0))?;
    let middle = picture.width() / 2;
    let line = (picture.width() / 400).max(1);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        if x < middle {
            *pixel = *before.get_pixel(x, y);
        }
        if x.abs_diff(middle) < line {
            *pixel = Rgba([u8::MAX; 4]);
        }
    }
    Ok(picture)
}

fn at_lambda(settings: &Settings, lambda: f32) -> Settings {
    let mut at = settings.clone();
    at.displace.lambda = lambda;
    at
}

/// Steps of λ on the way to its end in an animation.
const STEPS: u32 = 12;

/// Draws λ on its way from 0 to that of the settings and back, as the bytes of an animated PNG, which browsers show.
pub fn animation(
    settings: &Settings,
    mut draw: impl FnMut(&Settings) -> Result<RgbaImage, Failure>,
    progress: &dyn Progress,
) -> Result<Vec<u8>, Failure> {
    progress.stage("drawing");
    let mut pictures = Vec::new();
    for step in 0..=STEPS {
        progress.check()?;
        let way = step as f32 / STEPS as f32;
        // Slow at both ends.
        let lambda = settings.displace.lambda * way * way * (3.0 - 2.0 * way);
        pictures.push(draw(&at_lambda(settings, lambda))?);
        progress.done(f64::from(step + 1) / f64::from(STEPS + 1));
    }
    progress.stage("encoding");
    animated_png(&pictures).map_err(Failure::internal)
}

/// Encodes pictures as an animation to and fro without end.
fn animated_png(pictures: &[RgbaImage]) -> Result<Vec<u8>, png::EncodingError> {
    /// Times for which a picture is shown, milliseconds.
    const MOVING: u16 = 70;
    const RESTING: u16 = 1200;
    let last = pictures.len() - 1;
    let order = (0..last).chain((1..=last).rev());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pictures[0].width(), pictures[0].height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_animated(2 * last as u32, 0)?;
    encoder.set_blend_op(png::BlendOp::Over)?;
    let mut writer = encoder.write_header()?;
    let mut shown: Option<&RgbaImage> = None;
    for index in order {
        let picture = &pictures[index];
        let time = if index == 0 || index == last { RESTING } else { MOVING };
        writer.set_frame_delay(time, 1000)?;
        // What does not change is transparent, which takes hardly any bytes.
        let change = match shown {
            None => picture.clone(),
            Some(before) => RgbaImage::from_fn(picture.width(), picture.height(), |x, y| {
                let pixel = *picture.get_pixel(x, y);
                if pixel == *before.get_pixel(x, y) { Rgba([0; 4]) } else { pixel }
            }),
        };
        writer.write_image_data(&change)?;
        shown = Some(picture);
    }
    writer.finish()?;
    Ok(bytes)
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

    /// One pixel whose red is λ in hundredths, beside one that never changes.
    fn lambda(settings: &Settings) -> Result<RgbaImage, Failure> {
        let mut picture = RgbaImage::from_pixel(800, 1, Rgba([7, 7, 7, 255]));
        let red = (100.0 * settings.displace.lambda).round() as u8;
        (1..800).for_each(|x| picture.put_pixel(x, 0, Rgba([red, 0, 0, 255])));
        Ok(picture)
    }

    #[test]
    fn before_is_left_and_after_is_right_of_a_line() {
        let picture = before_after(&Settings::default(), lambda).unwrap();
        let reds = [1, 398, 400, 402, 799].map(|x| picture.get_pixel(x, 0).0[0]);
        assert_eq!(reds, [0, 0, 255, 100, 100]);
    }

    #[test]
    fn an_animation_goes_to_lambda_and_back() {
        let settings = at_lambda(&Settings::default(), 0.8);
        let bytes = animation(&settings, lambda, &Silent).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let frames = reader.info().animation_control().unwrap().num_frames;
        assert_eq!(frames, 2 * STEPS);
        // What is transparent shows the frame before.
        let mut shown = vec![0; 4 * 800];
        let mut reds = Vec::new();
        for _ in 0..frames {
            let mut frame = vec![0; shown.len()];
            reader.next_frame(&mut frame).unwrap();
            for (old, new) in shown.chunks_mut(4).zip(frame.chunks(4)).filter(|(_, new)| new[3] > 0) {
                old.copy_from_slice(new);
            }
            assert_eq!(shown[..4], [7, 7, 7, 255]);
            reds.push(shown[4]);
        }
        assert_eq!((reds[0], reds[STEPS as usize], reds.iter().max().copied()), (0, 80, Some(80)));
        assert!(reds[..=STEPS as usize].is_sorted() && reds[STEPS as usize..].is_sorted_by(|a, b| a >= b));
    }
}
