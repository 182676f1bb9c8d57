//! Laws of denoising, which a method that does nothing and one that sharpens break.
//!
//! Clean surfaces get white noise along their normals, so that both the surface and the noise are known.

use super::*;
use std::sync::LazyLock;

/// Standard deviations of the noise, mean edges.
const LEVELS: [f64; 3] = [0.1, 0.2, 0.3];

/// A sphere, a box and a bumpy sheet of 1280 to 3072 triangles, without noise.
///
/// The box must not be coarser: its edges are in the coarse band of the noise estimate, which at 14 cells takes one draw in
/// eight of white noise for noise that is correlated between neighbours, and then most of it stays.
static CLEAN: LazyLock<[Surface; 3]> =
    LazyLock::new(|| [shapes::sphere(3), shapes::gridded_box(16), shapes::bumpy_sheet(28)]);

const NAMES: [&str; 3] = ["sphere", "box", "sheet"];

/// Bounds for a method at its defaults, each for the sphere, the box and the sheet.
struct Expected {
    /// Bound of Ea after over Ea before, at all levels of noise.
    left: [f64; 3],
    /// Largest root mean square of the displacements of a surface without noise, mean edges.
    still: [f64; 3],
    /// Lower bound of the correlation ⟨δ, e⟩ / |δ| |e| with the added noise e, at all levels of noise.
    follows: [f64; 3],
    /// Smallest quotient of Ea after in noise of 0.2 and Ea after in noise of 0.1.
    grows: f64,
}

const USUAL: Expected = Expected { left: [0.0; 3], still: [0.0; 3], follows: [0.5; 3], grows: 1.0 };

/// Bounds of each method; without a line for each of them this does not compile.
fn expected(denoiser: &Denoiser) -> Expected {
    match denoiser {
        // Linear filters leave a fifth of the noise, round the edges of the box, and shrink the sphere. At 0.1 what they take
        // of such a shape is more than the noise, so that less of δ is noise.
        Denoiser::Laplacian(_) => {
            Expected { left: [0.25, 0.75, 0.32], still: [0.15, 0.24, 0.05], follows: [0.5, 0.35, 0.5], ..USUAL }
        }
        // The pass band gives back most of the shape, and lets more of the noise through.
        Denoiser::Taubin(_) => Expected { left: [0.28, 0.75, 0.36], still: [0.06, 0.15, 0.01], ..USUAL },
        Denoiser::Hc(_) => {
            Expected { left: [0.2, 0.8, 0.3], still: [0.07, 0.19, 0.012], follows: [0.5, 0.42, 0.5], ..USUAL }
        }
        // This method moves vertices farther than the others do at their defaults.
        Denoiser::Implicit(_) => {
            Expected { left: [0.22, 0.82, 0.31], still: [0.23, 0.31, 0.075], follows: [0.33, 0.28, 0.5], ..USUAL }
        }
        // The filter keeps edges better than a mean does, and shrinks the sphere most: each step goes to the neighbours, which
        // are inside.
        Denoiser::Bilateral(_) => {
            Expected { left: [0.28, 0.63, 0.43], still: [0.32, 0.06, 0.06], follows: [0.3, 0.5, 0.5], ..USUAL }
        }
        // A mean over all neighbours that look the same way suits the sphere and the sides of the box, while the bumps of
        // the sheet are flattened, by more than the noise at 0.1.
        Denoiser::Sun(_) => {
            Expected { left: [0.1, 0.21, 0.46], still: [0.02, 1e-12, 0.21], follows: [0.5, 0.5, 0.38], ..USUAL }
        }
        // Near neighbours count more, so that the bumps stay; in noise of 0.3 sides of the box are not told apart well.
        Denoiser::BilateralNormals(_) => Expected { left: [0.085, 0.31, 0.24], still: [0.006, 0.001, 0.06], ..USUAL },
        // The guidance of a patch is one normal, which a sphere has nowhere.
        Denoiser::GuidedNormals(_) => Expected { left: [0.25, 0.14, 0.15], still: [0.02, 0.025, 0.042], ..USUAL },
        // All that is not flat becomes facets, which on curved surfaces are wrong by a part of the angle between them.
        Denoiser::L0(_) => Expected { left: [0.8, 0.17, 0.52], still: [0.09, 0.0001, 0.085], ..USUAL },
        // Curvature costs as little as flatness, but forty rounds leave some of the noise.
        Denoiser::TgvNormals(_) => Expected { left: [0.33, 0.125, 0.29], still: [0.011, 0.007, 0.034], ..USUAL },
        // No noise is found where there is none. On the sphere the prior for creases leaves 1.9° in noise of 0.1 and 1.6° in
        // noise of 0.2.
        Denoiser::Map(_) => Expected { left: [0.25, 0.12, 0.35], grows: 0.8, ..USUAL },
        // Few training shapes are as coarse as this sphere: of light noise on it, it is not sure.
        Denoiser::Learned(_) => Expected { left: [0.42, 0.2, 0.3], still: [0.02; 3], grows: 0.38, ..USUAL },
        // The learned filter has the last word, and is not sure of light noise on so coarse a sphere: the mixture alone leaves a
        // seventh there.
        Denoiser::Auto(_) => Expected { left: [0.26, 0.1, 0.19], grows: 0.4, ..USUAL },
    }
}

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
        let still = deltas(&denoiser, &CLEAN[surface]);
        let deltas = [0, 1, 2].map(|level| deltas(&denoiser, &noisy(surface, level)));
        Case { denoiser, surface, still, deltas }
    };
    Denoiser::every().iter().flat_map(|denoiser| (0..3).map(|surface| case(denoiser.clone(), surface))).collect()
});

