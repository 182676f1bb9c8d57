use super::*;
use crate::denoise::tests::{moved_by, white_noise};
use crate::denoise::umbrella::Umbrella;
use crate::noise::{self, Noise};
use crate::progress::Silent;
use crate::shapes;

fn level(surface: &Surface) -> NoiseLevel {
    Look::at(surface, &Net::of(surface), &Silent).unwrap().level
}

fn noisy(clean: &Surface, noise: &Noise) -> Surface {
    moved_by(clean, &noise::displacements(clean, noise))
}

const WHITE: Noise = Noise { sigma: 0.2, direction: noise::Direction::Normal, share: 1.0, seed: 1 };

#[test]
fn sigma_is_known_to_three_standard_errors() {
    for (name, clean) in [("sphere", shapes::sphere(3)), ("box", shapes::gridded_box(12)), ("sheet", shapes::bumpy_sheet(28))] {
        for sigma in [0.1, 0.2, 0.3] {
            let found: Vec<f64> = (0..20).map(|seed| level(&noisy(&clean, &Noise { sigma, seed, ..WHITE })).fine).collect();
            let mean = found.iter().sum::<f64>() / 20.0;
            let sd = (found.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 19.0).sqrt();
            println!("{name} {sigma}: {mean} sd {sd} se {} bias {}", sd / 20f64.sqrt(), mean / sigma - 1.0);
        }
    }
}

/// White noise smoothed over some edges, of `sigma` mean edges along the normals. #V×3, model units
fn correlated(clean: &Surface, sigma: f64, mu: f64, seed: u64) -> Vec<DVec3> {
    let umbrella = Umbrella::of(clean);
    let white = gaussians(clean.positions().len(), seed);
    let smooth = umbrella.smoothed(&white, mu, &Freedom::default(), &Silent).unwrap();
    let rms = (smooth.iter().map(|g| g.x * g.x).sum::<f64>() / smooth.len() as f64).sqrt();
    let normals = Net::of(clean).vertex_normals(clean.positions());
    let scale = sigma * clean.mean_edge() / rms;
    smooth.iter().zip(normals).map(|(g, n)| scale * g.x * n).collect()
}

#[test]
fn probe_kinds() {
    for (name, clean) in [("sphere", shapes::sphere(4)), ("box", shapes::gridded_box(16)), ("sheet", shapes::bumpy_sheet(40))] {
        let show = |what: &str, surface: &Surface| {
            let level = level(surface);
            println!("{name} {what}: {:?} {level:.4?} excess {} rough {}", level.kind(), level.excess(), level.is_rough());
        };
        show("clean", &clean);
        show("white", &noisy(&clean, &WHITE));
        for share in [0.05, 0.1, 0.2, 0.3] {
            show(&format!("impulsive {share}"), &noisy(&clean, &Noise { share, sigma: 0.4, ..WHITE }));
        }
        for (sigma, mu) in [(0.3, 1.0), (0.3, 4.0), (0.5, 4.0), (0.5, 1.0)] {
            let smooth = correlated(&clean, sigma, mu, 3);
            show(&format!("correlated {sigma} {mu}"), &moved_by(&clean, &smooth));
            let both = moved_by(&moved_by(&clean, &smooth), &white_noise(&clean, 0.1, 4));
            show(&format!("correlated {sigma} {mu} + white 0.1"), &both);
        }
    }
}
