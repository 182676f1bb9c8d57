//! The learned filter as a partner of the mixture: its last network says for each face how far to trust which.
//!
//! It is asked only where the estimate found noise, so what is left alone stays so. White noise that was taken off is still white: where
//! a result takes off something that neighbours share, it takes shape off (the residual whiteness principle). Then the mixture stands.
//! How far the result counts beside the mixture is estimated beforehand (see `evaluate.rs`).

use super::{Found, Prepared};
use crate::denoise::choice::{Candidate, CandidateShare};
use crate::denoise::connectivity::Connectivity;
use crate::denoise::learned;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// By how much more the displacements of neighbours may be alike than those of the mixture, in white noise. On pieces of training
/// shapes, results were as often worse as better from here on.
const MORE_ALIKE: f64 = 0.2;

impl Prepared<'_> {
    /// Runs the learned filter, with the mixture at hand, on the vertices that have noise. The shares of what it finds are those that are
    /// not the mixture's. `None` if the mixture is to be preferred.
    pub(super) fn with_learned(&self, mixture: &Found, progress: &dyn Progress) -> Result<Option<Found>, Cancelled> {
        let Self { connectivity, noise, .. } = self;
        let surface = self.surface.at(self.data.clone());
        let fixed = noise.relative.iter().map(|sigma| *sigma == 0.0).collect();
        let fused = learned::fused(surface.positions(), &connectivity.mesh, fixed, &mixture.deltas, progress)?;
        let Some(fused) = fused else { return Ok(None) };
        let mut offsets: Vec<DVec3> = fused.deltas.iter().map(|delta| -*delta).collect();
        let bounded = noise.bound(&mut offsets);
        let deltas = offsets.iter().zip(&mixture.deltas).zip(&noise.relative);
        let deltas = deltas.map(|((offset, mixed), sigma)| if *sigma == 0.0 { *mixed } else { -*offset });
        let deltas: Vec<DVec3> = deltas.collect();
        let [before, after] = [&mixture.deltas, &deltas].map(|deltas| alikeness(&surface, connectivity, deltas));
        if noise.correlation == 0 && after - before > MORE_ALIKE {
            return Ok(None);
        }
        let share = 1.0 - fused.others_share;
        let shares = vec![CandidateShare { candidate: Candidate::Learned, share, risk_gap: None }];
        Ok(Some(Found { deltas, bounded, shares }))
    }
}

/// Correlation between neighbours of the displacements along the normals of the result; 0 where nothing moves.
fn alikeness(surface: &Surface, connectivity: &Connectivity, deltas: &[DVec3]) -> f64 {
    let normals = connectivity.vertex_normals(&surface.moved_by(deltas));
    let heights: Vec<f64> = deltas.iter().zip(normals).map(|(delta, n)| delta.dot(n)).collect();
    let pairs = connectivity.mesh.edge_vertices.iter().map(|edge| edge.map(|v| heights[v as usize]));
    let (products, squares) = pairs.fold((0.0, 0.0), |(p, s), [a, b]| (p + a * b, s + (a * a + b * b) / 2.0));
    if squares > 0.0 { products / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::Auto;
    use crate::denoise::auto::{choose, without_learned};
    use crate::denoise::tests::{displaced, mean_angle, white_noise};
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};
    use crate::progress::Silent;

    #[test]
    fn ridges_that_the_learned_filter_blunts_are_left_to_the_mixture() {
        let ball = shapes::sphere(4);
        // Nine ridges from pole to pole.
        let ridged = |p: &DVec3| {
            let turns = p.y.atan2(p.x) * 9.0 / std::f64::consts::TAU;
            *p * (1.0 + 0.24 * (turns - turns.round()).abs() * p.x.hypot(p.y))
        };
        let clean = ball.at(ball.positions().iter().map(ridged).collect());
        let noisy =
            synthetic_noise::noisy(&clean, &Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 3 });
        let left = |deltas: &[DVec3]| mean_angle(&clean, &noisy.at(noisy.moved_by(deltas)));
        let settings = Auto::default();
        let (deltas, choice) = choose(&noisy, &settings, &Silent).unwrap();
        let (mixture, _) = without_learned(&noisy, &settings, &Silent).unwrap();
        let prepared = Prepared::of(&noisy, &settings, &Silent).unwrap();
        let found = prepared.mixed(false, &Silent).unwrap().0;
        let learned = prepared.with_learned(&found, &Silent).unwrap().unwrap();
        assert!(left(&learned.deltas) > 1.15 * left(&mixture), "{} {} {choice}", left(&learned.deltas), left(&mixture));
        assert!(left(&deltas) < 1.03 * left(&mixture), "{} {} {choice}", left(&deltas), left(&mixture));
    }

    #[test]
    fn white_displacements_are_not_alike_and_a_taken_off_shape_is() {
        let sphere = shapes::sphere(3);
        let connectivity = Connectivity::of(&sphere);
        let white = white_noise(&sphere, 0.2, 3);
        let noisy = displaced(&sphere, &white);
        assert!(alikeness(&noisy, &connectivity, &white).abs() < 0.1);
        let shrunken: Vec<DVec3> = sphere.positions().iter().map(|p| *p * 0.1).collect();
        assert!(alikeness(&sphere, &connectivity, &shrunken) > 0.99);
        assert_eq!(alikeness(&sphere, &connectivity, &vec![DVec3::ZERO; white.len()]), 0.0);
    }
}
