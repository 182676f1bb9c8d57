//! Laws of denoising, which a method that does nothing and one that sharpens break.

use super::*;
use std::sync::LazyLock;

/// Noise that is added to the clean surfaces, mean edges.
const LEVELS: [f64; 3] = [0.1, 0.2, 0.3];

/// A sphere, a box and a sheet of 1280 to 1728 triangles, without noise.
static CLEAN: LazyLock<[Surface; 3]> =
    LazyLock::new(|| [shapes::sphere(3), shapes::gridded_box(12), shapes::bumpy_sheet(28)]);

const NAMES: [&str; 3] = ["sphere", "box", "sheet"];

/// One method at its defaults on one surface.
struct Case {
    denoiser: Denoiser,
    /// Index of the surface in [`CLEAN`].
    surface: usize,
    /// δ on the clean surface. #V×3, model units
    still: Vec<DVec3>,
    /// δ for each level of noise. #V×3, model units
    deltas: [Vec<DVec3>; 3],
}

/// Every method on every surface; the laws share the results because `auto` takes a while.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let case = |denoiser: Denoiser, surface: usize| {
        let clean = &CLEAN[surface];
        let still = deltas(&denoiser, clean);
        let deltas = LEVELS.map(|sigma| deltas(&denoiser, &moved_by(clean, &noise_on(surface, sigma))));
        Case { denoiser, surface, still, deltas }
    };
    Denoiser::every().iter().flat_map(|d| (0..3).map(move |surface| case(d.clone(), surface))).collect()
});

fn noise_on(surface: usize, sigma: f64) -> Vec<DVec3> {
    white_noise(&CLEAN[surface], sigma, 11)
}

impl Case {
    /// Ea after over Ea before, where δ was found in noise of level `k`.
    fn left(&self, k: usize, deltas: &[DVec3]) -> f64 {
        let clean = &CLEAN[self.surface];
        let noisy = moved_by(clean, &noise_on(self.surface, LEVELS[k]));
        mean_angle(clean, &without(&noisy, deltas)) / mean_angle(clean, &noisy)
    }
    fn correlation(&self, k: usize, deltas: &[DVec3]) -> f64 {
        let noise = noise_on(self.surface, LEVELS[k]);
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        dot(deltas, &noise) / (dot(deltas, deltas) * dot(&noise, &noise)).sqrt()
    }
}

#[test]
fn probe() {
    let start = std::time::Instant::now();
    for case in CASES.iter() {
        let clean = &CLEAN[case.surface];
        let left = [0, 1, 2].map(|k| case.left(k, &case.deltas[k]));
        let corr = [0, 1, 2].map(|k| case.correlation(k, &case.deltas[k]));
        let ea = [0, 1, 2].map(|k| mean_angle(clean, &moved_by(clean, &noise_on(case.surface, LEVELS[k]))));
        let lengths: Vec<f64> = case.still.iter().map(|d| d.length() / clean.mean_edge()).collect();
        let rms = (lengths.iter().map(|l| l * l).sum::<f64>() / lengths.len() as f64).sqrt();
        let most = lengths.iter().copied().fold(0.0, f64::max);
        println!(
            "{:18} {:7} left {:.3?} ea {:.2?} corr {:.3?} rms {rms:.4} max {most:.4}",
            case.denoiser.name(), NAMES[case.surface], left, [0,1,2].map(|k| left[k]*ea[k]), corr
        );
    }
    println!("{:?}", start.elapsed());
    let start = std::time::Instant::now();
    deltas(&Denoiser::default(), &moved_by(&CLEAN[1], &noise_on(1, 0.3)));
    println!("auto {:?}", start.elapsed());
}
