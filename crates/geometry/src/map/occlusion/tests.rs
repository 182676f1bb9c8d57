//! Occlusion against values that are known without rays.

use super::*;
use crate::map::{Coverage, Size};
use crate::mesh::shapes;
use crate::mesh::topology::Topology;
use crate::mesh::weld::Welding;
use crate::progress::Silent;
use crate::source::model::Model;
use crate::source::obj::Obj;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Enough rays for errors of a thousandth.
const MANY: Occlusion = Occlusion { rays: 4096, distance: None };

/// Error of [`MANY`] rays: a scrambled sequence of n points misses the area under a smooth edge by about n to the −3/4.
const NOISE: f64 = 0.004;

/// Rows of points of the planes of [`crease`], from their common edge to their ends.
const ROWS: [f64; 6] = [0.0, 0.5, 1.0, 1.5, 2.0, WIDTH];
const WIDTH: f64 = 10.0;

/// Two planes that meet along the y axis at an angle (radians), far longer than wide, seen from within. The points of a row are
/// numbered along y, the middle one is at y = 0.
fn crease(angle: f64) -> Surface {
    let columns = [-40.0, 0.0, 40.0];
    let mut points: Vec<DVec3> = Vec::new();
    for (side, row) in (0..2).flat_map(|side| ROWS.map(move |row| (side, row))) {
        let (sine, cosine) = (f64::from(side) * angle).sin_cos();
        if side == 0 || row > 0.0 {
            points.extend(columns.map(|y| DVec3::new(row * cosine, y, row * sine)));
        }
    }
    let mut faces = Vec::new();
    for (side, row, column) in (0..2).flat_map(|s| (0..5).flat_map(move |r| (0..2).map(move |c| (s, r, c)))) {
        let at = |row: u32, column: u32| {
            let shift = if side == 1 && row > 0 { 15 } else { 0 };
            shift + 3 * row + column
        };
        let square = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        let [a, b, c, d] = square;
        faces.extend(if side == 0 { [vec![a, b, c], vec![a, c, d]] } else { [vec![a, c, b], vec![a, d, c]] });
    }
    let faces: Ragged<Index> = faces.into_iter().collect();
    Surface::new(Topology::new(points.len(), faces), points)
}

#[test]
fn an_open_plane_gets_all_light() {
    let tilted = shapes::grid(9);
    let tilted = tilted.at(tilted.positions().iter().map(|p| *p + DVec3::Z * (0.3 * p.x - 0.7 * p.y) + 1e4).collect());
    assert_eq!(at_vertices(&tilted, Occlusion::default(), &Silent).unwrap(), vec![1.0; 100]);
}

#[test]
fn a_convex_body_gets_all_light_at_corners_and_edges_too() {
    for body in [shapes::sphere(3), shapes::cube(), shapes::gridded_box(4)] {
        assert!(at_vertices(&body, Occlusion::default(), &Silent).unwrap().iter().all(|open| *open == 1.0));
    }
}

#[test]
fn the_inside_of_a_closed_sphere_gets_no_light_unless_rays_are_short() {
    let sphere = shapes::sphere(3);
    let inside_out = sphere.at(sphere.positions().iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect());
    assert!(at_vertices(&inside_out, Occlusion::default(), &Silent).unwrap().iter().all(|open| *open == 0.0));
    // A chord of the unit sphere is 2 cos ϑ long, ϑ from the normal: rays of length D are open where cos ϑ > D/2, whose share of
    // the hemisphere is 1 − (D/2)². Chords between facets are shorter by the square of their size, 0.15.
    let short = Occlusion { distance: Some(0.8), ..MANY };
    for open in at_vertices(&inside_out, short, &Silent).unwrap() {
        assert!((open - 0.84).abs() < 0.02, "{open}");
    }
}

#[test]
fn a_crease_gets_the_light_of_its_angle() {
    // Flatter edges than 150° are smooth, and have one normal.
    for degrees in [45.0f64, 60.0, 90.0, 120.0, 140.0, 220.0, 300.0] {
        let angle = degrees.to_radians();
        let surface = crease(angle);
        let open = at_vertices(&surface, MANY, &Silent).unwrap();
        // The middle points of rows on both planes and on the edge itself, where rays start a little beside it.
        for (v, distance) in [(1, 0.005), (4, 0.5), (7, 1.0), (10, 1.5), (19, 0.5), (22, 1.0), (25, 1.5)] {
            // An endless strip hides what lies between its edges: (1 − sin φ) / 2 of the hemisphere, with φ from the normal to its
            // far edge. For a half plane that is (1 + cos α) / 2 at the angle α.
            let far = DVec3::new(distance - WIDTH * angle.cos(), 0.0, WIDTH * angle.sin());
            let expected = if degrees < 180.0 { 1.0 - (1.0 - far.x / far.length()) / 2.0 } else { 1.0 };
            let found = open[v];
            assert!((found - expected).abs() < NOISE, "{degrees}° at {v}: {found}, not {expected}");
        }
    }
}

