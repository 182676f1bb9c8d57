//! A lump of clay in the light of a studio, as a function of the normal in view space alone (a matcap): every dent shows
//! from every side, whatever the lights. Twin of `shaders/clay.wgsl`.

use glam::Vec3;

/// Towards a large soft light, up on the left.
const KEY: Vec3 = Vec3::new(-0.4767313, 0.6674238, 0.5720776);
/// Towards a weaker one, down on the right.
const FILL: Vec3 = Vec3::new(0.8295614, -0.2073903, 0.5184758);
/// Half-way between the key light and the eye.
const HIGHLIGHT: Vec3 = Vec3::new(-0.2688572, 0.3764001, 0.8865883);

/// Linear RGB of clay of a base colour; the normal is unit, in view space (right, up, towards the eye).
pub(super) fn colour(base: Vec3, normal: Vec3) -> Vec3 {
    // A large light reaches round the edge.
    let key = 0.5 + 0.5 * normal.dot(KEY);
    let fill = normal.dot(FILL).max(0.0);
    let rim = 1.0 - normal.z.clamp(0.0, 1.0);
    let scattered = Vec3::new(0.09, 0.085, 0.09)
        + key * key * Vec3::new(0.86, 0.83, 0.78)
        + fill * Vec3::new(0.10, 0.12, 0.16);
    let gloss = normal.dot(HIGHLIGHT).max(0.0).powf(32.0);
    base * scattered + 0.12 * gloss + rim * rim * rim * Vec3::new(0.07, 0.09, 0.12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_and_light_comes_from_above() {
        for direction in [KEY, FILL, HIGHLIGHT] {
            assert!((direction.length() - 1.0).abs() < 1e-6, "{direction} {}", direction.length());
        }
        assert!((KEY + Vec3::Z).normalize().distance(HIGHLIGHT) < 1e-4);
        let [above, below] = [Vec3::Y, Vec3::NEG_Y].map(|n| colour(Vec3::ONE, n).element_sum());
        assert!(above > 2.0 * below, "{above} {below}");
    }
}
