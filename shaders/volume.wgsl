// A volume: values on a grid, and what a ray through it sees. Twin of volume.rs and software/volume.rs of planish-render.
struct ControlPoint {
    colour: vec3f,
    opacity: f32,
    at: f32,
    _pad_a: f32,
    _pad_b: f32,
    _pad_c: f32,
}

struct Volume {
    texel_from_world: mat4x4f,
    // Columns: from the middle of the picture to its right and upper rim, ahead, and the eye; where rays are parallel, a point in
    // the middle of the picture.
    rays: mat4x4f,
    // Corners of the part of the box that is drawn, texel coordinates.
    low: vec3f,
    // From one sample to the next, world units.
    step: f32,
    high: vec3f,
    // Reciprocal of the length in which a ray loses the opacity of a control point, world units.
    density: f32,
    // Texel coordinates.
    slices: vec3f,
    // Bits: the axes that a slice plane lies across.
    has_slices: u32,
    value_low: f32,
    value_scale: f32,
    lighting: f32,
    // Of the box, world units.
    diagonal: f32,
    point_count: u32,
    _pad_a: u32,
    _pad_b: u32,
    _pad_c: u32,
    points: array<ControlPoint, 32>,
}

@group(0) @binding(8) var<uniform> volume: Volume;
@group(0) @binding(9) var volume_map: texture_3d<f32>;

/// Value at texel coordinates: trilinear between the values, in the middle of their voxels, and constant beyond the outermost ones.
///
/// By hand and not by a sampler, as heights are.
fn volume_at(texel: vec3f) -> f32 {
    let last = vec3i(textureDimensions(volume_map)) - 1;
    let p = clamp(texel - 0.5, vec3f(0.0), vec3f(last));
    let low = floor(p);
    let w = p - low;
    let a = vec3i(low);
    let b = min(a + 1, last);
    let near = volume_sheet(a, b, a.z, w);
    return near + (volume_sheet(a, b, b.z, w) - near) * w.z;
}

fn volume_sheet(a: vec3i, b: vec3i, z: i32, w: vec3f) -> f32 {
    let near = volume_row(a, b, a.y, z, w.x);
    return near + (volume_row(a, b, b.y, z, w.x) - near) * w.y;
}

fn volume_row(a: vec3i, b: vec3i, y: i32, z: i32, w: f32) -> f32 {
    let near = textureLoad(volume_map, vec3i(a.x, y, z), 0).r;
    return near + (textureLoad(volume_map, vec3i(b.x, y, z), 0).r - near) * w;
}

/// Colour and opacity of a value.
fn transferred(value: f32) -> vec4f {
    let t = (value - volume.value_low) * volume.value_scale;
    var below = volume.points[0];
    if t <= below.at {
        return vec4f(below.colour, below.opacity);
    }
    for (var i = 1u; i < volume.point_count; i++) {
        let above = volume.points[i];
        if t < above.at {
            let w = (t - below.at) / (above.at - below.at);
            return mix(vec4f(below.colour, below.opacity), vec4f(above.colour, above.opacity), w);
        }
        below = above;
    }
    return vec4f(below.colour, below.opacity);
}

/// Colour of the volume at a position in the scene.
fn solid_colour(position: vec3f) -> vec3f {
    return transferred(volume_at((volume.texel_from_world * vec4f(position, 1.0)).xyz)).rgb;
}

/// Change of the value over the scene, in ranges of the transfer function and diagonals of the box.
fn volume_slope(texel: vec3f) -> vec3f {
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let along = vec3f(
        volume_at(texel + x) - volume_at(texel - x),
        volume_at(texel + y) - volume_at(texel - y),
        volume_at(texel + z) - volume_at(texel - z),
    );
    let slope = vec4f(along, 0.0) * volume.texel_from_world;
    return 0.5 * volume.value_scale * volume.diagonal * slope.xyz;
}

