//! Vertices that fit given face normals.
//!
//! Xianfang Sun, Paul L. Rosin, Ralph R. Martin, Frank C. Langbein. Fast and effective feature-preserving mesh
//! denoising. TVCG 13 (5), 2007, section 4: descent on Σ_f Σ_{i∈f} (n_f · (c_f − pᵢ))², c_f the centroid, with a step
//! that cannot overshoot (eq. 12): pᵢ ← pᵢ + 1/|Fᵢ| Σ_{f∈Fᵢ} n_f (n_f · (c_f − pᵢ)).
//!
//! Only the normals are given, so vertices may drift; a closeness term w |pᵢ − pᵢ⁰|² / 2 holds them to where they came
//! from. A step that would turn a triangle away from its normal is not taken at the vertices of that triangle.
//!
//! The least of that functional can be had at once, see `vertex_update/least_squares.rs`.

pub(super) mod least_squares;

use super::Boundary;
use super::faces::Faces;
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How vertices follow filtered normals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexUpdate {
    /// How the least is looked for.
    #[serde(default)]
    pub scheme: VertexScheme,
    /// Steps of the descent; least squares take as many as they need.
    pub iterations: u32,
    /// w, in units of one face: 1 pulls as hard as one of the faces around. 0 in the papers.
    pub closeness: f64,
    /// What happens at the boundary.
    pub boundary: Boundary,
    /// Where vertices may go.
    pub motion: Motion,
    /// What happens to steps that fold the surface over.
    pub fold_overs: FoldOvers,
}

/// How vertices that fit are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VertexScheme {
    /// A number of steps downhill, as in the papers. Stopping early smooths, too.
    #[default]
    Descent,
    /// The least itself, by conjugate gradients.
    LeastSquares,
}

/// Where vertices may go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Anywhere.
    #[default]
    Free,
    /// Along one normal for each vertex, pᵢ − hᵢ nᵢ: a map of heights can hold all of it. See
    /// [`Along`](super::Along) for how that follows from the free form.
    AlongNormal,
}

/// What happens to steps that fold the surface over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FoldOvers {
    /// A triangle that faces the way of its normal goes on doing so.
    #[default]
    Prevent,
    /// They are taken, as in the papers.
    Allow,
}

impl VertexUpdate {
    /// What the papers do: no closeness, and folds as they come.
    pub fn paper(iterations: u32, boundary: Boundary) -> Self {
        let fold_overs = FoldOvers::Allow;
        let scheme = VertexScheme::Descent;
        Self { scheme, iterations, closeness: 0.0, boundary, motion: Motion::Free, fold_overs }
    }
    /// The same with vertices that keep near to the input, and no folds. On most meshes that brings the normals nearer
    /// to the true ones too.
    pub fn held(self) -> Self {
        Self { closeness: 0.05, fold_overs: FoldOvers::Prevent, ..self }
    }
}

/// Vertices of one surface that follow one field of normals after the other, wherever they are free to go.
pub(super) struct Updater<'a> {
    faces: &'a Faces,
    settings: VertexUpdate,
    input: &'a [DVec3],
    fixed: Vec<bool>,
    positions: Vec<DVec3>,
    next: Vec<DVec3>,
    centroids: Vec<DVec3>,
}

impl<'a> Updater<'a> {
    pub(super) fn new(surface: &'a Surface, faces: &'a Faces, settings: VertexUpdate) -> Self {
        let topology = surface.topology();
        let stays = |v: Index| settings.boundary == Boundary::Fixed && topology.is_boundary(v);
        let input = surface.positions();
        Self {
            faces,
            settings,
            input,
            fixed: (0..input.len() as Index).map(|v| stays(v) || faces.around.get(v).is_empty()).collect(),
            positions: input.to_vec(),
            next: input.to_vec(),
            centroids: vec![DVec3::ZERO; faces.len()],
        }
    }

    /// Where the vertices are. #V×3, model units.
    pub(super) fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// δ = p − p*. #V×3, model units.
    pub(super) fn deltas(&self) -> Vec<DVec3> {
        self.input.iter().zip(&self.positions).map(|(p, x)| *p - x).collect()
    }

