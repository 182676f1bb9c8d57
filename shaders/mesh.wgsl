// The fragment stage: one entry point for each way to shade. Twin of crates/viewer/src/shading.rs.

/// What is known about the surface at a pixel.
struct Fragment {
    // Unit, of the triangle, on the side that is seen.
    face_normal: vec3f,
    // Unit, with what maps do to it: outwards, and on the side that is seen.
    outwards: vec3f,
    normal: vec3f,
    to_eye: vec3f,
}

fn fragment(in: Varyings, is_front: bool) -> Fragment {
    var f: Fragment;
    f.to_eye = to_eye_from(in.position);
    // Derivatives first, while all pixels of a block are here.
    let across = cross(dpdx(in.position), dpdy(in.position));
    let face = unit_or(across, f.to_eye);
    f.face_normal = select(face, -face, dot(face, f.to_eye) < 0.0);
    let side = select(-1.0, 1.0, is_front);
    f.outwards = mapped_normal(in, unit_or(in.normal, side * f.face_normal));
    f.normal = side * f.outwards;
    return f;
}

fn mapped_normal(in: Varyings, smooth_normal: vec3f) -> vec3f {
    if !has_uv(in) {
        return smooth_normal;
    }
    if frame.normals == FROM_MAP && pictures.has_normals != 0u {
        return tilted_by_normal_map(in, smooth_normal);
    }
    if (frame.shading == BUMP || frame.shading == DISPLACEMENT) && pictures.has_relief != 0u {
        return tilted_by_heights(in, smooth_normal);
    }
    return smooth_normal;
}

fn has_uv(in: Varyings) -> bool {
    return in.stretch_scalar.x >= 0.0;
}

fn painted(base: vec3f, light: Lit) -> vec4f {
    return vec4f(base * light.diffuse + light.specular, 1.0);
}

/// Base colour from the texture, or else the material's.
fn base_colour(in: Varyings) -> vec3f {
    let dx = dpdx(in.uv);
    let dy = dpdy(in.uv);
    if pictures.has_colour == 0u || !has_uv(in) {
        return plain_colour(in.position);
    }
    return colour_at(in.uv, dx, dy);
}

/// The material's, with or without veins.
fn plain_colour(position: vec3f) -> vec3f {
    if material.noise_frequency == 0.0 {
        return material.colour;
    }
    let p = (0.5 * material.noise_frequency / frame.radius) * (position - frame.centre);
    return mix(material.colour, material.vein, vein(p));
}

/// Where there are no texture coordinates there are no squares.
fn checker_colour(in: Varyings) -> vec3f {
    if !has_uv(in) {
        return plain_colour(in.position);
    }
    let square = vec2i(floor(in.uv * material.checker_squares));
    return select(material.checker_light, material.checker_dark, ((square.x + square.y) & 1) == 1);
}

/// Between the samples of the colour map, which are encoded; what has no number keeps the material's colour.
fn heat_colour(in: Varyings) -> vec3f {
    let scalar = in.stretch_scalar.zw;
    if scalar.y <= 0.999 || material.heat_samples == 0u {
        return material.colour;
    }
    let last = material.heat_samples - 1u;
    let t = clamp((scalar.x - material.heat_low) / (material.heat_high - material.heat_low), 0.0, 1.0);
    let x = t * f32(last);
    let low = min(u32(x), last - 1u);
    let encoded = mix(material.heat_colours[low].rgb, material.heat_colours[low + 1u].rgb, x - f32(low));
    return linear_from_srgb(encoded);
}

@fragment
fn fs_flat(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    return painted(base_colour(in), lit(in.position, f.face_normal, f.to_eye));
}

@fragment
fn fs_blinn_phong(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    return painted(plain_colour(in.position), lit(in.position, f.normal, f.to_eye));
}

/// Also bumps and displacement: these change the normal and the vertices.
@fragment
fn fs_texture(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    return painted(base_colour(in), lit(in.position, f.normal, f.to_eye));
}

@fragment
fn fs_normals(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    return vec4f(linear_from_srgb(0.5 * f.outwards + 0.5), 1.0);
}

@fragment
fn fs_clay(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    let in_view = (transpose(frame.world_from_view) * vec4f(f.normal, 0.0)).xyz;
    return vec4f(clay(material.colour, in_view), 1.0);
}

@fragment
fn fs_checker(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    return painted(checker_colour(in), lit(in.position, f.normal, f.to_eye));
}

@fragment
fn fs_heat(in: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let f = fragment(in, is_front);
    let light = lit(in.position, f.normal, f.to_eye).diffuse;
    return vec4f(heat_colour(in) * mix(vec3f(1.0), light, material.heat_relief), 1.0);
}
