//! Laws of whole pictures.

use super::*;
use crate::colour::Colour;
use crate::draw_parameters::heat_range;
use crate::settings::camera::{Camera, Projection};
use crate::settings::lights::{Ambient, Light};
use crate::settings::{Background, Checker, Heat, Range, Size};
use image::Rgba;
use planish_geometry::metrics::colormap::Colormap;

/// Triangles over shared positions, lit with `normals` (one per position).
fn scene(positions: Vec<Vec3>, normals: Vec<Vec3>, uvs: Vec<Vec2>, triangles: &[[u32; 3]]) -> Scene {
    let uvs_of = |t: [u32; 3]| (!uvs.is_empty()).then_some(t);
    let triangles = triangles
        .iter()
        .map(|&t| Triangle { positions: t, normals: t, uvs: uvs_of(t), ..Triangle::default() })
        .collect();
    Scene::new(Mesh { positions, normals, uvs, triangles, ..Mesh::default() }).unwrap()
}

/// A unit sphere of 2 × `bands` by `bands` cells about the y axis; the poles are small holes.
fn sphere(bands: u32) -> Scene {
    let around = 2 * bands;
    let uv = |i: u32, j: u32| Vec2::new(i as f32 / around as f32, (j as f32 + 0.01) / (bands as f32 + 0.02));
    let uvs: Vec<Vec2> = (0..=bands).flat_map(|j| (0..=around).map(move |i| uv(i, j))).collect();
    let positions: Vec<Vec3> = uvs
        .iter()
        .map(|uv| {
            let (longitude, latitude) = (uv.x * std::f32::consts::TAU, (uv.y - 0.5) * std::f32::consts::PI);
            Vec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos())
        })
        .collect();
    let at = |i, j| j * (around + 1) + i;
    let triangles: Vec<[u32; 3]> = (0..bands)
        .flat_map(|j| (0..around).map(move |i| (i, j)))
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    scene(positions.clone(), positions, uvs, &triangles)
}

/// A rectangle about `centre`, spanned by two half sides.
fn rectangle(centre: Vec3, a: Vec3, b: Vec3) -> [Vec3; 4] {
    [centre - a - b, centre + a - b, centre + a + b, centre - a + b]
}

const TWO: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
const UNIT_SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

fn front() -> Settings {
    Settings {
        size: Size { width: 65, height: 65 },
        supersampling: 1,
        camera: Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() },
        ..Settings::default()
    }
}

/// Light that leaves base colours as they are.
fn unlit(settings: &Settings) -> Settings {
    let ambient = Ambient { sky: Colour::WHITE, ground: Colour::WHITE, intensity: 1.0, occlusion: 1.0 };
    Settings { lights: Vec::new(), ambient, ..settings.clone() }
}

fn opaque(Colour([r, g, b]): Colour) -> Rgba<u8> {
    Rgba([r, g, b, 255])
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let scene = sphere(20);
    let settings = Settings { size: Size { width: 97, height: 83 }, ..Settings::default() };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &settings))
    };
    let one = on(1);
    assert!(on(2) == one && on(7) == one);
}

#[test]
fn the_unit_of_length_does_not_matter() {
    // Powers of two, with which rounding commutes.
    let draw = |scale: f32, settings: &Settings| {
        let mut mesh = sphere(8).mesh().clone();
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        render(&Scene::new(mesh).unwrap(), settings)
    };
    for projection in [Projection::default(), Projection::Orthographic] {
        let camera = Camera { projection, ..Camera::default() };
        let settings = Settings { shading: Shading::Flat, camera, ..front() };
        let expected = draw(1.0, &settings);
        assert!([-45, -3, 40].iter().all(|&k| draw(2f32.powi(k), &settings) == expected), "{projection:?}");
    }
}

#[test]
fn nearer_wins_in_either_order() {
    // The nearer square is the smaller one, half in front of the other; normals tell them apart.
    let near = rectangle(Vec3::new(0.5, 0.0, 0.5), 0.4 * Vec3::X, 0.4 * Vec3::Y);
    let far = rectangle(Vec3::ZERO, Vec3::X, Vec3::Y);
    let settings = Settings { shading: Shading::Normals, ..front() };
    let draw = |squares: [([Vec3; 4], Vec3); 2]| {
        let positions = squares.iter().flat_map(|(corners, _)| *corners).collect();
        let normals = squares.iter().flat_map(|(_, normal)| [*normal; 4]).collect();
        render(&scene(positions, normals, Vec::new(), &[TWO[0], TWO[1], [4, 5, 6], [4, 6, 7]]), &settings)
    };
    let image = draw([(near, Vec3::X), (far, Vec3::Y)]);
    assert_eq!(image, draw([(far, Vec3::Y), (near, Vec3::X)]));
    assert_eq!(*image.get_pixel(42, 32), Rgba([255, 128, 128, 255]));
    assert_eq!(*image.get_pixel(22, 32), Rgba([128, 255, 128, 255]));
}

