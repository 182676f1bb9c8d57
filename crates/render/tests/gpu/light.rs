//! Laws of shadows, of the ground and of environments, drawn on every adapter that there is.

use crate::support::{no_complaints, renderer};
use glam::{Mat4, Vec2, Vec3};
use image::RgbaImage;
use planish_geometry::map::displace::ShaderVertex;
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat};
use planish_geometry::map::tangents::Tangent;
use planish_geometry::map::{HeightMap, Size as MapSize};
use planish_render::colour::Colour;
use planish_render::displaced_mesh::{DisplacementBinding, Sign};
use planish_render::environment::Environment;
use planish_render::environment::cube::CubeMap;
use planish_render::gpu::Backend;
use planish_render::mesh::{Mesh, Triangle};
use planish_render::scene::Scene;
use planish_render::settings::camera::Camera;
use planish_render::settings::environment::Surroundings;
use planish_render::settings::ground::{Ground, Show};
use planish_render::settings::lights::{Ambient, Anchor, Light, LightKind};
use planish_render::settings::shadow::{Casters, Filter, LightProjection, Outside, Shadow};
use planish_render::settings::{Displace, Material, Settings, Size};
use std::f32::consts::{PI, TAU};

/// Draws on every backend; complains if the validation of wgpu does.
fn draw(scene: &Scene, settings: &Settings, mut check: impl FnMut(&RgbaImage, &str)) {
    settings.check().unwrap();
    for backend in [Backend::Vulkan, Backend::Gl] {
        let image = {
            let renderer = renderer(backend);
            let image = renderer.image(scene, settings).unwrap();
            no_complaints(&renderer);
            image
        };
        check(&image, &format!("{backend:?}"));
    }
}

fn scene(positions: Vec<Vec3>, normals: Vec<Vec3>, triangles: &[[u32; 3]]) -> Scene {
    let triangle = |&t: &[u32; 3]| Triangle { positions: t, normals: t, ..Triangle::default() };
    let triangles = triangles.iter().map(triangle).collect();
    Scene::new(Mesh { positions, normals, triangles, ..Mesh::default() }).unwrap()
}

const TWO: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// A level square with half sides of 0.5 at the origin, and a speck at `depth` below it, on which the ground lies.
fn plate(depth: f32) -> Scene {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let speck = |x: f32| Vec3::new(x, -depth, 0.0);
    let square = [corner(-0.5, 0.5), corner(0.5, 0.5), corner(0.5, -0.5), corner(-0.5, -0.5)];
    let positions = square.into_iter().chain([speck(0.0), speck(1e-3), speck(-1e-3)]).collect();
    scene(positions, vec![Vec3::Y; 7], &[TWO[0], TWO[1], [4, 5, 6]])
}

/// A box with corners at ±0.5, ±`half`, ±0.5.
fn block(half: f32) -> Scene {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for n in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let (a, b) = n.any_orthonormal_pair();
        let first = positions.len() as u32;
        positions.extend([-a - b, a - b, a + b, b - a].map(|p| Vec3::new(0.5, half, 0.5) * (n + p)));
        normals.extend([n; 4]);
        triangles.extend(TWO.map(|t| t.map(|i| first + i)));
    }
    scene(positions, normals, &triangles)
}

fn sphere() -> Scene {
    let (bands, around) = (40, 80);
    let at = |i: u32, j: u32| {
        let (longitude, latitude) = (i as f32 / around as f32 * TAU, (j as f32 / bands as f32 - 0.5) * 0.9999 * PI);
        Vec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos())
    };
    let positions: Vec<Vec3> = (0..=bands).flat_map(|j| (0..=around).map(move |i| at(i, j))).collect();
    let number = |i, j| j * (around + 1) + i;
    let cell = |k: u32| {
        let (i, j) = (k % around, k / around);
        [[number(i, j), number(i + 1, j), number(i + 1, j + 1)], [number(i, j), number(i + 1, j + 1), number(i, j + 1)]]
    };
    let triangles: Vec<[u32; 3]> = (0..around * bands).flat_map(cell).collect();
    scene(positions.clone(), positions, &triangles)
}

const FAR: LightKind = LightKind::Directional;
const SPOT: LightKind = LightKind::Spot { distance: 4.0, angle: 60.0 };
const POINT: LightKind = LightKind::Point { distance: 3.0 };

