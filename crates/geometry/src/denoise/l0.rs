//! Few edges that are not flat: L0 minimisation.
//!
//! Lei He, Scott Schaefer. Mesh denoising via L0 minimization. SIGGRAPH 2013.
//!
//! Minimises |p − p⁰|² + α |R(p)|² + β |D(p) − δ|² + λ |δ|₀ in turns, where D is the area-based edge operator (eq. 6),
//! which vanishes at an edge whose triangles are in one plane, and R = p₁ − p₂ + p₃ − p₄ keeps triangles from folding. In
//! each round δ is D where |D|² ≥ λ/β and 0 elsewhere, then p solves a linear system; β grows and α shrinks.
//!
//! λ = 0.2 ē² γ and α = 0.1 γ, with ē the mean edge length and γ the mean absolute dihedral angle in radians. (The
//! published code averages the signed angles, which cancel, and so takes almost no λ.)

use super::Boundary;
use super::conjugate_gradients::{Solve, by_rows, solve};
use super::faces::{Faces, Shapes};
use crate::progress::{Cancelled, Progress};
use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
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
    /// What α is multiplied by after each round.
    pub alpha_growth: f64,
    /// β in the first round.
    pub beta_min: f64,
    /// Rounds end when β reaches this.
    pub beta_max: f64,
    /// What β is multiplied by after each round; above 1.
    pub beta_growth: f64,
    /// What happens at the boundary.
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

/// Whatever β does.
const MOST_ROUNDS: f64 = 1000.0;

/// δ of the solution. #V×3, model units.
pub(super) fn deltas(surface: &Surface, settings: &L0, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let faces = Faces::of(surface);
    let input = surface.positions();
    let mut shapes = Shapes::of(&faces, input);
    let bend = faces.mean_bend(&shapes);
    let mean_edge = surface.mean_edge();
    let lambda = settings.sparsity * 0.2 * mean_edge * mean_edge * bend;
    let (mut alpha, mut beta) = (settings.alpha * bend, settings.beta_min);
    let stays = |v: Index| settings.boundary == Boundary::Fixed && surface.topology().is_boundary(v);
    let fixed: Vec<bool> = (0..input.len() as Index).map(stays).collect();
    let mut edges = Edges::of(&faces, input.len());
    let mut matrix = Matrix::of(&edges);
    // The solution is found as a way from the input, which does not depend on where the origin is.
    let mut way = vec![DVec3::ZERO; input.len()];
    let mut before = way.clone();
    let mut positions = input.to_vec();
    let rounds = ((settings.beta_max / beta).ln() / settings.beta_growth.ln()).ceil().clamp(0.0, MOST_ROUNDS) as u32;
    for done in 1..=rounds {
        edges.measure(&faces, &shapes, &positions);
        let threshold = lambda / beta;
        let at = |points: &[DVec3], e: usize| edges.difference(points, e);
        // α R(p⁰) and β (D(p⁰) − δ), whose adjoints are minus the right-hand side.
        let missing = |e: usize| {
            let jump = at(&positions, e);
            let kept = if jump.length_squared() >= threshold { jump } else { DVec3::ZERO };
            [alpha * edges.fold(input, e), beta * (at(input, e) - kept)]
        };
        let missing: Vec<_> = (0..edges.coefficients.len()).into_par_iter().with_min_len(1024).map(missing).collect();
        let right: Vec<DVec3> = (0..input.len())
            .into_par_iter()
            .map(|v| if fixed[v] { DVec3::ZERO } else { -edges.gathered(&missing, v) })
            .collect();
        matrix.assemble(&edges, alpha, beta);
        let system =
            |x: &[DVec3], out: &mut [DVec3]| by_rows(x, out, |v| if fixed[v] { x[v] } else { matrix.times(v, x) });
        let limits = Solve { tolerance: 1e-4, steps: 1000 };
        // What is missing for D = δ falls as 1 / β, so the next way goes on from the last two.
        let ahead =
            before.iter().zip(&way).map(|(before, way)| *way + (*way - *before) / settings.beta_growth).collect();
        before = way;
        way = solve(system, &matrix.diagonal(), &right, ahead, limits, progress)?;
        positions.par_iter_mut().zip(input).zip(&way).for_each(|((x, p), way)| *x = *p + *way);
        shapes.measure(&faces, &positions);
        beta *= settings.beta_growth;
        alpha *= settings.alpha_growth;
        progress.done(f64::from(done) / f64::from(rounds));
    }
    Ok(way.into_iter().map(|way| -way).collect())
}

