//! Guided normal filter: a joint bilateral filter of the face normals, guided by the most consistent patch around each face.
//!
//! Wangyu Zhang, Bailin Deng, Juyong Zhang, Sofien Bouaziz, Ligang Liu. Guided mesh normal filtering. Computer Graphics
//! Forum 34 (7), Pacific Graphics 2015.
//!
//! Each face has a patch: itself and the faces that share a vertex with it. The guidance gᵢ is the mean normal of that
//! patch with face i in it that is most consistent: the least H = max_{j,k} |nⱼ − nₖ| · max_e φ_e / Σ_e φ_e, with
//! φ_e = |n₁ − n₂| over the edges inside the patch (eqs. 6–8). Then nᵢ ← normalise Σⱼ Aⱼ exp(−|cᵢ − cⱼ|² / 2σ_s²)
//! exp(−|gᵢ − gⱼ|² / 2σ_r²) nⱼ over the faces within a radius, and vertices follow before the next iteration.

use super::bilateral_normals::{SIGMA_RANGE, SIGMA_SPATIAL};
use super::boundary::Boundary;
use super::face_geometry::{FaceGeometry, filter_normals};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::motion::Motion;
use super::parameters::{Parameter, TINY};
use super::triangle_mesh::{TriangleMesh, build_lists};
use super::vertex_update::{self, Updater, VertexUpdate};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::GuidedNormals`](super::Denoiser::GuidedNormals).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidedNormals {
    /// Rounds of filter and vertex update.
    pub iterations: u32,
    /// How far off faces are averaged, in mean distances of the centroids of faces that share an edge, in the input.
    pub radius: f64,
    /// σ_s, in the same unit, measured anew in each round.
    pub sigma_spatial: f64,
    /// σ_r: how far guidance normals may differ and their faces still be averaged.
    pub sigma_range: f64,
    /// How vertices follow, in each round.
    pub vertex_update: VertexUpdate,
}

impl GuidedNormals {
    /// Radius 2, σ_s = 1, σ_r = 0.35, 20 rounds of 10 vertex steps each; the boundary moves.
    pub fn paper() -> Self {
        Self {
            iterations: 20,
            radius: 2.0,
            sigma_spatial: 1.0,
            sigma_range: 0.35,
            vertex_update: VertexUpdate::paper(10, Boundary::Free),
        }
    }
}

impl Default for GuidedNormals {
    /// As in the paper, with vertices that are held.
    fn default() -> Self {
        let paper = Self::paper();
        Self { vertex_update: paper.vertex_update.held(), ..paper }
    }
}

/// Largest radius, mean distances of neighbouring faces. Some ten thousand faces for each face take long enough.
const MAX_RADIUS: f64 = 100.0;

/// Parameters of the filter; those of the vertex update come on top.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count(
        "iterations",
        "/iterations",
        100,
        "number of steps of the normals, each with an update of the vertices",
    ),
    Parameter::number("radius", "/radius", [TINY, MAX_RADIUS], "how far off faces are averaged")
        .slider(5.0)
        .unit("mean distances of neighbouring faces"),
    SIGMA_SPATIAL,
    SIGMA_RANGE,
];

impl DenoiseMethod for GuidedNormals {
    const INFO: MethodInfo = MethodInfo {
        name: "guided-normals",
        summary: "Bilateral filter of the face normals, guided by consistent patches: for sharp edges and corners, heavy noise",
        reference: Some(Reference {
            cite: "Zhang et al. 2015",
            title: "Guided mesh normal filtering. Computer Graphics Forum 34 (7)",
        }),
        parameters: &[PARAMETERS, vertex_update::PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::paper())
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.vertex_update.motion)
    }
}

/// Filters the normals, lets the vertices follow in each round and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(
    surface: &Surface,
    settings: &GuidedNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let mesh = TriangleMesh::of(surface);
    let mut filter = Filter::new(surface, &mesh, settings, None);
    for done in 1..=settings.iterations {
        progress.check()?;
        filter.take_round(None, progress)?;
        progress.done(f64::from(done) / f64::from(settings.iterations));
    }
    Ok(filter.updater.deltas())
}

/// Start of one round of [`GuidedNormals`] on a part of a mesh, with what is measured on the whole mesh.
#[derive(Clone, Copy, Debug)]
pub struct GuidedRound<'a> {
    /// Positions at which the vertices are. #V×3, model units
    pub positions: &'a [DVec3],
    /// Mean distance of the centroids of triangles that share an edge in the whole mesh as it was given, model units.
    pub spacing_of_input: f64,
    /// Mean distance of these centroids in the whole mesh with the vertices where they are before the round, model units.
    pub spacing: f64,
}

/// Takes one round on a surface with positions as they were given, and returns where the vertices are then. #V×3, model units
pub(super) fn round(
    surface: &Surface,
    settings: &GuidedNormals,
    start: GuidedRound,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let mesh = TriangleMesh::of(surface);
    let mut filter = Filter::new(surface, &mesh, settings, Some(start.spacing_of_input));
    filter.updater.go_to(start.positions);
    filter.geometry.update(&mesh, start.positions);
    filter.take_round(Some(start.spacing), progress)?;
    Ok(filter.updater.positions().to_vec())
}

/// State of the filter on one mesh between two rounds.
struct Filter<'a> {
    settings: &'a GuidedNormals,
    mesh: &'a TriangleMesh,
    updater: Updater<'a>,
    geometry: FaceGeometry,
    /// Triangles that are averaged for each triangle, the triangle itself last. #T lists
    neighbours: Ragged<Index>,
    patches: Patches,
    guidance: Guidance,
    filtered: Vec<DVec3>,
}

impl<'a> Filter<'a> {
    /// The filter before its first round. `spacing` is the mean distance of neighbouring triangles; that of the mesh if it is `None`.
    fn new(surface: &'a Surface, mesh: &'a TriangleMesh, settings: &'a GuidedNormals, spacing: Option<f64>) -> Self {
        let updater = Updater::new(surface, mesh, settings.vertex_update);
        let geometry = FaceGeometry::of(mesh, surface.positions());
        let radius = settings.radius * spacing.unwrap_or_else(|| geometry.mean_centroid_distance(mesh));
        let around = mesh.neighbours_within(radius, most_within(settings.radius), &geometry.centroids);
        let neighbours = build_lists(mesh.face_count(), |f, list| {
            list.extend(around.get(f));
            list.push(f);
        });
        let patches = Patches::of(mesh, &geometry.centroids);
        let guidance = Guidance::new(&patches);
        let filtered = geometry.normals.clone();
        Self { settings, mesh, updater, geometry, neighbours, patches, guidance, filtered }
    }

    /// Filters the normals once and lets the vertices follow. `spacing` is that of [`Self::new`], now.
    fn take_round(&mut self, spacing: Option<f64>, progress: &dyn Progress) -> Result<(), Cancelled> {
        let Self { settings, mesh, updater, geometry, neighbours, patches, guidance, filtered } = self;
        guidance.update(patches, geometry);
        let sigma = settings.sigma_spatial * spacing.unwrap_or_else(|| geometry.mean_centroid_distance(mesh));
        let [spatial, range] = [sigma, settings.sigma_range].map(|sigma| -0.5 / (sigma * sigma));
        filter_normals(neighbours, &geometry.normals, filtered, |f, _, g| {
            let distance = geometry.centroids[f].distance_squared(geometry.centroids[g]);
            let difference = guidance.normals[f].distance_squared(guidance.normals[g]);
            geometry.areas[g] * (spatial * distance + range * difference).exp()
        });
        updater.follow(filtered, progress)?;
        geometry.update(mesh, updater.positions());
        Ok(())
    }
}

/// Largest number of faces that are averaged around a face within a radius, in mean distances of neighbouring faces: 26 times as many
/// as lie there in a mesh of equilateral triangles. Slivers, and meshes with a vertex far away, have any number.
fn most_within(radius: f64) -> usize {
    (64.0 * radius * radius).ceil() as usize
}

/// Patches: each face with the faces that share a vertex with it, see [`TriangleMesh::vertex_neighbours`].
struct Patches {
    /// Faces of each patch, ascending, with the face itself at the end. #T lists
    members: Ragged<Index>,
    /// Edges with both faces in the patch, as indices in `edges`. #T lists
    inner: Ragged<Index>,
    /// The two faces at each interior edge. #E×2
    edges: Vec<[Index; 2]>,
}

impl Patches {
    /// Patches of a mesh whose faces have these centroids. #T×3
    fn of(mesh: &TriangleMesh, centroids: &[DVec3]) -> Self {
        let vertex_neighbours = mesh.vertex_neighbours(centroids);
        let members = build_lists(mesh.face_count(), |f, list| {
            list.extend(vertex_neighbours.get(f));
            list.push(f);
        });
        let of_face =
            Ragged::group(mesh.face_count(), (0..).zip(&mesh.edge_faces).flat_map(|(e, &[f, g])| [(f, e), (g, e)]));
        // Each edge is listed by its lower face, so that it comes once.
        let inside = |f: Index, g: Index| f == g || vertex_neighbours.get(f).binary_search(&g).is_ok();
        let inner = build_lists(mesh.face_count(), |f, list: &mut Vec<Index>| {
            for &g in members.get(f) {
                let is_inner = |e: &&Index| {
                    let [a, b] = mesh.edge_faces[**e as usize];
                    g == a.min(b) && inside(f, a.max(b))
                };
                list.extend(of_face.get(g).iter().filter(is_inner));
            }
        });
        Self { members, inner, edges: mesh.edge_faces.clone() }
    }
}

/// Guidance normals: the mean normal of the most consistent patch at each face.
struct Guidance {
    /// Difference |n₁ − n₂| of the normals at each interior edge. #E
    differences: Vec<f64>,
    /// Inconsistency H and mean normal of each patch. #T
    patches: Vec<(f64, DVec3)>,
    /// Guidance normal gᵢ of each face. #T×3
    normals: Vec<DVec3>,
}

impl Guidance {
    fn new(patches: &Patches) -> Self {
        let count = patches.members.len();
        Self {
            differences: vec![0.0; patches.edges.len()],
            patches: vec![(0.0, DVec3::ZERO); count],
            normals: vec![DVec3::ZERO; count],
        }
    }

    /// Computes the guidance for the current normals.
    fn update(&mut self, patches: &Patches, geometry: &FaceGeometry) {
        let normal = |f: Index| geometry.normals[f as usize];
        self.differences.par_iter_mut().zip(&patches.edges).with_min_len(2048).for_each(|(difference, &[f, g])| {
            *difference = normal(f).distance(normal(g));
        });
        let differences = &self.differences;
        self.patches.par_iter_mut().enumerate().with_min_len(256).for_each_init(
            PatchNormals::default,
            |normals, (f, out)| {
                normals.clear();
                let mut mean = DVec3::ZERO;
                for &g in patches.members.get(f as Index) {
                    mean += normal(g) * geometry.areas[g as usize];
                    normals.push(normal(g));
                }
                let inner = patches.inner.get(f as Index).iter().map(|&e| differences[e as usize]);
                let (largest, sum) = inner.fold((0.0, 0.0), |(largest, sum), d| (larger(largest, d), sum + d));
                *out = (normals.widest() * largest / (sum + 1e-9), mean.normalize_or_zero());
            },
        );
        let found = &self.patches;
        self.normals.par_iter_mut().enumerate().with_min_len(1024).for_each(|(f, out)| {
            let mut best = (f64::INFINITY, DVec3::ZERO);
            for &g in patches.members.get(f as Index) {
                // Of patches that are equal up to rounding the first one is taken, whatever the rounding.
                if found[g as usize].0 < best.0 - 1e-9 {
                    best = found[g as usize];
                }
            }
            *out = best.1;
        });
    }
}

/// Guidance normals for filters that are guided by consistent patches as well.
pub(super) struct PatchGuidance(Patches);

impl PatchGuidance {
    /// Guidance for a mesh whose faces have these centroids. #T×3
    pub(super) fn of(mesh: &TriangleMesh, centroids: &[DVec3]) -> Self {
        Self(Patches::of(mesh, centroids))
    }

    /// Guidance normal of each face, and the inconsistency H of its own patch and of the one that gives the guidance. #T
    pub(super) fn of_geometry(&self, geometry: &FaceGeometry) -> (Vec<DVec3>, Vec<[f32; 2]>) {
        let Self(patches) = self;
        let mut guidance = Guidance::new(patches);
        guidance.update(patches, geometry);
        let score = |f: Index| guidance.patches[f as usize].0 as f32;
        let scores = |f: Index| {
            let least = patches.members.get(f).iter().map(|&g| score(g)).fold(f32::INFINITY, f32::min);
            [score(f), least]
        };
        let scores = (0..patches.members.len() as Index).into_par_iter().with_min_len(1024).map(scores).collect();
        (guidance.normals, scores)
    }
}

/// The normals of a patch, coordinate by coordinate, so that each is compared with the others two at a time.
#[derive(Default)]
struct PatchNormals {
    coordinates: [Vec<f64>; 3],
}

impl PatchNormals {
    fn clear(&mut self) {
        self.coordinates.iter_mut().for_each(Vec::clear);
    }

    fn push(&mut self, normal: DVec3) {
        self.coordinates.iter_mut().zip(normal.to_array()).for_each(|(all, x)| all.push(x));
    }

    /// Largest distance between two normals.
    fn widest(&mut self) -> f64 {
        if self.coordinates[0].len() % 2 == 1 {
            // Repeating the first normal does not change the largest distance.
            self.push(DVec3::from_array([0, 1, 2].map(|axis| self.coordinates[axis][0])));
        }
        let [x, y, z] = &self.coordinates;
        let mut widest = [0.0; 2];
        for k in 0..x.len() {
            let own = [x[k], y[k], z[k]];
            let from = k / 2 * 2;
            // Pairs start at even indices, so that the last one ends where the list does.
            let pairs = x[from..].chunks_exact(2).zip(y[from..].chunks_exact(2)).zip(z[from..].chunks_exact(2));
            for ((px, py), pz) in pairs {
                for lane in 0..2 {
                    let [dx, dy, dz] = [own[0] - px[lane], own[1] - py[lane], own[2] - pz[lane]];
                    widest[lane] = larger(widest[lane], dx * dx + dy * dy + dz * dz);
                }
            }
        }
        larger(widest[0], widest[1]).sqrt()
    }
}

/// Maximum of two numbers, neither of which is NaN, in one instruction; [`f64::max`] takes several.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests;
