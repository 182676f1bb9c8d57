//! Pictures for glTF, which takes PNG and JPEG only: made of others, or put together from channels of several.

use image::imageops::{self, FilterType};
use image::{DynamicImage, GrayImage, ImageDecoder as _, ImageFormat, ImageReader, Rgb, RgbImage};
use planish_geometry::bake::gltf::Picture;
use std::io::Cursor;
use std::path::Path;

/// Largest number of texels of a picture that is decoded. Its header says it before there is any memory for them.
const MOST_TEXELS: u64 = 1 << 27;

/// The picture of a file as glTF takes it: as it is, or as PNG if it is in another format that planish reads. `path` is the name of the
/// file. The error says what is wrong with it.
pub(super) fn for_gltf(bytes: Vec<u8>, path: &Path) -> Result<Vec<u8>, String> {
    match format(&bytes, path) {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => Ok(bytes),
        Some(_) => png(&decoded(&bytes, path)?),
        None => Err("is neither a PNG, a JPEG, a TGA nor a BMP file".to_owned()),
    }
}

/// A picture that several files give channels to, as PNG; `read` gives the bytes of a file, or `None` if it cannot be read, which is
/// somebody else's to say. `None` if no file can be read.
pub(super) fn combined(
    picture: Picture,
    read: &dyn Fn(&str) -> Option<Vec<u8>>,
    refuse: &dyn Fn(&str, String),
) -> Option<Vec<u8>> {
    let decoded = |file: &str| {
        let bytes = read(file)?;
        decoded(&bytes, Path::new(file)).map_err(|reason| refuse(file, reason)).ok()
    };
    let png = |image: DynamicImage| png(&image).ok();
    match picture {
        Picture::File(_) => None,
        Picture::MetallicRoughness { roughness, metallic } => {
            let [roughness, metallic] =
                [roughness, metallic].map(|file| file.and_then(decoded).map(image::DynamicImage::into_luma8));
            let size = roughness.as_ref().or(metallic.as_ref())?.dimensions();
            let [roughness, metallic] = [roughness, metallic].map(|grey| scaled(grey, size));
            let texel = |x, y| Rgb([u8::MAX, roughness.get_pixel(x, y).0[0], metallic.get_pixel(x, y).0[0]]);
            png(RgbImage::from_fn(size.0, size.1, texel).into())
        }
        Picture::ColourWithOpacity { colour, opacity } => {
            let opacity = decoded(opacity)?;
            // A picture with an alpha channel has its opacity there.
            let opacity = if opacity.color().has_alpha() {
                imageops::grayscale(&alpha_of(&opacity))
            } else {
                opacity.into_luma8()
            };
            let mut colour = match colour.and_then(decoded) {
                Some(colour) => colour.into_rgba8(),
                None => DynamicImage::ImageLuma8(scaled(None, opacity.dimensions())).into_rgba8(),
            };
            let opacity = scaled(Some(opacity), colour.dimensions());
            colour.pixels_mut().zip(opacity.pixels()).for_each(|(texel, opacity)| texel.0[3] = opacity.0[0]);
            png(colour.into())
        }
    }
}

/// The alpha channel of a picture as greys.
fn alpha_of(picture: &DynamicImage) -> GrayImage {
    let rgba = picture.to_rgba8();
    GrayImage::from_fn(rgba.width(), rgba.height(), |x, y| image::Luma([rgba.get_pixel(x, y).0[3]]))
}

/// Greys in a size; white where there is no picture.
fn scaled(grey: Option<GrayImage>, (width, height): (u32, u32)) -> GrayImage {
    match grey {
        Some(grey) if grey.dimensions() == (width, height) => grey,
        Some(grey) => imageops::resize(&grey, width, height, FilterType::Triangle),
        None => GrayImage::from_pixel(width, height, image::Luma([u8::MAX])),
    }
}

