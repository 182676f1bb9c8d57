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

use super::Boundary;
use super::conjugate_gradients::{Solve, solve};
use super::faces::{Faces, Shapes};
use super::vertex_update::{Updater, VertexUpdate};
use crate::progress::{Cancelled, Progress};
use crate::ragged::{Index, Ragged};
use crate::sparse::Csr;
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

/// Inner systems need not be solved to the end, since they change in each round.
const INNER: Solve = Solve { tolerance: 1e-3, steps: 20 };

/// The filtered normals. #T×3
fn filtered(
    operators: &Operators,
    input: &[DVec3],
    settings: &TgvNormals,
    bend: f64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let (fidelity, penalty) = (settings.fidelity / bend, PENALTY / bend);
    let (edges, lines) = (operators.edge_faces.len(), operators.lines.len());
    let of_normals = operators.of_normals([fidelity, penalty]);
    let of_field = operators.of_field();
    let mut normals = input.to_vec();
    let mut v = vec![DVec3::ZERO; edges];
    // What stands for ∇N − v and for E v, and the scaled multipliers.
    let (mut jumps, mut jump_duals) = (vec![DVec3::ZERO; edges], vec![DVec3::ZERO; edges]);
    let (mut bends, mut bend_duals) = (vec![DVec3::ZERO; lines], vec![DVec3::ZERO; lines]);
    let mut room = vec![DVec3::ZERO; lines];
    for done in 1..=settings.iterations {
        progress.check()?;
        let wanted: Vec<DVec3> = (0..edges).into_par_iter().map(|e| v[e] + jumps[e] - jump_duals[e]).collect();
        normals = operators.solve_normals(&of_normals, &wanted, input, normals, [fidelity, penalty], progress)?;
        normals.par_iter_mut().zip(input).for_each(|(n, n0)| *n = n.try_normalize().unwrap_or(*n0));
        let gradient = operators.gradient(&normals);
        let near: Vec<DVec3> = (0..edges).into_par_iter().map(|e| gradient[e] - jumps[e] + jump_duals[e]).collect();
        let wanted: Vec<DVec3> = (0..lines).into_par_iter().map(|l| bends[l] - bend_duals[l]).collect();
        v = operators.solve_field(&of_field, &near, &wanted, v, progress)?;
        jumps.par_iter_mut().zip(&mut jump_duals).enumerate().for_each(|(e, (jump, dual))| {
            let z = gradient[e] - v[e] + *dual;
            let weight = (-gradient[e].length_squared().powi(2)).exp();
            *jump = shrunk(z, weight / penalty);
            *dual = z - *jump;
        });
        operators.second_differences(&v, &mut room);
        bends.par_iter_mut().zip(&mut bend_duals).zip(&room).for_each(|((bend, dual), ev)| {
            let z = *ev + *dual;
            *bend = shrunk(z, settings.second_order / penalty);
            *dual = z - *bend;
        });
        progress.done(f64::from(done) / f64::from(settings.iterations) * 0.8);
    }
    Ok(normals)
}

/// argmin_y |y| · by + |y − x|² / 2
fn shrunk(x: DVec3, by: f64) -> DVec3 {
    let length = x.length();
    if length > by { x * ((length - by) / length) } else { DVec3::ZERO }
}

/// ∇ and E with their weights; lengths in mean edges.
struct Operators {
    areas: Vec<f64>,
    /// First minus second is the gradient.
    edge_faces: Vec<[Index; 2]>,
    edge_lengths: Vec<f64>,
    /// Edges of each face, and the sign of the face there.
    face_edges: Ragged<(Index, f64)>,
    /// Two edges with their signs, and the length.
    lines: Vec<([(Index, f64); 2], f64)>,
    /// Lines at each edge, and its sign there.
    edge_lines: Ragged<(Index, f64)>,
}

impl Operators {
    fn of(faces: &Faces, surface: &Surface, shapes: &Shapes) -> Self {
        let positions = surface.positions();
        let length = |&[a, b]: &[Index; 2]| positions[a as usize].distance(positions[b as usize]);
        let total: f64 = faces.pair_edges.iter().map(length).sum();
        let unit = if total > 0.0 { total / faces.pair_edges.len() as f64 } else { 1.0 };
        let sides = (0..).zip(&faces.pairs).flat_map(|(e, &[f, g])| [(f, (e, 1.0)), (g, (e, -1.0))]);
        let face_edges: Ragged<(Index, f64)> = Ragged::group(faces.len(), sides);
        let mut lines = Vec::with_capacity(3 * faces.len());
        for f in 0..faces.len() as Index {
            let own = face_edges.get(f);
            for (k, &first) in own.iter().enumerate() {
                for &second in &own[k + 1..] {
                    let [[a, b], [c, d]] = [first, second].map(|side| faces.pair_edges[side.0 as usize]);
                    let shared = if a == c || a == d { a } else { b };
                    let length = shapes.centroids[f as usize].distance(positions[shared as usize]) / unit;
                    lines.push(([first, second], length));
                }
            }
        }
        let at = (0..).zip(&lines).flat_map(|(l, (ends, _))| ends.map(|(e, sign)| (e, (l, sign))));
        let edge_lines = Ragged::group(faces.pairs.len(), at);
        Self {
            areas: shapes.areas.iter().map(|area| area / (unit * unit)).collect(),
            edge_faces: faces.pairs.clone(),
            edge_lengths: faces.pair_edges.iter().map(|ends| length(ends) / unit).collect(),
            face_edges,
            lines,
            edge_lines,
        }
    }

