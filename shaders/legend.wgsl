// Rectangles over the picture.
struct Legend {
    // Pixels of the picture.
    width: f32,
    height: f32,
    // 1 if the view encodes sRGB by itself.
    decode: u32,
    _pad: u32,
}

@group(0) @binding(0) var<uniform> legend: Legend;

struct Rectangle {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat, either) colour: vec4f,
}

/// `place` is left, top, width and height in pixels; the colour is encoded sRGB.
@vertex
fn vs_legend(@builtin(vertex_index) i: u32, @location(0) place: vec4f, @location(1) colour: vec4f) -> Rectangle {
    let right = f32(i == 1u || i == 2u || i == 4u);
    let below = f32(i == 2u || i == 4u || i == 5u);
    let pixel = place.xy + vec2f(right, below) * place.zw;
    var out: Rectangle;
    out.clip = vec4f(2.0 * pixel.x / legend.width - 1.0, 1.0 - 2.0 * pixel.y / legend.height, 0.0, 1.0);
    out.colour = colour;
    return out;
}

@fragment
fn fs_legend(in: Rectangle) -> @location(0) vec4f {
    if legend.decode == 1u {
        return vec4f(linear_from_srgb(in.colour.rgb), 1.0);
    }
    return in.colour;
}
