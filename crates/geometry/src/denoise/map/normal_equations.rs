//! The normal equations of one round, solved for positions and shape operators together by conjugate gradients.
//!
//! All is in single precision: a round only steers towards the next one, and the time goes into reading memory.

use super::Prior;
use super::edge_weights::HalfEdgeWeights;
use super::linearised_normals::LinearisedNormals;
use super::symmetric::Symmetric;
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::conjugate_gradients::{CHUNK, ConjugateGradients, Stop, Vector, sum_in_order};
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// Unknowns of the estimate.
#[derive(Clone)]
pub(super) struct Unknowns {
    /// Position minus input of each vertex. #V×3, mean edges
    pub(super) offsets: Vec<Vec3A>,
    /// Shape operator of each face, 1/mean edge. #T
    pub(super) shape_operators: Vec<Symmetric>,
}

impl Unknowns {
    fn zero(connectivity: &Connectivity) -> Self {
        Self {
            offsets: vec![Vec3A::ZERO; connectivity.corners.len()],
            shape_operators: vec![Symmetric::default(); connectivity.mesh.face_count()],
        }
    }
}

/// Inverse of the preconditioner's diagonal for [`Unknowns`].
pub(super) struct InverseDiagonal {
    vertices: Vec<f32>,
    faces: Vec<f32>,
}

impl Vector for Unknowns {
    type InverseDiagonal = InverseDiagonal;

    fn set_zero(&mut self) {
        self.offsets.set_zero();
        self.shape_operators.set_zero();
    }

    fn axpy(&mut self, alpha: f64, y: &Self) {
        self.offsets.axpy(alpha, &y.offsets);
        self.shape_operators.axpy(alpha, &y.shape_operators);
    }

    fn axpy_norm2(&mut self, alpha: f64, y: &Self, inverse: &InverseDiagonal) -> f64 {
        self.offsets.axpy_norm2(alpha, &y.offsets, &inverse.vertices)
            + self.shape_operators.axpy_norm2(alpha, &y.shape_operators, &inverse.faces)
    }

    fn precondition(&mut self, residual: &Self, beta: f64, inverse: &InverseDiagonal) {
        self.offsets.precondition(&residual.offsets, beta, &inverse.vertices);
        self.shape_operators.precondition(&residual.shape_operators, beta, &inverse.faces);
    }

    fn weighted_norm2(&self, inverse: &InverseDiagonal) -> f64 {
        self.offsets.weighted_norm2(&inverse.vertices) + self.shape_operators.weighted_norm2(&inverse.faces)
    }
}

/// Constants of one round: the point of linearisation and the weights there.
#[derive(Clone, Copy)]
pub(super) struct Linearisation<'a> {
    /// Normals, linear in the positions.
    pub(super) normals: &'a LinearisedNormals,
    /// Weights of the half-edges.
    pub(super) weights: &'a HalfEdgeWeights,
    /// Where the normals are linearised. #V×3, mean edges
    pub(super) positions: &'a [DVec3],
}

/// The normal equations, with work vectors for one round after the other.
pub(super) struct NormalEquations<'a> {
    operator: Operator<'a>,
    solver: ConjugateGradients<Unknowns>,
}

impl<'a> NormalEquations<'a> {
    /// Equations for data with these weights.
    pub(super) fn new(
        connectivity: &'a Connectivity,
        constraint: &'a BoundaryConstraint,
        data: DataWeights,
        prior: &Prior,
    ) -> Self {
        let zero = Unknowns::zero(connectivity);
        let inverse =
            InverseDiagonal { vertices: vec![0.0; zero.offsets.len()], faces: vec![0.0; zero.shape_operators.len()] };
        Self {
            operator: Operator::new(connectivity, constraint, data, prior),
            solver: ConjugateGradients::with(inverse, zero),
        }
    }

    /// Sets how much of the tangential weights of the data counts in the rounds to come, 0..=1.
    pub(super) fn set_tangential_share(&mut self, share: f64) {
        self.operator.tangential_share = share as f32;
    }