#[test]
fn short_rays_see_the_near_part_of_a_wall() {
    let surface = crease(PI / 2.0);
    for distance in [0.7, 1.2, 2.0, 5.0] {
        let open = at_vertices(&surface, Occlusion { distance: Some(distance), ..MANY }, &Silent).unwrap();
        for (row, v) in [(0.5f64, 4), (1.0, 7), (1.5, 10)] {
            // In the disc below the hemisphere, which the cosine makes even, the rays that meet the wall fill the segment
            // beyond d / D.
            let c = (row / distance).min(1.0);
            let expected = 1.0 - (c.acos() - c * (1.0 - c * c).sqrt()) / PI;
            assert!((open[v] - expected).abs() < NOISE, "{distance} at {row}: {}, not {expected}", open[v]);
        }
    }
}

/// Two squares with a right angle between them, side by side in the texture with a gap, and a third of it empty.
fn book() -> Model {
    let mut text = String::new();
    for (x, z) in [(0, 0), (1, 0), (0, 1)] {
        writeln!(text, "v {x} 0 {z}\nv {x} 1 {z}").unwrap();
    }
    text += "vt 0 0\nvt 0 1\nvt 0.3 0\nvt 0.3 1\nvt 0.5 0\nvt 0.5 1\nvt 0.8 0\nvt 0.8 1\n";
    text += "f 1/1 3/3 4/4 2/2\nf 1/5 2/6 6/8 5/7\n";
    Model::new(Obj::parse(text.into_bytes()).unwrap(), Welding::Exact)
}

fn texels(model: &Model, settings: Occlusion, progress: &dyn Progress) -> Result<Vec<f32>, Cancelled> {
    let atlas = model.atlas().unwrap();
    let coverage = Coverage::new(model.surface(), &atlas, Size::square(40), &Silent).unwrap();
    at_texels(TextureLayout { surface: model.surface(), atlas: &atlas, coverage: &coverage }, settings, progress)
}

#[test]
fn texels_darken_towards_the_edge_of_a_book_and_the_gutter_lies_between() {
    let open = texels(&book(), MANY, &Silent).unwrap();
    let row = &open[20 * 40..21 * 40];
    // Both pages: the edge is at their first column.
    for page in [&row[..12], &row[20..32]] {
        assert!(page.windows(2).all(|w| w[0] < w[1]), "{page:?}");
        // At the edge half of the light, as at an endless wall; the finite one lets some past its ends.
        assert!((0.5..0.56).contains(&page[0]), "{page:?}");
    }
    assert!(row[..12].iter().zip(&row[20..32]).all(|(a, b)| (a - b).abs() < 4.0 * NOISE as f32), "mirror images");
    let (low, high) = open.iter().fold((1f32, 0f32), |(low, high), t| (low.min(*t), high.max(*t)));
    assert!(row.iter().all(|t| (low..=high).contains(t)) && low > 0.4);
    assert!((row[12] - row[11]).abs() < 0.1, "the gutter goes on as the chart ends");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let (model, sheet) = (book(), shapes::bumpy_sheet(20));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let settings = Occlusion { rays: 33, distance: Some(0.5) };
            (texels(&model, settings, &Silent).unwrap(), at_vertices(&sheet, settings, &Silent).unwrap())
        })
    };
    let one = run(1);
    assert_eq!(one, run(3));
    assert!(one.1.iter().any(|open| *open < 0.99), "the sheet has cavities");
}

struct Stop;

impl Progress for Stop {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_caller_can_stop_it() {
    assert_eq!(at_vertices(&shapes::sphere(1), MANY, &Stop), Err(Cancelled));
    assert_eq!(texels(&book(), MANY, &Stop), Err(Cancelled));
}

#[test]
fn triangles_without_area_are_open() {
    let flat = shapes::grid(1);
    let line = flat.at(flat.positions().iter().map(|p| DVec3::new(p.x, 0.0, 0.0)).collect());
    assert_eq!(at_vertices(&line, Occlusion::default(), &Silent).unwrap(), [1.0; 4]);
}

#[test]
fn normals_at_a_crowded_vertex_are_blended_without_a_look_at_all_its_triangles_from_each() {
    // A flat fan, but for a fold of 90° between its halves. All pairs of its triangles would be ten thousand million.
    let count = 100_000;
    let rim = |k: Index| {
        let p = glam::DVec2::from_angle(f64::from(k) * TAU / f64::from(count)).extend(0.0);
        if p.y > 0.0 { DVec3::new(p.x, 0.0, p.y) } else { p }
    };
    let positions: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain((0..count).map(rim)).collect();
    let faces = (0..count).map(|k| vec![0, 1 + k, 1 + (k + 1) % count]).collect();
    let fan = Surface::new(crate::mesh::topology::Topology::new(positions.len(), faces), positions);
    let shade = Shade::new(&fan, Occlusion::default(), &Silent);
    let flat = |t: usize| if t < count as usize / 2 { DVec3::NEG_Y } else { DVec3::Z };
    let at_hub = shade.corners.iter().map(|corners| corners[0]).enumerate();
    assert!(at_hub.into_iter().all(|(t, n)| n.distance(flat(t)) < 1e-6));
}
