//! Fusion of depth images: a scan from all sides (Curless & Levoy 1996, A Volumetric Method for Building Complex Models from Range
//! Images).
//!
//! Eight depth cameras stand at the corners of a cube around the mesh, which is rotated at random. Their images err as a range image
//! does, but edges are not fattened. Each node of a grid of step `step` ē gets a signed distance from every image: the
//! difference of the depths at its pixel times cos θ, where θ is the angle between the ray and the normal of the image there. It is cut
//! off at two steps in front, and not counted farther behind, where the image sees nothing. The mean of these distances, with
//! weights cos² θ and without those at more than 75°, is zero at the surface, which is meshed by surface nets. Two to four images
//! see each part, so their mean has about half of the noise of one. The clean mesh has the nearest points of the true surface;
//! vertices that are farther than two steps from it, which false edges have left, are taken out of both.

use super::depth_image::{Camera, DepthImage};
use super::range_image::{JUMP, noisy_image};
use super::surface_nets::{self, Grid};
use super::{RemeshError, Remeshed, pair, step};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::mesh::synthetic_noise::layout_numbers;
use crate::mesh::synthetic_noise::settings::SyntheticNoise;
use crate::mesh::topology::Topology;
use crate::mesh::triangle_tree::TriangleTree;
use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Distance at which signed distances are cut off, steps.
const CUT_OFF: f64 = 2.0;
/// Smallest cosine between a ray and the normal of what it hits: the distance is too uncertain at a more grazing angle.
const SMALLEST_COSINE: f64 = 0.26;
/// Farthest that a vertex may be from the true surface, steps.
const FARTHEST: f64 = 2.0;

/// Mesh of fused depth images and its clean counterpart.
pub(super) fn remeshed(surface: &Surface, noise: &SyntheticNoise) -> Result<Remeshed, RemeshError> {
    let step = step(surface, noise)?;
    let grid = Grid::around(surface.bounds(), step, CUT_OFF + 1.0, DVec3::ZERO)?;
    let mut views = Vec::new();
    for (view, towards) in (0..).zip(directions(noise.seed)) {
        let camera = Camera::new(surface, towards, noise.distance, step)?;
        let image = DepthImage::of(surface, camera)?;
        let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
        random.set_stream(2 + view);
        match noisy_image(&image, noise, noise.sigma * surface.mean_edge(), &mut random) {
            Ok(image) => views.push(View::new(image)),
            // A sheet shows nothing to a camera that sees it edge on.
            Err(RemeshError::Nothing) => {}
            Err(e) => return Err(e),
        }
    }
    let value = |index: usize| mean_distance(&views, grid.position(grid.node(index)), step);
    let values: Vec<f32> = (0..grid.len()).into_par_iter().map(value).collect();
    let (noisy, mut faces) = surface_nets::surface(&grid, &values);
    let clean = TriangleTree::new(surface.positions(), surface.triangles()).nearest(&noisy);
    let is_near = |v: &u32| clean[*v as usize].distance(noisy[*v as usize]) <= FARTHEST * step;
    faces.retain(|t| t.iter().all(is_near));
    pair(&clean, &noisy, &faces)
}

/// Directions to the corners of a cube that is rotated at random.
fn directions(seed: u64) -> impl Iterator<Item = DVec3> {
    let mut random = layout_numbers(seed);
    // Four Gaussian numbers are a random rotation.
    let numbers: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
    let rotation = DQuat::from_array(numbers).normalize();
    let sign = |bits: u32, axis: u32| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
    (0..8).map(move |bits| rotation * DVec3::new(sign(bits, 0), sign(bits, 1), sign(bits, 2)).normalize())
}

/// A depth image with the angles at which it sees the surface.
struct View {
    image: DepthImage,
    /// Cosine of the angle between the ray of each pixel and the normal there; 0 where nothing is seen.
    cosines: Vec<f64>,
}

impl View {
    fn new(image: DepthImage) -> Self {
        let faces: Ragged<Index> = image.triangles(JUMP).iter().map(|t| t.to_vec()).collect();
        let count = image.depths.len();
        // A position that no face uses does not matter.
        let point = |k: usize| {
            let depth = image.depths[k];
            if depth.is_finite() { image.camera.point(image.pixel(k), depth) } else { image.camera.eye }
        };
        let surface = Surface::new(Topology::new(count, faces), (0..count).map(point).collect());
        let normals = normals::vertex_normals(&surface, FaceWeight::Angle);
        let towards_eye = surface.positions().iter().map(|p| (image.camera.eye - *p).normalize_or_zero());
        let cosines = normals.iter().zip(towards_eye).map(|(n, ray)| n.dot(ray)).collect();
        Self { image, cosines }
    }

    /// Signed distance of a point to what the view sees, in cut-off distances, positive in front, and its weight; `None` if the view
    /// cannot tell.
    fn distance(&self, point: DVec3, step: f64) -> Option<(f64, f64)> {
        let (pixel, depth) = self.image.camera.project(point);
        let k = self.image.index(pixel.round().to_array().map(|x| x as i64))?;
        let cosine = self.cosines[k];
        let distance = (self.image.depths[k] - depth) * cosine / (CUT_OFF * step);
        (cosine >= SMALLEST_COSINE && distance >= -1.0).then(|| (distance.min(1.0), cosine * cosine))
    }
}

/// Weighted mean signed distance of a node to what the views see, in cut-off distances, positive in front; NaN where none can tell.
fn mean_distance(views: &[View], node: DVec3, step: f64) -> f32 {
    let seen = views.iter().filter_map(|view| view.distance(node, step));
    let (sum, weights) =
        seen.fold((0.0, 0.0), |(sum, weights), (distance, weight)| (sum + distance * weight, weights + weight));
    (sum / weights) as f32
}
