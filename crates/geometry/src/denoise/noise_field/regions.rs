//! Regions of a mesh: connected groups of about as many vertices, over which the noise is measured.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::topology::Topology;
use std::collections::VecDeque;

/// A partition of the vertices into connected regions.
pub(super) struct Regions {
    /// Vertices of each region.
    pub(super) vertices: Ragged<Index>,
    /// Connected component of the mesh that each region is a part of.
    pub(super) component: Vec<Index>,
    /// Region of each vertex. #V
    pub(super) of_vertex: Vec<Index>,
}

/// Marks a vertex without a region.
const NONE: Index = Index::MAX;

impl Regions {
    /// Regions around seeds that are more than `rings` rings apart: each vertex belongs to the nearest seed. Regions of fewer
    /// than `least` vertices join a neighbour if they have one. The search for seeds begins at the vertex `start`.
    pub(super) fn of(topology: &Topology, start: Index, rings: u32, least: usize) -> Self {
        let seeds = seeds(topology, start, rings);
        let mut of_vertex = nearest(topology, &seeds);
        let mut vertices = group(seeds.len(), &of_vertex);
        let mut target: Vec<Index> = (0..seeds.len() as Index).collect();
        let mut sizes: Vec<usize> = vertices.iter().map(<[Index]>::len).collect();
        for region in 0..seeds.len() {
            let outside = |v: &Index| {
                let around = topology.rings().get(*v).iter().map(|&w| target[of_vertex[w as usize] as usize]);
                around.into_iter().find(|&r| r as usize != region)
            };
            if sizes[region] < least
                && let Some(neighbour) = vertices.get(region as Index).iter().find_map(outside)
            {
                sizes[neighbour as usize] += sizes[region];
                target.iter_mut().filter(|t| **t as usize == region).for_each(|t| *t = neighbour);
            }
        }
        let mut index = vec![NONE; seeds.len()];
        let mut count = 0;
        for &t in &target {
            if index[t as usize] == NONE {
                index[t as usize] = count;
                count += 1;
            }
        }
        of_vertex.iter_mut().for_each(|r| *r = index[target[*r as usize] as usize]);
        vertices = group(count as usize, &of_vertex);
        let of_component = topology.components().0;
        let component = vertices.iter().map(|members| of_component[members[0] as usize]).collect();
        Self { vertices, component, of_vertex }
    }
}

fn group(count: usize, of_vertex: &[Index]) -> Ragged<Index> {
    Ragged::group(count, (0..).zip(of_vertex).map(|(v, &region)| (region, v)))
}

/// Vertices that are more than `rings` rings apart and leave no room for another one.
fn seeds(topology: &Topology, start: Index, rings: u32) -> Vec<Index> {
    let count = topology.vertex_count() as Index;
    let mut distance = vec![u32::MAX; topology.vertex_count()];
    let mut seeds = Vec::new();
    let mut queue = VecDeque::new();
    for v in (start..count).chain(0..start) {
        if distance[v as usize] <= rings {
            continue;
        }
        seeds.push(v);
        distance[v as usize] = 0;
        queue.push_back(v);
        while let Some(v) = queue.pop_front() {
            let next = distance[v as usize] + 1;
            for &w in topology.rings().get(v).iter().filter(|_| next <= rings) {
                if next < distance[w as usize] {
                    distance[w as usize] = next;
                    queue.push_back(w);
                }
            }
        }
    }
    seeds
}

/// Index of the seed that each vertex reaches over the fewest edges. #V
fn nearest(topology: &Topology, seeds: &[Index]) -> Vec<Index> {
    let mut of_vertex = vec![NONE; topology.vertex_count()];
    let mut queue = VecDeque::from_iter(seeds.iter().copied());
    (0..).zip(seeds).for_each(|(region, &seed)| of_vertex[seed as usize] = region);
    while let Some(v) = queue.pop_front() {
        for &w in topology.rings().get(v) {
            if of_vertex[w as usize] == NONE {
                of_vertex[w as usize] = of_vertex[v as usize];
                queue.push_back(w);
            }
        }
    }
    of_vertex
}