#[test]
fn checker_on_a_slanted_plane_is_where_rays_meet_it() {
    let [a, b] = [Vec3::new(1.0, 0.1, -0.3), Vec3::new(0.2, 0.8, -1.5)];
    let plane = scene(rectangle(Vec3::ZERO, a, b).to_vec(), vec![Vec3::Y; 4], UNIT_SQUARE.to_vec(), &TWO);
    let checker = Checker { squares: 8.0, light: Colour::WHITE, dark: Colour::hex(0x204060) };
    let camera = Camera { projection: Projection::Perspective { field_of_view: 60.0 }, ..front().camera };
    let settings = unlit(&Settings { shading: Shading::Checker, checker, camera, ..front() });
    let image = render(&plane, &settings);

    let view = settings.camera.view(plane.bounds(), 1.0);
    let world_from_clip = view.clip_from_world.as_dmat4().inverse();
    let eye = view.eye_in_world.truncate().as_dvec3();
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    let normal = a.cross(b);
    let mut compared = 0;
    for (x, y, pixel) in image.enumerate_pixels() {
        let ndc = DVec2::new((f64::from(x) + 0.5) / 32.5 - 1.0, 1.0 - (f64::from(y) + 0.5) / 32.5);
        let ray = world_from_clip.project_point3(ndc.extend(0.5)) - eye;
        let hit = eye - ray * (eye.dot(normal) / ray.dot(normal));
        // hit = s a + t b
        let (s, t) =
            (hit.cross(b).dot(normal) / normal.length_squared(), a.cross(hit).dot(normal) / normal.length_squared());
        let squares = DVec2::new(s + 1.0, t + 1.0) * 0.5 * 8.0;
        let near_a_line = (squares - squares.round()).abs().min_element() < 1e-3;
        if s.abs() < 0.999 && t.abs() < 0.999 && !near_a_line {
            let odd = (squares.x.floor() + squares.y.floor()).rem_euclid(2.0) == 1.0;
            assert_eq!(*pixel, opaque(if odd { checker.dark } else { checker.light }), "({x}, {y}) at {squares}");
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}

#[test]
fn flat_sphere_has_the_blinn_phong_colour_of_its_middle_triangle() {
    let scene = sphere(9);
    let light = Light {
        azimuth: 30.0,
        elevation: 20.0,
        colour: Colour::WHITE,
        intensity: 0.6,
        kind: <_>::default(),
        anchor: <_>::default(),
    };
    let ambient = Ambient { sky: Colour::WHITE, ground: Colour::hex(0), intensity: 0.25, occlusion: 1.0 };
    let camera = Camera { yaw: 70.0, pitch: 20.0, projection: Projection::Orthographic, ..Camera::default() };
    let settings = Settings { shading: Shading::Flat, lights: vec![light], ambient, camera, ..front() };
    let image = render(&scene, &settings);

    // The middle pixel looks along the view axis; the triangle there is the one whose cone holds it.
    let Mesh { positions, triangles, .. } = scene.mesh();
    let view = settings.camera.view(scene.bounds(), 1.0);
    let eye = view.world_from_view.z_axis;
    let normal = triangles
        .iter()
        .map(|t| t.positions.map(|v| positions[v as usize]))
        .find(|[a, b, c]| [(a, b), (b, c), (c, a)].iter().all(|(p, q)| p.cross(**q).dot(eye) > 0.0))
        .map(|[a, b, c]| (b - a).cross(c - a).normalize())
        .unwrap();
    let (azimuth, elevation) = (30f32.to_radians(), 20f32.to_radians());
    let to_light = view.world_from_view
        * Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
    let half = (to_light + eye).normalize();
    let diffuse = 0.25 * (0.5 + 0.5 * normal.y) + 0.6 * normal.dot(to_light);
    let specular = 0.6 * settings.material.specular * normal.dot(half).powf(settings.material.exponent);
    let expected = pixel_from_linear(settings.material.colour.linear() * diffuse + specular);
    let found = image.get_pixel(32, 32).0;
    for k in 0..3 {
        assert!(found[k].abs_diff(expected[k]) <= 1, "{found:?} {expected:?}");
    }
}

#[test]
fn the_back_of_a_surface_is_lit_like_its_front() {
    // The lights stay with the camera; light from everywhere does not tell the sides apart either.
    let draw = |normal: Vec3, triangles: &[[u32; 3]], shading| {
        let corners = rectangle(Vec3::ZERO, Vec3::X, Vec3::Y).to_vec();
        render(&scene(corners, vec![normal; 4], Vec::new(), triangles), &Settings { shading, ..front() })
    };
    let turned = TWO.map(|[a, b, c]| [a, c, b]);
    for shading in [Shading::Flat, Shading::Phong] {
        assert_eq!(draw(Vec3::Z, &TWO, shading), draw(Vec3::NEG_Z, &turned, shading), "{shading:?}");
    }
}

#[test]
fn heat_without_relief_has_the_colours_of_the_bar() {
    let map = Colormap::Sequential;
    let mut mesh =
        scene(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y).to_vec(), vec![Vec3::Z; 4], Vec::new(), &TWO).mesh().clone();
    mesh.scalars = Some(vec![-5.0, 3.0, 3.0, -5.0]);
    let heat = Heat { map, relief: 0.0, range: None };
    let settings = Settings { shading: Shading::Heat, heat, ..front() };
    let image = render(&Scene::new(mesh.clone()).unwrap(), &settings);
    let [r, g, b] = map.bytes(0.5);
    assert_eq!(*image.get_pixel(32, 32), Rgba([r, g, b, 255]));

    // What is not a number is neither drawn as one nor does it spoil the range.
    mesh.scalars = Some(vec![f32::NAN, 3.0, 3.0, -5.0]);
    let scene = Scene::new(mesh).unwrap();
    assert_eq!(heat_range(&scene, &settings), Some(Range { low: -5.0, high: 3.0 }));
    let signed = Settings { heat: Heat { map: Colormap::Diverging, ..heat }, ..settings };
    assert_eq!(heat_range(&scene, &signed), Some(Range { low: -5.0, high: 5.0 }));
}

#[test]
fn samples_are_averaged_in_linear_light() {
    // The squares meet in the middle of the middle column, and all columns of samples left of it are dark.
    let uvs = [-1.0, 1.0, 1.0, -1.0].map(|u| Vec2::new(u, 0.5)).to_vec();
    let plane = scene(rectangle(Vec3::ZERO, Vec3::X, Vec3::Y).to_vec(), vec![Vec3::Z; 4], uvs, &TWO);
    let checker = Checker { squares: 1.0, light: Colour::WHITE, dark: Colour::hex(0) };
    let settings = unlit(&Settings { shading: Shading::Checker, checker, supersampling: 2, ..front() });
    let image = render(&plane, &settings);
    let [left, middle, right] = [31, 32, 33].map(|x| image.get_pixel(x, 32).0[0]);
    assert_eq!([left, middle, right], [0, pixel_from_linear(Vec3::splat(0.5))[0], 255]);
}

#[test]
fn a_surface_through_the_eye_is_cut_and_not_mirrored() {
    // The floor runs from far in front of the eye to far behind it.
    let floor = rectangle(Vec3::ZERO, 4.0 * Vec3::X, 4.0 * Vec3::Z);
    let plane = scene(floor.to_vec(), vec![Vec3::Y; 4], Vec::new(), &TWO);
    let camera = Camera { pitch: 2.0, distance: 0.05, ..front().camera };
    let settings = Settings { shading: Shading::Normals, camera, ..front() };
    let image = render(&plane, &settings);
    let floor = Rgba([128, 255, 128, 255]);
    assert!((0..65).all(|x| *image.get_pixel(x, 64) == floor), "the floor is below");
    assert!((0..65).all(|x| *image.get_pixel(x, 0) != floor), "and not above");
}

#[test]
fn an_empty_scene_is_the_background() {
    let background = Background { top: Colour::hex(0x123456), bottom: Colour::hex(0x123456) };
    let image = render(&Scene::new(Mesh::default()).unwrap(), &Settings { background, ..front() });
    assert!(image.pixels().all(|pixel| *pixel == opaque(background.top)));
}
