//! Environments from picture files: PNG and JPEG (sRGB), Radiance HDR and EXR (linear).

use crate::image_file;
use glam::Vec3;
use image::DynamicImage;
use planish_files::failure::Failure;
use planish_files::input;
use planish_render::colour::linear_from_srgb;
use planish_render::environment::cube::CubeMap;
use planish_render::environment::equirect::Equirect;
use planish_render::environment::{Environment, MAX_RADIANCE};
use std::convert::Infallible;
use std::path::{Path, PathBuf};

use planish_render::settings::environment::{Scene, Source};

/// The origin that a text names: `desert`, `ice`, a folder or a file.
pub fn parse_source(text: &str) -> Result<Source, Infallible> {
    Ok(match text {
        "desert" => Source::Scene(Scene::Desert),
        "ice" => Source::Scene(Scene::Ice),
        _ if Path::new(text).is_dir() => Source::Cube(text.into()),
        _ => Source::Equirect(text.into()),
    })
}

/// File names of the faces +x −x +y −y +z −z (right, left, up, down, ahead, behind), without the extension.
pub const NAMES: [[&str; 6]; 3] = [
    ["px", "nx", "py", "ny", "pz", "nz"],
    ["posx", "negx", "posy", "negy", "posz", "negz"],
    ["right", "left", "top", "bottom", "front", "back"],
];

/// Reads or draws an environment, with at most size² texels a face where the source has more.
pub fn load(source: &Source, size: usize) -> Result<Environment, Failure> {
    match source {
        Source::Scene(scene) => Ok(Environment::generated(*scene, size)),
        Source::Equirect(path) => {
            let (width, height, texels) = read_linear(path)?;
            if width != 2 * height {
                let reason = format!("{width}×{height} pixels: an equirectangular map is twice as wide as high");
                return Err(Failure::at(path, reason));
            }
            let map = Equirect::new(width, texels).ok_or_else(|| Failure::at(path, "the image is empty"))?;
            Ok(Environment::new(CubeMap::from_equirect(&map, size)))
        }
        Source::Cube(folder) => Ok(Environment::new(cube(folder, size)?)),
    }
}

fn cube(folder: &Path, size: usize) -> Result<CubeMap, Failure> {
    let unreadable = |e: std::io::Error| Failure::at(folder, input::plain(&e));
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .map_err(unreadable)?
        .map(|entry| entry.map(|e| e.path()).map_err(unreadable))
        .collect::<Result<_, _>>()?;
    // The order of a folder is anybody's guess.
    files.sort();
    let named = |name: &str| {
        let mut found = files.iter().filter(|f| f.file_stem().is_some_and(|stem| stem.eq_ignore_ascii_case(name)));
        match (found.next(), found.next()) {
            (Some(_), Some(second)) => Err(Failure::at(second, format!("a second picture called {name}"))),
            (first, _) => Ok(first),
        }
    };
    for names in NAMES {
        let found = names.map(named).into_iter().collect::<Result<Vec<_>, _>>()?;
        if found.iter().all(Option::is_none) {
            continue;
        }
        let mut faces = Vec::new();
        for (file, name) in found.into_iter().zip(names) {
            faces.push(file.ok_or_else(|| Failure::at(folder, format!("no picture is called {name}")))?);
        }
        let mut side = None;
        let mut texels: [Vec<Vec3>; 6] = Default::default();
        for (face, into) in faces.into_iter().zip(&mut texels) {
            let (width, height, read) = read_linear(face)?;
            let expected = *side.get_or_insert(width);
            if width != height || width != expected {
                return Err(Failure::at(face, format!("{width}×{height} pixels: faces must be squares of one size")));
            }
            *into = read;
        }
        let cube = CubeMap::from_faces(side.unwrap_or(0), &texels).map_err(|e| Failure::at(folder, e))?;
        return Ok(if cube.size() > size { cube.resized(size) } else { cube });
    }
    Err(Failure::at(folder, format!("no six pictures called {}, or …", NAMES[0].join(", "))))
}

/// Width, height and linear RGB of a picture. What is not a number becomes black, what is too bright the brightest.
fn read_linear(path: &Path) -> Result<(usize, usize, Vec<Vec3>), Failure> {
    let image = image_file::read(path)?;
    let linear = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let image = image.into_rgb32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let radiance = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(0.0, MAX_RADIANCE) };
    let texel = |p: &image::Rgb<f32>| Vec3::from(p.0).map(if linear { radiance } else { linear_from_srgb });
    Ok((width, height, image.pixels().map(texel).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, Rgb32FImage, RgbImage};
    use std::fs;

    fn error(source: &Source) -> String {
        load(source, 16).unwrap_err().to_string()
    }

    #[test]
    fn every_format_gives_its_light_back() {
        let folder = tempfile::tempdir().unwrap();
        // Half of the encoded range is 21 % of the light.
        let bytes = RgbImage::from_pixel(8, 4, Rgb([128, 255, 0]));
        let floats = Rgb32FImage::from_pixel(8, 4, Rgb([0.25, 4.0, 0.0]));
        for (name, expected, within) in [
            ("a.png", Vec3::new(0.2159, 1.0, 0.0), 1e-3),
            ("a.jpg", Vec3::new(0.2159, 1.0, 0.0), 0.03),
            ("a.hdr", Vec3::new(0.25, 4.0, 0.0), 0.03),
            ("a.exr", Vec3::new(0.25, 4.0, 0.0), 1e-3),
        ] {
            let path = folder.path().join(name);
            if name.ends_with("png") || name.ends_with("jpg") {
                bytes.save(&path).unwrap();
            } else {
                DynamicImage::ImageRgb32F(floats.clone()).save(&path).unwrap();
            }
            let environment = load(&Source::Equirect(path), 16).unwrap();
            for direction in [Vec3::X, Vec3::NEG_Y, Vec3::ONE] {
                let found = environment.levels[0].at(direction);
                assert!(found.abs_diff_eq(expected, within), "{name}: {found}");
            }
        }
    }

    #[test]
    fn faces_are_found_by_name_and_lie_where_it_says() {
        for names in NAMES {
            let folder = tempfile::tempdir().unwrap();
            for (i, name) in names.into_iter().enumerate() {
                RgbImage::from_pixel(4, 4, Rgb([40 * i as u8, 0, 0]))
                    .save(folder.path().join(format!("{name}.png")))
                    .unwrap();
            }
            let environment = load(&Source::Cube(folder.path().into()), 16).unwrap();
            let faces = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
            for (i, face) in faces.into_iter().enumerate() {
                let expected = linear_from_srgb(40.0 * i as f32 / 255.0);
                assert!((environment.levels[0].at(face).x - expected).abs() < 1e-5, "{} {face}", names[i]);
            }
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        RgbImage::new(4, 4).save(path("square.png")).unwrap();
        fs::write(path("text.png"), "no picture").unwrap();
        assert!(error(&Source::Equirect(path("square.png"))).contains("square.png: 4×4 pixels"));
        assert!(error(&Source::Equirect(path("text.png"))).contains("text.png: "));
        assert!(error(&Source::Equirect(path("none.hdr"))).contains("none.hdr: "));
        assert!(error(&Source::Cube(folder.path().into())).contains("px, nx"));
        RgbImage::new(4, 4).save(path("px.png")).unwrap();
        assert!(error(&Source::Cube(folder.path().into())).contains("called nx"));
        RgbImage::new(4, 4).save(path("px.bmp.png")).unwrap();
        fs::write(path("px.jpg"), "").unwrap();
        assert!(error(&Source::Cube(folder.path().into())).contains("second picture called px"));
    }
}
