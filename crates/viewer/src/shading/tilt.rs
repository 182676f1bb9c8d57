//! Normals from pictures, in the tangent frame of MikkTSpace. Twin of `shaders/tilt.wgsl`.

use super::Fragment;
use crate::texture::Texture;
use glam::{Vec2, Vec3};

/// Unit normal of a tangent-space normal map (Mikkelsen 2008): the frame is interpolated and not normalised, the
/// bitangent is sign · n × t, as bakers have it. `rgb` are the numbers of the map, 0..1.
pub(super) fn by_normal_map(rgb: Vec3, fragment: &Fragment<'_>, smooth: Vec3) -> Vec3 {
    let tangent = fragment.tangent.truncate();
    if tangent == Vec3::ZERO {
        return smooth;
    }
    let n = fragment.normal;
    let local = 2.0 * rgb - 1.0;
    let bitangent = fragment.tangent.w.signum() * n.cross(tangent);
    (local.x * tangent + local.y * bitangent + local.z * n).try_normalize().unwrap_or(smooth)
}

/// Unit normal of a surface lifted by `height` · texel along its normal: with p' = p + h n, and dropping the change of n,
/// ∂p'/∂u × ∂p'/∂v = |∂p/∂u| |∂p/∂v| (n − (∂h/∂u)/|∂p/∂u| t − (∂h/∂v)/|∂p/∂v| b) in an orthonormal frame.
///
/// James F. Blinn. Simulation of wrinkled surfaces. SIGGRAPH 1978. Pharr, Jakob, Humphreys. Physically Based Rendering,
/// section 10.5.3 (4th edition).
pub(super) fn by_heights(picture: &Texture, uv: Vec2, height: f32, fragment: &Fragment<'_>, smooth: Vec3) -> Vec3 {
    let across = fragment.tangent.truncate() - smooth * smooth.dot(fragment.tangent.truncate());
    let Some(t) = across.try_normalize().filter(|_| fragment.stretch.min_element() > 0.0) else { return smooth };
    let b = fragment.tangent.w.signum() * smooth.cross(t);
    let step = 1.0 / picture.size();
    let at = |du: f32, dv: f32| picture.numbers_at(uv + Vec2::new(du, dv)).x;
    let difference = Vec2::new(at(step.x, 0.0) - at(-step.x, 0.0), at(0.0, step.y) - at(0.0, -step.y));
    let slope = height * difference / (2.0 * step) / fragment.stretch;
    (smooth - slope.x * t - slope.y * b).try_normalize().unwrap_or(smooth)
}
