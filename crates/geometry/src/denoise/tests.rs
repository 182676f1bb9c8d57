//! Laws that hold for every method, whatever its settings.

mod invariance;
mod limits;
mod noise_laws;
mod robustness;
mod settings;

use super::*;
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::limits::{Limits, Outcome, Volume};
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Noise};
use crate::mesh::topology::Topology;
use crate::mesh::weld::{Weld, Welding};
use crate::progress::Silent;
use crate::source::model::NormalSource;
use glam::DQuat;

/// Methods with some settings each; a new method is added here and nowhere else.
fn every() -> Vec<Denoiser> {
    let mut all = normal_filters();
    for weights in [EdgeWeights::Uniform, EdgeWeights::Cotangent] {
        for boundary in [Boundary::Fixed, Boundary::Free] {
            all.push(Denoiser::Laplacian(Laplacian { iterations: 5, step: 0.5, weights, boundary }));
            all.push(Denoiser::Taubin(Taubin { iterations: 3, weights, boundary, ..Taubin::default() }));
            let solver = if boundary == Boundary::Fixed { Solver::Direct } else { Solver::Iterative };
            all.push(Denoiser::Implicit(Implicit { weights, boundary, solver, ..Implicit::default() }));
        }
    }
    for boundary in [Boundary::Fixed, Boundary::Free] {
        all.push(Denoiser::Hc(Hc { boundary, alpha: 0.1, ..Hc::default() }));
        all.push(Denoiser::Bilateral(Bilateral { iterations: 2, boundary }));
        all.push(Denoiser::L0(L0 { beta_max: 1.0, boundary, ..L0::default() }));
    }
    all.extend(estimates());
    all
}

fn estimates() -> Vec<Denoiser> {
    let prior = Prior { rounds: 3, ..Prior::default() };
    let mut all = Vec::new();
    for (motion, boundary) in [(Motion::Free, Boundary::Free), (Motion::AlongNormal, Boundary::Fixed)] {
        let map = Map { prior, steps: 10, motion, boundary, ..Map::default() };
        all.push(Denoiser::Map(map));
        all.push(Denoiser::Map(Map { noise: Some(0.2), ..map }));
        all.push(Denoiser::Auto(Auto { motion, boundary, ..Auto::default() }));
        all.push(Denoiser::Learned(Learned { motion, boundary, ..Learned::default() }));
    }
    all
}

/// A setting of the vertex update; none where the method has no such setting.
fn settings_of(denoiser: &Denoiser, name: &str) -> Option<serde_json::Value> {
    serde_json::to_value(denoiser).unwrap().get("vertex_update")?.get(name).cloned()
}

/// How far results may be apart for inputs that are alike but for rounding, model units.
fn rounding(denoiser: &Denoiser) -> f64 {
    match denoiser {
        // Features are of single precision.
        Denoiser::Learned(_) | Denoiser::Auto(Auto { boundary: Boundary::Free, .. }) => 1e-4,
        // Conjugate gradients end when 1e-8 of the pull is left, one step sooner or later.
        _ if settings_of(denoiser, "scheme").is_some_and(|scheme| scheme == "least-squares") => 1e-7,
        // Rounds are solved in single precision, and multiply what they are given.
        Denoiser::Map(_) | Denoiser::Auto(_) => 1e-5,
        // Single precision rounds other digits of normals that are turned.
        _ if denoiser.motion() == Some(Motion::AlongNormal) => 1e-7,
        // Sums of a dozen terms of size 10, five steps: a few hundred ulps.
        _ => 1e-12,
    }
}

