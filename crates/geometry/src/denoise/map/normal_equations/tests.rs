//! The operator against the energy at the head of `map.rs`, written out slowly.

use super::*;
use crate::denoise::Boundary;
use crate::denoise::map::edge_weights::{Configuration, RobustWeights};
use crate::denoise::noise_level::gaussians;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use crate::mesh::surface::Surface;
use crate::progress::Silent;
use glam::DMat3;

const SIGMA: f64 = 0.25;

/// The factor k at the head of `map.rs`.
const STIFFNESS: f64 = 3.0;

/// One round of an estimate, in mean edges.
struct Round {
    connectivity: Connectivity,
    constraint: BoundaryConstraint,
    positions: Vec<DVec3>,
    vertex_normals: Vec<DVec3>,
    unknowns: Unknowns,
    linear: LinearisedNormals,
    weights: HalfEdgeWeights,
}

impl Round {
    fn of(clean: &Surface, boundary: Boundary) -> Self {
        let unit = 1.0 / clean.mean_edge();
        let noisy = displaced(clean, &white_noise(clean, SIGMA, 2));
        let surface = noisy.at(noisy.positions().iter().map(|p| *p * unit).collect());
        let connectivity = Connectivity::of(&surface);
        let constraint = BoundaryConstraint::of(&surface, boundary);
        let unknowns = Self::random(&connectivity, &constraint, 0.1, 3);
        let positions = sum(surface.positions(), &in_double(&unknowns.offsets));
        let mut linear = LinearisedNormals::default();
        linear.update(&connectivity, &positions, |_| f64::INFINITY);
        let mut weights = HalfEdgeWeights::new(&connectivity);
        let robust = RobustWeights::at_round(&Prior::default(), 6);
        let edges = vec![1.0; connectivity.mesh.face_count()];
        let at = Configuration { normals: &linear, positions: &positions, edges: &edges };
        weights.update(&connectivity, &at, &unknowns.shape_operators, &robust);
        let vertex_normals = connectivity.vertex_normals(&positions);
        Self { connectivity, constraint, positions, vertex_normals, unknowns, linear, weights }
    }

    /// Gaussian numbers that the constraint allows.
    fn random(connectivity: &Connectivity, constraint: &BoundaryConstraint, scale: f64, seed: u64) -> Unknowns {
        let offsets = gaussians(connectivity.corners.len(), seed).into_iter().enumerate();
        let halves = gaussians(2 * connectivity.mesh.face_count(), seed + 1);
        let half = |x: DVec3| (scale * x).as_vec3a();
        let six = |pair: &[DVec3]| Symmetric { diagonal: half(pair[0]), off_diagonal: half(pair[1]) };
        Unknowns {
            offsets: offsets.map(|(v, offset)| constraint.projected(v, scale * offset).as_vec3a()).collect(),
            shape_operators: halves.chunks_exact(2).map(six).collect(),
        }
    }

    fn direction(&self, seed: u64) -> Unknowns {
        Self::random(&self.connectivity, &self.constraint, 1.0, seed)
    }

    fn zero(&self) -> Unknowns {
        Unknowns::zero(&self.connectivity)
    }

