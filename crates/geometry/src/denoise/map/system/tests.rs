//! The operator against the energy at the head of `map.rs`, written out slowly.

use super::*;
use crate::denoise::Boundary;
use crate::denoise::map::prior::Weighing;
use crate::denoise::noise_level::gaussians;
use crate::denoise::tests::{moved_by, white_noise};
use crate::progress::Silent;
use crate::shapes;
use crate::surface::Surface;
use glam::DMat3;

const SIGMA: f64 = 0.25;
/// k at the head of `map.rs`.
const HELD: f64 = 3.0;

/// One round of an estimate, in mean edges.
struct Round {
    net: Net,
    freedom: Freedom,
    positions: Vec<DVec3>,
    vertex_normals: Vec<DVec3>,
    way: Vec<DVec3>,
    shapes: Vec<Symmetric>,
    linear: Linear,
    sides: Sides,
}

/// Positions and shape operators.
type Point = (Vec<DVec3>, Vec<Symmetric>);

impl Round {
    fn of(clean: &Surface, boundary: Boundary) -> Self {
        let unit = 1.0 / clean.mean_edge();
        let noisy = moved_by(clean, &white_noise(clean, SIGMA, 2));
        let surface = noisy.at(noisy.positions().iter().map(|p| *p * unit).collect());
        let (net, freedom) = (Net::of(&surface), Freedom::of(&surface, boundary));
        let (way, shapes) = Self::any(&net, &freedom, 0.1, 3);
        let positions: Vec<DVec3> = surface.positions().iter().zip(&way).map(|(p, way)| *p + *way).collect();
        let mut linear = Linear::default();
        linear.measure(&net, &positions, f64::INFINITY);
        let mut sides = Sides::of(&net);
        sides.weigh(&net, &linear, &positions, &shapes, &Weighing::at(&Prior::default(), 6));
        let vertex_normals = net.vertex_normals(&positions);
        Self { net, freedom, positions, vertex_normals, way, shapes, linear, sides }
    }

    /// Gaussian numbers that the freedom allows.
    fn any(net: &Net, freedom: &Freedom, scale: f64, seed: u64) -> Point {
        let ways = gaussians(net.corners.len(), seed).into_iter().enumerate();
        let halves = gaussians(2 * net.faces.len(), seed + 1);
        let six = |pair: &[DVec3]| Symmetric(std::array::from_fn(|k| scale * pair[k / 3][k % 3]));
        (ways.map(|(v, way)| freedom.projected(v, scale * way)).collect(), halves.chunks_exact(2).map(six).collect())
    }

    fn direction(&self, seed: u64) -> Point {
        Self::any(&self.net, &self.freedom, 1.0, seed)
    }

