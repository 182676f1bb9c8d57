use super::*;
use crate::map::normal_map::{Convention, SharedTexels, TangentFrames};
use crate::mesh::normals::{FaceWeight, vertex_normals};
use crate::mesh::shapes;
use crate::progress::Silent;
use glam::{DVec2, Vec3};

/// A grid in the middle of the texture with the height x + 2y.
fn slope() -> (Surface, Atlas, Vec<f64>) {
    let grid = shapes::grid(8);
    let corners = 0..grid.topology().faces().items().len() as Index;
    let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate() * 0.5 + 0.25).collect();
    let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
    let heights = grid.positions().iter().map(|p| p.x + 2.0 * p.y).collect();
    (grid, atlas, heights)
}

fn map(interpolation: Interpolation, size: u32) -> (HeightMap, Coverage) {
    let (surface, atlas, heights) = slope();
    let coverage = Coverage::new(&surface, &atlas, Size::square(size), &Silent).unwrap();
    let layout = TextureLayout { surface: &surface, atlas: &atlas, coverage: &coverage };
    (interpolate_heights(layout, &heights, interpolation, &Silent).unwrap(), coverage)
}

#[test]
fn v_is_flipped_once() {
    let size = Size { width: 4, height: 2 };
    assert_eq!(size.texel_from_uv(DVec2::new(0.0, 1.0)), DVec2::ZERO);
    assert_eq!(size.uv_from_texel(0, 0), DVec2::new(0.125, 0.75));
    for (column, row) in [(0, 0), (3, 1), (2, 0)] {
        let centre = DVec2::new(column as f64, row as f64) + 0.5;
        assert_eq!(size.texel_from_uv(size.uv_from_texel(column, row)), centre);
    }
}

#[test]
fn linear_heights_are_reproduced_by_linear_and_by_natural_neighbour_interpolation() {
    for interpolation in [Interpolation::Barycentric, Interpolation::Natural] {
        let (map, coverage) = map(interpolation, 64);
        let mut inside = 0;
        for (i, texel) in map.texels.iter().enumerate() {
            let (column, row) = (i % 64, i / 64);
            if coverage.owner(column, row).is_some() {
                let p = (map.size.uv_from_texel(column, row) - 0.25) * 2.0;
                // A texel is rounded to single precision: values up to 3.
                assert!((f64::from(*texel) - (p.x + 2.0 * p.y)).abs() < 3e-7, "{interpolation:?} at {p}");
                inside += 1;
            }
        }
        assert_eq!(inside, 32 * 32);
    }
}

#[test]
fn no_background_bleeds_in() {
    for interpolation in
        [Interpolation::Barycentric, Interpolation::Natural, Interpolation::Idw, Interpolation::Nearest]
    {
        let (map, _) = map(interpolation, 32);
        // Left of the chart, at the height of its middle row: the value at the chart's border there.
        let texel = f64::from(map.texels[15 * 32 + 3]);
        let v = (map.size.uv_from_texel(3, 15).y - 0.25) * 2.0;
        // Nearest and inverse distance know the border only at its vertices, a quarter of a unit apart.
        assert!((texel - 2.0 * v).abs() < 0.3, "{interpolation:?}: {texel} for {}", 2.0 * v);
        assert!(map.texels.iter().all(|t| (0.0..=3.0).contains(t)), "{interpolation:?}");
    }
}

#[test]
fn interpolations_give_the_height_of_a_vertex_at_its_texture_coordinate() {
    // At 16 texels for 8 cells of half the texture, texel centres are never at vertices; at this odd size some are.
    let (surface, atlas, heights) = slope();
    let size = Size::square(12);
    let coverage = Coverage::new(&surface, &atlas, size, &Silent).unwrap();
    for interpolation in [Interpolation::Natural, Interpolation::Idw, Interpolation::Nearest] {
        let map = interpolate_heights(
            TextureLayout { surface: &surface, atlas: &atlas, coverage: &coverage },
            &heights,
            interpolation,
            &Silent,
        )
        .unwrap();
        let mut hits = 0;
        for i in 0..size.texels() {
            let uv = size.uv_from_texel(i % 12, i / 12);
            if let Some(v) = atlas.uvs().iter().position(|x| x.distance(uv) < 1e-12) {
                assert!((f64::from(map.texels[i]) - heights[v]).abs() < 1e-6, "{interpolation:?}");
                hits += 1;
            }
        }
        assert!(hits > 0);
    }
}