    fn at(&self) -> Linearisation<'_> {
        Linearisation { normals: &self.linear, weights: &self.weights, positions: &self.positions }
    }

    fn equations(&self) -> NormalEquations<'_> {
        let noise = NoiseField::uniform(self.positions.len(), SIGMA, 1.0, STIFFNESS);
        let data = DataWeights::of(&noise, &Prior::default());
        let mut equations = NormalEquations::new(&self.connectivity, &self.constraint, data, &Prior::default());
        equations.set_tangential_share(1.0);
        equations.operator.set_vertex_normals(&self.vertex_normals);
        equations
    }

    /// A d, and ⟨d, A d⟩ as the solver is told it.
    fn product(&self, d: &Unknowns) -> (Unknowns, f64) {
        let mut out = self.zero();
        let inner = self.equations().operator.apply(&self.at(), d, &mut out);
        (out, inner)
    }

    /// ∇E / 2 where the normals are linearised.
    fn gradient(&self) -> Unknowns {
        let mut out = self.zero();
        self.equations().operator.gradient(&self.at(), &self.unknowns, &mut out);
        out
    }

    /// E a step away, with the weights, the centroids and N of this round, for any normals of the faces.
    fn energy(&self, step: &Unknowns, normals: &[DVec3]) -> f64 {
        let (connectivity, prior) = (&self.connectivity, Prior::default());
        let positions = sum(&self.positions, &in_double(&step.offsets));
        let shape_operators = self.unknowns.shape_operators.iter().zip(&step.shape_operators);
        let shape_operators: Vec<DMat3> = shape_operators.map(|(s, t)| matrix(s) + matrix(t)).collect();
        let mut energy = 0.0;
        for (v, n) in self.vertex_normals.iter().enumerate() {
            let tangential = |x: DVec3| x - *n * n.dot(x);
            let offset = self.unknowns.offsets[v].as_dvec3() + step.offsets[v].as_dvec3();
            energy += (offset.length_squared() + STIFFNESS * tangential(offset).length_squared()) / SIGMA.powi(2);
            let row = connectivity.umbrella.row(v as Index);
            let umbrella = row.iter().map(|&(w, u)| u * positions[w as usize]).sum();
            energy += prior.spread * f64::min(SIGMA.powi(-2), 25.0) * tangential(umbrella).length_squared();
        }
        let corners = |f: usize| connectivity.mesh.triangles[f].iter().map(|&v| self.positions[v as usize]);
        let centroid = |f: usize| corners(f).sum::<DVec3>() / 3.0;
        for (e, pair) in connectivity.mesh.edge_faces.iter().enumerate() {
            let [i, j] = pair.map(|f| f as usize);
            let (w, v) = self.edge_weights(e, pair[0]);
            let predicted = 0.5 * (shape_operators[i] + shape_operators[j]) * (centroid(i) - centroid(j));
            energy += w * (normals[i] - normals[j] - predicted).length_squared();
            energy += v * frobenius(shape_operators[i] - shape_operators[j]);
        }
        energy + 1e-3 * prior.strength * shape_operators.iter().map(|s| frobenius(*s)).sum::<f64>()
    }

    /// Weights w and v of an edge of this face.
    fn edge_weights(&self, edge: usize, face: Index) -> (f64, f64) {
        let half_edges = &self.connectivity.half_edges;
        let k = half_edges.range(face).find(|&k| half_edges.items()[k].0 as usize == edge).unwrap();
        let weight = &self.weights.all[k];
        (weight.normal_weight.into(), weight.shape_operator_weight.into())
    }

    /// E of the normals that are linear in the positions.
    fn linear_energy(&self, step: &Unknowns) -> f64 {
        let mut changes = vec![Vec3A::ZERO; self.connectivity.mesh.face_count()];
        self.linear.apply_jacobian(&self.connectivity, &step.offsets, &mut changes);
        self.energy(step, &sum(&in_double(&self.linear.normals), &in_double(&changes)))
    }

    /// E of the normals that the triangles have.
    fn true_energy(&self, step: &Unknowns) -> f64 {
        let positions = sum(&self.positions, &in_double(&step.offsets));
        let normal = |t: &[Index; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        self.energy(step, &self.connectivity.mesh.triangles.iter().map(normal).collect::<Vec<_>>())
    }
}

fn in_double(list: &[Vec3A]) -> Vec<DVec3> {
    list.iter().map(|x| x.as_dvec3()).collect()
}

fn sum(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}

/// The vector x + α y.
fn plus(x: &Unknowns, alpha: f64, y: &Unknowns) -> Unknowns {
    let mut sum = x.clone();
    sum.axpy(alpha, y);
    sum
}

fn dot(x: &Unknowns, y: &Unknowns) -> f64 {
    let three = |x: &[Vec3A], y: &[Vec3A]| x.iter().zip(y).map(|(x, y)| x.as_dvec3().dot(y.as_dvec3())).sum::<f64>();
    let [[x_diagonal, x_rest], [y_diagonal, y_rest]] = [x, y].map(|of| {
        let halves = of.shape_operators.iter().map(|s| (s.diagonal, s.off_diagonal));
        let (diagonal, rest): (Vec<Vec3A>, Vec<Vec3A>) = halves.unzip();
        [diagonal, rest]
    });
    three(&x.offsets, &y.offsets) + three(&x_diagonal, &y_diagonal) + three(&x_rest, &y_rest)
}

fn matrix(s: &Symmetric) -> DMat3 {
    let DVec3 { x: xx, y: yy, z: zz } = s.diagonal.as_dvec3();
    let DVec3 { x: yz, y: xz, z: xy } = s.off_diagonal.as_dvec3() / 2f64.sqrt();
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
}

fn frobenius(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum()
}

/// A closed surface, and one with a fixed boundary.
fn rounds() -> [Round; 2] {
    [Round::of(&shapes::dented_sphere(2), Boundary::Free), Round::of(&shapes::bumpy_sheet(8), Boundary::Fixed)]
}

#[test]
fn six_numbers_are_the_matrix() {
    let symmetric = |d: [f32; 3], o: [f32; 3]| Symmetric { diagonal: d.into(), off_diagonal: o.into() };
    let a = symmetric([1.0, -2.0, 3.0], [0.5, -0.7, 1.1]);
    let b = symmetric([0.3, 1.0, -1.0], [2.0, 0.2, -0.4]);
    assert!((vec![a].weighted_norm2(&vec![1.0]) - frobenius(matrix(&a))).abs() < 1e-5);
    let [d, e] = [Vec3A::new(0.3, -1.0, 2.0), Vec3A::new(-0.6, 0.1, 0.7)];
    assert!((a.times(d).as_dvec3() - matrix(&a) * d.as_dvec3()).length() < 1e-6);
    assert!(matrix(&(a + b)).abs_diff_eq(matrix(&a) + matrix(&b), 1e-6));
    assert!(matrix(&(a - b)).abs_diff_eq(matrix(&a) - matrix(&b), 1e-6));
    let column = |y: f32| e.as_dvec3() * f64::from(y);
    let outer = DMat3::from_cols(column(d.x), column(d.y), column(d.z));
    assert!(matrix(&Symmetric::outer(d, e)).abs_diff_eq(0.5 * (outer + outer.transpose()), 1e-6));
}

