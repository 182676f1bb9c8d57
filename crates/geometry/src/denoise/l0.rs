//! L0 minimisation: as few edges as possible are not flat.
//!
//! Lei He, Scott Schaefer. Mesh denoising via L0 minimization. SIGGRAPH 2013.
//!
//! Minimises |p − p⁰|² + α |R(p)|² + β |D(p) − δ|² + λ |δ|₀ alternately in δ and p. D is the area-based edge operator
//! (eq. 6), which vanishes at an edge whose triangles are in one plane, and R = p₁ − p₂ + p₃ − p₄ keeps triangles from
//! folding. In each round δ is D where |D|² ≥ λ/β and 0 elsewhere, then p solves a linear system; β grows and α shrinks.
//!
//! λ = 0.2 ē² γ and α = 0.1 γ, with ē the mean edge length and γ the mean absolute dihedral angle in radians. (The
//! published code averages the signed angles, which cancel, and so takes almost no λ.)

use super::boundary::{BOUNDARY, Boundary};
use super::conjugate_gradients::{ConjugateGradients, Stop, multiply};
use super::face_geometry::FaceGeometry;
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::{HUGE, Parameter, TINY};
use super::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::L0`](super::Denoiser::L0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L0 {
    /// λ over its automatic value: more makes more edges flat.
    pub sparsity: f64,
    /// α over γ in the first round.
    pub alpha: f64,
    /// Factor of α from round to round.
    pub alpha_growth: f64,
    /// β in the first round.
    pub beta_min: f64,
    /// Rounds end when β reaches this.
    pub beta_max: f64,
    /// Factor of β from round to round, above 1.
    pub beta_growth: f64,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Default for L0 {
    /// As in the paper. The boundary moves; the first term holds it.
    fn default() -> Self {
        Self {
            sparsity: 1.0,
            alpha: 0.1,
            alpha_growth: 0.5,
            beta_min: 1e-3,
            beta_max: 1e3,
            beta_growth: 1.414,
            boundary: Boundary::Free,
        }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::number(
        "sparsity",
        "/sparsity",
        [0.0, HUGE],
        "how many edges become flat: 1 is automatic, more flattens more",
    )
    .slider(4.0),
    Parameter::number("alpha", "/alpha", [0.0, 1.0], "weight against folds, in the first round"),
    Parameter::number("alpha-growth", "/alpha_growth", [0.0, 10.0], "factor of alpha from round to round").internal(),
    Parameter::number("beta-min", "/beta_min", [TINY, 1e9], "weight of flat edges in the first round").internal(),
    Parameter::number("beta-max", "/beta_max", [TINY, 1e9], "weight of flat edges that ends the rounds").internal(),
    Parameter::number("beta-growth", "/beta_growth", [1.001, 1000.0], "factor of beta from round to round").internal(),
    BOUNDARY,
];

impl DenoiseMethod for L0 {
    const INFO: MethodInfo = MethodInfo {
        name: "l0",
        summary: "Makes as many edges flat as it can: for parts made of planes",
        reference: Some(Reference {
            cite: "He and Schaefer 2013",
            title: "Mesh denoising via L0 minimization. SIGGRAPH",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::default())
    }
}

/// Largest number of rounds, whatever the growth of β.
const MAX_ROUNDS: f64 = 1000.0;

/// Stopping criterion of the inner systems.
const INNER: Stop = Stop { tolerance: 1e-4, max_steps: 1000 };

/// Minimises and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &L0, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let mesh = TriangleMesh::of(surface);
    let input = surface.positions();
    let mut geometry = FaceGeometry::of(&mesh, input);
    let dihedral_angle = geometry.mean_dihedral_angle(&mesh);
    let mean_edge = surface.mean_edge();
    let lambda = settings.sparsity * 0.2 * mean_edge * mean_edge * dihedral_angle;
    let (mut alpha, mut beta) = (settings.alpha * dihedral_angle, settings.beta_min);
    let is_fixed = |v: Index| settings.boundary == Boundary::Fixed && surface.topology().is_boundary(v);
    let fixed: Vec<bool> = (0..input.len() as Index).map(is_fixed).collect();
    let mut edges = Edges::of(&mesh, input.len());
    let mut matrix = Matrix::of(&edges);
    // Offsets from the input are solved for, since they do not depend on where the origin is.
    let mut offsets = vec![DVec3::ZERO; input.len()];
    let mut previous = offsets.clone();
    let mut positions = input.to_vec();
    let rounds = ((settings.beta_max / beta).ln() / settings.beta_growth.ln()).ceil().clamp(0.0, MAX_ROUNDS) as u32;
    for done in 1..=rounds {
        edges.update(&mesh, &geometry, &positions);
        let right = edges.right_hand_side(input, &positions, [alpha, beta, lambda / beta], &fixed);
        matrix.assemble(&edges, alpha, beta);
        let operator =
            |x: &[DVec3], out: &mut [DVec3]| multiply(x, out, |v| if fixed[v] { x[v] } else { matrix.times(v, x) });
        // The residual of D = δ falls as 1/β, so the next solution is extrapolated from the last two.
        let extrapolated = previous.iter().zip(&offsets).map(|(a, b)| *b + (*b - *a) / settings.beta_growth).collect();
        previous = offsets;
        let mut solver = ConjugateGradients::new(&matrix.diagonal());
        offsets = solver.solve_from(operator, extrapolated, &right, INNER, progress)?;
        positions.par_iter_mut().zip(input).zip(&offsets).for_each(|((x, p), offset)| *x = *p + *offset);
        geometry.update(&mesh, &positions);
        beta *= settings.beta_growth;
        alpha *= settings.alpha_growth;
        progress.done(f64::from(done) / f64::from(rounds));
    }
    Ok(offsets.into_iter().map(|offset| -offset).collect())
}

/// Interior edges, and the operators R and D on their four vertices.
struct Edges {
    /// The four vertices of each edge: p₁ and p₃ are its ends, p₂ and p₄ are opposite to it. #E×4
    vertices: Vec<[Index; 4]>,
    /// Coefficients of D. #E×4
    coefficients: Vec<[f64; 4]>,
    /// Edges at each vertex, and which of their four vertices it is. #V lists
    at: Ragged<(Index, u8)>,
}

/// Coefficients of R.
const FOLD: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

impl Edges {
    fn of(mesh: &TriangleMesh, vertex_count: usize) -> Self {
        let third = |f: Index, a: Index, b: Index| {
            let [i, j, k] = mesh.triangles[f as usize];
            if i != a && i != b {
                i
            } else if j != a && j != b {
                j
            } else {
                k
            }
        };
        let four = |(&[f, g], &[a, b]): (&[Index; 2], &[Index; 2])| [a, third(g, a, b), b, third(f, a, b)];
        let vertices: Vec<[Index; 4]> = mesh.edge_faces.iter().zip(&mesh.edge_vertices).map(four).collect();
        let slots = (0..).zip(&vertices).flat_map(|(e, four)| (0..4u8).map(move |k| (four[usize::from(k)], (e, k))));
        let at = Ragged::group(vertex_count, slots);
        Self { coefficients: vec![[0.0; 4]; vertices.len()], vertices, at }
    }

    /// Computes the coefficients of D for these positions; they are zero where D does not exist.
    fn update(&mut self, mesh: &TriangleMesh, geometry: &FaceGeometry, positions: &[DVec3]) {
        let slots = self.coefficients.par_iter_mut().zip(&self.vertices).zip(&mesh.edge_faces).with_min_len(CHUNK);
        slots.for_each(|((out, vertices), &[f, g])| {
            let [p1, p2, p3, p4] = vertices.map(|v| positions[v as usize]);
            let [area_134, area_123] = [f, g].map(|f| geometry.areas[f as usize]);
            let total = area_123 + area_134;
            let scale = p1.distance_squared(p3) * total;
            *out = [
                (area_123 * (p4 - p3).dot(p3 - p1) + area_134 * (p1 - p3).dot(p3 - p2)) / scale,
                area_134 / total,
                (area_123 * (p3 - p1).dot(p1 - p4) + area_134 * (p2 - p1).dot(p1 - p3)) / scale,
                area_123 / total,
            ];
            if !out.iter().all(|c| c.is_finite()) {
                *out = [0.0; 4];
            }
        });
    }

    /// Value of D at an edge.
    fn difference(&self, points: &[DVec3], edge: usize) -> DVec3 {
        let [a, b, c, d] = self.vertices[edge].map(|v| points[v as usize]);
        let [w1, w2, w3, w4] = self.coefficients[edge];
        w1 * a + w2 * b + w3 * c + w4 * d
    }

    /// Value of R at an edge.
    fn fold(&self, points: &[DVec3], edge: usize) -> DVec3 {
        let [a, b, c, d] = self.vertices[edge].map(|v| points[v as usize]);
        a - b + c - d
    }

    /// Right-hand side of the system for the offsets: minus the adjoints of α R(p⁰) and β (D(p⁰) − δ), where δ is D at
    /// `positions` if |D|² reaches the threshold, else zero. #V×3
    fn right_hand_side(
        &self,
        input: &[DVec3],
        positions: &[DVec3],
        [alpha, beta, threshold]: [f64; 3],
        fixed: &[bool],
    ) -> Vec<DVec3> {
        let of_edge = |e: usize| {
            let jump = self.difference(positions, e);
            let kept = if jump.length_squared() >= threshold { jump } else { DVec3::ZERO };
            [alpha * self.fold(input, e), beta * (self.difference(input, e) - kept)]
        };
        let edges = (0..self.coefficients.len()).into_par_iter().with_min_len(CHUNK);
        let of_edges: Vec<_> = edges.map(of_edge).collect();
        let of_vertex = |v: usize| if fixed[v] { DVec3::ZERO } else { -self.gathered(&of_edges, v) };
        (0..input.len()).into_par_iter().map(of_vertex).collect()
    }

    /// Adjoints of R and D, added up at a vertex, for a vector of each at every edge.
    fn gathered(&self, of_edges: &[[DVec3; 2]], vertex: usize) -> DVec3 {
        self.at.get(vertex as Index).iter().fold(DVec3::ZERO, |sum, &(e, k)| {
            let (e, k) = (e as usize, usize::from(k));
            sum + FOLD[k] * of_edges[e][0] + self.coefficients[e][k] * of_edges[e][1]
        })
    }
}

/// Matrix 1 + α RᵀR + β DᵀD. It is assembled once in each round: conjugate gradients need many products, and applying R and D
/// with their adjoints would take four times as long.
struct Matrix {
    /// Columns of each row: the vertex itself, then all that share four vertices of an edge with it, ascending. #V lists
    columns: Ragged<Index>,
    /// Entries, in the order of `columns`.
    values: Vec<f64>,
    /// For each item of [`Edges::at`], where in the row the edge's four vertices are.
    slots: Vec<[Index; 4]>,
}

/// Number of rows or edges that a thread treats at a time.
const CHUNK: usize = 1024;

impl Matrix {
    fn of(edges: &Edges) -> Self {
        let mut columns = Ragged::default();
        let mut slots = Vec::with_capacity(edges.at.items().len());
        let mut row = Vec::new();
        for (v, at) in (0..).zip(edges.at.iter()) {
            row.clear();
            row.push(v);
            let others = at.iter().flat_map(|&(e, _)| edges.vertices[e as usize]);
            row.extend(others.filter(|w| *w != v));
            row[1..].sort_unstable();
            row.dedup();
            let slot = |w: Index| if w == v { 0 } else { 1 + row[1..].partition_point(|x| *x < w) as Index };
            slots.extend(at.iter().map(|&(e, _)| edges.vertices[e as usize].map(slot)));
            columns.push(row.iter().copied());
        }
        Self { values: vec![0.0; columns.items().len()], columns, slots }
    }

    /// Assembles the matrix for these weights and the coefficients of `edges`.
    fn assemble(&mut self, edges: &Edges, alpha: f64, beta: f64) {
        let Self { columns, values, slots } = self;
        let count = columns.len();
        let mut rest = &mut values[..];
        let mut chunks = Vec::with_capacity(count.div_ceil(CHUNK));
        for start in (0..count).step_by(CHUNK) {
            let end = (start + CHUNK).min(count);
            let length = (start..end).map(|v| columns.get(v as Index).len()).sum();
            let (chunk, after) = rest.split_at_mut(length);
            chunks.push((start..end, chunk));
            rest = after;
        }
        chunks.into_par_iter().for_each(|(vertices, mut values)| {
            for v in vertices {
                let (row, after) = values.split_at_mut(columns.get(v as Index).len());
                values = after;
                row.fill(0.0);
                row[0] = 1.0;
                let at = edges.at.range(v as Index);
                for (&(e, k), slots) in edges.at.items()[at.clone()].iter().zip(&slots[at]) {
                    let (d, k) = (&edges.coefficients[e as usize], usize::from(k));
                    let (fold, difference) = (alpha * FOLD[k], beta * d[k]);
                    for j in 0..4 {
                        row[slots[j] as usize] += fold * FOLD[j] + difference * d[j];
                    }
                }
            }
        });
    }

    fn diagonal(&self) -> Vec<f64> {
        (0..self.columns.len()).map(|v| self.values[self.columns.range(v as Index).start]).collect()
    }

    /// Product of row `v` and `x`.
    #[inline]
    fn times(&self, v: usize, x: &[DVec3]) -> DVec3 {
        let row = self.columns.range(v as Index);
        let entries = self.columns.items()[row.clone()].iter().zip(&self.values[row]);
        entries.fold(DVec3::ZERO, |sum, (&w, value)| sum + *value * x[w as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn a_round_leaves_no_gradient_of_its_energy() {
        let surface = shapes::dented_sphere(2);
        let (mesh, input) = (TriangleMesh::of(&surface), surface.positions());
        let start = FaceGeometry::of(&mesh, input);
        let mut edges = Edges::of(&mesh, input.len());
        edges.update(&mesh, &start, input);
        let count = edges.vertices.len();
        let (dihedral_angle, mean_edge) = (start.mean_dihedral_angle(&mesh), surface.mean_edge());
        let jump = |e: usize| edges.difference(input, e);
        let mut squares: Vec<f64> = (0..count).map(|e| jump(e).length_squared()).collect();
        squares.sort_unstable_by(f64::total_cmp);
        // Weights are about one, there is one round, and its λ/β makes half of the edges flat.
        let (alpha, beta) = (2.0 * dihedral_angle, 3.0);
        let threshold = 0.5 * (squares[count / 2 - 1] + squares[count / 2]);
        let sparsity = threshold * beta / (0.2 * mean_edge.powi(2) * dihedral_angle);
        let settings = L0 { alpha: 2.0, beta_min: beta, beta_max: 3.5, sparsity, ..L0::default() };
        let kept = |e: usize| if jump(e).length_squared() >= threshold { jump(e) } else { DVec3::ZERO };
        assert_eq!((0..count).filter(|&e| kept(e) == DVec3::ZERO).count(), count / 2);
        let deltas = deltas(&surface, &settings, &Silent).unwrap();
        let x = surface.moved_by(&deltas);
        let pulls = |x: &[DVec3]| -> Vec<[DVec3; 2]> {
            (0..count).map(|e| [alpha * edges.fold(x, e), beta * (edges.difference(x, e) - kept(e))]).collect()
        };
        let size = |gradient: Vec<DVec3>| gradient.iter().map(|g| g.length_squared()).sum::<f64>().sqrt();
        let gradient = |x: &[DVec3]| {
            let pulls = pulls(x);
            size((0..x.len()).map(|v| x[v] - input[v] + edges.gathered(&pulls, v)).collect())
        };
        // Conjugate gradients end at 1e-4 in the norm of the preconditioner.
        assert!(gradient(&x) < 1e-3 * gradient(input), "{} {}", gradient(&x), gradient(input));
    }

    #[test]
    fn the_operator_vanishes_on_a_plane_and_not_at_a_bend() {
        let bend = |lift: f64| {
            let grid = shapes::grid(4);
            let bent = grid.positions().iter().map(|p| *p + DVec3::Z * lift * (p.x - 0.5).abs());
            let surface = grid.at(bent.collect());
            let mesh = TriangleMesh::of(&surface);
            let mut edges = Edges::of(&mesh, surface.positions().len());
            edges.update(&mesh, &FaceGeometry::of(&mesh, surface.positions()), surface.positions());
            let count = edges.vertices.len();
            let jumps = (0..count).map(|e| edges.difference(surface.positions(), e).length());
            (jumps.filter(|jump| *jump > 1e-12).count(), count)
        };
        assert_eq!(bend(0.0).0, 0);
        // The four edges along x = ½.
        assert_eq!(bend(0.3).0, 4);
    }

    #[test]
    fn the_matrix_is_that_of_the_operators() {
        let sphere = shapes::dented_sphere(2);
        let mesh = TriangleMesh::of(&sphere);
        let points = sphere.positions();
        let mut edges = Edges::of(&mesh, points.len());
        edges.update(&mesh, &FaceGeometry::of(&mesh, points), points);
        let (alpha, beta) = (0.3, 7.0);
        let mut matrix = Matrix::of(&edges);
        // Twice: what was there before must be gone.
        matrix.assemble(&edges, 1.0, 1.0);
        matrix.assemble(&edges, alpha, beta);
        let products: Vec<[DVec3; 2]> = (0..edges.vertices.len())
            .map(|e| [alpha * edges.fold(points, e), beta * edges.difference(points, e)])
            .collect();
        for v in 0..points.len() {
            let expected = points[v] + edges.gathered(&products, v);
            assert!((matrix.times(v, points) - expected).length() < 1e-12, "{v}");
        }
    }
}
