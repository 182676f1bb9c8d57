//! Face normals of least total generalised variation, then vertices that follow.
//!
//! Zheng Liu, Yanlei Li, Weina Wang, Ligang Liu, Renjie Chen. Mesh total generalized variation for denoising. TVCG 28
//! (12), 2022 (online 2021).
//!
//! Minimises Σ_e lₑ wₑ |(∇N)ₑ − vₑ| + α Σ_l l_l |(E v)_l| + β/2 Σ_f A_f |N_f − N⁰_f|² over normals N and a field v on the
//! edges, by splitting and augmented Lagrangians. (∇N)ₑ is the difference of the normals across an edge; v takes what of
//! it is curvature, so that only jumps cost at first order. A line l joins the centroid of a triangle to a corner, and
//! (E v)_l is the difference of v between the two edges there, 2N_f − N_g − N_h where v = ∇N.
//!
//! The authors choose weights for each mesh. Here lengths are in mean edges and β is over γ, the mean absolute dihedral
//! angle of the input, so that more noise is given more smoothing. wₑ = exp(−|∇N|⁴) lets creases stand.

use super::conjugate_gradients::{Solve, Solver, by_rows};
use super::faces::{Faces, Shapes};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::{HUGE, Parameter, TINY};
use super::vertex_update::{self, Updater, VertexUpdate};
use super::{Boundary, Motion};
use crate::progress::{Cancelled, Progress};
use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
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
    /// What is good on parts with sharp edges and curved faces.
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