    /// Moves the unknowns towards the solution, in `max_steps` steps of conjugate gradients at most.
    pub(super) fn solve(
        &mut self,
        at: &Linearisation,
        unknowns: &mut Unknowns,
        max_steps: u32,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        // Relative to the first residual. A more exact solution is not worth its time: the next round linearises anew.
        let stop = Stop { tolerance: 1e-3, max_steps: max_steps as usize };
        let Self { operator, solver } = self;
        operator.set_vertex_normals(&operator.connectivity.vertex_normals(at.positions));
        operator.build_preconditioner(at, &mut solver.inverse_diagonal);
        // The residual is minus the gradient of the energy.
        operator.gradient(at, unknowns, &mut solver.residual);
        solver.residual.offsets.par_iter_mut().with_min_len(CHUNK).for_each(|r| *r = -*r);
        solver.residual.shape_operators.par_iter_mut().with_min_len(CHUNK).for_each(|r| *r = *r * -1.0);
        let norm2 = solver.residual.weighted_norm2(&solver.inverse_diagonal);
        solver.iterate(|x, out| operator.apply(at, x, out), unknowns, [norm2; 2], stop, progress)
    }
}

/// Irregularity of the vertex spacing that meshes without noise have too, local edges: lighter noise is no reason to even
/// the vertices out.
const TYPICAL_IRREGULARITY: f64 = 0.2;

/// Weights of the terms at a vertex; lengths are in mean edges.
#[derive(Clone, Copy)]
struct DataWeight {
    /// Weight of the data in all directions, 1/σ².
    all: f32,
    /// Weight of the data in tangential directions beyond `all`.
    tangential: f32,
    /// Weight of the tangential umbrella, τ min(1/σ², 1/(h/5)²), with h the length of the local edges.
    spread: f32,
}

/// Weights of the terms at the vertices. #V
pub(super) struct DataWeights(Vec<DataWeight>);

impl DataWeights {
    pub(super) fn of(noise: &NoiseField, prior: &Prior) -> Self {
        let mean_edge = noise.mean_edge();
        let of_vertex = |((sigma, stiffness), edge): ((f64, &f64), &f64)| {
            let all = (mean_edge / sigma).powi(2);
            let least = (mean_edge / (TYPICAL_IRREGULARITY * edge)).powi(2);
            let spread = prior.spread * all.min(least);
            // A vertex without noise is held by the constraint; its weight need only be finite.
            let weight = |x: f64| (x as f32).min(f32::MAX.sqrt());
            DataWeight { all: weight(all), tangential: weight(all * stiffness), spread: weight(spread) }
        };
        Self(noise.sigma().zip(&noise.stiffness).zip(&noise.edge).map(of_vertex).collect())
    }
}

/// The quadratic form of the energy around a linearisation, applied without storing its matrix.
struct Operator<'a> {
    connectivity: &'a Connectivity,
    constraint: &'a BoundaryConstraint,
    /// The umbrella operator U and its transpose.
    umbrella: [Csr<f32>; 2],
    data: DataWeights,
    /// Fraction of the tangential weights of the data that counts.
    tangential_share: f32,
    /// Weight of the shape operators themselves, 10⁻³ λ, which makes the system definite.
    ridge: f32,
    /// Unit normals at the point of linearisation. #V×3
    vertex_normals: Vec<Vec3A>,
    /// Normal changes dn that go with the offsets. #T×3
    normal_changes: Vec<Vec3A>,
    /// Force on each corner along the normal of its triangle. #T×3
    corner_forces: Vec<[f32; 3]>,
    /// Weighted tangential umbrella vector of each vertex. #V×3
    umbrella_forces: Vec<Vec3A>,
}

/// One chunk of faces: its number, and for its faces the output and the forces on the corners.
type FaceChunk<'a> = (usize, (&'a mut [Symmetric], &'a mut [[f32; 3]]));

