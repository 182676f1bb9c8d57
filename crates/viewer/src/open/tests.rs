//! Laws of what is read and baked for a picture.

use super::*;
use image::{Rgba, RgbaImage};
use planish_geometry::map::pages::PageRule;
use planish_render::settings::{Displace, Normals};
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

/// Picture that the processor draws of the scene of a folder's mesh with its map, and the scene.
fn drawn(folder: &Path, name: &str, settings: &Settings) -> (Scene, RgbaImage) {
    let map = Some(folder.join(format!("{name}.planish.json")));
    let files = Files { map, ..Files::default() };
    let scene = open(&files, settings, &planish_geometry::progress::Silent).unwrap().scene;
    let picture = planish_render::software::render(&scene, settings);
    (scene, picture)
}

/// Bakes a mesh into a folder with a method that changes it, and opens what was written.
fn baked(text: &str, settings: BakeSettings) -> (tempfile::TempDir, Scene) {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.obj");
    std::fs::write(&input, text).unwrap();
    let silent = planish_geometry::progress::Silent;
    let model = input::model(&input, Welding::Exact, Trust::Folder, &silent).unwrap();
    let out = folder.path().join("out");
    let job = Job { input: &input, model: &model, folder: &out, protected: &[], trust: Trust::Folder };
    let taubin = planish_geometry::denoise::Denoiser::named("taubin").unwrap();
    let settings = BakeSettings { target: taubin.into(), ..settings };
    let mut scene = model_input::scene(&model, None).unwrap();
    let (_, files) = bake_map(&mut scene, &job, &settings, &silent).unwrap();
    files.write(planish_files::output::Folder::open(&out).unwrap()).unwrap();
    (folder, scene)
}

/// A rough sheet, whose right half lies in the second tile of the texture coordinates, or everything in the first one.
fn sheet(tiles: f64) -> String {
    let (mut out, n) = (String::new(), 21);
    for i in 0..n * n {
        let [x, y] = [i % n, i / n].map(f64::from);
        let z = 0.15 * f64::from(i * i % 11) / 10.0;
        out += &format!("v {x} {y} {z}\n");
    }
    // Each half has texture coordinates of its own.
    for half in 0..2 {
        for i in 0..n * n {
            let [x, y] = [i % n, i / n].map(f64::from);
            let u = 0.05 + 0.9 * (x - 10.0 * f64::from(half)) / 10.0;
            let u = if tiles > 1.0 { u + f64::from(half) } else { 0.5 * (u + f64::from(half)) };
            out += &format!("vt {u} {}\n", 0.05 + 0.9 * y / 20.0);
        }
    }
    for i in (0..n * (n - 1)).filter(|i| i % n < n - 1) {
        let offset = if i % n < 10 { 1 } else { 1 + n * n };
        let corners = [i, i + 1, i + n + 1, i + n].map(|v| format!(" {}/{}", v + 1, v + offset));
        out += &format!("f{}\n", corners.concat());
    }
    out
}

#[test]
fn the_normal_maps_of_pages_light_their_triangles() {
    let side = Some(256);
    let (folder, scene) = baked(&sheet(2.0), BakeSettings { pages: PageRule::Udim, side, ..BakeSettings::default() });
    assert_eq!(scene.normal_maps.all().len(), 2);
    let (one_folder, _) = baked(&sheet(1.0), BakeSettings { side: Some(512), ..BakeSettings::default() });
    let settings = |normals| Settings {
        size: planish_render::settings::Size { width: 240, height: 240 },
        supersampling: 1,
        displace: Displace { lambda: 1.0, normals, ..Displace::default() },
        ..Settings::default()
    };
    let out = folder.path().join("out");
    let (opened, paged) = drawn(&out, "in", &settings(Normals::Map));
    let of = |scene: &Scene| (0..scene.mesh().triangles.len()).map(|t| scene.normal_maps.of_triangle(t)).collect();
    let [here, there]: [Vec<_>; 2] = [&scene, &opened].map(of);
    assert!(
        here == there && here.contains(&Some(0)) && here.contains(&Some(1)),
        "the map that is opened says the same"
    );
    let (_, one) = drawn(&one_folder.path().join("out"), "in", &settings(Normals::Map));
    let (_, base) = drawn(&out, "in", &settings(Normals::Base));
    let differs =
        |a: &RgbaImage, b: &RgbaImage| a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>();
    let [pages, none] = [differs(&paged, &one), differs(&base, &one)];
    assert!(20 * pages < none, "two pages look like one map of as many texels: {pages}, without them {none}");
}