/// Edges with two triangles, and the operators on their four vertices.
struct Edges {
    /// p₁ and p₃ are the ends, p₂ and p₄ opposite to them.
    vertices: Vec<[Index; 4]>,
    coefficients: Vec<[f64; 4]>,
    /// Edges at each vertex, and which of the four it is.
    at: Ragged<(Index, u8)>,
}

/// R as coefficients.
const FOLD: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

impl Edges {
    fn of(faces: &Faces, vertex_count: usize) -> Self {
        let third = |f: Index, a: Index, b: Index| {
            let [i, j, k] = faces.triangles[f as usize];
            if i != a && i != b {
                i
            } else if j != a && j != b {
                j
            } else {
                k
            }
        };
        let four = |(&[f, g], &[a, b]): (&[Index; 2], &[Index; 2])| [a, third(g, a, b), b, third(f, a, b)];
        let vertices: Vec<[Index; 4]> = faces.pairs.iter().zip(&faces.pair_edges).map(four).collect();
        let slots = (0..).zip(&vertices).flat_map(|(e, four)| (0..4u8).map(move |k| (four[usize::from(k)], (e, k))));
        let at = Ragged::group(vertex_count, slots);
        Self { coefficients: vec![[0.0; 4]; vertices.len()], vertices, at }
    }

