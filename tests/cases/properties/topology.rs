//! Who touches whom, for any lists of indices.

use super::cases;
use planish_geometry::mesh::jagged::Ragged;
use planish_geometry::mesh::topology::{self, EdgeKind, TidyFaces, Topology};
use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Lists over few vertices: repeated corners, repeated faces, edges with many faces.
fn lists() -> impl Strategy<Value = (usize, Ragged<u32>)> {
    (1..9_usize).prop_flat_map(|count| {
        let faces = vec(vec(0..count as u32, 0..6), 0..14);
        (Just(count), faces.prop_map(|faces| faces.into_iter().collect()))
    })
}

fn ascends(list: &[impl Ord]) -> bool {
    list.windows(2).all(|w| w[0] < w[1])
}

fn vertices(face: &[u32]) -> BTreeSet<u32> {
    face.iter().copied().collect()
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn tidying_drops_only_what_it_says((count, input) in lists()) {
        let tidy = topology::tidy(count, input.clone());
        let TidyFaces { faces, degenerate, duplicate, .. } = &tidy;
        let source_faces: Vec<u32> = (0..faces.len() as u32).map(|f| tidy.source_face(f)).collect();
        let source_corners: Vec<u32> = (0..faces.items().len() as u32).map(|c| tidy.source_corner(c)).collect();
        let mut all = [&source_faces[..], degenerate, duplicate].concat();
        all.sort_unstable();
        prop_assert!(all.iter().copied().eq(0..input.len() as u32), "each face has one fate");
        prop_assert!(ascends(&source_faces) && ascends(&source_corners));
        prop_assert_eq!(source_faces.len(), faces.len());
        let sources = source_corners.iter().map(|&c| input.items()[c as usize]);
        prop_assert!(sources.eq(faces.items().iter().copied()));
        for (face, &source) in faces.iter().zip(&source_faces) {
            prop_assert_eq!(vertices(face), vertices(input.get(source)));
        }
        for &face in duplicate {
            let twin = |&earlier: &u32| earlier < face && vertices(input.get(earlier)) == vertices(input.get(face));
            prop_assert!(source_faces.iter().any(twin));
        }
        for &face in degenerate {
            let mut different = input.get(face).to_vec();
            different.sort_unstable();
            different.dedup();
            prop_assert!(different.len() < 3);
        }
    }

    #[test]
    fn neighbourhoods_agree_with_each_other((count, input) in lists()) {
        let topology = Topology::new(count, topology::tidy(count, input.clone()).faces);
        let (faces, rings, edges) = (topology.faces(), topology.rings(), topology.edges());
        let corners = faces.items().len();

        prop_assert_eq!(rings.len(), count);
        for (v, ring) in (0..).zip(rings.iter()) {
            prop_assert!(ascends(ring) && !ring.contains(&v));
            prop_assert!(ring.iter().all(|&n| rings.get(n).contains(&v)), "rings are symmetric");
            prop_assert_eq!(topology.is_isolated(v), ring.is_empty());
        }
        prop_assert!(ascends(edges) && edges.iter().all(|[a, b]| a < b));
        prop_assert_eq!(rings.items().len(), 2 * edges.len());
        prop_assert!(edges.iter().all(|&[a, b]| rings.get(a).contains(&b)));

        let at_vertices: usize = (0..count as u32).map(|v| topology.corners(v).len()).sum();
        prop_assert_eq!((at_vertices, topology.edge_corners().items().len()), (corners, corners));
        for c in 0..corners as u32 {
            prop_assert_eq!(topology.previous(topology.next(c)), c);
            prop_assert_eq!(topology.face(topology.next(c)), topology.face(c));
            prop_assert!(topology.corners(topology.vertex(c)).contains(&c));
            prop_assert!(faces.range(topology.face(c)).contains(&(c as usize)));
        }
        for (e, (&[a, b], corners)) in (0..).zip(edges.iter().zip(topology.edge_corners().iter())) {
            let ends = |&c: &u32| (topology.vertex(c), topology.vertex(topology.next(c)));
            prop_assert!(corners.iter().map(ends).all(|ends| ends == (a, b) || ends == (b, a)));
            let is_boundary = topology.edge_kind(e) == EdgeKind::Boundary;
            prop_assert_eq!(is_boundary, corners.len() == 1);
            prop_assert!(!is_boundary || topology.is_boundary(a) && topology.is_boundary(b));
        }
        let kinds = (0..edges.len() as u32).map(|e| topology.edge_kind(e));
        prop_assert_eq!(topology.misoriented_edges(), kinds.filter(|kind| *kind == EdgeKind::Misoriented).count());
        for v in 0..count as u32 {
            let at_end = (0..).zip(edges).any(|(e, ends)| ends.contains(&v) && topology.edge_kind(e) == EdgeKind::Boundary);
            prop_assert_eq!(topology.is_boundary(v), at_end);
        }
        prop_assert!(ascends(&topology.non_manifold_vertices()));
    }

    #[test]
    fn components_are_what_edges_join((count, input) in lists()) {
        let topology = Topology::new(count, topology::tidy(count, input.clone()).faces);
        let (component, components) = topology.components();
        prop_assert!(topology.edges().iter().all(|&[a, b]| component[a as usize] == component[b as usize]));
        prop_assert_eq!(component.iter().copied().collect::<BTreeSet<_>>().len(), components);
        // No fewer than Euler's count of a forest allows.
        prop_assert!(components + topology.edges().len() >= count);
    }
}