/// White light and white ground, black where no light arrives.
fn lit_by(kind: LightKind, shadow: Shadow) -> Settings {
    let light =
        Light { azimuth: 0.0, elevation: 60.0, colour: Colour::WHITE, intensity: 1.0, kind, anchor: Anchor::Model };
    Settings {
        size: Size { width: 240, height: 180 },
        supersampling: 1,
        camera: Camera { yaw: 0.0, pitch: 20.0, distance: 1.6, ..Camera::default() },
        material: Material { colour: Colour::WHITE, specular: 0.0, exponent: 1.0 },
        lights: vec![light],
        shadow,
        ground: Ground { show: Show::Plane, colour: Colour::WHITE, gap: 0.0, size: 20.0 },
        ambient: Ambient { intensity: 0.0, ..Ambient::default() },
        ..Settings::default()
    }
}

fn filtered(filter: Filter) -> Shadow {
    Shadow { filter, size: 1024, ..Shadow::default() }
}

/// Shadow of a point of the scene in the light of [`lit_by`], at this height.
fn thrown(point: Vec3, scene: &Scene, kind: LightKind, height: f32) -> Vec3 {
    let to_light = Vec3::new(0.0, 3.0f32.sqrt() / 2.0, 0.5);
    let away = match kind {
        LightKind::Directional => to_light,
        LightKind::Spot { distance, .. } | LightKind::Point { distance } => {
            scene.bounds().centre + distance * scene.bounds().radius * to_light - point
        }
    };
    point - (point.y - height) / away.y * away
}

fn clip_from_world(scene: &Scene, settings: &Settings) -> Mat4 {
    let aspect = settings.size.width as f32 / settings.size.height as f32;
    settings.camera.view(scene.bounds(), aspect).clip_from_world
}

/// Red of the pixel that shows a place.
#[track_caller]
fn brightness(image: &RgbaImage, clip_from_world: Mat4, place: Vec3) -> u8 {
    let ndc = clip_from_world.project_point3(place);
    let size = Vec2::new(image.width() as f32, image.height() as f32);
    let pixel = (Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size).floor();
    assert!(pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(size).all(), "{place} is not in the picture");
    image.get_pixel(pixel.x as u32, pixel.y as u32).0[0]
}

#[test]
fn the_umbra_is_dark_and_all_else_as_without_shadows() {
    let scene = plate(1.0);
    for kind in [FAR, SPOT, POINT] {
        let mut bright = Vec::new();
        let open = thrown(Vec3::new(1.0, 0.0, 0.0), &scene, kind, -1.0);
        let umbra = thrown(Vec3::ZERO, &scene, kind, -1.0);
        for filter in Filter::ALL {
            let settings = lit_by(kind, filtered(*filter));
            let clip = clip_from_world(&scene, &settings);
            draw(&scene, &settings, |image, backend| {
                let found = brightness(image, clip, umbra);
                if *filter == Filter::None {
                    bright.push(brightness(image, clip, open));
                    assert!(found > 80, "{kind:?} {backend}: {found}");
                } else {
                    assert_eq!(found, 0, "{kind:?} {filter:?} {backend}");
                    assert_eq!(brightness(image, clip, open), bright[0], "{kind:?} {filter:?} {backend}");
                }
            });
        }
    }
}

#[test]
fn both_projections_throw_the_same_shadow() {
    let scene = plate(1.0);
    for (kind, projection) in [(FAR, LightProjection::Perspective), (SPOT, LightProjection::Orthographic)] {
        let settings = lit_by(kind, Shadow { projection, ..filtered(Filter::Hard) });
        let clip = clip_from_world(&scene, &settings);
        // In the other projection rays differ, but not those through the middle of the model.
        let umbra = thrown(scene.bounds().centre, &scene, kind, -1.0);
        draw(&scene, &settings, |image, backend| assert_eq!(brightness(image, clip, umbra), 0, "{kind:?} {backend}"));
    }
}

/// Pixels between 10 % and 90 % of the light along a line over the shadow's right edge.
fn penumbra(depth: f32, shadow: Shadow, mut report: impl FnMut(f32)) {
    let scene = plate(depth);
    let settings = lit_by(FAR, shadow);
    let clip = clip_from_world(&scene, &settings);
    let [from, to] = [0.0, 1.0].map(|x| thrown(Vec3::new(x, 0.0, 0.0), &scene, FAR, -depth));
    draw(&scene, &settings, |image, _| {
        let steps = 4000;
        let linear = |i: i32| {
            let value = brightness(image, clip, from.lerp(to, i as f32 / steps as f32));
            Colour([value; 3]).linear().x
        };
        let open = linear(steps);
        let partly = (0..=steps).filter(|&i| (0.1..0.9).contains(&(linear(i) / open))).count();
        report(partly as f32 / steps as f32);
    });
}