/// Noise of a level on a surface, which is the same draw at each level. #V×3, model units
fn noise_on(surface: usize, level: usize) -> Vec<DVec3> {
    white_noise(&CLEAN[surface], LEVELS[level], 11)
}

fn noisy(surface: usize, level: usize) -> Surface {
    displaced(&CLEAN[surface], &noise_on(surface, level))
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

impl Case {
    fn name(&self) -> String {
        format!("{} on the {}", self.denoiser.name(), NAMES[self.surface])
    }
    /// Ea between the clean surface and a result, degrees.
    fn ea(&self, level: usize, deltas: &[DVec3]) -> f64 {
        mean_angle(&CLEAN[self.surface], &without(&noisy(self.surface, level), deltas))
    }
    /// Fraction of Ea that a result leaves.
    fn left(&self, level: usize, deltas: &[DVec3]) -> f64 {
        self.ea(level, deltas) / mean_angle(&CLEAN[self.surface], &noisy(self.surface, level))
    }
    /// Correlation ⟨δ, e⟩ / |δ| |e| with the added noise e; NaN where nothing moves.
    fn correlation(&self, level: usize, deltas: &[DVec3]) -> f64 {
        let noise = noise_on(self.surface, level);
        dot(deltas, &noise) / (dot(deltas, deltas) * dot(&noise, &noise)).sqrt()
    }
    fn lowers_ea(&self, level: usize, deltas: &[DVec3]) -> bool {
        self.left(level, deltas) < expected(&self.denoiser).left[self.surface]
    }
    fn follows_the_noise(&self, level: usize, deltas: &[DVec3]) -> bool {
        self.correlation(level, deltas) > expected(&self.denoiser).follows[self.surface]
    }
}

/// Lists every case that breaks a law, so that one run shows them all.
fn assert_none(broken: &[String]) {
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Cases with each level of noise.
fn noisy_cases() -> impl Iterator<Item = (&'static Case, usize, &'static [DVec3])> {
    CASES.iter().flat_map(|case| (0..).zip(&case.deltas).map(move |(level, deltas)| (case, level, &deltas[..])))
}

#[test]
fn the_angle_between_normals_falls() {
    let broken = noisy_cases().filter(|(case, level, deltas)| !case.lowers_ea(*level, deltas));
    let told = broken.map(|(case, level, deltas)| {
        format!("{} in noise of {}: {:.3} of Ea is left", case.name(), LEVELS[level], case.left(level, deltas))
    });
    assert_none(&told.collect::<Vec<_>>());
}

#[test]
fn twice_the_noise_leaves_no_less() {
    let told = CASES.iter().filter_map(|case| {
        let [once, twice] = [0, 1].map(|level| case.ea(level, &case.deltas[level]));
        let less = twice < expected(&case.denoiser).grows * once;
        less.then(|| format!("{}: {once:.2}° in noise of 0.1 and {twice:.2}° in noise of 0.2", case.name()))
    });
    assert_none(&told.collect::<Vec<_>>());
}

#[test]
fn deltas_follow_the_noise_that_was_added() {
    let broken = noisy_cases().filter(|(case, level, deltas)| !case.follows_the_noise(*level, deltas));
    let told = broken.map(|(case, level, deltas)| {
        format!("{} in noise of {}: correlation {:.3}", case.name(), LEVELS[level], case.correlation(level, deltas))
    });
    assert_none(&told.collect::<Vec<_>>());
}

#[test]
fn a_surface_without_noise_hardly_moves() {
    let told = CASES.iter().filter_map(|case| {
        let mean_square = dot(&case.still, &case.still) / case.still.len() as f64;
        let moved = mean_square.sqrt() / CLEAN[case.surface].mean_edge();
        let far = moved > expected(&case.denoiser).still[case.surface];
        far.then(|| format!("{}: {moved:.5} mean edges", case.name()))
    });
    assert_none(&told.collect::<Vec<_>>());
}

#[test]
fn do_nothing_and_a_sharpener_fail() {
    for (case, level, deltas) in noisy_cases() {
        let nothing = vec![DVec3::ZERO; deltas.len()];
        let sharpened: Vec<DVec3> = deltas.iter().map(|delta| -*delta).collect();
        for wrong in [nothing, sharpened] {
            assert!(!case.lowers_ea(level, &wrong), "{}", case.name());
            assert!(!case.follows_the_noise(level, &wrong), "{}", case.name());
        }
    }
}