    fn system(&self) -> System<'_> {
        let data = SIGMA.powi(-2);
        let mut system = System::new(&self.net, &self.freedom, data, &Prior::default());
        system.hold(HELD * data);
        system.vertex_normals.clone_from(&self.vertex_normals);
        system
    }

    /// A d, and ⟨d, A d⟩ as the solver is told it.
    fn product(&self, (d, shapes): &Point) -> (Point, f64) {
        let mut system = self.system();
        self.linear.change(&self.net, d, &mut system.changes);
        let mut inner = system.bend(&self.linear, &self.sides, shapes);
        system.relax(d);
        inner += system.gather(&self.linear, d);
        (products(&system), inner)
    }

    /// ∇E / 2 where the normals are linear.
    fn gradient(&self) -> Point {
        let mut system = self.system();
        system.changes.copy_from_slice(&self.linear.normals);
        system.bend(&self.linear, &self.sides, &self.shapes);
        system.relax(&self.positions);
        system.gather(&self.linear, &self.way);
        products(&system)
    }

    /// E a step away, with the weights, the centroids and N of this round, for any normals of the faces.
    fn energy(&self, (step, turn): &Point, normals: &[DVec3]) -> f64 {
        let (net, prior) = (&self.net, Prior::default());
        let positions = sum(&self.positions, step);
        let shapes: Vec<DMat3> = self.shapes.iter().zip(turn).map(|(s, t)| matrix(s) + matrix(t)).collect();
        let mut energy = 0.0;
        for (v, n) in self.vertex_normals.iter().enumerate() {
            let across = |x: DVec3| x - *n * n.dot(x);
            let way = self.way[v] + step[v];
            energy += (way.length_squared() + HELD * across(way).length_squared()) / SIGMA.powi(2);
            let umbrella = net.umbrella.row(v as Index).iter().map(|&(w, u)| u * positions[w as usize]).sum();
            energy += prior.spread * f64::min(SIGMA.powi(-2), 25.0) * across(umbrella).length_squared();
        }
        let centroid =
            |f: usize| net.faces.triangles[f].iter().map(|&v| self.positions[v as usize]).sum::<DVec3>() / 3.0;
        for (e, pair) in net.faces.pairs.iter().enumerate() {
            let [i, j] = pair.map(|f| f as usize);
            let (w, v) = self.weights(e, pair[0]);
            let bend = normals[i] - normals[j] - 0.5 * (shapes[i] + shapes[j]) * (centroid(i) - centroid(j));
            energy += w * bend.length_squared() + v * frobenius(shapes[i] - shapes[j]);
        }
        energy + 1e-3 * prior.strength * shapes.iter().map(|s| frobenius(*s)).sum::<f64>()
    }

    /// w and v of an edge with this face.
    fn weights(&self, edge: usize, face: Index) -> (f64, f64) {
        let at = self.net.sides.range(face).find(|&k| self.net.sides.items()[k].0 as usize == edge).unwrap();
        let side = self.sides.all[at];
        (side.turn, side.jump)
    }

    /// E of the normals that are linear in the positions.
    fn linear_energy(&self, at: &Point) -> f64 {
        let mut normals = vec![DVec3::ZERO; self.net.faces.len()];
        self.linear.change(&self.net, &at.0, &mut normals);
        self.energy(at, &sum(&self.linear.normals, &normals))
    }

    /// E of the normals that triangles have.
    fn true_energy(&self, at: &Point) -> f64 {
        let mut there = Linear::default();
        there.measure(&self.net, &sum(&self.positions, &at.0), f64::INFINITY);
        self.energy(at, &there.normals)
    }
}

fn products(system: &System) -> Point {
    (system.vertices.iter().map(|row| row.product).collect(), system.faces.iter().map(|row| row.product).collect())
}

fn sum(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}

fn plus((x, s): &Point, scale: f64, (d, t): &Point) -> Point {
    let moved = x.iter().zip(d).map(|(x, d)| *x + scale * *d);
    (moved.collect(), s.iter().zip(t).map(|(s, t)| s.zip(t, |s, t| s + scale * t)).collect())
}

fn dot((x, s): &Point, (d, t): &Point) -> f64 {
    x.iter().zip(d).map(|(x, d)| x.dot(*d)).sum::<f64>() + s.iter().zip(t).map(|(s, t)| s.dot(t)).sum::<f64>()
}