impl<'a> Operator<'a> {
    fn new(
        connectivity: &'a Connectivity,
        constraint: &'a BoundaryConstraint,
        data: DataWeights,
        prior: &Prior,
    ) -> Self {
        let (vertices, faces) = (connectivity.corners.len(), connectivity.mesh.face_count());
        Self {
            connectivity,
            constraint,
            umbrella: connectivity.umbrella.in_single_precision(),
            data,
            tangential_share: 0.0,
            ridge: 1e-3 * prior.strength as f32,
            vertex_normals: Vec::new(),
            normal_changes: vec![Vec3A::ZERO; faces],
            corner_forces: vec![[0.0; 3]; faces],
            umbrella_forces: vec![Vec3A::ZERO; vertices],
        }
    }

    fn set_vertex_normals(&mut self, normals: &[DVec3]) {
        self.vertex_normals.clear();
        self.vertex_normals.extend(normals.iter().map(|n| n.as_vec3a()));
    }

    /// Half the gradient of the energy at the point of linearisation, where `unknowns` are.
    fn gradient(&mut self, at: &Linearisation, unknowns: &Unknowns, out: &mut Unknowns) {
        self.normal_changes.copy_from_slice(&at.normals.normals);
        self.apply_bending(at, &unknowns.shape_operators, &mut out.shape_operators);
        let umbrella = |v| self.connectivity.umbrella.at(at.positions, v).as_vec3a();
        write_umbrella_forces(umbrella, &self.data, &self.vertex_normals, &mut self.umbrella_forces);
        self.assemble_vertices(at, &unknowns.offsets, &mut out.offsets);
    }

    /// Writes A x into `out` and returns xᵀ A x; A is half the Hessian of the energy.
    fn apply(&mut self, at: &Linearisation, x: &Unknowns, out: &mut Unknowns) -> f64 {
        at.normals.apply_jacobian(self.connectivity, &x.offsets, &mut self.normal_changes);
        let of_faces = self.apply_bending(at, &x.shape_operators, &mut out.shape_operators);
        let umbrella = |v| self.umbrella[0].row_times(v, &x.offsets);
        write_umbrella_forces(umbrella, &self.data, &self.vertex_normals, &mut self.umbrella_forces);
        of_faces + self.assemble_vertices(at, &x.offsets, &mut out.offsets)
    }