    /// Goes towards `normals` (#T×3, unit or zero).
    pub(super) fn follow(&mut self, normals: &[DVec3], progress: &dyn Progress) -> Result<(), Cancelled> {
        let prevent = self.settings.fold_overs == FoldOvers::Prevent;
        if self.settings.scheme == VertexScheme::LeastSquares {
            let Self { faces, settings, input, fixed, positions, .. } = self;
            let system = least_squares::System { faces, normals, fixed, along: None, closeness: settings.closeness };
            self.next = system.solve(positions, input, progress)?;
            if prevent {
                take_folds_back(faces, normals, &self.positions, &mut self.next, least_squares::HALVINGS);
            }
            std::mem::swap(&mut self.positions, &mut self.next);
            return Ok(());
        }
        for _ in 0..self.settings.iterations {
            progress.check()?;
            self.step(normals);
            if prevent {
                take_folds_back(self.faces, normals, &self.positions, &mut self.next, 0);
            }
            std::mem::swap(&mut self.positions, &mut self.next);
        }
        Ok(())
    }

    fn step(&mut self, normals: &[DVec3]) {
        let Self { faces, settings, input, fixed, positions, next, centroids } = self;
        let positions: &[DVec3] = positions;
        centroids.par_iter_mut().zip(&faces.triangles).with_min_len(2048).for_each(|(centroid, t)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            *centroid = (a + b + c) / 3.0;
        });
        let w = settings.closeness;
        next.par_iter_mut().enumerate().with_min_len(1024).for_each(|(v, out)| {
            let p = positions[v];
            if fixed[v] {
                *out = p;
                return;
            }
            let around = faces.around.get(v as Index);
            let pull = around.iter().fold(w * (input[v] - p), |sum, &f| {
                let n = normals[f as usize];
                sum + n * n.dot(centroids[f as usize] - p)
            });
            *out = p + pull / (around.len() as f64 + w);
        });
    }
}