    /// ∇N. #E×3
    fn gradient(&self, normals: &[DVec3]) -> Vec<DVec3> {
        self.edge_faces.par_iter().map(|&[f, g]| normals[f as usize] - normals[g as usize]).collect()
    }

    /// E v. #L×3
    fn second_differences(&self, v: &[DVec3], out: &mut [DVec3]) {
        out.par_iter_mut().zip(&self.lines).with_min_len(2048).for_each(|(out, ([(d, s), (e, t)], _))| {
            *out = *s * v[*d as usize] + *t * v[*e as usize];
        });
    }

    /// A face without area or neighbours would have no equation.
    fn own(&self, face: usize, fidelity: f64) -> f64 {
        fidelity * self.areas[face].max(1e-9)
    }

    /// Edges without length would have no equation either.
    fn own_of_edge(&self, edge: usize) -> f64 {
        self.edge_lengths[edge].max(1e-9)
    }

    /// β A + r ∇ᵀ l ∇. #T×T
    fn of_normals(&self, [fidelity, penalty]: [f64; 2]) -> Csr {
        let own = (0..self.areas.len()).map(|f| (f as Index, f as Index, self.own(f, fidelity)));
        let sides = self.edge_faces.iter().zip(&self.edge_lengths).flat_map(move |(&[f, g], length)| {
            let w = penalty * length;
            [(f, f, w), (g, g, w), (f, g, -w), (g, f, -w)]
        });
        Csr::from_triplets(self.areas.len(), own.chain(sides))
    }

    /// l + Eᵀ l E. #E×E
    fn of_field(&self) -> Csr {
        let own = (0..self.edge_lengths.len()).map(|e| (e as Index, e as Index, self.own_of_edge(e)));
        let ends = self
            .lines
            .iter()
            .flat_map(|&([(d, s), (e, t)], w)| [(d, d, w), (e, e, w), (d, e, w * s * t), (e, d, w * s * t)]);
        Csr::from_triplets(self.edge_lengths.len(), own.chain(ends))
    }

    /// argmin_N β/2 Σ A |N − N⁰|² + r/2 Σ l |∇N − wanted|²
    fn solve_normals(
        &self,
        matrix: &Csr,
        wanted: &[DVec3],
        input: &[DVec3],
        guess: Vec<DVec3>,
        [fidelity, penalty]: [f64; 2],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let right = |f: usize| {
            let sides = self.face_edges.get(f as Index).iter();
            sides.fold(self.own(f, fidelity) * input[f], |sum, &(e, sign)| {
                sum + penalty * self.edge_lengths[e as usize] * sign * wanted[e as usize]
            })
        };
        let right: Vec<DVec3> = (0..input.len()).into_par_iter().map(right).collect();
        let system = |x: &[DVec3], out: &mut Vec<DVec3>| matrix.times_into(x, out);
        solve(system, matrix.diagonal(), &right, guess, INNER, progress)
    }

    /// argmin_v Σ l |v − near|² + Σ l |E v − wanted|²
    fn solve_field(
        &self,
        matrix: &Csr,
        near: &[DVec3],
        wanted: &[DVec3],
        guess: Vec<DVec3>,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let adjoint = |of_lines: &[DVec3], e: usize| {
            self.edge_lines
                .get(e as Index)
                .iter()
                .fold(DVec3::ZERO, |sum, &(l, sign)| sum + self.lines[l as usize].1 * sign * of_lines[l as usize])
        };
        let right: Vec<DVec3> =
            (0..near.len()).into_par_iter().map(|e| self.own_of_edge(e) * near[e] + adjoint(wanted, e)).collect();
        let system = |x: &[DVec3], out: &mut Vec<DVec3>| matrix.times_into(x, out);
        solve(system, matrix.diagonal(), &right, guess, INNER, progress)
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
        let mut out = vec![DVec3::ZERO; operators.lines.len()];
        operators.second_differences(&operators.gradient(&shapes.normals), &mut out);
        for (([d, e], _), found) in operators.lines.iter().zip(out) {
            let [[f, g], [h, i]] = [d, e].map(|side| operators.edge_faces[side.0 as usize]);
            let centre = if f == h || f == i { f } else { g };
            let others = [f, g, h, i].into_iter().filter(|face| *face != centre);
            let expected = others.fold(2.0 * shapes.normals[centre as usize], |s, g| s - shapes.normals[g as usize]);
            assert!(found.distance(expected) < 1e-15);
        }
    }
}
