//! Triangles that are flipped: by noise, which an estimate of the surface unfolds, and by an estimate, which is undone there.

use super::connectivity::{Connectivity, doubled_area};
use super::noise_field::NoiseField;
use crate::mesh::jagged::Index;
use glam::DVec3;
use rayon::prelude::*;

/// Deviation, local edges, up to which noise turns over hardly more triangles than decimated scans have folds.
const LIGHT_NOISE: f64 = 0.15;

impl Connectivity {
    /// Unfolds triangles that noise has turned over: vertices around them spread evenly within the surface. `offsets` are those
    /// of the vertices from `input`. #V×3, model units
    ///
    /// Noise of all directions folds triangles that are small beside it, and a data term that holds vertices across their normals
    /// keeps the folds. Light noise folds hardly any: a fold there is one of the surface itself.
    pub(super) fn unfold(&self, input: &[DVec3], offsets: &mut [DVec3], noise: &NoiseField) {
        /// Cosine of the angle to the smoothed surface beyond which a triangle is on its way to turn over.
        const TURNED: f64 = 0.3;
        /// Largest number of steps.
        const STEPS: usize = 30;
        let mesh = &self.mesh;
        let mut positions: Vec<DVec3> = input.iter().zip(&*offsets).map(|(p, offset)| *p + *offset).collect();
        for _ in 0..STEPS {
            let normals = self.smoothed_normals(&positions);
            let is_turned = |t: &[Index; 3]| {
                let mean = t.iter().map(|&v| normals[v as usize]).sum::<DVec3>().normalize_or_zero();
                doubled_area(t, &positions).normalize_or_zero().dot(mean) < TURNED
            };
            let mut spreads = vec![false; positions.len()];
            let mut any = false;
            for t in mesh.triangles.iter().filter(|t| is_turned(t)) {
                for v in t {
                    if noise.relative[*v as usize] > LIGHT_NOISE && !self.umbrella.irregular[*v as usize] {
                        spreads[*v as usize] = true;
                        any = true;
                    }
                }
            }
            if !any {
                break;
            }
            let step = |v: usize| {
                if !spreads[v] {
                    return positions[v];
                }
                let umbrella = self.umbrella.at(&positions, v);
                positions[v] - 0.6 * umbrella.reject_from_normalized(normals[v])
            };
            positions = (0..positions.len()).into_par_iter().map(step).collect();
        }
        for ((offset, x), p) in offsets.iter_mut().zip(&positions).zip(input) {
            *offset = *x - *p;
        }
    }

    /// Vertex normals averaged over two rings, which single triangles that have turned over do not turn. #V×3
    fn smoothed_normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let mut normals = self.vertex_normals(positions);
        for _ in 0..2 {
            normals = self.umbrella.lazy_step(&normals).into_iter().map(DVec3::normalize_or_zero).collect();
        }
        normals
    }

    /// Undoes offsets from `input` (#V×3) that flip triangles, and returns δ = p − p*, the negated offsets.
    ///
    /// A vertex is reset while one of its triangles agreed with the mean vertex normal before and disagrees now, or has
    /// flipped and disagrees more than before. Light noise flips hardly any triangle: one that an
    /// estimate flips back was a fold of the surface itself, so there every flip is undone. Each round resets a vertex at
    /// least, so this ends.
    pub(super) fn undo_flips(&self, input: &[DVec3], mut offsets: Vec<DVec3>, noise: &NoiseField) -> Vec<DVec3> {
        let moved: Vec<DVec3> = input.iter().zip(&offsets).map(|(p, offset)| *p + *offset).collect();
        let normals = self.vertex_normals(&moved);
        let mesh = &self.mesh;
        let flipped = |f: Index, offsets: &[DVec3]| {
            let t = mesh.triangles[f as usize];
            let mean: DVec3 = t.iter().map(|&v| normals[v as usize]).sum();
            let before = doubled_area(&t, input).normalize_or_zero();
            let [a, b, c] = t.map(|v| input[v as usize] + offsets[v as usize]);
            let after = (b - a).cross(c - a).normalize_or_zero();
            let (agreed, agrees) = (before.dot(mean), after.dot(mean));
            let turned_over = before.dot(after) < 0.0;
            let is_light = t.iter().all(|&v| noise.relative[v as usize] < LIGHT_NOISE);
            (is_light && turned_over) || (agreed > 0.0 && (agrees <= 0.0 || (turned_over && agrees < agreed)))
        };
        let mut queue: Vec<Index> = (0..mesh.face_count() as Index).filter(|&f| flipped(f, &offsets)).collect();
        while let Some(f) = queue.pop() {
            if !flipped(f, &offsets) {
                continue;
            }
            for v in mesh.triangles[f as usize] {
                if offsets[v as usize] != DVec3::ZERO {
                    offsets[v as usize] = DVec3::ZERO;
                    queue.extend(mesh.vertex_faces.get(v));
                }
            }
        }
        offsets.iter().map(|offset| -*offset).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn folds_of_the_surface_stay_in_light_noise_and_go_in_heavy_noise() {
        let flat = shapes::grid(8);
        let connectivity = Connectivity::of(&flat);
        let inner = (0..).zip(flat.positions()).find(|(_, p)| (**p - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-9);
        let (moved, _) = inner.unwrap();
        let mut folded = flat.positions().to_vec();
        // Over the triangles beside it: a cell is an eighth.
        folded[moved] += DVec3::new(0.2, 0.03, 0.0);
        let offsets: Vec<DVec3> = flat.positions().iter().zip(&folded).map(|(to, from)| *to - *from).collect();
        let kept = |sigma: f64| {
            let noise = NoiseField::uniform(folded.len(), sigma, 0.125, 0.0);
            connectivity.undo_flips(&folded, offsets.clone(), &noise)[moved]
        };
        assert_eq!(kept(0.1), DVec3::ZERO);
        assert_eq!(kept(0.3), -offsets[moved]);
    }

    #[test]
    fn triangles_that_were_turned_over_unfold_in_heavy_noise_and_stay_in_light_noise() {
        let flat = shapes::grid(8);
        let connectivity = Connectivity::of(&flat);
        let moved = flat.positions().iter().position(|p| (*p - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-9).unwrap();
        let mut folded = flat.positions().to_vec();
        folded[moved] += DVec3::new(0.2, 0.03, 0.0);
        let turned = |offsets: &[DVec3]| {
            let at: Vec<DVec3> = folded.iter().zip(offsets).map(|(p, offset)| *p + *offset).collect();
            connectivity.mesh.triangles.iter().filter(|t| doubled_area(t, &at).z <= 0.0).count()
        };
        let unfolded = |sigma: f64| {
            let mut offsets = vec![DVec3::ZERO; folded.len()];
            connectivity.unfold(&folded, &mut offsets, &NoiseField::uniform(folded.len(), sigma, 0.125, 0.0));
            offsets
        };
        let still = vec![DVec3::ZERO; folded.len()];
        assert!(turned(&still) > 0 && turned(&unfolded(0.3)) == 0, "{}", turned(&unfolded(0.3)));
        assert_eq!(unfolded(0.1), still);
    }
}
