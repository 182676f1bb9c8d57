// Bind group 1: the baked map.
struct Displacement {
    // Model units at texel 0.
    bias: f32,
    // Model units from texel 0 to texel 1.
    scale: f32,
    // Strength: 0 draws the noisy surface, 1 the denoised one.
    lambda: f32,
    _pad: f32,
}

@group(1) @binding(0) var height_map: texture_2d<f32>;
@group(1) @binding(1) var<uniform> displacement: Displacement;

/// In this form, other than in that of `mix`, equal values give just that value, whatever the weight.
fn blend(a: f32, b: f32, w: f32) -> f32 {
    return a + (b - a) * w;
}

/// Height at a texture coordinate (v up, as in OBJ), in model units: bilinear between texel centres, clamped to the edge.
///
/// By hand and not by a sampler: R32Float cannot be filtered everywhere, filters round their weights to a
/// few bits, and so the twin on the CPU is the same formula.
fn height_at(uv: vec2f) -> f32 {
    let size = textureDimensions(height_map);
    let p = vec2f(uv.x, 1.0 - uv.y) * vec2f(size) - 0.5;
    let low = floor(p);
    let w = p - low;
    let last = vec2i(size) - 1;
    let a = clamp(vec2i(low), vec2i(0), last);
    let b = clamp(vec2i(low) + 1, vec2i(0), last);
    let top = blend(textureLoad(height_map, a, 0).r, textureLoad(height_map, vec2i(b.x, a.y), 0).r, w.x);
    let bottom = blend(textureLoad(height_map, vec2i(a.x, b.y), 0).r, textureLoad(height_map, b, 0).r, w.x);
    return displacement.bias + displacement.scale * blend(top, bottom, w.y);
}

/// Where a vertex goes: p' = p − λ · height · n. The map holds how far the noise lifted the vertex, hence the minus.
fn displaced_position(position: vec3f, normal: vec3f, uv: vec2f) -> vec3f {
    return position - displacement.lambda * height_at(uv) * normal;
}
