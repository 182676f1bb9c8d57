//! Patches of a large mesh, on which candidates are evaluated instead of on the whole.

use crate::denoise::connectivity::Connectivity;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;

/// Sizes of the patches.
#[derive(Clone, Copy)]
pub(super) struct PatchSizes {
    /// Largest number of triangles of a mesh on which candidates are evaluated as a whole.
    pub(super) whole: usize,
    /// Number of patches of a larger mesh.
    pub(super) patches: usize,
    /// Number of triangles in a patch.
    pub(super) triangles: usize,
    /// Number of rings around a patch that are denoised along with it but not evaluated: its boundary is not one of the mesh.
    pub(super) margin: usize,
}

impl Default for PatchSizes {
    fn default() -> Self {
        Self { whole: 6_000, patches: 6, triangles: 1_000, margin: 4 }
    }
}

/// The patches of a surface with their margins, as a surface.
pub(super) struct Subsample {
    pub(super) surface: Surface,
    pub(super) connectivity: Connectivity,
    /// Index in the whole surface of each vertex. #V
    pub(super) vertices: Vec<Index>,
    /// True for triangles of the patches, false for those of the margins. #T
    pub(super) evaluated: Vec<bool>,
}

/// Takes patches from all over the surface; `None` for a mesh that is small enough to be evaluated as a whole.
pub(super) fn subsample(surface: &Surface, connectivity: &Connectivity, sizes: PatchSizes) -> Option<Subsample> {
    let triangles = &connectivity.mesh.triangles;
    let count = triangles.len();
    if count <= sizes.whole {
        return None;
    }
    let seeds = (0..sizes.patches).map(|k| k * count / sizes.patches);
    let evaluated = grow_patches(connectivity, seeds, sizes.triangles);
    let kept = with_margin(triangles, &evaluated, sizes.margin, surface.positions().len());
    let mut used = vec![false; surface.positions().len()];
    for (t, _) in triangles.iter().zip(&kept).filter(|(_, kept)| **kept) {
        t.iter().for_each(|&v| used[v as usize] = true);
    }
    let vertices: Vec<Index> = (0..).zip(&used).filter(|(_, used)| **used).map(|(v, _)| v).collect();
    let mut index = vec![Index::MAX; used.len()];
    (0..).zip(&vertices).for_each(|(k, &v)| index[v as usize] = k);
    let kept_faces = || (0..count).filter(|&f| kept[f]);
    let faces = kept_faces().map(|f| triangles[f].map(|v| index[v as usize]).to_vec()).collect();
    let positions = vertices.iter().map(|&v| surface.positions()[v as usize]).collect();
    let part = Surface::new(Topology::new(vertices.len(), faces), positions);
    Some(Subsample {
        connectivity: Connectivity::of(&part),
        surface: part,
        vertices,
        evaluated: kept_faces().map(|f| evaluated[f]).collect(),
    })
}

/// Patches and so many rings of triangles around them. #T
fn with_margin(triangles: &[[Index; 3]], patches: &[bool], rings: usize, vertex_count: usize) -> Vec<bool> {
    let mut inside = patches.to_vec();
    let mut near = vec![false; vertex_count];
    for _ in 0..rings {
        for (t, _) in triangles.iter().zip(&inside).filter(|(_, inside)| **inside) {
            t.iter().for_each(|&v| near[v as usize] = true);
        }
        for (t, inside) in triangles.iter().zip(&mut inside) {
            *inside |= t.iter().any(|&v| near[v as usize]);
        }
    }
    inside
}

/// Patches that grow from their seeds over edges until they have their size or meet each other. #T
fn grow_patches(connectivity: &Connectivity, seeds: impl Iterator<Item = usize>, size: usize) -> Vec<bool> {
    let mut taken = vec![false; connectivity.mesh.face_count()];
    for seed in seeds {
        let mut queue = Vec::from_iter((!taken[seed]).then_some(seed));
        queue.iter().for_each(|&f| taken[f] = true);
        let mut next = 0;
        while next < queue.len() && queue.len() < size {
            for g in connectivity.edge_neighbours(queue[next]) {
                if !taken[g] && queue.len() < size {
                    taken[g] = true;
                    queue.push(g);
                }
            }
            next += 1;
        }
    }
    taken
}