/// Format of a picture by its content; a TGA file has no mark at its beginning, and is told by its name.
fn format(bytes: &[u8], path: &Path) -> Option<ImageFormat> {
    let known = |format: &ImageFormat| {
        matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Bmp | ImageFormat::Tga)
    };
    let of_name = || ImageFormat::from_path(path).ok().filter(|format| *format == ImageFormat::Tga);
    image::guess_format(bytes).ok().filter(known).or_else(of_name)
}

fn decoded(bytes: &[u8], path: &Path) -> Result<DynamicImage, String> {
    let Some(format) = format(bytes, path) else {
        return Err("is neither a PNG, a JPEG, a TGA nor a BMP file".to_owned());
    };
    let plain = |e: image::ImageError| e.to_string();
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().map_err(plain)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MOST_TEXELS {
        return Err(format!("has {width} × {height} texels, and at most {MOST_TEXELS} can be read"));
    }
    DynamicImage::from_decoder(decoder).map_err(plain)
}

fn png(image: &DynamicImage) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of two texels in a format.
    fn two(format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 1, |x, _| Rgb([200, 100 * x as u8, 7]));
        DynamicImage::from(image).write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn other_formats_become_png_with_the_same_texels() {
        for (format, name) in [(ImageFormat::Tga, "a.TGA"), (ImageFormat::Bmp, "a.picture"), (ImageFormat::Png, "a")] {
            let bytes = for_gltf(two(format), Path::new(name)).unwrap();
            assert_eq!(image::guess_format(&bytes).unwrap(), ImageFormat::Png);
            let image = image::load_from_memory(&bytes).unwrap().into_rgb8();
            assert_eq!(image.into_raw(), [200, 0, 7, 200, 100, 7], "{name}");
        }
        let png = two(ImageFormat::Png);
        assert_eq!(
            for_gltf(png.clone(), Path::new("a.tga")).unwrap(),
            png,
            "content counts, and nothing is packed again"
        );
        assert!(for_gltf(b"a text".to_vec(), Path::new("a.txt")).unwrap_err().starts_with("is neither"));
    }

    #[test]
    fn a_header_that_claims_too_much_is_refused_before_any_texel_is_read() {
        // 65,535 × 65,535 texels of 24 bits, run-length encoded, in the 18 bytes of a header.
        let mut tga = vec![0; 18];
        (tga[2], tga[16]) = (10, 24);
        tga[12..16].fill(255);
        let reason = for_gltf(tga, Path::new("a.tga")).unwrap_err();
        assert!(reason.starts_with("has 65535 × 65535 texels"), "{reason}");
        assert!(for_gltf(b"BM, not more".to_vec(), Path::new("a.bmp")).is_err());
    }

    #[test]
    fn channels_are_put_where_gltf_has_them() {
        let grey = |value: u8, side: u32| {
            png(&DynamicImage::ImageLuma8(GrayImage::from_pixel(side, side, image::Luma([value])))).unwrap()
        };
        let read = |file: &str| match file {
            "dull" => Some(grey(200, 2)),
            "metal" => Some(grey(30, 4)),
            "clear" => Some(grey(9, 1)),
            "colours" => Some(two(ImageFormat::Tga)),
            _ => None,
        };
        let refused = |file: &str, reason: String| assert_eq!(reason, "", "{file}");
        let first = |picture| {
            let image = image::load_from_memory(&combined(picture, &read, &refused)?).unwrap().into_rgba8();
            Some((image.dimensions(), image.get_pixel(0, 0).0))
        };
        let both = Picture::MetallicRoughness { roughness: Some("dull"), metallic: Some("metal") };
        assert_eq!(first(both), Some(((2, 2), [255, 200, 30, 255])));
        let one = Picture::MetallicRoughness { roughness: Some("absent"), metallic: Some("metal") };
        assert_eq!(first(one), Some(((4, 4), [255, 255, 30, 255])));
        assert_eq!(first(Picture::MetallicRoughness { roughness: None, metallic: Some("absent") }), None);
        let white = Picture::ColourWithOpacity { colour: None, opacity: "clear" };
        assert_eq!(first(white), Some(((1, 1), [255, 255, 255, 9])));
    }
}