fn matrix(s: &Symmetric) -> DMat3 {
    let [xx, yy, zz, yz, xz, xy] = s.0;
    let [yz, xz, xy] = [yz, xz, xy].map(|x| x / 2f64.sqrt());
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
fn the_norm_of_six_numbers_is_that_of_the_matrix() {
    let [a, b] = [[1.0, -2.0, 3.0, 0.5, -0.7, 1.1], [0.3, 1.0, -1.0, 2.0, 0.2, -0.4]].map(Symmetric);
    assert!((a.squared() - frobenius(matrix(&a))).abs() < 1e-14);
    let d = DVec3::new(0.3, -1.0, 2.0);
    assert!((a.times(d) - matrix(&a) * d).length() < 1e-14);
    assert!((matrix(&a.plus(&b)) - (matrix(&a) + matrix(&b))).abs_diff_eq(DMat3::ZERO, 1e-14));
    assert!((matrix(&a.minus(&b)) - (matrix(&a) - matrix(&b))).abs_diff_eq(DMat3::ZERO, 1e-14));
}

#[test]
fn the_operator_is_symmetric_and_positive() {
    for round in rounds() {
        for seed in 10..15 {
            let [a, b] = [round.direction(seed), round.direction(seed + 100)];
            let [(of_a, inner), (of_b, _)] = [&a, &b].map(|x| round.product(x));
            let size = (dot(&a, &of_a) * dot(&b, &of_b)).sqrt();
            assert!((dot(&a, &of_b) - dot(&b, &of_a)).abs() < 1e-13 * size);
            assert!(inner > 0.0 && (inner - dot(&a, &of_a)).abs() < 1e-13 * inner);
        }
    }
}

#[test]
fn the_operator_is_the_second_derivative_of_the_energy() {
    for round in rounds() {
        for seed in 20..25 {
            let [a, b] = [round.direction(seed), round.direction(seed + 100)];
            let (of_a, inner) = round.product(&a);
            let zero = plus(&a, -1.0, &a);
            let at = |x: f64, y: f64| round.linear_energy(&plus(&plus(&zero, x, &a), y, &b));
            // E is quadratic: differences are exact but for rounding.
            let mixed = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / 8.0;
            assert!((mixed - dot(&b, &of_a)).abs() < 1e-11 * at(1.0, 1.0), "{mixed} {}", dot(&b, &of_a));
            let own = (at(1.0, 0.0) - 2.0 * at(0.0, 0.0) + at(-1.0, 0.0)) / 2.0;
            assert!((own / inner - 1.0).abs() < 1e-10, "{own} {inner}");
        }
    }
}

#[test]
fn the_residual_is_the_gradient_of_the_energy_with_true_normals() {
    for round in rounds() {
        let gradient = round.gradient();
        for seed in 30..35 {
            let d = round.direction(seed);
            let zero = plus(&d, -1.0, &d);
            const STEP: f64 = 1e-5;
            let [forth, back] = [STEP, -STEP].map(|step| round.true_energy(&plus(&zero, step, &d)));
            let (slope, expected) = ((forth - back) / (2.0 * STEP), 2.0 * dot(&gradient, &d));
            // Differences are good to the square of the step, and E to 1e-16 of it over the step.
            assert!((slope - expected).abs() < 1e-5 * expected.abs().max(1.0), "{slope} {expected}");
        }
    }
}

#[test]
fn a_solution_leaves_no_gradient_and_moves_no_fixed_vertex() {
    for round in rounds() {
        let mut system = round.system();
        let (mut way, mut shapes) = (round.way.clone(), round.shapes.clone());
        let Round { linear, sides, positions, .. } = &round;
        system.solve(linear, sides, positions, &mut way, &mut shapes, 1000, &Silent).unwrap();
        let step = |(to, from): (&DVec3, &DVec3)| *to - *from;
        let moved: Vec<DVec3> = way.iter().zip(&round.way).map(step).collect();
        assert!(moved.iter().enumerate().all(|(v, way)| round.freedom.projected(v, *way) == *way));
        let turned = shapes.iter().zip(&round.shapes).map(|(to, from)| to.minus(from)).collect();
        let solution = (moved, turned);
        // What is left of the gradient is A s + g.
        let (before, of_solution) = (round.gradient(), round.product(&solution).0);
        let after = plus(&before, 1.0, &of_solution);
        let [before, after] = [&before, &after].map(|g| dot(g, g).sqrt());
        // A thousandth in the norm of the preconditioner.
        assert!(after < 5e-3 * before, "{after} {before}");
        let zero = plus(&solution, -1.0, &solution);
        let [start, end] = [&zero, &solution].map(|at| round.linear_energy(at));
        // The decrease of a quadratic function at its least: −⟨s, A s⟩.
        let decrease = dot(&solution, &of_solution);
        assert!(((start - end) / decrease - 1.0).abs() < 1e-4, "{start} {end} {decrease}");
    }
}
