//! Laws of what is read and baked for a picture.

use super::*;
use image::{Rgba, RgbaImage};
use planish_render::settings::Displace;
use std::io::Cursor;

#[test]
fn a_map_is_baked_only_where_the_picture_shows_it() {
    let with = |lambda: f32, shading: Shading| {
        needs_map(&Settings { shading, displace: Displace { lambda, ..Displace::default() }, ..Settings::default() })
    };
    for &shading in Shading::ALL {
        assert!(with(1.0, shading) && with(-0.5, shading), "{shading:?} of a displaced surface");
        let looks_at_the_map = [Shading::Height, Shading::NormalMap, Shading::Bump].contains(&shading);
        assert_eq!(with(0.0, shading), looks_at_the_map, "{shading:?} of the mesh as it is");
    }
}

#[test]
fn normal_maps_have_green_up_whatever_the_convention_of_their_file() {
    let picture = RgbaImage::from_fn(4, 2, |x, y| Rgba([10, 60 * x as u8, 7 * y as u8, 255]));
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let read = |convention| {
        let entry = NormalMapEntry { file: "n.png".to_owned(), width: 4, height: 2, convention };
        normal_map(png.get_ref(), &entry, Path::new("n.png")).unwrap()
    };
    let flipped = RgbaImage::from_fn(4, 2, |x, y| {
        let [r, g, b, a] = picture.get_pixel(x, y).0;
        Rgba([r, 255 - g, b, a])
    });
    assert_eq!(read(Convention::OpenGl).levels()[0], picture);
    assert_eq!(read(Convention::DirectX).levels()[0], flipped);
}

#[test]
fn a_folder_is_no_mesh_and_an_empty_mesh_has_nothing_to_show() {
    let folder = tempfile::tempdir().unwrap();
    let complaint = |mesh: &Path| {
        let files = Files { mesh: Some(mesh.to_owned()), ..Files::default() };
        open(&files, &Settings::default(), &planish_geometry::progress::Silent).unwrap_err().to_string()
    };
    assert!(complaint(folder.path()).ends_with(": is a directory, not a file"));
    let points = folder.path().join("points.obj");
    std::fs::write(&points, "v 0 0 0\nv 1 0 0\nf 1 2 1\n").unwrap();
    assert!(complaint(&points).ends_with("points.obj: no face has three different vertices"));
    assert!(!complaint(&folder.path().join("gone.obj")).contains("os error"), "in plain words");
}
