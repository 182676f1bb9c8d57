//! The normal equations of one round, solved for positions and shape operators together by conjugate gradients.

use super::Prior;
use super::edge_weights::HalfEdgeWeights;
use super::linearised_normals::LinearisedNormals;
use super::symmetric::{HALF_ROOT, Symmetric};
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::conjugate_gradients::{CHUNK, ConjugateGradients, Stop, Vector, sum_in_order};
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// Unknowns of the estimate.
#[derive(Clone)]
pub(super) struct Unknowns {
    /// Position minus input of each vertex. #V×3, mean edges
    pub(super) offsets: Vec<DVec3>,
    /// Shape operator of each face, 1/mean edge. #T
    pub(super) shape_operators: Vec<Symmetric>,
}

impl Unknowns {
    fn zero(connectivity: &Connectivity) -> Self {
        Self {
            offsets: vec![DVec3::ZERO; connectivity.corners.len()],
            shape_operators: vec![Symmetric::default(); connectivity.mesh.face_count()],
        }
    }
}

/// Inverse of the preconditioner's diagonal for [`Unknowns`].
pub(super) struct InverseDiagonal {
    vertices: Vec<f64>,
    faces: Vec<f64>,
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
        self.operator.tangential_share = share;
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
        operator.vertex_normals = operator.connectivity.vertex_normals(at.positions);
        operator.build_preconditioner(at, &mut solver.inverse_diagonal);
        // The residual is minus the gradient of the energy.
        operator.gradient(at, unknowns, &mut solver.residual);
        solver.residual.offsets.par_iter_mut().with_min_len(CHUNK).for_each(|r| *r = -*r);
        solver.residual.shape_operators.par_iter_mut().with_min_len(CHUNK).for_each(|r| r.0 = r.0.map(|x| -x));
        let norm2 = solver.residual.weighted_norm2(&solver.inverse_diagonal);
        solver.iterate(|x, out| operator.apply(at, x, out), unknowns, [norm2; 2], stop, progress)
    }
}

/// Irregularity of the vertex spacing that meshes without noise have too, local edges: lighter noise is no reason to even
/// the vertices out.
const TYPICAL_IRREGULARITY: f64 = 0.2;

/// Weights of the terms at the vertices; lengths are in mean edges.
pub(super) struct DataWeights {
    /// Weight of the data in all directions, 1/σ². #V
    all: Vec<f64>,
    /// Weight of the data in tangential directions beyond `all`. #V
    tangential: Vec<f64>,
    /// Weight of the tangential umbrella, τ min(1/σ², 1/(h/5)²), with h the length of the local edges. #V
    spread: Vec<f64>,
}

impl DataWeights {
    pub(super) fn of(noise: &NoiseField, prior: &Prior) -> Self {
        let mean_edge = noise.mean_edge();
        let all: Vec<f64> = noise.sigma().map(|sigma| (mean_edge / sigma).powi(2)).collect();
        let tangential = all.iter().zip(&noise.stiffness).map(|(weight, stiffness)| weight * stiffness).collect();
        let least = |edge: f64| (mean_edge / (TYPICAL_IRREGULARITY * edge)).powi(2);
        let spread =
            all.iter().zip(&noise.edge).map(|(weight, edge)| prior.spread * weight.min(least(*edge))).collect();
        Self { all, tangential, spread }
    }
}

/// The quadratic form of the energy around a linearisation, applied without storing its matrix.
struct Operator<'a> {
    connectivity: &'a Connectivity,
    constraint: &'a BoundaryConstraint,
    data: DataWeights,
    /// Fraction of the tangential weights of the data that counts.
    tangential_share: f64,
    /// Weight of the shape operators themselves, 10⁻³ λ, which makes the system definite.
    ridge: f64,
    /// Unit normals at the point of linearisation. #V×3
    vertex_normals: Vec<DVec3>,
    /// Normal changes dn that go with the offsets. #T×3
    normal_changes: Vec<DVec3>,
    /// Force on each corner along the normal of its triangle. #T×3
    corner_forces: Vec<[f64; 3]>,
    /// Weighted tangential umbrella vector of each vertex. #V×3
    umbrella_forces: Vec<DVec3>,
}