/// δ of the vertices that follow the filtered normals. #V×3, model units.
pub(super) fn deltas(
    surface: &Surface,
    settings: &TgvNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let faces = Faces::of(surface);
    let mut updater = Updater::new(surface, &faces, settings.vertex_update);
    let shapes = Shapes::of(&faces, surface.positions());
    let bend = faces.mean_bend(&shapes);
    let normals = if bend > 0.0 {
        filtered(&Operators::of(&faces, surface, &shapes), &shapes.normals, settings, bend, progress)?
    } else {
        shapes.normals
    };
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// Penalty of the splitting, times γ.
const PENALTY: f64 = 2.0;

/// Inner systems need not be solved to the end, since each round starts from the solution of the last.
const INNER: Solve = Solve { tolerance: 1e-2, steps: 20 };

/// Items that a thread treats at least.
const RUN: usize = 1024;

/// The filtered normals. #T×3
fn filtered(
    operators: &Operators,
    input: &[DVec3],
    settings: &TgvNormals,
    bend: f64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let Operators { areas, edge_faces, edge_lengths, divergence, lines, at_edges } = operators;
    let (fidelity, penalty) = (settings.fidelity / bend, PENALTY / bend);
    let of_normals = operators.of_normals(fidelity / penalty);
    let of_field = operators.of_field();
    let mut normals_solver = Solver::new(&of_normals.diagonal);
    let mut field_solver = Solver::new(&of_field.diagonal);
    let mut normals = input.to_vec();
    // The same before they are made unit: the next solution is near to these.
    let mut free = input.to_vec();
    let mut v = vec![DVec3::ZERO; edge_faces.len()];
    // Of ∇N − v and of E v.
    let mut jumps = vec![Split::default(); edge_faces.len()];
    let mut bends = vec![Split::default(); lines.len()];
    for done in 1..=settings.iterations {
        progress.check()?;
        // argmin_N β A |N − N⁰|² + r l |∇N − v − jump|²
        let sides = |x: &[DVec3], f: usize| {
            let own = fidelity / penalty * areas[f] * input[f];
            [own + divergence[f].times(|e| v[e] + jumps[e].target()), of_normals.times(f, x)]
        };
        let system = |x: &[DVec3], out: &mut [DVec3]| by_rows(x, out, |f| of_normals.times(f, x));
        normals_solver.solve(system, &mut free, sides, INNER, progress)?;
        let slots = normals.par_iter_mut().zip(&free).zip(input).with_min_len(RUN);
        slots.for_each(|((n, free), n0)| *n = free.try_normalize().unwrap_or(*n0));
        // argmin_v l |∇N − v − jump|² + l |E v − bend|²
        let gradient = |e: usize| {
            let [f, g] = edge_faces[e];
            normals[f as usize] - normals[g as usize]
        };
        let sides = |x: &[DVec3], e: usize| {
            let own = edge_lengths[e] * (gradient(e) - jumps[e].target());
            [own + at_edges[e].times(|l| bends[l].target()), of_field.times(e, x)]
        };
        let system = |x: &[DVec3], out: &mut [DVec3]| by_rows(x, out, |e| of_field.times(e, x));
        field_solver.solve(system, &mut v, sides, INNER, progress)?;
        jumps.par_iter_mut().enumerate().with_min_len(RUN).for_each(|(e, jump)| {
            let gradient = gradient(e);
            let weight = (-gradient.length_squared().powi(2)).exp();
            jump.update(gradient - v[e], weight / penalty);
        });
        bends.par_iter_mut().zip(lines).with_min_len(RUN).for_each(|(bend, line)| {
            bend.update(line.times(|e| v[e]), settings.second_order / penalty);
        });
        progress.done(f64::from(done) / f64::from(settings.iterations) * 0.8);
    }
    Ok(normals)
}

/// What stands for an expression in its norm, and the scaled multiplier of the two being equal. Their sum is all there is
/// to keep, since the first is the sum shrunk.
#[derive(Clone, Copy, Default)]
struct Split {
    sum: DVec3,
    threshold: f64,
}

impl Split {
    /// argmin_y |y| · threshold + |y − sum|² / 2
    fn part(&self) -> DVec3 {
        let squared = self.sum.length_squared();
        let by = self.threshold;
        if squared > by * by { self.sum * (1.0 - by / squared.sqrt()) } else { DVec3::ZERO }
    }

    /// What the expression is to be near to: the part less the multiplier.
    fn target(&self) -> DVec3 {
        2.0 * self.part() - self.sum
    }

    fn update(&mut self, expression: DVec3, threshold: f64) {
        self.sum += expression - self.part();
        self.threshold = threshold;
    }
}

/// Row of a matrix with that many entries at most; those that are missing are 0.
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

/// Square matrix with that many entries beside the diagonal in each row.
struct Matrix<const N: usize> {
    diagonal: Vec<f64>,
    others: Vec<Row<N>>,
}

impl<const N: usize> Matrix<N> {
    /// Row `i` times `x`.
    fn times(&self, i: usize, x: &[DVec3]) -> DVec3 {
        self.others[i].times(|j| x[j]) + self.diagonal[i] * x[i]
    }
}

/// ∇ and E, and their adjoints with the weights; lengths in mean edges.
struct Operators {
    areas: Vec<f64>,
    /// First minus second is the gradient.
    edge_faces: Vec<[Index; 2]>,
    edge_lengths: Vec<f64>,
    /// ∇ᵀ l. #T×#E
    divergence: Vec<Row<3>>,
    /// E: three lines for each face, one opposite to each side; empty where a side has no other face. #L×#E
    lines: Vec<Row<2>>,
    /// Eᵀ l. #E×#L
    at_edges: Vec<Row<4>>,
}

impl Operators {
    fn of(faces: &Faces, surface: &Surface, shapes: &Shapes) -> Self {
        let positions = surface.positions();
        let length = |&[a, b]: &[Index; 2]| positions[a as usize].distance(positions[b as usize]);
        let total: f64 = faces.pair_edges.iter().map(length).sum();
        let unit = if total > 0.0 { total / faces.pair_edges.len() as f64 } else { 1.0 };
        // Faces without area and edges without length would have no equation.
        let areas = shapes.areas.iter().map(|area| (area / (unit * unit)).max(1e-9)).collect();
        let edge_lengths: Vec<f64> = faces.pair_edges.iter().map(|ends| (length(ends) / unit).max(1e-9)).collect();
        let sides = (0..).zip(&faces.pairs).flat_map(|(e, &[f, g])| [(f, (e, 1.0)), (g, (e, -1.0))]);
        // Edges of each face, and the sign of the face there.
        let sides: Ragged<(Index, f64)> = Ragged::group(faces.len(), sides);
        let weighted = |&(e, sign): &(Index, f64)| (e, sign * edge_lengths[e as usize]);
        let divergence = sides.iter().map(|own| Row::of(own.iter().map(weighted))).collect();
        let line = |l: usize| {
            let own = sides.get((l / 3) as Index);
            let [Some(first), Some(second)] = [l + 1, l + 2].map(|k| own.get(k % 3)) else {
                return (Row::of([]), 0.0);
            };
            let [[a, b], [c, d]] = [first, second].map(|side| faces.pair_edges[side.0 as usize]);
            let shared = if a == c || a == d { a } else { b };
            let length = shapes.centroids[l / 3].distance(positions[shared as usize]) / unit;
            (Row::of([*first, *second]), length)
        };
        let (lines, line_lengths): (Vec<_>, Vec<_>) = (0..3 * faces.len()).into_par_iter().map(line).unzip();
        let at_edge = |e: usize| {
            Row::of(faces.pairs[e].into_iter().flat_map(|f| {
                let near = (3 * f..3 * f + 3).map(|l| (l, lines[l as usize]));
                near.map(|(l, line): (Index, Row<2>)| {
                    let of_edge = line.columns.iter().zip(line.values).find(|(column, _)| **column == e as Index);
                    (l, of_edge.map_or(0.0, |(_, sign)| sign * line_lengths[l as usize]))
                })
                .filter(|(_, weight)| *weight != 0.0)
            }))
        };
        let at_edges = (0..faces.pairs.len()).into_par_iter().map(at_edge).collect();
        Self { areas, edge_faces: faces.pairs.clone(), edge_lengths, divergence, lines, at_edges }
    }

    /// κ A + ∇ᵀ l ∇. #T×#T
    fn of_normals(&self, fidelity: f64) -> Matrix<3> {
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

    /// l + Eᵀ l E. #E×#E
    fn of_field(&self) -> Matrix<4> {
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
    use crate::shapes;

    #[test]
    fn second_differences_of_a_gradient_look_at_three_faces() {
        let sphere = shapes::dented_sphere(2);
        let faces = Faces::of(&sphere);
        let shapes = Shapes::of(&faces, sphere.positions());
        let operators = Operators::of(&faces, &sphere, &shapes);
        // Three corners of each face, none at a boundary.
        assert_eq!(operators.lines.len(), 3 * faces.len());
        let gradient = |e: usize| {
            let [f, g] = operators.edge_faces[e];
            shapes.normals[f as usize] - shapes.normals[g as usize]
        };
        for line in &operators.lines {
            let [[f, g], [h, i]] = line.columns.map(|e| operators.edge_faces[e as usize]);
            let centre = if f == h || f == i { f } else { g };
            let others = [f, g, h, i].into_iter().filter(|face| *face != centre);
            let expected = others.fold(2.0 * shapes.normals[centre as usize], |s, g| s - shapes.normals[g as usize]);
            assert!(line.times(gradient).distance(expected) < 1e-15);
        }
    }
}
