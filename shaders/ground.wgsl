// A level disc under the model.
struct Ground {
    centre: vec3f,
    radius: f32,
    right: vec3f,
    // 1 where only shadows are seen.
    catches: f32,
    ahead: vec3f,
    _pad: f32,
    colour: vec3f,
    _pad_b: f32,
}

@group(0) @binding(6) var<uniform> ground: Ground;

struct Spot {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    // From −1 to 1.
    @location(1) at: vec2f,
}

@vertex
fn vs_ground(@builtin(vertex_index) i: u32) -> Spot {
    let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let position = ground.centre + ground.radius * (corner.x * ground.right + corner.y * ground.ahead);
    return Spot(frame.clip_from_world * vec4f(position, 1.0), position, corner);
}

/// Light that arrives, and what would without shadows.
struct Lit {
    light: vec3f,
    open: vec3f,
}

fn ground_light(position: vec3f, normal: vec3f) -> Lit {
    var lit = Lit(ambient(normal), ambient(normal));
    for (var i = 0u; i < frame.light_count; i++) {
        let light = arriving(frame.lights[i], position);
        let open = max(dot(normal, light.direction), 0.0) * light.radiance;
        lit.open += open;
        lit.light += open * unshadowed(i, position, normal, light.direction);
    }
    return lit;
}

@fragment
fn fs_ground(in: Spot) -> @location(0) vec4f {
    let cover = 1.0 - smoothstep(0.45, 1.0, length(in.at));
    let lit = ground_light(in.position, frame.up_in_world);
    if ground.catches > 0.5 {
        const LUMA = vec3f(0.2126, 0.7152, 0.0722);
        let open = max(dot(lit.open, LUMA), 1e-6);
        return vec4f(over_volume_to(vec3f(0.0), in.position), cover * (1.0 - dot(lit.light, LUMA) / open));
    }
    return vec4f(over_volume_to(ground.colour * lit.light, in.position), cover);
}
