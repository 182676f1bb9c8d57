// Bind group 2: pictures on the surface, one group for each material.

struct Pictures {
    // 1 where there is one, else 0; of normals, 2 if they are in the frames of the carrier.
    has_colour: u32,
    has_normals: u32,
    has_relief: u32,
    // The entry of `Filter`, in the order of settings/shading.rs.
    filter_mode: u32,
}

@group(2) @binding(0) var colour_map: texture_2d<f32>;
@group(2) @binding(1) var colour_sampler: sampler;
@group(2) @binding(2) var normal_map: texture_2d<f32>;
@group(2) @binding(3) var relief_map: texture_2d<f32>;
@group(2) @binding(4) var<uniform> pictures: Pictures;

const BICUBIC = 2u;

/// Row 0 is the top, v points up.
fn picture_from_uv(uv: vec2f) -> vec2f {
    return vec2f(uv.x, 1.0 - uv.y);
}

/// A texel of a picture that repeats outside the unit square.
fn texel_repeated(picture: texture_2d<f32>, texel: vec2i) -> vec3f {
    let size = vec2i(textureDimensions(picture));
    return textureLoad(picture, (texel % size + size) % size, 0).rgb;
}

/// Bilinear between texel centres by hand, for pictures whose twin on the CPU is the same formula.
fn bilinear(picture: texture_2d<f32>, uv: vec2f) -> vec3f {
    let unit = uv - floor(uv);
    let p = picture_from_uv(unit) * vec2f(textureDimensions(picture)) - 0.5;
    let low = floor(p);
    let w = p - low;
    let a = vec2i(low);
    let top = blend(texel_repeated(picture, a), texel_repeated(picture, a + vec2i(1, 0)), w.x);
    let bottom = blend(texel_repeated(picture, a + vec2i(0, 1)), texel_repeated(picture, a + vec2i(1, 1)), w.x);
    return blend(top, bottom, w.y);
}

/// Weights of four texels by Catmull-Rom's cubic (Keys 1981, a = −½): it goes through the texels.
fn cubic_weights(t: f32) -> vec4f {
    let t2 = t * t;
    let t3 = t2 * t;
    return vec4f(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2) * 0.5;
}

fn bicubic(picture: texture_2d<f32>, uv: vec2f) -> vec3f {
    let unit = uv - floor(uv);
    let p = picture_from_uv(unit) * vec2f(textureDimensions(picture)) - 0.5;
    let low = floor(p);
    let wx = cubic_weights(p.x - low.x);
    let wy = cubic_weights(p.y - low.y);
    var sum = vec3f(0.0);
    for (var y = 0; y < 4; y++) {
        var row = vec3f(0.0);
        for (var x = 0; x < 4; x++) {
            row += wx[x] * texel_repeated(picture, vec2i(low) + vec2i(x - 1, y - 1));
        }
        sum += wy[y] * row;
    }
    return clamp(sum, vec3f(0.0), vec3f(1.0));
}

/// Linear RGB of the colour map. Derivatives are given because callers may not be in uniform control flow.
fn colour_at(uv: vec2f, dx: vec2f, dy: vec2f) -> vec3f {
    if pictures.filter_mode == BICUBIC {
        return bicubic(colour_map, uv);
    }
    // Rows point down, and so does the derivative along v.
    let flip = vec2f(1.0, -1.0);
    return textureSampleGrad(colour_map, colour_sampler, picture_from_uv(uv), dx * flip, dy * flip).rgb;
}

/// Height of the relief, 0..1.
fn relief_at(uv: vec2f) -> f32 {
    return bilinear(relief_map, uv).r;
}
