//! Connectivity of a triangle mesh as the estimates of noise and surface need it.

use super::faces::Faces;
use super::umbrella::Umbrella;
use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;

/// Connectivity as the estimate needs it.
pub(super) struct Connectivity {
    pub(super) faces: Faces,
    pub(super) umbrella: Umbrella,
    /// For each face the place in `faces.pairs`, and the other face, of each edge that has two.
    pub(super) sides: Ragged<(Index, Index)>,
    /// Triangles at each vertex, and which corner of theirs it is.
    pub(super) corners: Ragged<(Index, u8)>,
}

impl Connectivity {
    pub(super) fn of(surface: &Surface) -> Self {
        let faces = Faces::of(surface);
        let both = (0..).zip(&faces.pairs).flat_map(|(e, &[f, g])| [(f, (e, g)), (g, (e, f))]);
        let sides = Ragged::group(faces.len(), both);
        let all = (0..).zip(&faces.triangles).flat_map(|(f, t)| (0..3u8).map(move |k| (t[usize::from(k)], (f, k))));
        let corners = Ragged::group(surface.positions().len(), all);
        Self { faces, umbrella: Umbrella::of(surface), sides, corners }
    }

    /// Faces that share an edge with this one.
    pub(super) fn beside(&self, face: usize) -> impl Iterator<Item = usize> + '_ {
        self.sides.get(face as Index).iter().map(|side| side.1 as usize)
    }

    /// Area-weighted unit normals. #V×3
    pub(super) fn vertex_normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let doubled: Vec<DVec3> = self.faces.triangles.par_iter().map(|t| doubled_area(t, positions)).collect();
        let sum = |v: usize| self.faces.around.get(v as Index).iter().map(|&f| doubled[f as usize]).sum::<DVec3>();
        (0..positions.len()).into_par_iter().with_min_len(1024).map(|v| sum(v).normalize_or_zero()).collect()
    }

    /// δ = p − p* for ways from `input` (#V×3), zero at vertices that have to stay: until no triangle that faces the way of
    /// the mean normal at its vertices in the input faces away from it, or is turned over and farther from it than before.
    /// Light noise (`sigma` in mean edges) turns hardly any triangle over: one that the estimate turns over was a fold of
    /// the surface itself, and goes back as well. Each round puts one back at least, so this ends.
    pub(super) fn without_folds(&self, input: &[DVec3], ways: Vec<DVec3>, sigma: f64) -> Vec<DVec3> {
        // Decimated scans have a fold in a few hundred triangles. Noise of that size turns over about as many.
        const LIGHT: f64 = 0.15;
        let mut ways = ways;
        let moved: Vec<DVec3> = input.iter().zip(&ways).map(|(p, way)| *p + way).collect();
        let normals = self.vertex_normals(&moved);
        let faces = &self.faces;
        let turned = |f: Index, ways: &[DVec3]| {
            let t = faces.triangles[f as usize];
            let mean: DVec3 = t.iter().map(|&v| normals[v as usize]).sum();
            let before = doubled_area(&t, input).normalize_or_zero();
            let [a, b, c] = t.map(|v| input[v as usize] + ways[v as usize]);
            let after = (b - a).cross(c - a).normalize_or_zero();
            let (upright, now) = (before.dot(mean), after.dot(mean));
            let over = before.dot(after) < 0.0;
            (sigma < LIGHT && over) || (upright > 0.0 && (now <= 0.0 || (over && now < upright)))
        };
        let mut folded: Vec<Index> = (0..faces.len() as Index).filter(|&f| turned(f, &ways)).collect();
        while let Some(f) = folded.pop() {
            if !turned(f, &ways) {
                continue;
            }
            for v in faces.triangles[f as usize] {
                if ways[v as usize] != DVec3::ZERO {
                    ways[v as usize] = DVec3::ZERO;
                    folded.extend(faces.around.get(v));
                }
            }
        }
        ways.iter().map(|way| -*way).collect()
    }
}

fn doubled_area(triangle: &[Index; 3], positions: &[DVec3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn folds_of_the_surface_stay_in_light_noise_and_go_in_heavy_noise() {
        let flat = shapes::grid(8);
        let net = Connectivity::of(&flat);
        let inner = (0..).zip(flat.positions()).find(|(_, p)| (**p - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-9);
        let (moved, _) = inner.unwrap();
        let mut folded = flat.positions().to_vec();
        // Over the triangles beside it: a cell is an eighth.
        folded[moved] += DVec3::new(0.2, 0.03, 0.0);
        let ways: Vec<DVec3> = flat.positions().iter().zip(&folded).map(|(to, from)| *to - *from).collect();
        let kept = |sigma: f64| net.without_folds(&folded, ways.clone(), sigma)[moved];
        assert_eq!(kept(0.1), DVec3::ZERO);
        assert_eq!(kept(0.3), -ways[moved]);
    }
}
