// Behind the model: the environment, or a vertical gradient.
struct Screen {
    @builtin(position) clip: vec4f,
    // From −1 to 1, right and up.
    @location(0) at: vec2f,
}

/// One triangle that covers the picture, at the far end.
@vertex
fn vs_background(@builtin(vertex_index) i: u32) -> Screen {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Screen(vec4f(at, 1.0, 1.0), at);
}

@fragment
fn fs_background(in: Screen) -> @location(0) vec4f {
    return vec4f(over_volume_behind(behind(in.at), in.at), 1.0);
}

fn behind(at: vec2f) -> vec3f {
    if environment.background > 0.5 {
        let direction = environment.rays * vec4f(at, 1.0, 0.0);
        return surroundings(direction.xyz, environment.blur);
    }
    // Encoded values, because a gradient should be even to the eye.
    return linear_from_srgb(mix(frame.background_top, frame.background_bottom, 0.5 - 0.5 * at.y));
}