fn normal_filters() -> Vec<Denoiser> {
    let mut all = Vec::new();
    let held = VertexUpdate::paper(5, Boundary::Fixed).held();
    let along = VertexUpdate { motion: Motion::AlongNormal, boundary: Boundary::Free, ..held };
    let fitted = VertexUpdate { scheme: VertexScheme::LeastSquares, ..held };
    for vertex_update in [VertexUpdate::paper(5, Boundary::Free), held, along, fitted] {
        all.push(Denoiser::Sun(Sun { iterations: 4, vertex_update, ..Sun::paper() }));
        for (scheme, neighbours) in [(Scheme::Local, Neighbours::Vertex), (Scheme::Global, Neighbours::Edge)] {
            let settings = BilateralNormals { iterations: 4, scheme, neighbours, vertex_update, ..<_>::default() };
            all.push(Denoiser::BilateralNormals(settings));
        }
        let guided = GuidedNormals { iterations: 3, vertex_update, ..GuidedNormals::paper() };
        all.push(Denoiser::GuidedNormals(guided));
        all.push(Denoiser::TgvNormals(TgvNormals { iterations: 3, vertex_update, ..TgvNormals::default() }));
    }
    all
}

/// Setting of the method for the boundary; none where it has no such setting.
fn boundary(denoiser: &Denoiser) -> Option<Boundary> {
    let settings = serde_json::to_value(denoiser).unwrap();
    let found = settings.get("boundary").or_else(|| settings.get("vertex_update")?.get("boundary"))?;
    Some(serde_json::from_value(found.clone()).unwrap())
}

fn deltas(denoiser: &Denoiser, surface: &Surface) -> Vec<DVec3> {
    denoiser.deltas(surface, &Silent).unwrap()
}

/// All limits at once; the boundary is fixed because without that an open surface has no volume.
fn limits() -> Limits {
    Limits {
        fixed: "boundary 2-3 5".parse().unwrap(),
        max_displacement: Some(0.05),
        volume: Volume::Preserve,
        ..Limits::default()
    }
}

fn limited(denoiser: &Denoiser, limits: &Limits, surface: &Surface) -> (Vec<DVec3>, Option<Outcome>) {
    let weld = Weld::new(surface.positions(), Welding::None);
    let denoising = Denoising { denoiser: denoiser.clone(), limits: limits.clone() };
    let Moved { deltas, limits, .. } = denoising.run(surface, &weld, denoising.output(), &Silent).unwrap();
    (deltas, limits)
}

/// Six times the volume between the faces and the origin, where vertices go by −δ.
fn six_volumes(surface: &Surface, deltas: &[DVec3]) -> f64 {
    let at = |v: Index| surface.positions()[v as usize] - deltas[v as usize];
    surface.triangles().map(|t| t.map(at)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

/// A closed surface, one with a boundary, one of quads, and one with noise.
fn families() -> [Surface; 4] {
    let sphere = shapes::sphere(2);
    let noise = white_noise(&sphere, 0.2, 1);
    [shapes::dented_sphere(2), shapes::bumpy_sheet(8), shapes::cube(), displaced(&sphere, &noise)]
}

/// White noise of `sigma` mean edges along the normals. #V×3, model units
pub(super) fn white_noise(surface: &Surface, sigma: f64, seed: u64) -> Vec<DVec3> {
    synthetic_noise::displacements(
        surface,
        &Noise { sigma, direction: synthetic_noise::Direction::Normal, share: 1.0, seed },
    )
}

/// The surface with each vertex moved by its own displacement (#V×3, model units).
pub(super) fn displaced(surface: &Surface, displacements: &[DVec3]) -> Surface {
    surface.at(surface.positions().iter().zip(displacements).map(|(p, d)| *p + *d).collect())
}

/// The surface with δ (#V×3, model units) taken off.
pub(super) fn without(surface: &Surface, deltas: &[DVec3]) -> Surface {
    surface.at(surface.moved_by(deltas))
}

/// Ea: mean angle between the normals of corresponding triangles, degrees.
pub(super) fn mean_angle(a: &Surface, b: &Surface) -> f64 {
    let mesh = TriangleMesh::of(a);
    let [a, b] = [a, b].map(|surface| FaceGeometry::of(&mesh, surface.positions()).normals);
    a.iter().zip(&b).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / mesh.face_count() as f64
}

fn largest_gap(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}
