//! Cuts a surface into patches flat enough to be laid out.
//!
//! David Cohen-Steiner, Pierre Alliez, Mathieu Desbrun. Variational shape approximation.
//! SIGGRAPH 2004: Lloyd's clustering, the distance from a face to a patch being the difference of
//! their normals. The distance to the seed is added, which keeps patches round.

use crate::mesh::{Mesh, area_vector, faces_across};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

const ROUNDS: usize = 24;
const STRAIGHTENING_ROUNDS: usize = 8;
/// Weight of the squared distance to the seed, in units of a patch's radius, against the squared
/// difference of unit normals.
const COMPACTNESS: f64 = 0.3;

/// What clustering asks of the faces of a mesh.
pub(crate) struct Faces {
    centroids: Vec<DVec3>,
    /// Outward normals times twice the area.
    area_vectors: Vec<DVec3>,
    across: Vec<[usize; 3]>,
    /// Faces that share a vertex with each face; those that share two are listed twice.
    around: Vec<Vec<usize>>,
}

impl Faces {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let corners = || mesh.triangles.iter().map(|&t| mesh.corners(t));
        let mut rings = vec![Vec::new(); mesh.positions.len()];
        for (f, triangle) in mesh.triangles.iter().enumerate() {
            for &v in triangle {
                rings[v].push(f);
            }
        }
        let around = |t: &[usize; 3]| t.iter().flat_map(|&v| rings[v].clone()).collect();
        Self {
            around: mesh.triangles.iter().map(around).collect(),
            centroids: corners().map(|[a, b, c]| (a + b + c) / 3.0).collect(),
            area_vectors: corners().map(area_vector).collect(),
            across: faces_across(&mesh.triangles),
        }
    }

    /// The three faces that share an edge with `face`.
    pub(crate) fn across(&self, face: usize) -> [usize; 3] {
        self.across[face]
    }

    pub(crate) fn area(&self, faces: &[usize]) -> f64 {
        0.5 * faces.iter().map(|&f| self.area_vectors[f].length()).sum::<f64>()
    }

    /// Connected sets of faces with equal labels.
    pub(crate) fn components(&self, faces: &[usize], label: impl Fn(usize) -> usize) -> Vec<Vec<usize>> {
        let mut is_waiting = vec![false; self.across.len()];
        for &f in faces {
            is_waiting[f] = true;
        }
        let mut components = Vec::new();
        for &first in faces {
            if !std::mem::take(&mut is_waiting[first]) {
                continue;
            }
            let mut component = vec![first];
            let mut next = 0;
            while let Some(&f) = component.get(next) {
                next += 1;
                for g in self.across[f] {
                    if is_waiting[g] && label(g) == label(f) {
                        is_waiting[g] = false;
                        component.push(g);
                    }
                }
            }
            component.sort_unstable();
            components.push(component);
        }
        components
    }

    /// Cuts a connected set of faces into about `count` connected patches with straight borders.
    pub(crate) fn partition(&self, faces: &[usize], count: usize) -> Vec<Vec<usize>> {
        let mut patch_of = self.cluster(faces, count);
        let ragged = patch_of.clone();
        self.straighten_borders(faces, &mut patch_of);
        let patches = self.components(faces, |f| patch_of[f].unwrap_or(usize::MAX));
        if patches.len() >= count {
            return patches;
        }
        // Straightening swallowed a small patch: rather ragged than too few.
        self.components(faces, |f| ragged[f].unwrap_or(usize::MAX))
    }

    /// The patch of each face; exactly `count` patches, each connected.
    fn cluster(&self, faces: &[usize], count: usize) -> Vec<Option<usize>> {
        let mut seeds = self.spread_seeds(faces, count);
        let radius2 = self.area(faces) / count as f64;
        let mut patch_of = vec![None; self.across.len()];
        let mut normals: Vec<_> = seeds.iter().map(|&s| self.area_vectors[s].normalize()).collect();
        for _ in 0..ROUNDS {
            let cost = |f: usize, patch: usize| {
                let turn = self.area_vectors[f].normalize_or_zero() - normals[patch];
                let away = self.centroids[f] - self.centroids[seeds[patch]];
                turn.length_squared() + COMPACTNESS * away.length_squared() / radius2
            };
            patch_of = self.grow(faces, &seeds, cost);
            let mut sums = vec![DVec3::ZERO; seeds.len()];
            let mut middles = vec![(DVec3::ZERO, 0.0); seeds.len()];
            for &f in faces {
                if let Some(patch) = patch_of[f] {
                    let weight = self.area_vectors[f].length();
                    sums[patch] += self.area_vectors[f];
                    middles[patch].0 += weight * self.centroids[f];
                    middles[patch].1 += weight;
                }
            }
            normals = sums.iter().map(|n| n.normalize_or_zero()).collect();
            for (patch, seed) in seeds.iter_mut().enumerate() {
                let middle = middles[patch].0 / middles[patch].1;
                let distance = |f: &usize| self.centroids[*f].distance_squared(middle);
                let own = faces.iter().copied().filter(|&f| patch_of[f] == Some(patch));
                let nearest = own.min_by(|f, g| distance(f).total_cmp(&distance(g)));
                *seed = nearest.unwrap_or(*seed);
            }
        }
        patch_of
    }

    /// Faces far from each other, each the farthest from those before it.
    fn spread_seeds(&self, faces: &[usize], count: usize) -> Vec<usize> {
        let farthest = |seeds: &[usize]| {
            let distance = |f: &usize| {
                let from = |s: &usize| self.centroids[*s].distance_squared(self.centroids[*f]);
                seeds.iter().map(from).fold(f64::INFINITY, f64::min)
            };
            faces.iter().copied().max_by(|f, g| distance(f).total_cmp(&distance(g)))
        };
        let mut seeds: Vec<usize> = farthest(&faces[..1]).into_iter().collect();
        while seeds.len() < count {
            seeds.extend(farthest(&seeds));
        }
        seeds
    }

    /// Grows patches from their seeds, the cheapest face first.
    fn grow(&self, faces: &[usize], seeds: &[usize], cost: impl Fn(usize, usize) -> f64) -> Vec<Option<usize>> {
        let mut is_waiting = vec![false; self.across.len()];
        for &f in faces {
            is_waiting[f] = true;
        }
        let mut patch_of = vec![None; self.across.len()];
        let mut queue: BinaryHeap<_> =
            seeds.iter().enumerate().map(|(patch, &face)| Candidate { cost: 0.0, face, patch }).collect();
        while let Some(Candidate { face, patch, .. }) = queue.pop() {
            if !std::mem::take(&mut is_waiting[face]) {
                continue;
            }
            patch_of[face] = Some(patch);
            let beside = self.across[face].into_iter().filter(|&f| is_waiting[f]);
            queue.extend(beside.map(|face| Candidate { cost: cost(face, patch), face, patch }));
        }
        patch_of
    }

    /// Gives each face to the patch that most faces around its corners belong to, which cuts off
    /// tongues; then to the one across two of its edges, which cuts off teeth.
    fn straighten_borders(&self, faces: &[usize], patch_of: &mut [Option<usize>]) {
        for _ in 0..STRAIGHTENING_ROUNDS {
            for &f in faces {
                patch_of[f] = majority(patch_of[f], self.around[f].iter().map(|&g| patch_of[g]));
            }
        }
        for _ in 0..STRAIGHTENING_ROUNDS {
            for &f in faces {
                patch_of[f] = majority(patch_of[f], self.across[f].into_iter().map(|g| patch_of[g]));
            }
        }
    }
}

/// The patch with most votes; `own` if none has more.
fn majority(own: Option<usize>, votes: impl Iterator<Item = Option<usize>>) -> Option<usize> {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for patch in votes.flatten() {
        *counts.entry(patch).or_default() += 1;
    }
    let count = |patch: Option<usize>| patch.and_then(|p| counts.get(&p).copied()).unwrap_or(0);
    counts.keys().copied().map(Some).fold(own, |best, patch| if count(patch) > count(best) { patch } else { best })
}

/// A face that a patch could take next; the cheapest is the greatest.
struct Candidate {
    cost: f64,
    face: usize,
    patch: usize,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |c: &Self| (c.face, c.patch);
        other.cost.total_cmp(&self.cost).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}
