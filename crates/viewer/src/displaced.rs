//! The vertex stage on the CPU: where wedges are drawn, and with which normals they are lit.

use crate::scene::{FrameNormals, Scene};
use crate::settings::{Normals, Settings, Shading};
use crate::wedges::{self, PER_VERTEX, Wedges, shader_vertex};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What the vertex stage gives. #W
#[derive(Debug)]
pub(crate) struct Displaced {
    /// World space.
    pub(crate) positions: Vec<Vec3>,
    /// Unit, or zero where there is none.
    pub(crate) normals: Vec<Vec3>,
}

impl Displaced {
    pub(crate) fn new(scene: &Scene, wedges: &Wedges, settings: &Settings) -> Self {
        let denoised = denoised(scene, wedges, settings.map.lambda);
        let normals = normals(scene, wedges, &denoised, settings.map.normals);
        Self { positions: lifted(scene, wedges, settings, denoised), normals }
    }
}

/// Where the displacement map takes the wedges.
pub(crate) fn denoised(scene: &Scene, wedges: &Wedges, lambda: f32) -> Vec<Vec3> {
    let is_per_vertex = wedges::kind(scene) & PER_VERTEX != 0;
    let place = |wedge| match scene.carried() {
        Some(carried) => shader_vertex(wedge, is_per_vertex).displaced(&carried.map, lambda),
        None => wedge.position,
    };
    wedges.wedges.par_iter().map(place).collect()
}

/// Where the relief lifts them.
fn lifted(scene: &Scene, wedges: &Wedges, settings: &Settings, mut positions: Vec<Vec3>) -> Vec<Vec3> {
    if let (Shading::Displacement, Some(picture)) = (settings.shading, &scene.relief) {
        let (radius, relief) = (scene.bounds().radius, settings.relief);
        for (position, wedge) in positions.iter_mut().zip(&wedges.wedges) {
            let height = radius * relief.bias + radius * relief.scale * picture.numbers_at(wedge.dominant_uv).x;
            *position += relief.lambda * height * wedge.normal;
        }
    }
    positions
}

fn normals(scene: &Scene, wedges: &Wedges, denoised: &[Vec3], source: Normals) -> Vec<Vec3> {
    let carrier = scene.normal_map.as_ref().is_some_and(|map| map.frames == FrameNormals::Carrier);
    match source {
        Normals::Derived => derived(wedges, denoised),
        Normals::Map if carrier && scene.mesh().tangents.is_some() => wedges.wedges.iter().map(|w| w.normal).collect(),
        Normals::Base | Normals::Map => wedges.normals.iter().map(|n| n.truncate()).collect(),
    }
}

/// Angle-weighted over the triangles around each vertex (Thürmer & Wüthrich 1998); zero where they cancel.
fn derived(wedges: &Wedges, positions: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; wedges.vertices];
    for triangle in &wedges.triangles {
        let corners = triangle.map(|w| positions[w as usize].as_dvec3());
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
            let (a, b) = (q - p, r - p);
            let across = a.cross(b);
            let angle = across.length().atan2(a.dot(b));
            let vertex = wedges.wedges[triangle[k] as usize].vertex;
            sums[vertex as usize] += angle * across.normalize_or_zero();
        }
    }
    let of_vertices: Vec<Vec3> = sums.into_iter().map(|n| n.normalize_or_zero().as_vec3()).collect();
    wedges.wedges.iter().map(|wedge| of_vertices[wedge.vertex as usize]).collect()
}
