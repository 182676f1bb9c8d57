use super::*;
use crate::map::{Coverage, Size};
use crate::mesh::atlas::Atlas;
use crate::mesh::shapes;
use crate::mesh::surface::Surface;
use crate::mesh::weld::Welding;
use crate::progress::Silent;
use crate::source::obj::Obj;
use std::fmt::Write as _;

const SIDE: u32 = 1024;

struct Stopped;

impl Progress for Stopped {
    fn cancelled(&self) -> bool {
        true
    }
}

fn file(surface: &Surface) -> String {
    let mut text = String::new();
    for p in surface.positions() {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for face in surface.topology().faces().iter() {
        let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

fn model(text: &str) -> Model {
    Model::new(Obj::parse(text.into()).unwrap(), Welding::Exact)
}

fn unwrapped(model: &Model, side: u32) -> Unwrapped {
    let charts = Charts::cut(model, model.surface().positions(), &Silent).unwrap();
    charts.pack(side, &Silent).unwrap().unwrap()
}

fn laid_out(model: &Model, side: u32) -> Model {
    let unwrapped = unwrapped(model, side);
    let text = model.source().as_obj().unwrap().with_uvs(&unwrapped.uvs, &unwrapped.corners);
    Model::new(Obj::parse(text).unwrap(), Welding::Exact)
}

/// A dented sphere of triangles, a cube of squares, and a tube of squares that noise has bent: no chart can take it whole.
fn meshes() -> [Model; 3] {
    let mut tube = String::new();
    let (rows, columns) = (12_u32, 16_u32);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (sin, cos) = (f64::from(column) / f64::from(columns) * std::f64::consts::TAU).sin_cos();
        let r = 1.0 + 0.15 * f64::from((row * 7 + column * 11) % 5);
        writeln!(tube, "v {} {} {}", r * cos, r * sin, f64::from(row) * 0.4).unwrap();
    }
    for (row, column) in (0..rows - 1).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = |row: u32, column: u32| row * columns + column % columns + 1;
        let [a, b] = [at(row, column), at(row, column + 1)];
        writeln!(tube, "f {a} {b} {} {}", at(row + 1, column + 1), at(row + 1, column)).unwrap();
    }
    [model(&file(&shapes::dented_sphere(3))), model(&file(&shapes::cube())), model(&tube)]
}

/// Chart of each texel that belongs to one.
fn charts_of_texels(model: &Model, atlas: &Atlas, coverage: &Coverage) -> Vec<Option<Index>> {
    let surface = model.surface();
    let mut charts = crate::mesh::union_find::UnionFind::new(atlas.uvs().len());
    for face in 0..surface.topology().faces().len() as Index {
        let corners: Vec<Index> = surface.topology().faces().range(face).map(|c| c as Index).collect();
        corners.windows(2).for_each(|pair| {
            charts.join(atlas.corner_uv(pair[0]).unwrap(), atlas.corner_uv(pair[1]).unwrap());
        });
    }
    let side = coverage.size().width as usize;
    let texels = (0..side * side).map(|i| coverage.owner(i % side, i / side));
    texels
        .map(|t| t.map(|t| charts.lowest(atlas.corner_uv(surface.triangle_corners()[t as usize][0]).unwrap())))
        .collect()
}

#[test]
fn every_corner_has_texture_coordinates_and_no_two_faces_share_texels() {
    for before in meshes() {
        let model = laid_out(&before, SIDE);
        let (surface, atlas) = (model.surface(), model.atlas().unwrap());
        assert_eq!(surface.topology().faces().items(), before.surface().topology().faces().items());
        for corner in 0..surface.topology().faces().items().len() as Index {
            let uv = atlas.at_corner(corner).unwrap();
            assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{uv}");
        }
        let coverage = Coverage::new(surface, &atlas, Size::square(SIDE), &Silent).unwrap();
        assert_eq!(coverage.overlaps(), 0);
        assert_eq!(atlas.mirrored_faces(surface), 0);
    }
}

#[test]
fn charts_keep_their_distance_at_the_size_they_were_packed_for() {
    for side in [256, SIDE] {
        for before in meshes() {
            let model = laid_out(&before, side);
            let atlas = model.atlas().unwrap();
            let coverage = Coverage::new(model.surface(), &atlas, Size::square(side), &Silent).unwrap();
            let charts = charts_of_texels(&model, &atlas, &coverage);
            let side = side as usize;
            let mut all: Vec<Index> = charts.iter().copied().flatten().collect();
            all.sort_unstable();
            all.dedup();
            assert!(all.len() > 1, "one chart keeps every distance");
            let reach = GUTTER as usize;
            for (i, chart) in charts.iter().enumerate().filter_map(|(i, chart)| Some((i, (*chart)?))) {
                let (x, y) = (i % side, i / side);
                assert!(x.min(y) >= reach && x.max(y) + reach < side, "texel {x}, {y} is at the border");
                for (dx, dy) in (0..=2 * reach).flat_map(|dx| (0..=2 * reach).map(move |dy| (dx, dy))) {
                    let near = charts[(y + dy - reach) * side + x + dx - reach];
                    assert!(near.is_none_or(|other| other == chart), "texels {x}, {y} of two charts are too near");
                }
            }
        }
    }
}

#[test]
fn the_same_mesh_gives_the_same_bits() {
    for model in meshes() {
        assert_eq!(unwrapped(&model, 512), unwrapped(&model, 512));
    }
}

#[test]
fn it_stops_when_asked_to() {
    let model = model(&file(&shapes::sphere(3)));
    let cut = Charts::cut(&model, model.surface().positions(), &Stopped);
    assert!(matches!(cut, Err(UnwrapError::Cancelled(_))));
    let charts = Charts::cut(&model, model.surface().positions(), &Silent).unwrap();
    assert_eq!(charts.pack(SIDE, &Stopped), Err(UnwrapError::Cancelled(Cancelled)));
}

#[test]
fn faces_outside_the_surface_get_texture_coordinates_too() {
    // Vertex 9 lies on an edge of the cube; a triangle without area, a repeated face, a collapsed one, and one that
    // hangs on the edge by a single vertex.
    let text = file(&shapes::cube()) + "v 0.5 0 0\nv 7 7 7\nf 1 2 9\nf 1 2 3\nf 1 2 1\nf 3 10 10\n";
    let before = model(&text);
    let model = laid_out(&before, SIDE);
    assert_eq!(model.data().faces().len(), before.data().faces().len());
    assert!(model.data().faces().items().iter().all(|corner| corner.uv().is_some()));
    assert!(model.data().uvs().iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
}

#[test]
fn what_cannot_be_laid_out_is_named() {
    let flat = model("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let cut = Charts::cut(&flat, flat.surface().positions(), &Silent);
    assert!(matches!(cut, Err(UnwrapError::NoArea)));
    // Six charts with two free texels each all around take more than seven texels a side.
    let cube = model(&file(&shapes::cube()));
    let charts = Charts::cut(&cube, cube.surface().positions(), &Silent).unwrap();
    assert_eq!(charts.pack(4, &Silent), Ok(None));
}

#[test]
fn other_statements_stay() {
    let text =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.2 # old\nvn 0 0 1\ng one\nf 1/1/1 2//1 -1 # face\nl 1/1 2\n";
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::new(0.25, 0.5)];
    let written = model(text).source().as_obj().unwrap().with_uvs(&uvs, &[2, 1, 0]);
    let expected = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\ng one\nvt 0.0 0.0\nvt 1.0 0.0\nvt 0.25 0.5\n\
                    f 1/3/1 2/2/1 3/1 # face\nl 1 2\n";
    assert_eq!(String::from_utf8(written).unwrap(), expected);
}
