// Bind group 1: what is behind the model.
struct Background {
    // Encoded sRGB.
    top: vec4f,
    bottom: vec4f,
}

@group(1) @binding(0) var<uniform> background: Background;

@fragment
fn fs_background(in: Screen) -> @location(0) vec4f {
    // Encoded values, because a gradient should be even to the eye.
    return vec4f(linear_from_srgb(mix(background.top.rgb, background.bottom.rgb, in.unit.y)), 1.0);
}
