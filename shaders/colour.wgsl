// sRGB (IEC 61966-2-1) and linear light. Twin of crates/viewer/src/colour.rs.

fn linear_from_srgb(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((max(encoded, vec3f(0.0)) + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}

/// Encoded sRGB of linear light; what lies outside 0..1 is clamped.
fn srgb_from_linear(linear: vec3f) -> vec3f {
    let light = clamp(linear, vec3f(0.0), vec3f(1.0));
    let high = 1.055 * pow(light, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, 12.92 * light, light <= vec3f(0.0031308));
}