#[test]
fn maps_are_the_same_bits_on_any_number_of_threads() {
    let sphere = shapes::dented_sphere(3);
    // Each face has its own piece of a lattice, so that the gutter is everywhere.
    let corners = sphere.topology().faces().items().len() as Index;
    let uv = |c: Index| {
        let (face, k) = (f64::from(c / 3), c % 3);
        let cell = DVec2::new(face % 36.0, (face / 36.0).floor());
        (cell + [DVec2::new(0.1, 0.1), DVec2::new(0.9, 0.2), DVec2::new(0.3, 0.8)][k as usize]) / 36.0
    };
    let uvs: Vec<_> = (0..corners).map(uv).collect();
    let atlas = Atlas::new(&sphere, &uvs, (0..corners).map(Some)).unwrap();
    let heights: Vec<_> = sphere.positions().iter().map(|p| p.x * p.y + p.length()).collect();
    for interpolation in [Interpolation::Barycentric, Interpolation::Natural, Interpolation::Idw] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let coverage = Coverage::new(&sphere, &atlas, Size::square(128), &Silent).unwrap();
                let layout = TextureLayout { surface: &sphere, atlas: &atlas, coverage: &coverage };
                interpolate_heights(layout, &heights, interpolation, &Silent).unwrap()
            })
        };
        assert!(on(1) == on(2) && on(1) == on(7), "{interpolation:?}");
    }
}

#[test]
fn a_normal_map_gives_back_the_normals_it_was_made_of() {
    // A wavy sheet and its flat version: in the frames of the waves the map has a normal that points up.
    let (surface, atlas, _) = slope();
    let wavy = surface.at(surface.positions().iter().map(|p| *p + DVec3::Z * 0.05 * (9.0 * p.x).sin()).collect());
    let normals: Vec<Vec3> = vertex_normals(&wavy, FaceWeight::Angle).iter().map(|n| n.as_vec3()).collect();
    let coverage = Coverage::new(&wavy, &atlas, Size::square(32), &Silent).unwrap();
    let flat = surface.positions().to_vec();
    let tangents = tangents::tangents(&wavy, &atlas, &normals);
    let layout = TextureLayout { surface: &wavy, atlas: &atlas, coverage: &coverage };
    let frames = TangentFrames { normals: &normals, tangents: &tangents };
    let bake = |convention| {
        normal_map::bake(layout, frames, flat.clone(), (convention, SharedTexels::First), &Silent).unwrap()
    };
    let (gl, dx) = (bake(Convention::OpenGl), bake(Convention::DirectX));
    for i in 0..32 * 32 {
        let (column, row) = (i % 32, i / 32);
        let Some(owner) = coverage.owner(column, row) else { continue };
        let (t, w) = coverage.weights(owner, column, row);
        let w = w.as_vec3().to_array();
        let vertices = wavy.triangle_corners()[t as usize].map(|c| wavy.topology().vertex(c) as usize);
        let n: Vec3 = (0..3).map(|k| normals[vertices[k]] * w[k]).sum();
        let tangent: Vec3 = (0..3).map(|k| tangents[t as usize][k].tangent * w[k]).sum();
        let bitangent = n.cross(tangent) * tangents[t as usize][0].sign;
        // v runs along +y, so must the bitangent.
        assert!(bitangent.y > 0.9, "{bitangent}");
        let texel = gl.texels[i].map(|x| f32::from(x) / 127.5 - 1.0);
        let shaded = (tangent * texel[0] + bitangent * texel[1] + n * texel[2]).normalize();
        // 8 bits: half a step of 1/127.5 in each of three channels.
        assert!(shaded.distance(Vec3::Z) < 3f32.sqrt() / 255.0, "{shaded}");
        assert!((i32::from(gl.texels[i][1]) + i32::from(dx.texels[i][1]) - 255).abs() <= 1);
    }
    let tilt = gl.texels.iter().map(|t| (i32::from(t[0]) - 128).abs()).max();
    assert!(tilt > Some(20), "the waves must show");
}
