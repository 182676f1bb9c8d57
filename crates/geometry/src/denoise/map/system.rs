//! The normal equations of one round, solved for positions and shape operators together by conjugate gradients.

use super::Prior;
use super::estimate::Net;
use super::prior::{Linear, RUN, Sides};
use crate::denoise::umbrella::Freedom;
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use glam::DVec3;
use rayon::prelude::*;

/// A symmetric matrix as (xx, yy, zz, √2 yz, √2 xz, √2 xy): the norm of these is that of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric([f64; 6]);

const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Symmetric {
    pub(super) fn times(&self, d: DVec3) -> DVec3 {
        let [xx, yy, zz, yz, xz, xy] = self.0;
        let e = d * HALF_ROOT;
        DVec3::new(xx * d.x + xy * e.y + xz * e.z, xy * e.x + yy * d.y + yz * e.z, xz * e.x + yz * e.y + zz * d.z)
    }
    fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    pub(super) fn minus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    fn dot(&self, other: &Self) -> f64 {
        let products = self.zip(other, |a, b| a * b).0;
        products.iter().sum()
    }
    pub(super) fn squared(&self) -> f64 {
        self.dot(self)
    }
}

/// The equations, and the room that solving them takes.
pub(super) struct System<'a> {
    net: &'a Net,
    freedom: &'a Freedom,
    /// 1/σ²
    data: f64,
    /// What is added to that across the normals.
    held: f64,
    /// 10⁻³ λ
    ridge: f64,
    /// τ/σ²
    spread: f64,
    vertex_normals: Vec<DVec3>,
    vertices: Vec<Row<DVec3>>,
    faces: Vec<Row<Symmetric>>,
    direction: Vec<DVec3>,
    shape_direction: Vec<Symmetric>,
    changes: Vec<DVec3>,
    pulls: Vec<[f64; 3]>,
    bends: Vec<DVec3>,
}

/// What conjugate gradients keep for each unknown.
#[derive(Clone, Copy, Default)]
struct Row<T> {
    residual: T,
    product: T,
    /// Of the diagonal of the system.
    inverse: f64,
}

/// Sums of runs in their order, so that the result does not depend on the number of threads.
fn total(runs: impl IndexedParallelIterator<Item = f64>) -> f64 {
    runs.collect::<Vec<f64>>().iter().sum()
}

/// A run of faces: its number, their rows, and the pulls on their corners.
type BendingRun<'a> = (usize, (&'a mut [Row<Symmetric>], &'a mut [[f64; 3]]));
/// A run of faces: their rows, directions, and shape operators.
type DescendingRun<'a> = ((&'a mut [Row<Symmetric>], &'a [Symmetric]), &'a mut [Symmetric]);

/// How uneven vertices lie in a mesh without noise, mean edges: lighter noise is no reason to even them out.
const UNEVEN: f64 = 0.2;

impl<'a> System<'a> {
    pub(super) fn new(net: &'a Net, freedom: &'a Freedom, data: f64, prior: &Prior) -> Self {
        let (vertices, faces) = (net.corners.len(), net.faces.len());
        Self {
            net,
            freedom,
            data,
            held: 0.0,
            ridge: 1e-3 * prior.strength,
            spread: prior.spread * data.min(UNEVEN.powi(-2)),
            vertex_normals: Vec::new(),
            vertices: vec![Row::default(); vertices],
            faces: vec![Row::default(); faces],
            direction: vec![DVec3::ZERO; vertices],
            shape_direction: vec![Symmetric::default(); faces],
            changes: vec![DVec3::ZERO; faces],
            pulls: vec![[0.0; 3]; faces],
            bends: vec![DVec3::ZERO; vertices],
        }
    }

    /// Weight of the data across the normals beyond that along them, for the rounds to come.
    pub(super) fn hold(&mut self, held: f64) {
        self.held = held;
    }

