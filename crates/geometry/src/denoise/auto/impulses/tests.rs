use super::*;
use crate::denoise::noise_level::gaussians;

#[test]
fn few_values_with_much_noise_are_told_from_the_others() {
    let values: Vec<f64> =
        gaussians(4000, 3).iter().enumerate().map(|(i, g)| if i % 5 == 0 { 5.0 * g.x } else { 0.2 * g.y }).collect();
    let found = TwoGaussians::of(&values).unwrap();
    let [little, much] = found.variances.map(f64::sqrt);
    assert!((little / 0.2 - 1.0).abs() < 0.05 && (much / 5.0 - 1.0).abs() < 0.1, "{found:?}");
    assert!((found.share - 0.2).abs() < 0.03, "{found:?}");
    assert!(found.variance(0.1).sqrt() < 0.25 && found.variance(8.0).sqrt() > 4.5);
    for same in [1e-8, 1.0, 1e8] {
        let white: Vec<f64> = gaussians(4000, 4).iter().map(|g| same * g.x).collect();
        assert!(TwoGaussians::of(&white).is_none());
    }
    assert!(TwoGaussians::of(&[]).is_none() && TwoGaussians::of(&[0.0; 9]).is_none());
}