    /// D for these positions; zero where it does not exist.
    fn measure(&mut self, faces: &Faces, shapes: &Shapes, positions: &[DVec3]) {
        let slots = self.coefficients.par_iter_mut().zip(&self.vertices).zip(&faces.pairs).with_min_len(1024);
        slots.for_each(|((out, vertices), &[f, g])| {
            let [p1, p2, p3, p4] = vertices.map(|v| positions[v as usize]);
            let [area_134, area_123] = [f, g].map(|f| shapes.areas[f as usize]);
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

    /// D at an edge.
    fn difference(&self, points: &[DVec3], edge: usize) -> DVec3 {
        let [a, b, c, d] = self.vertices[edge].map(|v| points[v as usize]);
        let [w1, w2, w3, w4] = self.coefficients[edge];
        w1 * a + w2 * b + w3 * c + w4 * d
    }

    /// R at an edge.
    fn fold(&self, points: &[DVec3], edge: usize) -> DVec3 {
        let [a, b, c, d] = self.vertices[edge].map(|v| points[v as usize]);
        a - b + c - d
    }

    /// Adjoint of R and D together, at a vertex.
    fn gathered(&self, of_edges: &[[DVec3; 2]], vertex: usize) -> DVec3 {
        self.at.get(vertex as Index).iter().fold(DVec3::ZERO, |sum, &(e, k)| {
            let (e, k) = (e as usize, usize::from(k));
            sum + FOLD[k] * of_edges[e][0] + self.coefficients[e][k] * of_edges[e][1]
        })
    }
}

/// 1 + α RᵀR + β DᵀD. Its rows are summed once in each round: conjugate gradients need many products, and R and D with their
/// adjoints would take four times as long.
struct Matrix {
    /// Vertices that share an edge's four with each, the vertex itself first.
    columns: Ragged<Index>,
    /// In the order of `columns`.
    values: Vec<f64>,
    /// For each slot of [`Edges::at`], where in the row the edge's four vertices are.
    places: Vec<[Index; 4]>,
}

/// Rows that are summed at a time.
const RUN: usize = 1024;

impl Matrix {
    fn of(edges: &Edges) -> Self {
        let mut columns = Ragged::default();
        let mut places = Vec::with_capacity(edges.at.items().len());
        let mut row = Vec::new();
        for (v, slots) in (0..).zip(edges.at.iter()) {
            row.clear();
            row.push(v);
            let others = slots.iter().flat_map(|&(e, _)| edges.vertices[e as usize]);
            row.extend(others.filter(|w| *w != v));
            row[1..].sort_unstable();
            row.dedup();
            let place = |w: Index| if w == v { 0 } else { 1 + row[1..].partition_point(|x| *x < w) as Index };
            places.extend(slots.iter().map(|&(e, _)| edges.vertices[e as usize].map(place)));
            columns.push(row.iter().copied());
        }
        Self { values: vec![0.0; columns.items().len()], columns, places }
    }

    /// Sums the rows for these weights and the D of `edges`.
    fn assemble(&mut self, edges: &Edges, alpha: f64, beta: f64) {
        let Self { columns, values, places } = self;
        let count = columns.len();
        let mut rest = &mut values[..];
        let mut runs = Vec::with_capacity(count.div_ceil(RUN));
        for start in (0..count).step_by(RUN) {
            let end = (start + RUN).min(count);
            let length = (start..end).map(|v| columns.get(v as Index).len()).sum();
            let (run, after) = rest.split_at_mut(length);
            runs.push((start..end, run));
            rest = after;
        }
        runs.into_par_iter().for_each(|(vertices, mut values)| {
            for v in vertices {
                let (row, after) = values.split_at_mut(columns.get(v as Index).len());
                values = after;
                row.fill(0.0);
                row[0] = 1.0;
                let slots = edges.at.range(v as Index);
                for (&(e, k), places) in edges.at.items()[slots.clone()].iter().zip(&places[slots]) {
                    let (d, k) = (&edges.coefficients[e as usize], usize::from(k));
                    let (fold, difference) = (alpha * FOLD[k], beta * d[k]);
                    for j in 0..4 {
                        row[places[j] as usize] += fold * FOLD[j] + difference * d[j];
                    }
                }
            }
        });
    }

    fn diagonal(&self) -> Vec<f64> {
        (0..self.columns.len()).map(|v| self.values[self.columns.range(v as Index).start]).collect()
    }

    /// Row `v` times `x`.
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
    use crate::progress::Silent;
    use crate::shapes;

    #[test]
    fn a_round_leaves_no_gradient_of_its_energy() {
        let surface = shapes::dented_sphere(2);
        let (faces, input) = (Faces::of(&surface), surface.positions());
        let start = Shapes::of(&faces, input);
        let mut edges = Edges::of(&faces, input.len());
        edges.measure(&faces, &start, input);
        let count = edges.vertices.len();
        let (bend, mean_edge) = (faces.mean_bend(&start), surface.mean_edge());
        let jump = |e: usize| edges.difference(input, e);
        let mut squares: Vec<f64> = (0..count).map(|e| jump(e).length_squared()).collect();
        squares.sort_unstable_by(f64::total_cmp);
        // One round with weights of size one, in which λ/β makes half of the edges flat.
        let (alpha, beta, threshold) = (2.0 * bend, 3.0, 0.5 * (squares[count / 2 - 1] + squares[count / 2]));
        let sparsity = threshold * beta / (0.2 * mean_edge.powi(2) * bend);
        let settings = L0 { alpha: 2.0, beta_min: beta, beta_max: 3.5, sparsity, ..L0::default() };
        let kept = |e: usize| if jump(e).length_squared() >= threshold { jump(e) } else { DVec3::ZERO };
        assert_eq!((0..count).filter(|&e| kept(e) == DVec3::ZERO).count(), count / 2);
        let deltas = deltas(&surface, &settings, &Silent).unwrap();
        let x: Vec<DVec3> = input.iter().zip(&deltas).map(|(p, delta)| *p - *delta).collect();
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
            let faces = Faces::of(&surface);
            let mut edges = Edges::of(&faces, surface.positions().len());
            edges.measure(&faces, &Shapes::of(&faces, surface.positions()), surface.positions());
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
        let faces = Faces::of(&sphere);
        let points = sphere.positions();
        let mut edges = Edges::of(&faces, points.len());
        edges.measure(&faces, &Shapes::of(&faces, points), points);
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
