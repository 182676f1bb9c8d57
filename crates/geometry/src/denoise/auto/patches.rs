//! A part of a large mesh on which candidates are tried.

use crate::denoise::connectivity::Connectivity;
use crate::ragged::Index;
use crate::surface::Surface;
use crate::topology::Topology;

/// How much is enough.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// Meshes of up to so many triangles are tried as a whole.
    pub(super) whole: usize,
    /// Of a larger one, so many patches
    pub(super) patches: usize,
    /// of so many triangles each.
    pub(super) patch: usize,
    /// Rings around each patch that are denoised along with it but not judged: its rim is not one of the mesh.
    pub(super) margin: usize,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { whole: 24_000, patches: 10, patch: 1_500, margin: 4 }
    }
}

/// Patches of a surface.
pub(super) struct Part {
    pub(super) surface: Surface,
    pub(super) net: Connectivity,
    /// The vertex of the whole surface that each of the part's is.
    pub(super) vertices: Vec<Index>,
    /// Which triangles are judged.
    pub(super) judged: Vec<bool>,
}

/// Patches spread over the triangles; none for a mesh that is small enough to be tried as a whole.
pub(super) fn part(surface: &Surface, net: &Connectivity, sizes: Sizes) -> Option<Part> {
    let count = net.faces.len();
    if count <= sizes.whole {
        return None;
    }
    let judged = grown(net, (0..sizes.patches).map(|k| k * count / sizes.patches), sizes.patch);
    let mut near = vec![false; surface.positions().len()];
    let mut inside = judged.clone();
    for _ in 0..sizes.margin {
        for (t, _) in net.faces.triangles.iter().zip(&inside).filter(|(_, inside)| **inside) {
            t.iter().for_each(|&v| near[v as usize] = true);
        }
        for (t, inside) in net.faces.triangles.iter().zip(&mut inside) {
            *inside |= t.iter().any(|&v| near[v as usize]);
        }
    }
    let mut place = vec![Index::MAX; surface.positions().len()];
    for (t, _) in net.faces.triangles.iter().zip(&inside).filter(|(_, inside)| **inside) {
        t.iter().for_each(|&v| place[v as usize] = 0);
    }
    let vertices: Vec<Index> = (0..).zip(&place).filter(|(_, p)| **p == 0).map(|(v, _)| v).collect();
    (0..).zip(&vertices).for_each(|(k, &v)| place[v as usize] = k);
    let kept = || net.faces.triangles.iter().zip(&inside).zip(&judged).filter(|((_, inside), _)| **inside);
    let faces = kept().map(|((t, _), _)| t.map(|v| place[v as usize]).to_vec()).collect();
    let positions = vertices.iter().map(|&v| surface.positions()[v as usize]).collect();
    let part = Surface::new(Topology::new(vertices.len(), faces), positions);
    let net = Connectivity::of(&part);
    Some(Part { judged: kept().map(|(_, judged)| *judged).collect(), surface: part, net, vertices })
}

/// Patches that grow from their seeds over edges until they have their size or meet each other.
fn grown(net: &Connectivity, seeds: impl Iterator<Item = usize>, size: usize) -> Vec<bool> {
    let mut taken = vec![false; net.faces.len()];
    for seed in seeds {
        let mut queue = Vec::from_iter((!taken[seed]).then_some(seed));
        queue.iter().for_each(|&f| taken[f] = true);
        let mut next = 0;
        while next < queue.len() && queue.len() < size {
            for g in net.beside(queue[next]) {
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
