// Bind group 3: pictures on the surface, v up, repeated outside the unit square. Twin of texture.rs of planish-render.
@group(3) @binding(0) var colour_map: texture_2d<f32>;
@group(3) @binding(1) var colour_sampler: sampler;
@group(3) @binding(2) var normal_map: texture_2d<f32>;
// The colours of a heat map, sRGB as stored, one row.
@group(3) @binding(3) var heat_map: texture_2d<f32>;

// Grey: the fraction of the ambient light that arrives.
@group(3) @binding(4) var occlusion_map: texture_2d<f32>;

fn flipped(uv: vec2f) -> vec2f {
    return vec2f(uv.x, 1.0 - uv.y);
}

fn wrapped(texel: vec2i, size: vec2i) -> vec2i {
    return ((texel % size) + size) % size;
}

fn colour_texel(texel: vec2i) -> vec3f {
    return textureLoad(colour_map, wrapped(texel, vec2i(textureDimensions(colour_map))), 0).rgb;
}

/// Weights of a uniform cubic B-spline for the texels at −1, 0, 1 and 2.
fn b_spline(t: f32) -> vec4f {
    let s = 1.0 - t;
    return vec4f(s * s * s, 4.0 - 3.0 * t * t * (1.0 + s), 4.0 - 3.0 * s * s * (1.0 + t), t * t * t) / 6.0;
}

fn bicubic(uv: vec2f) -> vec3f {
    let p = fract(flipped(uv)) * vec2f(textureDimensions(colour_map)) - 0.5;
    let low = vec2i(floor(p));
    let across = b_spline(p.x - floor(p.x));
    let down = b_spline(p.y - floor(p.y));
    var sum = vec3f(0.0);
    for (var j = 0; j < 4; j++) {
        for (var i = 0; i < 4; i++) {
            sum += across[i] * down[j] * colour_texel(low + vec2i(i - 1, j - 1));
        }
    }
    return sum;
}

/// Linear RGB; derivatives of uv over the picture choose the level of detail.
fn colour_at(uv: vec2f, dx: vec2f, dy: vec2f) -> vec3f {
    if SAMPLING == SAMPLING_BICUBIC {
        return bicubic(uv);
    }
    if SAMPLING == SAMPLING_NEAREST {
        return colour_texel(vec2i(floor(fract(flipped(uv)) * vec2f(textureDimensions(colour_map)))));
    }
    if SAMPLING == SAMPLING_BILINEAR {
        return textureSampleLevel(colour_map, colour_sampler, flipped(uv), 0.0).rgb;
    }
    // Flipping v turns its derivatives over.
    return textureSampleGrad(colour_map, colour_sampler, flipped(uv), dx * vec2f(1.0, -1.0), dy * vec2f(1.0, -1.0)).rgb;
}

/// Tangent-space normal, not normalised; bilinear by hand like all that has to be exact.
fn tangent_normal_at(uv: vec2f) -> vec3f {
    let size = vec2i(textureDimensions(normal_map));
    let p = fract(flipped(uv)) * vec2f(size) - 0.5;
    let low = vec2i(floor(p));
    let w = p - floor(p);
    let a = textureLoad(normal_map, wrapped(low, size), 0).rgb;
    let b = textureLoad(normal_map, wrapped(low + vec2i(1, 0), size), 0).rgb;
    let c = textureLoad(normal_map, wrapped(low + vec2i(0, 1), size), 0).rgb;
    let d = textureLoad(normal_map, wrapped(low + vec2i(1, 1), size), 0).rgb;
    return 2.0 * blend(blend(a, b, w.x), blend(c, d, w.x), w.y) - 1.0;
}

/// Fraction of the ambient light that the picture of it lets through.
fn occlusion_at(uv: vec2f) -> f32 {
    let size = vec2i(textureDimensions(occlusion_map));
    let p = fract(flipped(uv)) * vec2f(size) - 0.5;
    let low = vec2i(floor(p));
    let w = p - floor(p);
    let a = textureLoad(occlusion_map, wrapped(low, size), 0).rgb;
    let b = textureLoad(occlusion_map, wrapped(low + vec2i(1, 0), size), 0).rgb;
    let c = textureLoad(occlusion_map, wrapped(low + vec2i(0, 1), size), 0).rgb;
    let d = textureLoad(occlusion_map, wrapped(low + vec2i(1, 1), size), 0).rgb;
    return blend(blend(a, b, w.x), blend(c, d, w.x), w.y).x;
}

/// Fraction of the ambient light that arrives, by the picture where there is one, else by the number of the vertex.
fn open_at(uv: vec2f, has_uv: bool, at_vertex: f32) -> f32 {
    var open = at_vertex;
    if (frame.has & HAS_OCCLUSION_MAP) != 0u && has_uv {
        open = occlusion_at(uv);
    }
    return mix(1.0, open, frame.occlusion);
}

/// Linear RGB of a number; below 0 and above 1 the ends go on.
fn heat_colour(t: f32) -> vec3f {
    let last = i32(textureDimensions(heat_map).x) - 1;
    let x = clamp(t, 0.0, 1.0) * f32(last);
    let low = min(i32(x), last - 1);
    let a = textureLoad(heat_map, vec2i(low, 0), 0).rgb;
    let b = textureLoad(heat_map, vec2i(low + 1, 0), 0).rgb;
    // Between encoded values, because these are even to the eye.
    return linear_from_srgb(mix(a, b, x - f32(low)));
}