    /// Moves `way` and `shapes` towards the solution.
    #[expect(clippy::too_many_arguments, reason = "one round has that many ingredients")]
    pub(super) fn solve(
        &mut self,
        linear: &Linear,
        sides: &Sides,
        positions: &[DVec3],
        way: &mut [DVec3],
        shapes: &mut [Symmetric],
        steps: u32,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        // A thousandth in the norm of the residual: the next round linearises anew anyway.
        const ENOUGH: f64 = 1e-6;
        self.vertex_normals = self.net.vertex_normals(positions);
        self.condition(linear, sides);
        // The residual is minus the gradient at the place where the normals are linear.
        self.changes.copy_from_slice(&linear.normals);
        self.bend(linear, sides, shapes);
        self.relax(positions);
        self.gather(linear, way);
        let negate = |row: &mut Row<DVec3>| row.residual = -row.product;
        self.vertices.par_iter_mut().with_min_len(RUN).for_each(negate);
        self.faces
            .par_iter_mut()
            .with_min_len(RUN)
            .for_each(|row| row.residual = row.product.zip(&row.product, |a, _| -a));
        self.direction.fill(DVec3::ZERO);
        self.shape_direction.fill(Symmetric::default());
        let mut energy = self.energy();
        let first = energy;
        self.turn(0.0);
        for _ in 0..steps {
            if energy <= ENOUGH * first {
                break;
            }
            progress.check()?;
            let direction = std::mem::take(&mut self.direction);
            let shape_direction = std::mem::take(&mut self.shape_direction);
            linear.change(self.net, &direction, &mut self.changes);
            let mut curvature = self.bend(linear, sides, &shape_direction);
            self.relax(&direction);
            curvature += self.gather(linear, &direction);
            let step = energy / curvature;
            // Rounding is all that is left, or the numbers are beyond what can be summed.
            if curvature > 0.0 && step.is_finite() {
                way.par_iter_mut().zip(&direction).with_min_len(RUN).for_each(|(x, d)| *x += step * *d);
            }
            self.direction = direction;
            self.shape_direction = shape_direction;
            if !(curvature > 0.0 && step.is_finite()) {
                break;
            }
            let before = energy;
            energy = self.descend(shapes, step);
            self.turn(energy / before);
        }
        Ok(())
    }

    /// The diagonal, roughly.
    fn condition(&mut self, linear: &Linear, sides: &Sides) {
        let net = self.net;
        let weight = |f: Index| sides.all[net.sides.range(f)].iter().map(|side| side.turn).sum::<f64>();
        // Two of three directions lie across the normal.
        let (data, spread, ridge) = (self.data + 0.67 * self.held, self.spread, self.ridge);
        self.vertices.par_iter_mut().enumerate().with_min_len(RUN).for_each(|(v, row)| {
            let turning = net
                .corners
                .get(v as Index)
                .iter()
                .map(|&(f, k)| 0.5 * weight(f) * linear.gradients[f as usize][usize::from(k)].length_squared());
            row.inverse = 1.0 / (data + 0.7 * spread + turning.sum::<f64>());
        });
        self.faces.par_iter_mut().enumerate().with_min_len(RUN).for_each(|(f, row)| {
            let of_sides = &sides.all[net.sides.range(f as Index)];
            let sum: f64 = of_sides.iter().map(|s| 0.125 * s.turn * s.way.length_squared() + s.jump).sum();
            row.inverse = 1.0 / (ridge + sum);
        });
    }

    /// Second to fourth term for changes of the normals and these shape operators: their part of the product goes to the
    /// faces, the pull on each corner to `pulls`. Gives the product's inner product with the shape operators.
    fn bend(&mut self, linear: &Linear, sides: &Sides, shapes: &[Symmetric]) -> f64 {
        let Self { net, faces, changes, pulls, .. } = self;
        let ridge = self.ridge;
        let runs = faces.par_chunks_mut(RUN).zip(pulls.par_chunks_mut(RUN)).enumerate();
        let run = |(run, (rows, pulls)): BendingRun| {
            let mut inner = 0.0;
            for (i, (row, pulls)) in rows.iter_mut().zip(pulls).enumerate() {
                let f = run * RUN + i;
                let shape = shapes[f].0;
                let change = changes[f];
                let mut pull = DVec3::ZERO;
                let mut product = shape.map(|s| ridge * s);
                let range = net.sides.range(f as Index);
                for (&(_, g), side) in net.sides.items()[range.clone()].iter().zip(&sides.all[range]) {
                    let other = &shapes[g as usize].0;
                    let mut sum = [0.0; 6];
                    for k in 0..6 {
                        sum[k] = shape[k] + other[k];
                        product[k] += side.jump * (shape[k] - other[k]);
                    }
                    let (d, e) = (0.5 * side.way, 0.5 * HALF_ROOT * side.way);
                    let turn = DVec3::new(
                        change.x - changes[g as usize].x - (sum[0] * d.x + sum[5] * e.y + sum[4] * e.z),
                        change.y - changes[g as usize].y - (sum[5] * e.x + sum[1] * d.y + sum[3] * e.z),
                        change.z - changes[g as usize].z - (sum[4] * e.x + sum[3] * e.y + sum[2] * d.z),
                    ) * side.turn;
                    pull += turn;
                    product[0] -= turn.x * d.x;
                    product[1] -= turn.y * d.y;
                    product[2] -= turn.z * d.z;
                    product[3] -= turn.y * e.z + turn.z * e.y;
                    product[4] -= turn.x * e.z + turn.z * e.x;
                    product[5] -= turn.x * e.y + turn.y * e.x;
                }
                for k in 0..6 {
                    inner += shape[k] * product[k];
                }
                row.product = Symmetric(product);
                *pulls = linear.gradients[f].map(|g| -g.dot(pull));
            }
            inner
        };
        total(runs.map(run))
    }

