// Appended to `displace.wgsl`: where a vertex samples the map, and flat shading, which shows the noise as it is.
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;

struct Seen {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
}

@vertex
fn vs(@location(0) p: vec3f, @location(1) n: vec3f, @location(2) uv: vec2f, @location(3) texel: u32) -> Seen {
    var height: f32;
    if texel == 0xffffffffu {
        height = height_at(uv);
    } else {
        height = height_of(texel);
    }
    let world = displaced_position(p, n, height);
    return Seen(clip_from_world * vec4f(world, 1.0), world);
}

@fragment
fn fs(in: Seen) -> @location(0) vec4f {
    // The picture's y points down.
    let normal = normalize(cross(dpdy(in.world), dpdx(in.world)));
    let light = 0.1 + 0.8 * max(dot(normal, vec3f(-0.2, 0.8, 0.56)), 0.0);
    return vec4f(light * vec3f(0.9, 0.8, 0.7), 1.0);
}
