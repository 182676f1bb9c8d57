// Noise in three dimensions, for surfaces without texture coordinates. Twin of noise.rs of planish-render.
// Ken Perlin. An image synthesizer. SIGGRAPH 1985. Improving noise. SIGGRAPH 2002. The permutations are a hash here.

fn noise_hash(cell: vec3i) -> u32 {
    let c = bitcast<vec3u>(cell);
    var h = (c.x * 0x8da6b343u) ^ (c.y * 0xd8163841u) ^ (c.z * 0xcb1ab31fu);
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

/// One of the twelve directions from a cube's middle to its edges.
fn noise_slope(cell: vec3i) -> vec3f {
    let h = noise_hash(cell);
    let a = select(-1.0, 1.0, (h & 1u) == 0u);
    let b = select(-1.0, 1.0, (h & 2u) == 0u);
    switch (h >> 2u) % 3u {
        case 0u: { return vec3f(a, b, 0.0); }
        case 1u: { return vec3f(a, 0.0, b); }
        default: { return vec3f(0.0, a, b); }
    }
}

/// Along x between two corners of a cell.
fn noise_row(cell: vec3i, p: vec3f, y: i32, z: i32, w: f32) -> f32 {
    let near = vec3i(0, y, z);
    let far = vec3i(1, y, z);
    let a = dot(noise_slope(cell + near), p - vec3f(near));
    let b = dot(noise_slope(cell + far), p - vec3f(far));
    return a + (b - a) * w;
}

/// Smooth noise, about −1..1; 0 at all points with integer coordinates.
fn noise(point: vec3f) -> f32 {
    let cell = vec3i(floor(point));
    let p = point - floor(point);
    let fade = p * p * p * (p * (p * 6.0 - 15.0) + 10.0);
    let a = noise_row(cell, p, 0, 0, fade.x);
    let b = noise_row(cell, p, 1, 0, fade.x);
    let c = noise_row(cell, p, 0, 1, fade.x);
    let d = noise_row(cell, p, 1, 1, fade.x);
    let near = a + (b - a) * fade.y;
    let far = c + (d - c) * fade.y;
    return near + (far - near) * fade.z;
}

/// How much of a vein there is at a point, 0..1.
fn vein(point: vec3f) -> f32 {
    var sum = 0.0;
    var share = 1.0;
    var p = point;
    for (var octave = 0; octave < 4; octave++) {
        sum += share * noise(p);
        share *= 0.5;
        p *= 2.0;
    }
    let near = max(1.0 - 3.0 * abs(sum), 0.0);
    return near * near;
}
