//! Writer that copies the bytes of an STL file and replaces the numbers that change.

use super::{FACET, HEADER, Stl};
use crate::mesh::polygon;
use crate::source::patch::{Patch, lenient_number, push_number};
use crate::source::text::Words;
use glam::{DVec3, Vec3};

/// Unit normal of a facet, for the right-hand rule; zero without area.
pub(super) fn facet_normal(corners: &[DVec3]) -> Vec3 {
    polygon::newell(corners.iter().copied()).normalize_or_zero().as_vec3()
}

pub(super) fn with_positions(stl: &Stl, positions: &[DVec3]) -> Vec<u8> {
    assert_eq!(positions.len(), stl.data.positions.len(), "one position for each vertex");
    if stl.is_text { text(stl, positions) } else { binary(stl, positions) }
}

fn binary(stl: &Stl, positions: &[DVec3]) -> Vec<u8> {
    let mut out = stl.bytes.clone();
    for (facet, vertices) in out[HEADER..].chunks_exact_mut(FACET).zip(stl.facets.iter()) {
        let moves = |v: &&u32| stl.data.moves(**v, positions[**v as usize]);
        if !vertices.iter().any(|v| moves(&v)) {
            continue;
        }
        let held: Vec<DVec3> = vertices.iter().map(|&v| positions[v as usize].as_vec3().as_dvec3()).collect();
        write(&mut facet[..12], facet_normal(&held));
        for ((corner, v), p) in facet[12..48].chunks_exact_mut(12).zip(vertices).zip(&held) {
            if moves(&v) {
                write(corner, p.as_vec3());
            }
        }
    }
    out
}

/// Writes a vector in the space for it.
fn write(bytes: &mut [u8], v: Vec3) {
    for (number, x) in bytes.chunks_exact_mut(4).zip(v.to_array()) {
        number.copy_from_slice(&x.to_le_bytes());
    }
}

fn text(stl: &Stl, positions: &[DVec3]) -> Vec<u8> {
    let bytes = &stl.bytes;
    let mut patch = Patch::new(bytes);
    let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let mut words = Words { bytes, at, line: 1 };
    let (mut facet, mut corner) = (0, 0);
    let mut normal = None;
    let moves = |v: u32| stl.data.moves(v, positions[v as usize]);
    while let Some(word) = words.next_word() {
        match bytes[word].to_ascii_lowercase().as_slice() {
            b"solid" | b"endsolid" => words.skip_line(),
            b"facet" if facet < stl.facets.len() => {
                let vertices = stl.facets.get(facet as u32);
                let corners: Vec<DVec3> = vertices.iter().map(|&v| positions[v as usize]).collect();
                normal = vertices.iter().any(|v| moves(*v)).then(|| facet_normal(&corners));
            }
            b"endfacet" => facet += 1,
            b"normal" => {
                for x in normal.take().iter().flat_map(Vec3::to_array) {
                    let number = words.clone().next_word().filter(|n| lenient_number(&bytes[n.clone()]).is_some());
                    let Some(number) = number else { break };
                    words.next_word();
                    push_number(patch.replace(number), x);
                }
            }
            b"vertex" => {
                let v = stl.facets.items()[corner];
                corner += 1;
                let [before, after] = [stl.data.positions[v as usize], positions[v as usize]].map(|p| p.to_array());
                for (x, y) in before.into_iter().zip(after) {
                    let Some(number) = words.next_word() else { break };
                    if moves(v) && x.to_bits() != y.to_bits() {
                        push_number(patch.replace(number), y);
                    }
                }
            }
            _ => {}
        }
    }
    patch.finish()
}