/// Takes vertices of `to` back towards `from`, by half of the way so often and then all of it, until no triangle has
/// turned away from its normal. Each round takes one back at least, and a triangle whose vertices are all back is as it
/// was, so this ends.
pub(super) fn take_folds_back(faces: &Faces, normals: &[DVec3], from: &[DVec3], to: &mut [DVec3], halvings: u8) {
    let faces_normal = |f: Index, points: &[DVec3]| {
        let [a, b, c] = faces.triangles[f as usize].map(|v| points[v as usize]);
        (b - a).cross(c - a).dot(normals[f as usize]) > 0.0
    };
    let turned = |f: &Index, to: &[DVec3]| !faces_normal(*f, to) && faces_normal(*f, from);
    let all = (0..faces.len() as Index).into_par_iter().with_min_len(2048);
    let mut folded: Vec<Index> = all.filter(|f| turned(f, to)).collect();
    let mut halved = vec![0; if halvings == 0 || folded.is_empty() { 0 } else { to.len() }];
    while let Some(f) = folded.pop() {
        if !turned(&f, to) {
            continue;
        }
        for v in faces.triangles[f as usize] {
            let place = v as usize;
            if to[place] == from[place] {
                continue;
            }
            match halved.get_mut(place) {
                Some(times) if *times < halvings => {
                    *times += 1;
                    to[place] = (from[place] + to[place]) / 2.0;
                }
                _ => to[place] = from[place],
            }
            folded.extend(faces.around.get(v));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::faces::Shapes;
    use crate::noise::{self, Noise};
    use crate::progress::Silent;
    use crate::shapes;

    const SETTINGS: VertexUpdate = VertexUpdate {
        scheme: VertexScheme::Descent,
        iterations: 100,
        closeness: 0.0,
        boundary: Boundary::Fixed,
        motion: Motion::Free,
        fold_overs: FoldOvers::Prevent,
    };

    /// A sphere, the same with noise, and its faces.
    fn noisy(sigma: f64) -> (Surface, Surface, Faces) {
        let sphere = shapes::sphere(3);
        let noise = Noise { sigma, direction: noise::Direction::Normal, share: 1.0, seed: 3 };
        let lifted = noise::displacements(&sphere, &noise);
        let noisy = sphere.at(sphere.positions().iter().zip(lifted).map(|(p, d)| *p + d).collect());
        let faces = Faces::of(&sphere);
        (sphere, noisy, faces)
    }

    fn off(faces: &Faces, positions: &[DVec3], normals: &[DVec3]) -> f64 {
        let found = Shapes::of(faces, positions).normals;
        found.iter().zip(normals).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / faces.len() as f64
    }

    #[test]
    fn vertices_reach_normals_that_a_surface_has() {
        let (clean, noisy, faces) = noisy(0.2);
        let normals = Shapes::of(&faces, clean.positions()).normals;
        // From 21°. A hundred steps do not come to the end.
        for (scheme, bound) in [(VertexScheme::Descent, 0.2), (VertexScheme::LeastSquares, 1e-3)] {
            let mut updater = Updater::new(&noisy, &faces, VertexUpdate { scheme, ..SETTINGS });
            updater.follow(&normals, &Silent).unwrap();
            let left = off(&faces, updater.positions(), &normals);
            assert!(left < bound, "{scheme:?}: {left}");
        }
    }

    #[test]
    fn least_squares_are_where_the_descent_ends() {
        let (clean, noisy, faces) = noisy(0.2);
        let normals = Shapes::of(&faces, clean.positions()).normals;
        let end = |scheme| {
            let settings = VertexUpdate { scheme, iterations: 2000, closeness: 0.1, ..SETTINGS };
            let mut updater = Updater::new(&noisy, &faces, settings);
            updater.follow(&normals, &Silent).unwrap();
            updater.deltas()
        };
        let ends = end(VertexScheme::Descent).into_iter().zip(end(VertexScheme::LeastSquares));
        let gap = ends.map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
        // A step takes a share of w / (6 + w) at least of what is left, and 2000 of them leave 1e-14; conjugate gradients
        // leave 1e-8 of the pull, which is sixty times as much of the way where w alone holds a vertex.
        assert!(gap < 1e-6 * noisy.mean_edge(), "{gap:e}");
    }

    #[test]
    fn a_step_is_that_of_the_formula() {
        let (clean, noisy, faces) = noisy(0.2);
        let normals = Shapes::of(&faces, clean.positions()).normals;
        let settings = VertexUpdate { iterations: 1, closeness: 0.3, fold_overs: FoldOvers::Allow, ..SETTINGS };
        let mut updater = Updater::new(&noisy, &faces, settings);
        // The second step starts away from the input, so that closeness pulls back.
        let mut x = noisy.positions().to_vec();
        for _ in 0..2 {
            updater.follow(&normals, &Silent).unwrap();
            let step = |v: usize| {
                let at = |f: usize| faces.triangles[f].map(|w| x[w as usize]);
                let around: Vec<usize> =
                    (0..faces.len()).filter(|&f| faces.triangles[f].contains(&(v as Index))).collect();
                let pull = |&f: &usize| normals[f] * normals[f].dot(at(f).iter().sum::<DVec3>() / 3.0 - x[v]);
                let back = 0.3 * (noisy.positions()[v] - x[v]);
                x[v] + (around.iter().map(pull).sum::<DVec3>() + back) / (around.len() as f64 + 0.3)
            };
            x = (0..x.len()).map(step).collect();
            let gap = updater.positions().iter().zip(&x).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(gap < 1e-14, "{gap:e}");
        }
    }

    #[test]
    fn closeness_holds_vertices_back() {
        let (clean, noisy, faces) = noisy(0.2);
        let target = Shapes::of(&faces, clean.positions()).normals;
        let moved = [0.0, 0.5, 5.0].map(|closeness| {
            let mut updater = Updater::new(&noisy, &faces, VertexUpdate { closeness, ..SETTINGS });
            updater.follow(&target, &Silent).unwrap();
            updater.deltas().iter().map(|d| d.length()).sum::<f64>()
        });
        assert!(moved[0] > moved[1] && moved[1] > moved[2] && moved[2] > 0.0, "{moved:?}");
    }

    #[test]
    fn no_triangle_is_turned_over_where_that_is_prevented() {
        // Normals that nothing can have, in all directions.
        let (_, noisy, faces) = noisy(0.4);
        let before = Shapes::of(&faces, noisy.positions()).normals;
        let target: Vec<DVec3> = before.iter().map(|n| (*n + 0.9 * DVec3::new(n.y, n.z, n.x)).normalize()).collect();
        let turned = |scheme, fold_overs| {
            let mut updater = Updater::new(&noisy, &faces, VertexUpdate { scheme, fold_overs, ..SETTINGS });
            updater.follow(&target, &Silent).unwrap();
            let after = Shapes::of(&faces, updater.positions()).normals;
            let turned = |f: &usize| before[*f].dot(target[*f]) > 0.0 && after[*f].dot(target[*f]) <= 0.0;
            (0..faces.len()).filter(turned).count()
        };
        for scheme in [VertexScheme::Descent, VertexScheme::LeastSquares] {
            assert_eq!(turned(scheme, FoldOvers::Prevent), 0, "{scheme:?}");
        }
        assert!(turned(VertexScheme::Descent, FoldOvers::Allow) > 0, "otherwise this shows nothing");
    }
}
