// Behind the model: a vertical gradient.
struct Screen {
    @builtin(position) clip: vec4f,
    // From the first row (0) to the last (1).
    @location(0) down: f32,
}

/// One triangle that covers the picture, at the far end.
@vertex
fn vs_background(@builtin(vertex_index) i: u32) -> Screen {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Screen(vec4f(at, 1.0, 1.0), 0.5 - 0.5 * at.y);
}

@fragment
fn fs_background(in: Screen) -> @location(0) vec4f {
    // Encoded values, because a gradient should be even to the eye.
    return vec4f(linear_from_srgb(mix(frame.background_top, frame.background_bottom, in.down)), 1.0);
}
