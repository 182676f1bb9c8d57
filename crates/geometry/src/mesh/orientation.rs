//! Consistent orientation of faces: which of them to turn around so that neighbours agree about the outside.
//!
//! ```
//! use planish_geometry::mesh::{orientation, shapes};
//!
//! let cube = shapes::cube();
//! let turned = vec![false, false, true, false, false, false];
//! let mixed = orientation::with_turned(cube.topology(), &turned);
//! assert_eq!(orientation::turned_faces(&mixed), Some(turned));
//! assert_eq!(orientation::turned_faces(cube.topology()), None);
//! ```

use super::jagged::{Index, Ragged};
use super::topology::{EdgeKind, Topology};

/// Turns faces around so that neighbours agree on which side is outside, and so that in each connected piece the fewest faces are
/// turned. Edges with more than two faces join nothing. Returns true for each face that is to be turned around (#F), or `None`
/// where all neighbours agree already.
///
/// A surface that cannot be oriented, such as a Möbius strip, keeps edges at which faces disagree.
pub fn turned_faces(topology: &Topology) -> Option<Vec<bool>> {
    if topology.misoriented_edges() == 0 {
        return None;
    }
    let edges = topology.edges().len() as Index;
    let faces = topology.faces().len();
    let pairs = (0..edges).filter_map(|e| match topology.edge_kind(e) {
        EdgeKind::Interior => Some((e, false)),
        EdgeKind::Misoriented => Some((e, true)),
        _ => None,
    });
    let joined = pairs.flat_map(|(e, disagree)| {
        let [a, b] = [0, 1].map(|k| topology.face(topology.edge_corners().get(e)[k]));
        [(a, (b, disagree)), (b, (a, disagree))]
    });
    let neighbours: Ragged<(Index, bool)> = Ragged::group(faces, joined.collect::<Vec<_>>().iter().copied());
    let mut turned: Vec<Option<bool>> = vec![None; faces];
    for seed in 0..faces as Index {
        if turned[seed as usize].is_some() {
            continue;
        }
        let mut piece = vec![seed];
        turned[seed as usize] = Some(false);
        let mut next = 0;
        while next < piece.len() {
            let own = turned[piece[next] as usize] == Some(true);
            for &(face, disagree) in neighbours.get(piece[next]) {
                if turned[face as usize].is_none() {
                    turned[face as usize] = Some(own != disagree);
                    piece.push(face);
                }
            }
            next += 1;
        }
        let count = piece.iter().filter(|&&f| turned[f as usize] == Some(true)).count();
        if 2 * count > piece.len() {
            piece.iter().for_each(|&f| turned[f as usize] = turned[f as usize].map(|t| !t));
        }
    }
    Some(turned.into_iter().map(|t| t == Some(true)).collect())
}

/// Returns the topology with these faces (#F) turned around.
pub fn with_turned(topology: &Topology, turned: &[bool]) -> Topology {
    let face = |(face, turned): (&[Index], &bool)| {
        let mut corners = face.to_vec();
        if *turned {
            corners.reverse();
        }
        corners
    };
    Topology::new(topology.vertex_count(), topology.faces().iter().zip(turned).map(face).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn turned_faces_are_found_whichever_they_are() {
        let sphere = shapes::sphere(2);
        assert_eq!(turned_faces(sphere.topology()), None);
        let every_third: Vec<bool> = (0..sphere.topology().faces().len()).map(|f| f % 3 == 1).collect();
        let mixed = with_turned(sphere.topology(), &every_third);
        let found = turned_faces(&mixed).unwrap();
        assert_eq!(found, every_third);
        assert_eq!(turned_faces(&with_turned(&mixed, &found)), None);
    }
}