    /// Inverse of an estimate of the diagonal of A.
    fn build_preconditioner(&self, at: &Linearisation, inverse: &mut InverseDiagonal) {
        let Self { connectivity, ref data, tangential_share, ridge, .. } = *self;
        let weights = &at.weights.all;
        let of_face = |f: Index| weights[connectivity.half_edges.range(f)].iter().map(|w| w.normal_weight).sum::<f32>();
        inverse.vertices.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, inverse)| {
            let bending =
                connectivity.corners.get(v as Index).iter().map(|&(f, k)| {
                    0.5 * of_face(f) * at.normals.gradients[f as usize][usize::from(k)].length_squared()
                });
            // Two of three directions are tangential, and the diagonal of UᵀU is little more than one.
            let DataWeight { all, tangential, spread } = data.0[v];
            let of_data = all + 0.67 * tangential_share * tangential + 0.7 * spread;
            *inverse = 1.0 / (of_data + bending.sum::<f32>());
        });
        inverse.faces.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(f, inverse)| {
            let half_edges = &weights[connectivity.half_edges.range(f as Index)];
            let of_half_edges = half_edges
                .iter()
                .map(|w| 0.125 * w.normal_weight * w.centroid_offset.length_squared() + w.shape_operator_weight);
            *inverse = 1.0 / (ridge + of_half_edges.sum::<f32>());
        });
    }

    /// Terms of the prior for the normal changes and `shape_operators` (#T): their part of the product goes to `out`, the
    /// force on each corner to `corner_forces`. Returns the inner product of `shape_operators` and `out`.
    fn apply_bending(&mut self, at: &Linearisation, shape_operators: &[Symmetric], out: &mut [Symmetric]) -> f64 {
        let mut corner_forces = std::mem::take(&mut self.corner_forces);
        let chunks = out.par_chunks_mut(CHUNK).zip(corner_forces.par_chunks_mut(CHUNK)).enumerate();
        let inner = sum_in_order(chunks.map(|(chunk, (out, corner_forces)): FaceChunk| {
            let mut inner = 0.0;
            for (f, (out, corner_forces)) in (chunk * CHUNK..).zip(out.iter_mut().zip(corner_forces)) {
                let (product, force) = self.bending_of_face(at, shape_operators, f);
                inner += f64::from(shape_operators[f].dot(product));
                *out = product;
                *corner_forces = at.normals.gradients[f].map(|g| -g.dot(force));
            }
            inner
        }));
        self.corner_forces = corner_forces;
        inner
    }

    /// Product of one face's row, and the derivative with respect to the face's normal. With the jump
    /// j = dnᵢ − dnⱼ − ½ (Sᵢ + Sⱼ) (cᵢ − cⱼ) of each half-edge, the row of Sᵢ is −½ wₑ sym(j (cᵢ − cⱼ)ᵀ) + vₑ (Sᵢ − Sⱼ).
    #[inline]
    fn bending_of_face(&self, at: &Linearisation, shape_operators: &[Symmetric], f: usize) -> (Symmetric, Vec3A) {
        let own = shape_operators[f];
        let change = self.normal_changes[f];
        let mut force = Vec3A::ZERO;
        let mut product = own * self.ridge;
        for half_edge in &at.weights.all[self.connectivity.half_edges.range(f as Index)] {
            let g = half_edge.other as usize;
            let other = shape_operators[g];
            let half_offset = 0.5 * half_edge.centroid_offset;
            let predicted = (own + other).times(half_offset);
            let jump = (change - self.normal_changes[g] - predicted) * half_edge.normal_weight;
            force += jump;
            product = product + (own - other) * half_edge.shape_operator_weight - Symmetric::outer(jump, half_offset);
        }
        (product, force)
    }

    /// Rows of the vertices: the data term of `x` (#V×3), corner forces and umbrella forces. Returns the inner product of `x`
    /// and `out`.
    fn assemble_vertices(&self, at: &Linearisation, x: &[Vec3A], out: &mut [Vec3A]) -> f64 {
        let Self { connectivity, constraint, data, tangential_share, vertex_normals, corner_forces, .. } = self;
        let of_chunk = |(chunk, out): (usize, &mut [Vec3A])| {
            let mut inner = 0.0;
            for (v, out) in (chunk * CHUNK..).zip(out) {
                let in_plane = x[v].reject_from_normalized(vertex_normals[v]);
                let umbrella = self.umbrella[1].row_times(v, &self.umbrella_forces);
                let data = &data.0[v];
                let mut product = data.all * x[v] + *tangential_share * data.tangential * in_plane + umbrella;
                for &(f, k) in connectivity.corners.get(v as Index) {
                    product += corner_forces[f as usize][usize::from(k)] * at.normals.normals[f as usize];
                }
                *out = if constraint.holds(v) { Vec3A::ZERO } else { product };
                inner += f64::from(x[v].dot(*out));
            }
            inner
        };
        sum_in_order(out.par_chunks_mut(CHUNK).enumerate().map(of_chunk))
    }
}

/// Last term of the energy: weighted umbrella vectors (`umbrella` of each vertex) without their parts along the normals.
fn write_umbrella_forces(
    umbrella: impl Fn(usize) -> Vec3A + Sync,
    data: &DataWeights,
    normals: &[Vec3A],
    forces: &mut [Vec3A],
) {
    forces.par_iter_mut().zip(normals).zip(&data.0).enumerate().with_min_len(CHUNK).for_each(
        |(v, ((force, n), data))| {
            let umbrella = umbrella(v);
            *force = data.spread * (umbrella - *n * n.dot(umbrella));
        },
    );
}

#[cfg(test)]
mod tests;