#[test]
fn penumbras_widen_with_the_distance_of_the_caster() {
    let soft = Shadow { filter: Filter::Pcss, light_angle: 12.0, ..filtered(Filter::Pcss) };
    let (mut near, mut far) = (Vec::new(), Vec::new());
    penumbra(0.4, soft, |width| near.push(width));
    penumbra(1.2, soft, |width| far.push(width));
    for (near, far) in near.into_iter().zip(far) {
        // The caster is three times as far away: so is the width, up to pixels.
        assert!((2.0..4.5).contains(&(far / near)), "{near} {far}");
        // 80 % of the light of a disc comes through 71 % of its width: 2 tan 6° · 1.2 / sin 60° of the ground.
        assert!((far / (0.69 * 0.2102 * 1.2 / 0.866) - 1.0).abs() < 0.3, "{far}");
    }
}

/// Share of the pixels that are more than a few steps darker than without shadows.
fn darker(scene: &Scene, shadow: Shadow, mut report: impl FnMut(f32)) {
    let ground = Ground { show: Show::Nothing, ..Ground::default() };
    let settings = |shadow| Settings { ground, ..lit_by(FAR, shadow) };
    let mut open = Vec::new();
    draw(scene, &settings(filtered(Filter::None)), |image, _| open.push(image.clone()));
    let mut open = open.into_iter();
    draw(scene, &settings(shadow), |image, _| {
        let pairs =
            image.pixels().zip(open.next().unwrap().into_raw().chunks_exact(4).map(|p| p[0]).collect::<Vec<_>>());
        let dark = pairs.filter(|(p, open)| p.0[0].saturating_add(8) < *open).count();
        report(dark as f32 / (image.width() * image.height()) as f32);
    });
}

#[test]
fn without_bias_there_is_acne_and_with_it_none() {
    let scene = sphere();
    let hard = Shadow { size: 256, ..filtered(Filter::Hard) };
    darker(&scene, Shadow { slope_bias: 0.0, least_bias: 0.0, ..hard }, |share| assert!(share > 0.05, "{share}"));
    // At the terminator facets turn away from the light before their blended normals do.
    darker(&scene, hard, |share| assert!(share < 2e-3, "{share}"));
    // Only what faces away from the light is in the map, far behind what is lit.
    let back = Shadow { casters: Casters::BackFaces, slope_bias: 0.0, least_bias: 1e-4, ..hard };
    darker(&block(0.5), back, |share| assert!(share < 1e-3, "{share}"));
    for filter in [Filter::Pcf, Filter::Pcss] {
        darker(&scene, Shadow { filter, kernel: 7, size: 1024, ..hard }, |share| {
            assert!(share < 2e-3, "{filter:?} {share}");
        });
    }
}

#[test]
fn too_much_bias_takes_the_shadow_off_its_caster() {
    let scene = block(0.05);
    // The ground right behind a slab, seen from behind; the light comes from the front and over it.
    let behind = Vec3::new(0.0, -0.05, -0.53);
    let cases = [
        (Shadow::default(), 0),
        (Shadow { slope_bias: 0.3, least_bias: 0.3, ..Shadow::default() }, 1),
        (Shadow { casters: Casters::BackFaces, slope_bias: 0.0, least_bias: 1e-4, ..Shadow::default() }, 0),
    ];
    for (shadow, lit) in cases {
        let mut settings = lit_by(FAR, Shadow { filter: Filter::Hard, ..shadow });
        settings.camera = Camera { yaw: 180.0, pitch: 30.0, distance: 1.6, ..Camera::default() };
        let clip = clip_from_world(&scene, &settings);
        draw(&scene, &settings, |image, backend| {
            let found = brightness(image, clip, behind);
            assert_eq!(found > 128, lit == 1, "{shadow:?} {backend}: {found}");
        });
    }
}

#[test]
fn what_no_light_sees_is_lit() {
    let scene = plate(0.3);
    // A map that covers the middle of the plate alone: elsewhere there is no shadow, unless it is repeated.
    let narrow = |outside| Shadow { extent: 0.3, outside, ..filtered(Filter::Hard) };
    // Beside and behind the plate's shadow, and as far from the light as that.
    let row: Vec<Vec3> = (14..24).map(|i| Vec3::new(0.05 * i as f32, -0.3, -0.8)).collect();
    for (outside, dark) in [(Outside::Lit, false), (Outside::Repeated, true)] {
        let settings = lit_by(FAR, narrow(outside));
        let clip = clip_from_world(&scene, &settings);
        draw(&scene, &settings, |image, backend| {
            let any = row.iter().any(|place| brightness(image, clip, *place) == 0);
            assert_eq!(any, dark, "{outside:?} {backend}");
        });
    }
}

