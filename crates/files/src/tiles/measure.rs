//! Lengths that a method takes from the whole mesh, added in the order in which it adds them there.

use super::part::Part;
use super::plan::{Plan, of_tile};
use super::records::{Numbers, NumbersOut};
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::topology::{EdgeKind, Topology};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::WeldedSurface;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::{Path, PathBuf};

/// Lengths of a whole mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lengths {
    /// Mean length of the edges, model units.
    pub mean_edge: f64,
    /// Mean distance between the centroids of triangles that share an edge, model units.
    pub mean_centroid_distance: f64,
}

/// Writes the lengths of the edges that belong to a tile: those whose first vertex is in it.
pub fn lengths(folder: &Path, tile: usize, progress: &dyn Progress) -> Result<(), Failure> {
    let path = of_tile(folder, tile, "lengths");
    if path.exists() {
        return Ok(());
    }
    let plan = Plan::of(folder)?;
    // The triangles at both ends of an edge have all of their vertices two rings around.
    let part = Part::read(folder, &plan, tile, 2, progress)?;
    let WeldedSurface { weld, surface, .. } = surface_of(&part, plan.welding);
    let own: Vec<Option<Index>> =
        weld.first().iter().map(|&v| (part.rings[v as usize] == 0).then(|| part.ids[v as usize])).collect();
    let positions = surface.positions();
    let edges = surface.topology().edges().iter();
    let edges = edges.map(|[a, b]| (*a, positions[*a as usize].distance(positions[*b as usize])));
    let mut edges = edges.peekable();
    let mut across = centroid_distances(&surface, positions).into_iter().peekable();
    let mut out = NumbersOut::create(path)?;
    for (v, id) in (0..).zip(own) {
        let [edges, across]: [Vec<f64>; 2] = [
            std::iter::from_fn(|| edges.next_if(|(first, _)| *first == v)).map(|(_, length)| length).collect(),
            std::iter::from_fn(|| across.next_if(|(first, _)| *first == v)).map(|(_, length)| length).collect(),
        ];
        if let (Some(id), false) = (id, edges.is_empty() && across.is_empty()) {
            out.index(id)?;
            for lengths in [edges, across] {
                out.index(lengths.len() as u32)?;
                lengths.into_iter().try_for_each(|length| out.number(length))?;
            }
        }
    }
    out.finish()
}

/// Adds up the lengths of all tiles, edge after edge as in the whole mesh.
pub fn measure(folder: &Path) -> Result<Lengths, Failure> {
    let plan = Plan::of(folder)?;
    let [mean_edge, mean_centroid_distance] =
        means((0..plan.tiles.len()).map(|tile| of_tile(folder, tile, "lengths")))?;
    if mean_centroid_distance > 0.0 {
        return Ok(Lengths { mean_edge, mean_centroid_distance });
    }
    Err(Failure::Input("no two faces share an edge, so the method has no length to go by".to_owned()))
}

/// Means of lengths in files, one for each tile: records of a vertex, ascending, with N lists of lengths.
pub(super) fn means<const N: usize>(paths: impl Iterator<Item = PathBuf>) -> Result<[f64; N], Failure> {
    let (mut files, mut next) = (Vec::new(), BinaryHeap::new());
    for (tile, path) in paths.enumerate() {
        let mut file = Numbers::open(path)?;
        if !file.is_at_end()? {
            next.push(Reverse((file.index()?, tile)));
        }
        files.push(file);
    }
    // The sum of no numbers is −0, as in the whole mesh.
    let mut sums = [(-0.0, 0usize); N];
    while let Some(Reverse((_, tile))) = next.pop() {
        let file = &mut files[tile];
        for (sum, count) in &mut sums {
            for _ in 0..file.index()? {
                *sum += file.number()?;
                *count += 1;
            }
        }
        if !file.is_at_end()? {
            next.push(Reverse((file.index()?, tile)));
        }
    }
    Ok(sums.map(|(sum, count)| sum / count as f64))
}

/// Mean length of the edges between the first vertices of a surface, model units: without an anchor.
pub(super) fn mean_edge(surface: &Surface, vertices: usize) -> f64 {
    let (positions, edges) = (surface.positions(), surface.topology().edges());
    let own = edges.iter().filter(|edge| (edge[1] as usize) < vertices);
    let lengths = own.map(|[a, b]| positions[*a as usize].distance(positions[*b as usize]));
    let (sum, count) = lengths.fold((0.0, 0usize), |(sum, count), length| (sum + length, count + 1));
    sum / count.max(1) as f64
}

/// Surface of a part.
pub(super) fn surface_of(part: &Part, welding: Welding) -> WeldedSurface {
    WeldedSurface::new(&part.positions, part.faces.iter().map(|face| face.iter().copied()), welding)
}

/// Distances of the centroids of triangles that share an edge, each with the first vertex of the edge, in the order of the edges. The
/// vertices are at `positions` (#V×3); polygons are cut where the surface has them.
pub(super) fn centroid_distances(surface: &Surface, positions: &[DVec3]) -> Vec<(Index, f64)> {
    let topology = triangles(surface);
    let centroid = |f: Index| {
        let [a, b, c] = [0, 1, 2].map(|k| positions[topology.faces().get(f)[k] as usize]);
        (a + b + c) / 3.0
    };
    let edges = (0..).zip(topology.edges()).filter(|(e, _)| topology.edge_kind(*e) == EdgeKind::Interior);
    edges
        .map(|(e, edge)| {
            let faces = topology.edge_corners().get(e);
            let [f, g]: [DVec3; 2] = [0, 1].map(|k| centroid(topology.face(faces[k])));
            (edge[0], f.distance(g))
        })
        .collect()
}

/// Connectivity of the triangles of a surface, as filters of face normals see it.
fn triangles(surface: &Surface) -> Cow<'_, Topology> {
    let topology = surface.topology();
    if topology.faces().iter().all(|face| face.len() == 3) {
        return Cow::Borrowed(topology);
    }
    let sound = surface.triangles().filter(|[a, b, c]| a != b && b != c && c != a);
    Cow::Owned(Topology::new(topology.vertex_count(), sound.map(Vec::from).collect()))
}
