// Bind group 1: the baked map.
struct Displacement {
    // Model units at texel 0.
    bias: f32,
    // Model units from texel 0 to texel 1.
    scale: f32,
    // Strength: 0 draws the noisy surface, 1 the denoised one.
    lambda: f32,
    // What a texel says: 0 a height, 1 a vector in the axes of the model, 2 one in those of the vertex; 4 is added where
    // each `v` line has a texel of its own.
    kind: u32,
}

@group(1) @binding(0) var height_map: texture_2d<f32>;
@group(1) @binding(1) var<uniform> displacement: Displacement;

/// In this form, other than in that of `mix`, equal values give just that value, whatever the weight.
fn blend(a: vec3f, b: vec3f, w: f32) -> vec3f {
    return a + (b - a) * w;
}

/// Texel at a texture coordinate (v up, as in OBJ): bilinear between texel centres, clamped to the edge.
///
/// By hand and not by a sampler: R32Float cannot be filtered everywhere, filters round their weights to a
/// few bits, and so the twin on the CPU is the same formula.
fn texel_at(uv: vec2f) -> vec3f {
    let size = textureDimensions(height_map);
    let p = vec2f(uv.x, 1.0 - uv.y) * vec2f(size) - 0.5;
    let low = floor(p);
    let w = p - low;
    let last = vec2i(size) - 1;
    let a = clamp(vec2i(low), vec2i(0), last);
    let b = clamp(vec2i(low) + 1, vec2i(0), last);
    let top = blend(textureLoad(height_map, a, 0).rgb, textureLoad(height_map, vec2i(b.x, a.y), 0).rgb, w.x);
    let bottom = blend(textureLoad(height_map, vec2i(a.x, b.y), 0).rgb, textureLoad(height_map, b, 0).rgb, w.x);
    return blend(top, bottom, w.y);
}

/// Texel of the i-th `v` line, from 0, of a map with one for each.
fn texel_of(vertex: u32) -> vec3f {
    let width = textureDimensions(height_map).x;
    return textureLoad(height_map, vec2u(vertex % width, vertex / width), 0).rgb;
}

/// Offset, model units: along the normal in red; of a map of vectors along three axes.
fn offset_from_texel(texel: vec3f) -> vec3f {
    return displacement.bias + displacement.scale * texel;
}

/// Height at a texture coordinate (v up), model units.
fn height_at(uv: vec2f) -> f32 {
    return offset_from_texel(texel_at(uv)).x;
}

/// Height of the i-th `v` line, model units.
fn height_of(vertex: u32) -> f32 {
    return offset_from_texel(texel_of(vertex)).x;
}

/// Where a vertex goes: p' = p − λ · height · n. The map holds how far the noise lifted the vertex, hence the minus.
fn displaced_position(position: vec3f, normal: vec3f, height: f32) -> vec3f {
    return position - displacement.lambda * height * normal;
}

/// The same for vectors, p' = p − λ · δ: the axes are those of the model, or tangent, bitangent and normal.
fn displaced_by_vector(position: vec3f, axes: mat3x3f, offset: vec3f) -> vec3f {
    return position - axes * (displacement.lambda * offset);
}