#[test]
fn shadows_follow_the_displaced_surface() {
    let mut scene = plate(1.0);
    let size = MapSize::square(1);
    let encoding = Encoding { texel: TexelFormat::Png16, bias: 0.0, scale: 1.0 };
    let map = Displacement::encode(&[HeightMap { size, texels: vec![1.0] }], MapKind::Scalar, encoding);
    let vertex = |(i, p): (usize, &Vec3)| ShaderVertex {
        position: *p,
        normal: Vec3::X,
        tangent: Tangent::default(),
        // The speck stays.
        sample_at: (i < 4).then_some(SampleAt::Uv(Vec2::splat(0.5))),
    };
    let vertices = scene.mesh().positions.iter().enumerate().map(vertex).collect();
    scene.displacement = Some(DisplacementBinding::new(scene.mesh(), map, vertices, Sign::Add));
    for lambda in [0.0, 0.3] {
        let displace = Displace { lambda, ..Displace::default() };
        let settings = Settings { displace, ..lit_by(FAR, filtered(Filter::Hard)) };
        let clip = clip_from_world(&scene, &settings);
        // The plate moves to the right by λ.
        let [stays, moves] = [-0.4, 0.7].map(|x| thrown(Vec3::new(x, 0.0, 0.0), &scene, FAR, -1.0));
        draw(&scene, &settings, |image, backend| {
            let dark = [stays, moves].map(|place| brightness(image, clip, place) == 0);
            assert_eq!(dark, [lambda == 0.0, lambda > 0.0], "{lambda} {backend}");
        });
    }
}

#[test]
fn a_shadow_map_shows_what_is_near_darker() {
    let scene = plate(1.0);
    let shadow = Shadow { show_map: Some(0), ..filtered(Filter::None) };
    draw(&scene, &lit_by(FAR, shadow), |image, backend| {
        let [middle, corner] = [[120, 90], [36, 6]].map(|[x, y]| image.get_pixel(x, y).0[0]);
        assert!(middle < corner && corner == 255, "{backend}: {middle} {corner}");
    });
    // There is no second map: the picture itself.
    let none = Shadow { show_map: Some(1), ..filtered(Filter::None) };
    let mut pictures = Vec::new();
    for shadow in [none, filtered(Filter::None)] {
        draw(&scene, &lit_by(FAR, shadow), |image, _| pictures.push(image.clone()));
    }
    let half = pictures.len() / 2;
    assert!(pictures[..half] == pictures[half..]);
}

#[test]
fn the_ground_may_show_shadows_alone() {
    let scene = plate(1.0);
    let mut settings = lit_by(FAR, filtered(Filter::Hard));
    settings.ground.show = Show::Shadows;
    let clip = clip_from_world(&scene, &settings);
    let [open, umbra] = [1.0, 0.0].map(|x| thrown(Vec3::new(x, 0.0, 0.0), &scene, FAR, -1.0));
    let empty = Settings { ground: Ground::default(), ..settings.clone() };
    let mut behind = Vec::new();
    draw(&scene, &empty, |image, _| behind.push(brightness(image, clip, open)));
    draw(&scene, &settings, |image, backend| {
        assert_eq!(brightness(image, clip, umbra), 0, "{backend}");
        assert_eq!(brightness(image, clip, open), behind[0], "{backend}");
    });
}

/// Smooth and different in all directions.
fn sky() -> Environment {
    Environment::new(CubeMap::from_fn(64, |d| 0.4 + 0.35 * Vec3::new(d.x, d.y, d.z * d.x)))
}

#[test]
fn environments_look_as_on_the_processor() {
    let mut scene = sphere();
    scene.environment = Some(sky());
    for surroundings in [
        Surroundings::default(),
        Surroundings { rotation: 130.0, blur: 0.4, ..Surroundings::default() },
        Surroundings { reflectance: 0.9, roughness: 0.0, ..Surroundings::default() },
        Surroundings { reflectance: 0.3, roughness: 0.6, intensity: 1.2, ..Surroundings::default() },
    ] {
        let settings = Settings {
            size: Size { width: 120, height: 90 },
            supersampling: 2,
            environment: Some(surroundings.clone()),
            ..Settings::default()
        };
        let expected = planish_render::software::render(&scene, &settings);
        draw(&scene, &settings, |image, backend| {
            let differences = image.iter().zip(expected.iter()).map(|(a, b)| a.abs_diff(*b));
            let mut differences: Vec<u8> = differences.collect();
            differences.sort_unstable();
            let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
            // Seams of the cube are filtered a little differently; silhouettes are a handful of pixels.
            let most = differences[differences.len() * 99 / 100];
            assert!(mean < 0.5 && most <= 3, "{surroundings:?} {backend}: {mean} {most}");
        });
    }
}