#[test]
fn the_operator_is_symmetric_and_positive() {
    for round in rounds() {
        for seed in 10..15 {
            let [a, b] = [round.direction(seed), round.direction(seed + 100)];
            let [(of_a, inner), (of_b, _)] = [&a, &b].map(|x| round.product(x));
            let size = (dot(&a, &of_a) * dot(&b, &of_b)).sqrt();
            assert!((dot(&a, &of_b) - dot(&b, &of_a)).abs() < 1e-6 * size);
            assert!(inner > 0.0 && (inner - dot(&a, &of_a)).abs() < 1e-6 * inner);
        }
    }
}

#[test]
fn the_operator_is_the_second_derivative_of_the_energy() {
    for round in rounds() {
        for seed in 20..25 {
            let [a, b] = [round.direction(seed), round.direction(seed + 100)];
            let (of_a, inner) = round.product(&a);
            let at = |x: f64, y: f64| round.linear_energy(&plus(&plus(&round.zero(), x, &a), y, &b));
            // E is quadratic: differences are exact but for rounding.
            let mixed = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / 8.0;
            assert!((mixed - dot(&b, &of_a)).abs() < 1e-6 * at(1.0, 1.0), "{mixed} {}", dot(&b, &of_a));
            let own = (at(1.0, 0.0) - 2.0 * at(0.0, 0.0) + at(-1.0, 0.0)) / 2.0;
            assert!((own / inner - 1.0).abs() < 1e-6, "{own} {inner}");
        }
    }
}

#[test]
fn the_residual_is_the_gradient_of_the_energy_with_true_normals() {
    for round in rounds() {
        let gradient = round.gradient();
        for seed in 30..35 {
            let d = round.direction(seed);
            const STEP: f64 = 1.0 / 65536.0;
            let [forth, back] = [STEP, -STEP].map(|step| round.true_energy(&plus(&round.zero(), step, &d)));
            let (slope, expected) = ((forth - back) / (2.0 * STEP), 2.0 * dot(&gradient, &d));
            // Differences are good to the square of the step, and directions and the gradient to single precision of their lengths.
            let size = (dot(&gradient, &gradient) * dot(&d, &d)).sqrt();
            assert!((slope - expected).abs() < 1e-6 * size, "{slope} {expected} {size}");
        }
    }
}

#[test]
fn a_solution_leaves_no_gradient_and_moves_no_fixed_vertex() {
    for round in rounds() {
        let mut end = round.unknowns.clone();
        round.equations().solve(&round.at(), &mut end, 1000, &Silent).unwrap();
        let solution = plus(&end, -1.0, &round.unknowns);
        let mut moved = solution.offsets.iter().enumerate();
        assert!(moved.all(|(v, offset)| *offset == Vec3A::ZERO || !round.constraint.holds(v)));
        // The solution s leaves a gradient of A s + g.
        let (before, of_solution) = (round.gradient(), round.product(&solution).0);
        let after = plus(&before, 1.0, &of_solution);
        let [before, after] = [&before, &after].map(|g| dot(g, g).sqrt());
        // The solver stops at a thousandth in the norm of the preconditioner.
        assert!(after < 5e-3 * before, "{after} {before}");
        let [start, end] = [&round.zero(), &solution].map(|step| round.linear_energy(step));
        // The minimum of a quadratic function is ⟨s, A s⟩ below its value at zero.
        let decrease = dot(&solution, &of_solution);
        assert!(((start - end) / decrease - 1.0).abs() < 1e-4, "{start} {end} {decrease}");
    }
}

#[test]
fn a_round_whose_numbers_are_infinite_leaves_nothing_to_the_next() {
    for round in rounds() {
        let solved = |equations: &mut NormalEquations, mut unknowns: Unknowns| {
            equations.solve(&round.at(), &mut unknowns, 20, &Silent).unwrap();
            unknowns
        };
        let mut equations = round.equations();
        let mut infinite = round.unknowns.clone();
        infinite.offsets.fill(Vec3A::INFINITY);
        solved(&mut equations, infinite);
        let [again, fresh] =
            [&mut equations, &mut round.equations()].map(|equations| solved(equations, round.unknowns.clone()));
        assert!(again.offsets == fresh.offsets && fresh.offsets != round.unknowns.offsets);
    }
}