/// One chunk of faces: its number, and for its faces the output and the forces on the corners.
type FaceChunk<'a> = (usize, (&'a mut [Symmetric], &'a mut [[f64; 3]]));

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
            data,
            tangential_share: 0.0,
            ridge: 1e-3 * prior.strength,
            vertex_normals: Vec::new(),
            normal_changes: vec![DVec3::ZERO; faces],
            corner_forces: vec![[0.0; 3]; faces],
            umbrella_forces: vec![DVec3::ZERO; vertices],
        }
    }

    /// Half the gradient of the energy at the point of linearisation, where `unknowns` are.
    fn gradient(&mut self, at: &Linearisation, unknowns: &Unknowns, out: &mut Unknowns) {
        self.normal_changes.copy_from_slice(&at.normals.normals);
        self.apply_bending(at, &unknowns.shape_operators, &mut out.shape_operators);
        self.apply_tangential(at.positions);
        self.assemble_vertices(at, &unknowns.offsets, &mut out.offsets);
    }

    /// Writes A x into `out` and returns xᵀ A x; A is half the Hessian of the energy.
    fn apply(&mut self, at: &Linearisation, x: &Unknowns, out: &mut Unknowns) -> f64 {
        at.normals.apply_jacobian(self.connectivity, &x.offsets, &mut self.normal_changes);
        let of_faces = self.apply_bending(at, &x.shape_operators, &mut out.shape_operators);
        self.apply_tangential(&x.offsets);
        of_faces + self.assemble_vertices(at, &x.offsets, &mut out.offsets)
    }

    /// Inverse of an estimate of the diagonal of A.
    fn build_preconditioner(&self, at: &Linearisation, inverse: &mut InverseDiagonal) {
        let Self { connectivity, ref data, tangential_share, ridge, .. } = *self;
        let weights = &at.weights.all;
        let of_face = |f: Index| weights[connectivity.half_edges.range(f)].iter().map(|w| w.normal_weight).sum::<f64>();
        inverse.vertices.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, inverse)| {
            let bending =
                connectivity.corners.get(v as Index).iter().map(|&(f, k)| {
                    0.5 * of_face(f) * at.normals.gradients[f as usize][usize::from(k)].length_squared()
                });
            // Two of three directions are tangential, and the diagonal of UᵀU is little more than one.
            let of_data = data.all[v] + 0.67 * tangential_share * data.tangential[v] + 0.7 * data.spread[v];
            *inverse = 1.0 / (of_data + bending.sum::<f64>());
        });
        inverse.faces.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(f, inverse)| {
            let half_edges = &weights[connectivity.half_edges.range(f as Index)];
            let of_half_edges = half_edges
                .iter()
                .map(|w| 0.125 * w.normal_weight * w.centroid_offset.length_squared() + w.shape_operator_weight);
            *inverse = 1.0 / (ridge + of_half_edges.sum::<f64>());
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
                for (s, p) in shape_operators[f].0.iter().zip(product) {
                    inner += s * p;
                }
                *out = Symmetric(product);
                *corner_forces = at.normals.gradients[f].map(|g| -g.dot(force));
            }
            inner
        }));
        self.corner_forces = corner_forces;
        inner
    }

    /// Product of one face's row, and the derivative with respect to the face's normal. With the jump
    /// j = dnᵢ − dnⱼ − ½ (Sᵢ + Sⱼ) (cᵢ − cⱼ) of each half-edge, the row of Sᵢ is −½ wₑ sym(j (cᵢ − cⱼ)ᵀ) + vₑ (Sᵢ − Sⱼ); it
    /// is written out for the six numbers of [`Symmetric`], which is twice as fast.
    #[inline]
    fn bending_of_face(&self, at: &Linearisation, shape_operators: &[Symmetric], f: usize) -> ([f64; 6], DVec3) {
        let own = shape_operators[f].0;
        let change = self.normal_changes[f];
        let mut force = DVec3::ZERO;
        let mut product = own.map(|s| self.ridge * s);
        let half_edges = &self.connectivity.half_edges;
        let range = half_edges.range(f as Index);
        for (&(_, g), weight) in half_edges.items()[range.clone()].iter().zip(&at.weights.all[range]) {
            let other = &shape_operators[g as usize].0;
            let mut sum = [0.0; 6];
            for k in 0..6 {
                sum[k] = own[k] + other[k];
                product[k] += weight.shape_operator_weight * (own[k] - other[k]);
            }
            let (d, e) = (0.5 * weight.centroid_offset, 0.5 * HALF_ROOT * weight.centroid_offset);
            let other_change = self.normal_changes[g as usize];
            let jump = DVec3::new(
                change.x - other_change.x - (sum[0] * d.x + sum[5] * e.y + sum[4] * e.z),
                change.y - other_change.y - (sum[5] * e.x + sum[1] * d.y + sum[3] * e.z),
                change.z - other_change.z - (sum[4] * e.x + sum[3] * e.y + sum[2] * d.z),
            ) * weight.normal_weight;
            force += jump;
            product[0] -= jump.x * d.x;
            product[1] -= jump.y * d.y;
            product[2] -= jump.z * d.z;
            product[3] -= jump.y * e.z + jump.z * e.y;
            product[4] -= jump.x * e.z + jump.z * e.x;
            product[5] -= jump.x * e.y + jump.y * e.x;
        }
        (product, force)
    }

    /// Last term of the energy: weighted umbrella vectors of `x` (#V×3) without their parts along the normals.
    fn apply_tangential(&mut self, x: &[DVec3]) {
        let Self { connectivity, data, vertex_normals, umbrella_forces, .. } = self;
        umbrella_forces.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, force)| {
            let umbrella = connectivity.umbrella.at(x, v);
            let n = vertex_normals[v];
            *force = data.spread[v] * (umbrella - n * n.dot(umbrella));
        });
    }

    /// Rows of the vertices: the data term of `x` (#V×3), corner forces and umbrella forces. Returns the inner product of `x`
    /// and `out`.
    fn assemble_vertices(&self, at: &Linearisation, x: &[DVec3], out: &mut [DVec3]) -> f64 {
        let Self { connectivity, constraint, data, tangential_share, vertex_normals, corner_forces, .. } = self;
        let of_chunk = |(chunk, out): (usize, &mut [DVec3])| {
            let mut inner = 0.0;
            for (v, out) in (chunk * CHUNK..).zip(out) {
                let in_plane = x[v].reject_from_normalized(vertex_normals[v]);
                let umbrella = connectivity.umbrella.transposed_at(&self.umbrella_forces, v);
                let tangential = *tangential_share * data.tangential[v];
                let mut product = data.all[v] * x[v] + tangential * in_plane + umbrella;
                for &(f, k) in connectivity.corners.get(v as Index) {
                    product += corner_forces[f as usize][usize::from(k)] * at.normals.normals[f as usize];
                }
                *out = constraint.projected(v, product);
                inner += x[v].dot(*out);
            }
            inner
        };
        sum_in_order(out.par_chunks_mut(CHUNK).enumerate().map(of_chunk))
    }
}

#[cfg(test)]
mod tests;
