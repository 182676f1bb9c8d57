// A shadow map itself.
struct Screen {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn vs_shadow_view(@builtin(vertex_index) i: u32) -> Screen {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Screen(vec4f(at, 0.0, 1.0), at);
}

/// Distance from the light, black at the near end of its view and white at the far one, in a square.
@fragment
fn fs_shadow_view(in: Screen) -> @location(0) vec4f {
    let shape = fwidth(in.at);
    // As large as fits: half the smaller side in pixels.
    let at = in.at * max(shape.x, shape.y) / shape * vec2f(1.0, -1.0);
    if any(abs(at) > vec2f(1.0)) {
        return vec4f(0.05, 0.05, 0.06, 1.0);
    }
    let size = vec2f(textureDimensions(shadow_maps));
    let eye = shadows.eyes[shadows.shown];
    let depth = stored_depth(shadows.shown, vec2i((0.5 * at + 0.5) * size));
    let grey = (distance_from_depth(eye, depth) - eye.near) / (eye.far - eye.near);
    return vec4f(linear_from_srgb(vec3f(grey)), 1.0);
}
