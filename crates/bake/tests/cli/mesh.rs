//! Meshes to bake.

use std::fmt::Write as _;

/// Polygons; a corner names a position and a texture coordinate, both from 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f64; 3]>,
    pub(crate) uvs: Vec<[f64; 2]>,
    pub(crate) faces: Vec<Vec<[usize; 2]>>,
}

impl Mesh {
    /// A flat grid of n × n squares over the unit square, open all around.
    pub(crate) fn grid(n: usize) -> Self {
        let at = |k: usize| k as f64 / n as f64;
        let nodes = || (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let corner = |i, j| [j * (n + 1) + i; 2];
        let square = |i, j| vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        Self {
            positions: nodes().map(|(i, j)| [at(i), at(j), 0.0]).collect(),
            uvs: nodes().map(|(i, j)| [0.02 + 0.96 * at(i), 0.02 + 0.96 * at(j)]).collect(),
            faces: (0..n).flat_map(|j| (0..n).map(move |i| square(i, j))).collect(),
        }
    }

    /// A unit sphere of 2n × n fields with one seam from pole to pole. Its vertices are whole; only the texture
    /// coordinates are cut. Triangles at the poles, squares elsewhere.
    pub(crate) fn sphere(n: usize) -> Self {
        let columns = 2 * n;
        let mut mesh = Self { positions: vec![[0.0, 0.0, 1.0]], ..Self::default() };
        for (row, column) in (1..n).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let (polar, azimuth) = (row as f64 / n as f64, column as f64 / n as f64);
            let [(s, z), (y, x)] = [polar, azimuth].map(|turns| (turns * std::f64::consts::PI).sin_cos());
            mesh.positions.push([s * x, s * y, z]);
        }
        mesh.positions.push([0.0, 0.0, -1.0]);
        let vertex = |row: usize, column: usize| match row {
            0 => 0,
            _ if row == n => (n - 1) * columns + 1,
            _ => (row - 1) * columns + column % columns + 1,
        };
        for row in 0..=n {
            mesh.uvs.extend((0..=columns).map(|c| [c as f64 / columns as f64, 1.0 - row as f64 / n as f64]));
        }
        let corner = |row: usize, column: usize| [vertex(row, column), row * (columns + 1) + column];
        for (row, c) in (0..n).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let square = [corner(row, c), corner(row + 1, c), corner(row + 1, c + 1), corner(row, c + 1)];
            let left_out = if row == 0 { 3 } else { 2 };
            let at_pole = row == 0 || row + 1 == n;
            mesh.faces.push((0..4).filter(|k| !at_pole || *k != left_out).map(|k| square[k]).collect());
        }
        mesh
    }

    /// Moves each vertex by up to `amount` along each axis, the same way at every call.
    pub(crate) fn noisy(mut self, amount: f64) -> Self {
        for (i, x) in self.positions.iter_mut().flatten().enumerate() {
            *x += amount * (2.0 * ((i as f64 * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 1.0);
        }
        self
    }

    /// One `v` line for each texture coordinate, as exporters write that have one index only.
    pub(crate) fn split_at_seams(&self) -> Self {
        let mut positions = vec![[0.0; 3]; self.uvs.len()];
        for [v, vt] in self.faces.iter().flatten() {
            positions[*vt] = self.positions[*v];
        }
        let faces = self.faces.iter().map(|face| face.iter().map(|c| [c[1]; 2]).collect()).collect();
        Self { positions, uvs: self.uvs.clone(), faces }
    }

    /// Moves the whole mesh.
    pub(crate) fn moved(mut self, by: [f64; 3]) -> Self {
        for p in &mut self.positions {
            *p = [0, 1, 2].map(|k| p[k] + by[k]);
        }
        self
    }

    /// With what scans have: a vertex of no face, a face twice, a face that is flipped and repeated, and one that
    /// names a vertex twice.
    pub(crate) fn with_defects(mut self) -> Self {
        let (first, mut flipped) = (self.faces[0].clone(), self.faces[1].clone());
        flipped.reverse();
        let [a, b] = [self.faces[2][0], self.faces[2][1]];
        self.faces.extend([first, flipped, vec![a, b, b]]);
        self.positions.push([3.0, -2.0, 1.0]);
        self
    }

    /// Coordinates are spelt so that they read back to the same numbers.
    pub(crate) fn obj(&self) -> String {
        let mut out = String::new();
        for [x, y, z] in &self.positions {
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        for [u, v] in &self.uvs {
            let _ = writeln!(out, "vt {u} {v}");
        }
        for face in &self.faces {
            let corners: String = face.iter().map(|[v, vt]| format!(" {}/{}", v + 1, vt + 1)).collect();
            let _ = writeln!(out, "f{corners}");
        }
        out
    }
}

/// The smallest mesh that can be baked.
pub(crate) const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
