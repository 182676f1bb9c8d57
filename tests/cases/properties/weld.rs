//! Which `v` lines are one vertex.

use super::{cases, coarse};
use crate::support::{model, obj_text};
use glam::DVec3;
use planish_geometry::mesh::weld::{Weld, Welding};
use planish_geometry::source::model::{Defects, Model};
use proptest::collection::vec;
use proptest::prelude::*;

/// Positions on a lattice, so that some coincide, and polygons over them.
fn soup() -> impl Strategy<Value = (Vec<DVec3>, Vec<Vec<usize>>)> {
    (3..20_usize).prop_flat_map(|count| {
        let positions = vec([coarse(), coarse(), coarse()].prop_map(DVec3::from), count);
        (positions, vec(vec(0..count, 3..6), 1..12))
    })
}

/// A soup, and an order for its `v` lines.
fn shuffled_soup() -> impl Strategy<Value = (Vec<DVec3>, Vec<Vec<usize>>, Vec<usize>)> {
    soup().prop_flat_map(|(positions, faces)| {
        let order = Just((0..positions.len()).collect::<Vec<_>>()).prop_shuffle();
        (Just(positions), Just(faces), order)
    })
}

fn welded(positions: &[DVec3], faces: &[Vec<usize>]) -> Model {
    let faces: Vec<_> = faces.iter().map(|face| face.iter().map(|&v| (v, None)).collect()).collect();
    model(obj_text(positions, &[], &faces), Welding::Exact)
}

/// The bits of a position without the sign of its zeros, which depends on which of several `v` lines comes first.
type Place = [u64; 3];

fn place(p: DVec3) -> Place {
    (p + 0.0).to_array().map(f64::to_bits)
}

/// A surface without the numbers of its vertices.
#[derive(Debug, PartialEq)]
struct Essence {
    faces: Vec<Vec<Place>>,
    vertices: Vec<Place>,
    defects: Defects,
}

fn essence(model: &Model) -> Essence {
    let surface = model.surface();
    let at = |&v: &u32| place(surface.positions()[v as usize]);
    let faces = surface.topology().faces().iter().map(|face| face.iter().map(at).collect()).collect();
    let mut vertices: Vec<Place> = surface.positions().iter().copied().map(place).collect();
    vertices.sort_unstable();
    // Lines count the `v` lines before the faces, too.
    let defects = Defects { first_degenerate_line: None, first_duplicate_line: None, ..model.defects() };
    Essence { faces, vertices, defects }
}

/// The definition: pairs not farther apart than this are one vertex, and so are chains of them.
fn by_definition(positions: &[DVec3], epsilon: f64) -> Vec<u32> {
    let mut of: Vec<usize> = (0..positions.len()).collect();
    for i in 0..positions.len() {
        for j in 0..i {
            if positions[i].distance(positions[j]) <= epsilon {
                let (a, b) = (of[i].min(of[j]), of[i].max(of[j]));
                of.iter_mut().filter(|x| **x == b).for_each(|x| *x = a);
            }
        }
    }
    let mut names = Vec::new();
    let name = |&lowest: &usize| {
        let known = names.iter().position(|n| *n == lowest);
        known.unwrap_or_else(|| {
            names.push(lowest);
            names.len() - 1
        }) as u32
    };
    of.iter().map(name).collect()
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_order_of_vertices_does_not_matter((positions, faces, order) in shuffled_soup()) {
        // Line `order[i]` holds what was in line i.
        let mut moved = positions.clone();
        for (p, &to) in positions.iter().zip(&order) {
            moved[to] = *p;
        }
        let renamed: Vec<Vec<_>> = faces.iter().map(|face| face.iter().map(|&v| order[v]).collect()).collect();
        prop_assert_eq!(essence(&welded(&positions, &faces)), essence(&welded(&moved, &renamed)));
    }

    #[test]
    fn copies_of_vertices_do_not_matter((positions, faces) in soup(), copies in vec(any::<bool>(), 72)) {
        let doubled = [&positions[..], &positions[..]].concat();
        let mut copies = copies.into_iter();
        let mut either = |&v: &usize| if copies.next() == Some(true) { v + positions.len() } else { v };
        let mut split = Vec::new();
        for face in &faces {
            split.push(face.iter().map(&mut either).collect::<Vec<_>>());
        }
        prop_assert_eq!(essence(&welded(&positions, &faces)), essence(&welded(&doubled, &split)));
    }

    #[test]
    fn no_welding_is_the_identity((positions, _) in soup()) {
        let weld = Weld::new(&positions, Welding::None);
        let all: Vec<u32> = (0..positions.len() as u32).collect();
        prop_assert_eq!((weld.vertex_of(), weld.first()), (&all[..], &all[..]));
    }

    #[test]
    fn welding_is_what_its_definition_says((positions, _) in soup(), epsilon in 0.1..1.2) {
        let exact = Weld::new(&positions, Welding::Exact);
        prop_assert_eq!(exact.vertex_of(), by_definition(&positions, 0.0));
        let near = Weld::new(&positions, Welding::Epsilon(epsilon));
        prop_assert_eq!(near.vertex_of(), by_definition(&positions, epsilon));
    }

    #[test]
    fn welding_again_changes_nothing((positions, _) in soup(), epsilon in 0.1..1.2) {
        for welding in [Welding::Exact, Welding::Epsilon(epsilon)] {
            let weld = Weld::new(&positions, welding);
            let vertices: Vec<DVec3> = weld.first().iter().map(|&v| positions[v as usize]).collect();
            let again = Weld::new(&vertices, welding);
            prop_assert_eq!(again.first().len(), vertices.len(), "{:?}", welding);
        }
    }
}
