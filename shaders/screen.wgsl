// A triangle that covers the picture.

struct Screen {
    @builtin(position) clip: vec4f,
    // 0..1, from the top left corner.
    @location(0) unit: vec2f,
}

@vertex
fn vs_screen(@builtin(vertex_index) i: u32) -> Screen {
    let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0;
    var out: Screen;
    // On the far plane.
    out.clip = vec4f(corner.x * 2.0 - 1.0, 1.0 - corner.y * 2.0, 1.0, 1.0);
    out.unit = corner;
    return out;
}