    /// Last term: the umbrella of x without its part along the normal.
    fn relax(&mut self, x: &[DVec3]) {
        let Self { net, spread, vertex_normals, bends, .. } = self;
        bends.par_iter_mut().enumerate().with_min_len(RUN).for_each(|(v, bend)| {
            let umbrella = net.umbrella.at(x, v);
            let n = vertex_normals[v];
            *bend = *spread * (umbrella - n * n.dot(umbrella));
        });
    }

    /// Product at the vertices from pulls, bends and the data term of `x`. Gives its inner product with x.
    fn gather(&mut self, linear: &Linear, x: &[DVec3]) -> f64 {
        let Self { net, freedom, data, held, vertex_normals, vertices, pulls, bends, .. } = self;
        let run = |(run, rows): (usize, &mut [Row<DVec3>])| {
            let mut inner = 0.0;
            for (i, row) in rows.iter_mut().enumerate() {
                let v = run * RUN + i;
                let across = x[v].reject_from_normalized(vertex_normals[v]);
                let mut product = *data * x[v] + *held * across + net.umbrella.transposed_at(bends, v);
                for &(f, k) in net.corners.get(v as Index) {
                    product += pulls[f as usize][usize::from(k)] * linear.normals[f as usize];
                }
                row.product = freedom.projected(v, product);
                inner += x[v].dot(row.product);
            }
            inner
        };
        total(vertices.par_chunks_mut(RUN).enumerate().map(run))
    }

    /// |residual|² in the norm of the preconditioner.
    fn energy(&self) -> f64 {
        let of_vertices =
            |rows: &[Row<DVec3>]| rows.iter().map(|r| r.inverse * r.residual.length_squared()).sum::<f64>();
        let of_faces = |rows: &[Row<Symmetric>]| rows.iter().map(|r| r.inverse * r.residual.squared()).sum::<f64>();
        total(self.vertices.par_chunks(RUN).map(of_vertices)) + total(self.faces.par_chunks(RUN).map(of_faces))
    }

    /// Takes a step of the shape operators and of all residuals; gives the new energy.
    fn descend(&mut self, shapes: &mut [Symmetric], step: f64) -> f64 {
        let of_vertices = |rows: &mut [Row<DVec3>]| {
            rows.iter_mut().fold(0.0, |sum, row| {
                row.residual -= step * row.product;
                sum + row.inverse * row.residual.length_squared()
            })
        };
        let moved = total(self.vertices.par_chunks_mut(RUN).map(of_vertices));
        let runs =
            self.faces.par_chunks_mut(RUN).zip(self.shape_direction.par_chunks(RUN)).zip(shapes.par_chunks_mut(RUN));
        let of_faces = |((rows, directions), shapes): DescendingRun| {
            rows.iter_mut().zip(directions).zip(shapes).fold(0.0, |sum, ((row, direction), shape)| {
                *shape = shape.zip(direction, |s, d| s + step * d);
                row.residual = row.residual.zip(&row.product, |r, p| r - step * p);
                sum + row.inverse * row.residual.squared()
            })
        };
        moved + total(runs.map(of_faces))
    }

    /// The next direction: downhill, plus `turn` times the last one.
    fn turn(&mut self, turn: f64) {
        let vertices = self.direction.par_iter_mut().zip(&self.vertices).with_min_len(RUN);
        vertices.for_each(|(d, row)| *d = row.inverse * row.residual + turn * *d);
        let faces = self.shape_direction.par_iter_mut().zip(&self.faces).with_min_len(RUN);
        faces.for_each(|(d, row)| *d = d.zip(&row.residual, |d, r| row.inverse * r + turn * d));
    }
}

#[cfg(test)]
mod tests;
