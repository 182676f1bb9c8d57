// What lies in a light's shadow. Maps are read texel by texel, because filters of hardware compare with few bits, and
// percentage-closer soft shadows need the depths themselves. Twin of software/shadows.rs of planish-render.
struct Eye {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    // Along its axis, world units.
    near: f32,
    far: f32,
    // Half the width of the picture: world units if rays are parallel, else a tangent.
    half_width: f32,
    // Radius of the light: a tangent if rays are parallel, else world units.
    light_size: f32,
    // 1 if rays are parallel.
    parallel: f32,
    _pad_a: f32,
    _pad_b: f32,
    _pad_c: f32,
}

struct Shadows {
    // For each light the number of its first picture, and how many it takes.
    first_eye: vec4u,
    eye_count: vec4u,
    // Texels along a side of the square whose mean is taken.
    kernel: i32,
    // World units.
    slope_bias: f32,
    least_bias: f32,
    // Number of the picture that is shown.
    shown: u32,
    eyes: array<Eye, 24>,
}

@group(0) @binding(1) var<uniform> shadows: Shadows;
@group(0) @binding(2) var shadow_maps: texture_2d_array<f32>;
// The nearest texel: to OpenGL a depth texture that is read without a sampler is incomplete, and black.
@group(0) @binding(7) var shadow_sampler: sampler;

/// Depth in a map, 0..1.
fn stored_depth(eye: u32, texel: vec2i) -> f32 {
    let size = vec2i(textureDimensions(shadow_maps));
    var inside = clamp(texel, vec2i(0), size - 1);
    if OUTSIDE == OUTSIDE_REPEATED {
        inside = ((texel % size) + size) % size;
    }
    return textureSampleLevel(shadow_maps, shadow_sampler, (vec2f(inside) + 0.5) / vec2f(size), eye, 0.0).r;
}

/// World units along the axis of an eye.
fn distance_from_depth(eye: Eye, depth: f32) -> f32 {
    return select(eye.near * eye.far / (eye.far - depth * (eye.far - eye.near)), mix(eye.near, eye.far, depth), eye.parallel > 0.5);
}

/// Which face of a cube a direction meets: +x −x +y −y +z −z.
fn cube_face(d: vec3f) -> u32 {
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(1u, 0u, d.x > 0.0);
    }
    if a.y >= a.z {
        return select(3u, 2u, d.y > 0.0);
    }
    return select(5u, 4u, d.z > 0.0);
}

/// Mean over a square of texels; each answer is blended between four, so that the weights at its rim are those of the place.
fn percentage_closer(eye: u32, place: vec2f, depth: f32) -> f32 {
    let p = place - 0.5;
    let low = floor(p);
    let w = p - low;
    let half_kernel = shadows.kernel / 2;
    var lit = 0.0;
    for (var j = -half_kernel; j <= half_kernel + 1; j++) {
        let down = select(select(1.0, w.y, j == half_kernel + 1), 1.0 - w.y, j == -half_kernel);
        for (var i = -half_kernel; i <= half_kernel + 1; i++) {
            let across = select(select(1.0, w.x, i == half_kernel + 1), 1.0 - w.x, i == -half_kernel);
            lit += across * down * step(depth, stored_depth(eye, vec2i(low) + vec2i(i, j)));
        }
    }
    return lit / f32(shadows.kernel * shadows.kernel);
}

/// How wide a light's disc looks in the map through a pinhole `blocker` away, from a place `receiver` away.
fn spread(eye: Eye, receiver: f32, blocker: f32) -> f32 {
    let shift = eye.light_size * (receiver - blocker) / (2.0 * eye.half_width);
    return clamp(select(shift / (receiver * blocker), shift, eye.parallel > 0.5), 0.0, 0.15);
}

/// A point of a spiral that fills the unit disc evenly.
fn disc(i: u32, count: u32, turn: f32) -> vec2f {
    let angle = 2.399963 * f32(i) + turn;
    return sqrt((f32(i) + 0.5) / f32(count)) * vec2f(cos(angle), sin(angle));
}

/// Randima Fernando. Percentage-closer soft shadows. SIGGRAPH sketches 2005. `slope`: change of the surface's own depth over
/// the map, so that a wide penumbra does not find the surface itself.
fn soft(number: u32, eye: Eye, uv: vec2f, depth: f32, slope: vec2f) -> f32 {
    const SEARCHES = 24u;
    const SAMPLES = 48u;
    let size = vec2f(textureDimensions(shadow_maps));
    let receiver = distance_from_depth(eye, depth);
    // Turned from texel to texel: noise is less seen than bands.
    let texel = floor(uv * size);
    let turn = 6.2831853 * fract(52.9829189 * fract(dot(texel, vec2f(0.06711056, 0.00583715))));
    let search = max(spread(eye, receiver, max(eye.near, 0.25 * receiver)), 1.0 / size.x);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < SEARCHES; i++) {
        let offset = search * disc(i, SEARCHES, turn);
        let stored = stored_depth(number, vec2i(floor((uv + offset) * size)));
        if stored < depth + dot(slope, offset) {
            sum += distance_from_depth(eye, stored);
            count += 1.0;
        }
    }
    if count == 0.0 {
        return 1.0;
    }
    // At least as wide as a texel, so that contacts are not jagged.
    let penumbra = max(spread(eye, receiver, min(sum / count, receiver)), 1.0 / size.x);
    var lit = 0.0;
    for (var i = 0u; i < SAMPLES; i++) {
        let offset = penumbra * disc(i, SAMPLES, turn);
        lit += step(depth + dot(slope, offset), stored_depth(number, vec2i(floor((uv + offset) * size))));
    }
    return lit / f32(SAMPLES);
}

/// Share of a light that arrives at a place with this unit normal: 0 in the umbra, 1 in the open.
fn unshadowed(light: u32, position: vec3f, normal: vec3f, to_light: vec3f) -> f32 {
    if FILTER == FILTER_NONE || shadows.eye_count[light] == 0u {
        return 1.0;
    }
    var number = shadows.first_eye[light];
    if shadows.eye_count[light] == 6u {
        number += cube_face(-to_light);
    }
    let eye = shadows.eyes[number];
    let place = position + max(shadows.slope_bias * (1.0 - dot(normal, to_light)), shadows.least_bias) * to_light;
    let clip = eye.clip_from_world * vec4f(place, 1.0);
    if clip.w <= 0.0 {
        return 1.0;
    }
    let ndc = clip.xyz / clip.w;
    let uv = vec2f(0.5, -0.5) * ndc.xy + 0.5;
    if OUTSIDE == OUTSIDE_LIT && (any(uv < vec2f(0.0)) || any(uv > vec2f(1.0)) || ndc.z > 1.0) {
        return 1.0;
    }
    let size = vec2f(textureDimensions(shadow_maps));
    if FILTER == FILTER_HARD {
        return step(ndc.z, stored_depth(number, vec2i(floor(uv * size))));
    }
    if FILTER == FILTER_PCF {
        return percentage_closer(number, uv * size, ndc.z);
    }
    // The surface's plane as the eye sees it: planes go with the transposed inverse of points.
    let plane = vec4f(normal, -dot(normal, place)) * eye.world_from_clip;
    let steep = select(plane.z, -1e-4, abs(plane.z) < 1e-4);
    let slope = clamp(-plane.xy / steep, vec2f(-8.0), vec2f(8.0)) * vec2f(2.0, -2.0);
    return soft(number, eye, uv, ndc.z, slope);
}
