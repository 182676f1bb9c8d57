//! Total generalised variation (TGV) of the face normals is minimised, then vertices follow.
//!
//! Zheng Liu, Yanlei Li, Weina Wang, Ligang Liu, Renjie Chen. Mesh total generalized variation for denoising. TVCG 28
//! (12), 2022 (online 2021).
//!
//! Minimises Σ_e lₑ wₑ |(∇N)ₑ − vₑ| + α Σ_l l_l |(E v)_l| + β/2 Σ_f A_f |N_f − N⁰_f|² over normals N and a field v on the
//! edges, by the alternating direction method of multipliers (ADMM). (∇N)ₑ is the difference of the normals across an edge;
//! v takes the part of it that is curvature, so that only jumps cost at first order. A line l joins the centroid of a
//! triangle to a corner, and (E v)_l is the difference of v between the two edges there, 2N_f − N_g − N_h where v = ∇N.
//!
//! The authors choose weights for each mesh. Here lengths are in mean edges and β is divided by γ, the mean absolute dihedral
//! angle of the input, so that more noise gets more smoothing. The weights wₑ = exp(−|∇N|⁴) preserve creases.

use super::boundary::Boundary;
use super::conjugate_gradients::{ConjugateGradients, Stop, multiply};
use super::face_geometry::FaceGeometry;
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::motion::Motion;
use super::parameters::{HUGE, Parameter, TINY};
use super::triangle_mesh::TriangleMesh;
use super::vertex_update::{self, Updater, VertexUpdate};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::TgvNormals`](super::Denoiser::TgvNormals).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TgvNormals {
    /// Rounds of the splitting.
    pub iterations: u32,
    /// β γ: how near normals stay to the input.
    pub fidelity: f64,
    /// α: how much curvature that changes costs against normals that jump.
    pub second_order: f64,
    /// How vertices follow.
    pub vertex_update: VertexUpdate,
}

impl Default for TgvNormals {
    /// Settings that suit parts with sharp edges and curved faces.
    fn default() -> Self {
        let vertex_update = VertexUpdate::paper(20, Boundary::Free).held();
        Self { iterations: 40, fidelity: 0.7, second_order: 0.4, vertex_update }
    }
}

/// Parameters of the filter; those of the vertex update come on top.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of steps of the normals"),
    Parameter::number(
        "fidelity",
        "/fidelity",
        [TINY, HUGE],
        "how near normals stay to the input, relative to how noisy they are",
    )
    .slider(4.0),
    Parameter::number(
        "second-order",
        "/second_order",
        [TINY, HUGE],
        "cost of curvature that changes, relative to normals that jump at an edge",
    )
    .label("second order")
    .slider(2.0),
];

impl DenoiseMethod for TgvNormals {
    const INFO: MethodInfo = MethodInfo {
        name: "tgv-normals",
        summary: "Total generalised variation of the face normals: for sharp edges between curved faces",
        reference: Some(Reference {
            cite: "Liu et al. 2021",
            title: "Mesh total generalized variation for denoising. TVCG 28 (12)",
        }),
        parameters: &[PARAMETERS, vertex_update::PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.vertex_update.motion)
    }
}

/// Filters the normals, lets the vertices follow and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(
    surface: &Surface,
    settings: &TgvNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let mesh = TriangleMesh::of(surface);
    let mut updater = Updater::new(surface, &mesh, settings.vertex_update);
    let geometry = FaceGeometry::of(&mesh, surface.positions());
    let dihedral_angle = geometry.mean_dihedral_angle(&mesh);
    let normals = if dihedral_angle > 0.0 {
        let operators = Operators::of(&mesh, surface, &geometry);
        filtered(&operators, &geometry.normals, settings, dihedral_angle, progress)?
    } else {
        geometry.normals
    };
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// Penalty of the splitting, times γ.
const PENALTY: f64 = 2.0;

/// Stopping criterion of the inner systems: they need not be solved exactly, since each round starts from the solution of
/// the last one.
const INNER: Stop = Stop { tolerance: 1e-2, max_steps: 20 };

/// Smallest number of items that a thread treats at a time.
const CHUNK: usize = 1024;

/// Filters the face normals by ADMM; `dihedral_angle` is γ. #T×3
fn filtered(
    operators: &Operators,
    input: &[DVec3],
    settings: &TgvNormals,
    dihedral_angle: f64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let Operators { areas, edge_faces, edge_lengths, divergence, lines, at_edges } = operators;
    let (fidelity, penalty) = (settings.fidelity / dihedral_angle, PENALTY / dihedral_angle);
    let normal_matrix = operators.normal_matrix(fidelity / penalty);
    let field_matrix = operators.field_matrix();
    let mut normal_solver = ConjugateGradients::new(&normal_matrix.diagonal);
    let mut field_solver = ConjugateGradients::new(&field_matrix.diagonal);
    let mut normals = input.to_vec();
    // Normals before they are made unit: the next solution is near to these.
    let mut unnormalised = input.to_vec();
    let mut v = vec![DVec3::ZERO; edge_faces.len()];
    // Splittings of ∇N − v and of E v.
    let mut first_order = vec![Splitting::default(); edge_faces.len()];
    let mut second_order = vec![Splitting::default(); lines.len()];
    for done in 1..=settings.iterations {
        progress.check()?;
        // argmin_N β A |N − N⁰|² + r l |∇N − v − target|²
        let sides = |x: &[DVec3], f: usize| {
            let data = fidelity / penalty * areas[f] * input[f];
            [data + divergence[f].times(|e| v[e] + first_order[e].target()), normal_matrix.times(f, x)]
        };
        let operator = |x: &[DVec3], out: &mut [DVec3]| multiply(x, out, |f| normal_matrix.times(f, x));
        normal_solver.solve(operator, &mut unnormalised, sides, INNER, progress)?;
        let slots = normals.par_iter_mut().zip(&unnormalised).zip(input).with_min_len(CHUNK);
        slots.for_each(|((n, x), n0)| *n = x.try_normalize().unwrap_or(*n0));
        // argmin_v l |∇N − v − target|² + l |E v − target|²
        let gradient = |e: usize| {
            let [f, g] = edge_faces[e];
            normals[f as usize] - normals[g as usize]
        };
        let sides = |x: &[DVec3], e: usize| {
            let data = edge_lengths[e] * (gradient(e) - first_order[e].target());
            [data + at_edges[e].times(|l| second_order[l].target()), field_matrix.times(e, x)]
        };
        let operator = |x: &[DVec3], out: &mut [DVec3]| multiply(x, out, |e| field_matrix.times(e, x));
        field_solver.solve(operator, &mut v, sides, INNER, progress)?;
        first_order.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(e, splitting)| {
            let gradient = gradient(e);
            let weight = (-gradient.length_squared().powi(2)).exp();
            splitting.update(gradient - v[e], weight / penalty);
        });
        second_order.par_iter_mut().zip(lines).with_min_len(CHUNK).for_each(|(splitting, line)| {
            splitting.update(line.times(|e| v[e]), settings.second_order / penalty);
        });
        progress.done(f64::from(done) / f64::from(settings.iterations) * 0.8);
    }
    Ok(normals)
}

/// ADMM splitting variable and scaled dual, stored as their sum: the variable is the soft-thresholded sum, the dual the
/// remainder.
#[derive(Clone, Copy, Default)]
struct Splitting {
    sum: DVec3,
    threshold: f64,
}

impl Splitting {
    /// Splitting variable, argmin_y |y| · threshold + |y − sum|² / 2.
    fn variable(&self) -> DVec3 {
        let squared = self.sum.length_squared();
        let by = self.threshold;
        if squared > by * by { self.sum * (1.0 - by / squared.sqrt()) } else { DVec3::ZERO }
    }

    /// Target of the expression that was split: the variable minus the dual.
    fn target(&self) -> DVec3 {
        2.0 * self.variable() - self.sum
    }

    /// Adds the constraint violation to the dual, and sets the threshold of the next variable.
    fn update(&mut self, expression: DVec3, threshold: f64) {
        self.sum += expression - self.variable();
        self.threshold = threshold;
    }
}

/// Row of a matrix with at most N entries; missing ones are stored as 0.
#[derive(Clone, Copy)]
struct Row<const N: usize> {
    columns: [Index; N],
    values: [f64; N],
}

impl<const N: usize> Row<N> {
    fn of(entries: impl IntoIterator<Item = (Index, f64)>) -> Self {
        let mut row = Self { columns: [0; N], values: [0.0; N] };
        let slots = row.columns.iter_mut().zip(&mut row.values);
        slots.zip(entries).for_each(|((column, value), entry)| (*column, *value) = entry);
        row
    }

    fn times(&self, x: impl Fn(usize) -> DVec3) -> DVec3 {
        self.columns.iter().zip(self.values).fold(DVec3::ZERO, |sum, (&j, w)| sum + w * x(j as usize))
    }
}

/// Square matrix with at most N off-diagonal entries in each row.
struct Matrix<const N: usize> {
    diagonal: Vec<f64>,
    others: Vec<Row<N>>,
}

impl<const N: usize> Matrix<N> {
    /// Product of row `i` and `x`.
    fn times(&self, i: usize, x: &[DVec3]) -> DVec3 {
        self.others[i].times(|j| x[j]) + self.diagonal[i] * x[i]
    }
}

/// The operators ∇ and E, and their adjoints with the weights; lengths are in mean edges.
struct Operators {
    /// Area of each face, square mean edges. #T
    areas: Vec<f64>,
    /// The two faces of each interior edge; the gradient is the normal of the first minus that of the second. #E×2
    edge_faces: Vec<[Index; 2]>,
    /// Length lₑ of each interior edge. #E
    edge_lengths: Vec<f64>,
    /// Weighted adjoint ∇ᵀ l of the gradient. #T×#E
    divergence: Vec<Row<3>>,
    /// Operator E, with three lines for each face, one opposite to each side; empty where a side has no other face. #L×#E
    lines: Vec<Row<2>>,
    /// Weighted adjoint Eᵀ l. #E×#L
    at_edges: Vec<Row<4>>,
}

impl Operators {
    fn of(mesh: &TriangleMesh, surface: &Surface, geometry: &FaceGeometry) -> Self {
        let positions = surface.positions();
        let length = |&[a, b]: &[Index; 2]| positions[a as usize].distance(positions[b as usize]);
        let total: f64 = mesh.edge_vertices.iter().map(length).sum();
        let unit = if total > 0.0 { total / mesh.edge_vertices.len() as f64 } else { 1.0 };
        // Faces without area and edges without length would have no equation.
        let areas = geometry.areas.iter().map(|area| (area / (unit * unit)).max(1e-9)).collect();
        let edge_lengths: Vec<f64> = mesh.edge_vertices.iter().map(|ends| (length(ends) / unit).max(1e-9)).collect();
        let sides = (0..).zip(&mesh.edge_faces).flat_map(|(e, &[f, g])| [(f, (e, 1.0)), (g, (e, -1.0))]);
        // Edges of each face, and the sign of the face in their gradients.
        let sides: Ragged<(Index, f64)> = Ragged::group(mesh.face_count(), sides);
        let weighted = |&(e, sign): &(Index, f64)| (e, sign * edge_lengths[e as usize]);
        let divergence = sides.iter().map(|own| Row::of(own.iter().map(weighted))).collect();
        let line = |l: usize| {
            let own = sides.get((l / 3) as Index);
            let [Some(first), Some(second)] = [l + 1, l + 2].map(|k| own.get(k % 3)) else {
                return (Row::of([]), 0.0);
            };
            let [[a, b], [c, d]] = [first, second].map(|side| mesh.edge_vertices[side.0 as usize]);
            let shared = if a == c || a == d { a } else { b };
            let length = geometry.centroids[l / 3].distance(positions[shared as usize]) / unit;
            (Row::of([*first, *second]), length)
        };
        let (lines, line_lengths): (Vec<_>, Vec<_>) = (0..3 * mesh.face_count()).into_par_iter().map(line).unzip();
        let at_edge = |e: usize| {
            Row::of(mesh.edge_faces[e].into_iter().flat_map(|f| {
                let near = (3 * f..3 * f + 3).map(|l| (l, lines[l as usize]));
                near.map(|(l, line): (Index, Row<2>)| {
                    let of_edge = line.columns.iter().zip(line.values).find(|(column, _)| **column == e as Index);
                    (l, of_edge.map_or(0.0, |(_, sign)| sign * line_lengths[l as usize]))
                })
                .filter(|(_, weight)| *weight != 0.0)
            }))
        };
        let at_edges = (0..mesh.edge_faces.len()).into_par_iter().map(at_edge).collect();
        Self { areas, edge_faces: mesh.edge_faces.clone(), edge_lengths, divergence, lines, at_edges }
    }

    /// Matrix κ A + ∇ᵀ l ∇ of the system for the normals, κ the fidelity. #T×#T
    fn normal_matrix(&self, fidelity: f64) -> Matrix<3> {
        let row = |(f, sides): (usize, &Row<3>)| {
            let own = fidelity * self.areas[f] + sides.values.iter().map(|w| w.abs()).sum::<f64>();
            let others = sides.columns.iter().zip(sides.values).filter(|side| side.1 != 0.0).map(|(&e, w)| {
                let pair = self.edge_faces[e as usize];
                (pair[usize::from(w > 0.0)], -w.abs())
            });
            (own, Row::of(others))
        };
        let (diagonal, others) = self.divergence.par_iter().enumerate().map(row).unzip();
        Matrix { diagonal, others }
    }

    /// Matrix l + Eᵀ l E of the system for the field. #E×#E
    fn field_matrix(&self) -> Matrix<4> {
        let row = |(e, at): (usize, &Row<4>)| {
            let own = self.edge_lengths[e] + at.values.iter().map(|w| w.abs()).sum::<f64>();
            let others = at.columns.iter().zip(at.values).filter(|line| line.1 != 0.0).map(|(&l, w)| {
                let line = self.lines[l as usize];
                let other = usize::from(line.columns[0] == e as Index);
                (line.columns[other], w * line.values[other])
            });
            (own, Row::of(others))
        };
        let (diagonal, others) = self.at_edges.par_iter().enumerate().map(row).unzip();
        Matrix { diagonal, others }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn second_differences_of_a_gradient_look_at_three_faces() {
        let sphere = shapes::dented_sphere(2);
        let mesh = TriangleMesh::of(&sphere);
        let geometry = FaceGeometry::of(&mesh, sphere.positions());
        let operators = Operators::of(&mesh, &sphere, &geometry);
        // Three corners of each face, none at a boundary.
        assert_eq!(operators.lines.len(), 3 * mesh.face_count());
        let gradient = |e: usize| {
            let [f, g] = operators.edge_faces[e];
            geometry.normals[f as usize] - geometry.normals[g as usize]
        };
        for line in &operators.lines {
            let [[f, g], [h, i]] = line.columns.map(|e| operators.edge_faces[e as usize]);
            let centre = if f == h || f == i { f } else { g };
            let others = [f, g, h, i].into_iter().filter(|face| *face != centre);
            let expected =
                others.fold(2.0 * geometry.normals[centre as usize], |s, g| s - geometry.normals[g as usize]);
            assert!(line.times(gradient).distance(expected) < 1e-15);
        }
    }
}
