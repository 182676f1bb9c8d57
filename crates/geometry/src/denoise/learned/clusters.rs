//! A pyramid of clusters of faces, for looking far without looking at every face.

use crate::mesh::jagged::{Index, Ragged};
use glam::Vec3;

/// Faces, or clusters of them, with what is averaged over a cluster.
#[derive(Default)]
pub(super) struct Level {
    /// Cluster of each item of the level below.
    pub(super) cluster_of: Vec<Index>,
    /// Area of each cluster.
    pub(super) areas: Vec<f32>,
    /// Centroid of each cluster.
    pub(super) centroids: Vec<Vec3>,
    /// Mean normal of each cluster, weighted by area; its length says how alike the normals are.
    pub(super) normals: Vec<Vec3>,
    /// Mean guidance normal of each cluster, a unit vector or zero.
    pub(super) guidance: Vec<Vec3>,
    /// Scale of each cluster: the mean of its items'.
    pub(super) scales: Vec<f32>,
    /// Clusters beside each cluster, ascending.
    pub(super) neighbours: Ragged<Index>,
}

/// Largest number of items of a cluster.
const LARGEST: usize = 400;

impl Level {
    /// Gathers the items of `fine`: each cluster grows from the first item that has none, over neighbours that are nearer to that item
    /// than `radius` times its scale.
    pub(super) fn above(fine: &Fine, radius: f32) -> Self {
        let count = fine.areas.len();
        let mut cluster_of = vec![Index::MAX; count];
        let mut clusters: Index = 0;
        let mut queue = Vec::new();
        for seed in 0..count {
            if cluster_of[seed] != Index::MAX {
                continue;
            }
            let reach = (radius * fine.scales[seed]).powi(2);
            queue.clear();
            queue.push(seed as Index);
            cluster_of[seed] = clusters;
            let mut next = 0;
            while next < queue.len().min(LARGEST) {
                for &item in fine.neighbours.get(queue[next]) {
                    let near = fine.centroids[item as usize].distance_squared(fine.centroids[seed]) < reach;
                    if cluster_of[item as usize] == Index::MAX && near {
                        cluster_of[item as usize] = clusters;
                        queue.push(item);
                    }
                }
                next += 1;
            }
            clusters += 1;
        }
        let size = clusters as usize;
        let [mut areas, mut scales, mut members] = [(); 3].map(|()| vec![0.0f32; size]);
        let [mut centroids, mut normals, mut guidance] = [(); 3].map(|()| vec![Vec3::ZERO; size]);
        for (item, &cluster) in cluster_of.iter().enumerate() {
            let (c, area) = (cluster as usize, fine.areas[item]);
            areas[c] += area;
            scales[c] += fine.scales[item];
            members[c] += 1.0;
            centroids[c] += fine.centroids[item] * area;
            normals[c] += fine.normals[item] * area;
            guidance[c] += fine.guidance[item] * area;
        }
        for c in 0..size {
            centroids[c] /= areas[c];
            normals[c] /= areas[c];
            guidance[c] = guidance[c].normalize_or_zero();
            scales[c] /= members[c];
        }
        let mut pairs = Vec::new();
        for (item, &a) in (0..).zip(&cluster_of) {
            let beside = fine.neighbours.get(item).iter().map(|&other| cluster_of[other as usize]);
            pairs.extend(beside.filter(|&b| b != a).map(|b| (a, b)));
        }
        pairs.sort_unstable();
        pairs.dedup();
        let neighbours = Ragged::group(size, pairs.iter().copied());
        Self { cluster_of, areas, centroids, normals, guidance, scales, neighbours }
    }

    /// The level as items of the next one.
    pub(super) fn as_fine(&self) -> Fine<'_> {
        let Self { areas, centroids, normals, guidance, scales, neighbours, .. } = self;
        Fine { areas, centroids, normals, guidance, scales, neighbours }
    }
}

/// Items that are gathered into clusters.
#[derive(Clone, Copy)]
pub(super) struct Fine<'a> {
    pub(super) areas: &'a [f32],
    pub(super) centroids: &'a [Vec3],
    pub(super) normals: &'a [Vec3],
    pub(super) guidance: &'a [Vec3],
    pub(super) scales: &'a [f32],
    pub(super) neighbours: &'a Ragged<Index>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_have_the_area_the_centroid_and_the_mean_normals_of_their_items() {
        // A row of items of unlike areas, each beside the next.
        let count = 40;
        let x = |k: usize| k as f32;
        let areas: Vec<f32> = (0..count).map(|k| 1.0 + 0.3 * x(k % 7)).collect();
        let centroids: Vec<Vec3> = (0..count).map(|k| Vec3::new(x(k), (0.7 * x(k)).sin(), 0.0)).collect();
        let normals: Vec<Vec3> = (0..count).map(|k| Vec3::new(0.2 * x(k % 3), 0.1, 1.0).normalize()).collect();
        let guidance: Vec<Vec3> = (0..count).map(|k| Vec3::new(0.1, 0.2 * x(k % 5), 1.0).normalize()).collect();
        let scales: Vec<f32> = (0..count).map(|k| 1.0 + 0.1 * x(k % 4)).collect();
        let beside = (0..count as Index).flat_map(|k| {
            [k.checked_sub(1), (k + 1 < count as Index).then_some(k + 1)].into_iter().flatten().map(move |w| (k, w))
        });
        let neighbours = Ragged::group(count, beside);
        let [areas, scales] = [&areas[..], &scales[..]];
        let (centroids, normals, guidance) = (&centroids[..], &normals[..], &guidance[..]);
        let found = Level::above(&Fine { areas, centroids, normals, guidance, scales, neighbours: &neighbours }, 3.0);
        assert!(found.areas.len() > 3 && found.areas.len() < count / 2, "{}", found.areas.len());
        for c in 0..found.areas.len() {
            let members: Vec<usize> = (0..count).filter(|&k| found.cluster_of[k] as usize == c).collect();
            let area: f32 = members.iter().map(|&k| areas[k]).sum();
            let mean = |of: &[Vec3]| members.iter().map(|&k| of[k] * areas[k]).sum::<Vec3>() / area;
            assert!((found.areas[c] - area).abs() < 1e-4);
            assert!(found.centroids[c].distance(mean(centroids)) < 1e-4);
            assert!(found.normals[c].distance(mean(normals)) < 1e-5);
            assert!(found.guidance[c].distance(mean(guidance).normalize()) < 1e-5);
            let scale = members.iter().map(|&k| scales[k]).sum::<f32>() / members.len() as f32;
            assert!((found.scales[c] - scale).abs() < 1e-5);
            // Clusters of a row are beside those before and after them.
            let near = |other: usize| {
                members.iter().any(|&k| {
                    found.cluster_of[k.saturating_sub(1)] as usize == other
                        || found.cluster_of[(k + 1).min(count - 1)] as usize == other
                })
            };
            let expected: Vec<Index> =
                (0..found.areas.len()).filter(|&o| o != c && near(o)).map(|o| o as Index).collect();
            assert_eq!(found.neighbours.get(c as Index), expected);
        }
    }
}