/// Light from a sample to the eye: Blinn-Phong where values change (Levoy 1988), else the colour as it is. A volume casts no shadow, and
/// lies in none.
fn volume_lit(base: vec3f, texel: vec3f, position: vec3f, eye: vec3f) -> vec3f {
    if volume.lighting == 0.0 {
        return base;
    }
    let slope = volume_slope(texel);
    let steepness = length(slope);
    if steepness == 0.0 {
        return base;
    }
    let towards = select(1.0, -1.0, dot(slope, eye) < 0.0);
    let normal = towards * slope / steepness;
    var scattered = ambient(normal);
    var highlights = vec3f(0.0);
    for (var i = 0u; i < frame.light_count; i++) {
        let light = arriving(frame.lights[i], position);
        let cosine = dot(normal, light.direction);
        scattered += max(cosine, 0.0) * light.radiance;
        if cosine > 0.0 {
            let half_way = normalize(light.direction + eye);
            highlights += pow(max(dot(normal, half_way), 0.0), frame.exponent) * light.radiance;
        }
    }
    return mix(base, base * scattered + frame.specular * highlights, volume.lighting * min(2.0 * steepness, 1.0));
}

/// What a ray sees of the volume from `start` to `end` along it, before a colour at `end`. Front to back, as Levoy. Efficient ray
/// tracing of volume data. TOG 9(3), 1990: it ends where hardly any light comes through.
fn over_volume(behind: vec3f, origin: vec3f, direction: vec3f, start: f32, end: f32) -> vec3f {
    if VOLUME == VOLUME_HIDDEN {
        return behind;
    }
    let o = (volume.texel_from_world * vec4f(origin, 1.0)).xyz;
    let d = (volume.texel_from_world * vec4f(direction, 0.0)).xyz;
    // A ray along a side of the box meets it far away, and not nowhere.
    let least = 1e-6 * max(max(abs(d.x), abs(d.y)), abs(d.z));
    let divisor = select(d, vec3f(least), abs(d) < vec3f(least));
    let a = (volume.low - o) / divisor;
    let b = (volume.high - o) / divisor;
    let entries = min(a, b);
    let exits = max(a, b);
    let near = max(max(max(entries.x, entries.y), entries.z), start);
    var far = min(min(min(exits.x, exits.y), exits.z), end);
    if near >= far {
        return behind;
    }
    var colour = behind;
    for (var axis = 0u; axis < 3u; axis++) {
        let t = (volume.slices[axis] - o[axis]) / divisor[axis];
        if (volume.has_slices & (1u << axis)) != 0u && near <= t && t <= far {
            far = t;
            colour = transferred(volume_at(o + t * d)).rgb;
        }
    }
    if VOLUME == VOLUME_SLICES {
        return colour;
    }
    var light = vec3f(0.0);
    var through = 1.0;
    let count = u32(ceil((far - near) / volume.step));
    for (var i = 0u; i < count; i++) {
        let begin = near + f32(i) * volume.step;
        // The last step ends where the ray ends.
        let size = min(volume.step, far - begin);
        let t = begin + 0.5 * size;
        let texel = o + t * d;
        let found = transferred(volume_at(texel));
        if found.a > 0.0 && size > 0.0 {
            let opacity = 1.0 - pow(max(1.0 - found.a, 1e-6), size * volume.density);
            light += through * opacity * volume_lit(found.rgb, texel, origin + t * direction, -direction);
            through *= 1.0 - opacity;
            if through < 0.002 {
                break;
            }
        }
    }
    return light + through * colour;
}

/// The volume before a point of a surface.
fn over_volume_to(behind: vec3f, position: vec3f) -> vec3f {
    let direction = -to_eye(position);
    if frame.eye_in_world.w > 0.0 {
        let eye = frame.eye_in_world.xyz;
        return over_volume(behind, eye, direction, 0.0, distance(eye, position));
    }
    return over_volume(behind, position, direction, -1e30, 0.0);
}

/// The volume before everything, at a position of the picture, −1..1 right and up.
fn over_volume_behind(behind: vec3f, at: vec2f) -> vec3f {
    let offset = at.x * volume.rays[0].xyz + at.y * volume.rays[1].xyz;
    let ahead = volume.rays[2].xyz;
    let origin = volume.rays[3].xyz;
    if frame.eye_in_world.w > 0.0 {
        return over_volume(behind, origin, normalize(ahead + offset), 0.0, 1e30);
    }
    return over_volume(behind, origin + offset, ahead, -1e30, 1e30);
}
