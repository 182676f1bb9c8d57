//! The definition of what is baked, spelt out slowly and without the library: h = ⟨p − mean of the neighbours, n⟩.

use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Statements of an OBJ file whose lines are plain.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    /// Corners of each face: `v`, `vt` and `vn`, counted from 1 as in the file; 0 where there is none.
    pub(crate) faces: Vec<Vec<[usize; 3]>>,
}

impl Lines {
    pub(crate) fn of(obj: &str) -> Self {
        let mut lines = Self::default();
        for line in obj.lines() {
            let mut words = line.split_whitespace();
            let keyword = words.next().unwrap_or("");
            match keyword {
                "v" | "vn" => {
                    let numbers: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                    let list = if keyword == "v" { &mut lines.positions } else { &mut lines.normals };
                    list.push(DVec3::new(numbers[0], numbers[1], numbers[2]));
                }
                "f" => lines.faces.push(words.map(corner).collect()),
                _ => {}
            }
        }
        lines
    }
}

fn corner(word: &str) -> [usize; 3] {
    let mut parts = word.split('/').map(|part| part.parse().unwrap_or(0));
    std::array::from_fn(|_| parts.next().unwrap_or(0))
}

/// Lines of a file that start with a keyword.
pub(crate) fn statements<'a>(obj: &'a str, keyword: &'a str) -> Vec<&'a str> {
    obj.lines().filter(|line| line.split_whitespace().next() == Some(keyword)).collect()
}

/// Positions of the `v` lines at λ = 1 for a bake of one whole step to the mean of the neighbours, with a fixed boundary and
/// angle-weighted normals; and the vertex of each line.
pub(crate) struct OneStep {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) vertex_of_line: Vec<usize>,
}

impl OneStep {
    pub(crate) fn of(obj: &str) -> Self {
        let Lines { positions, faces, .. } = Lines::of(obj);
        let mut numbers = BTreeMap::new();
        let weld = |p: &DVec3| {
            let next = numbers.len();
            *numbers.entry(p.to_array().map(f64::to_bits)).or_insert(next)
        };
        let vertex_of_line: Vec<usize> = positions.iter().map(weld).collect();
        let mut vertices = vec![DVec3::ZERO; numbers.len()];
        for (v, p) in vertex_of_line.iter().zip(&positions) {
            vertices[*v] = *p;
        }
        let faces = faces.iter().map(|face| face.iter().map(|corner| vertex_of_line[corner[0] - 1]).collect());
        let denoised = one_step(&vertices, faces);
        Self { positions: vertex_of_line.iter().map(|v| denoised[*v]).collect(), vertex_of_line }
    }
}

/// p − h·n of each vertex.
fn one_step(vertices: &[DVec3], faces: impl Iterator<Item = Vec<usize>>) -> Vec<DVec3> {
    let mut seen = BTreeSet::new();
    let mut neighbours = vec![BTreeSet::new(); vertices.len()];
    let mut faces_of_edge: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    let mut normals = vec![DVec3::ZERO; vertices.len()];
    for face in faces {
        let distinct: BTreeSet<usize> = face.iter().copied().collect();
        // Degenerate faces and second layers do not count.
        if distinct.len() < 3 || !seen.insert(distinct) {
            continue;
        }
        let at = |k: usize| vertices[face[k % face.len()]];
        let vector: DVec3 = (1..face.len() - 1).map(|k| (at(k) - at(0)).cross(at(k + 1) - at(0))).sum();
        for k in 0..face.len() {
            let [v, next] = [face[k], face[(k + 1) % face.len()]];
            neighbours[v].insert(next);
            neighbours[next].insert(v);
            *faces_of_edge.entry([v.min(next), v.max(next)]).or_default() += 1;
            let angle = (at(k + 1) - at(k)).angle_between(at(k + face.len() - 1) - at(k));
            normals[v] += angle * vector.normalize_or_zero();
        }
    }
    let boundary: BTreeSet<usize> = faces_of_edge.iter().filter(|e| *e.1 == 1).flat_map(|e| *e.0).collect();
    let displaced = |(v, p): (usize, &DVec3)| {
        let ring = &neighbours[v];
        if ring.is_empty() || boundary.contains(&v) {
            return *p;
        }
        let lift = ring.iter().map(|n| *p - vertices[*n]).sum::<DVec3>() / ring.len() as f64;
        // The normal of the definition is the one that the GPU has, in single precision. Where the last bit of this
        // sum in double falls on the other side, h·n differs by 2⁻²⁴ h, far less than the ulp in the bound.
        let n = normals[v].normalize_or_zero().as_vec3().as_dvec3();
        *p - lift.dot(n) * n
    };
    vertices.iter().enumerate().map(displaced).collect()
}
