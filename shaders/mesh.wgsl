// The surface in colour.
struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    // For a heat map.
    @location(4) number: f32,
    @location(5) lit: vec3f,
    @location(6) barycentric: vec3f,
    // Share of the corners that have a number, and a texture coordinate.
    @location(7) has: vec2f,
    @location(8) @interpolate(flat) face_normal: vec3f,
    @location(9) @interpolate(flat) dp_du: vec3f,
    @location(10) @interpolate(flat) dp_dv: vec3f,
    @location(11) @interpolate(flat) sides: u32,
    // Fraction of the ambient light that arrives, by the numbers of the vertices.
    @location(12) open: f32,
}

/// Bits of the sides, below the flags of the triangle.
const SIDE_BITS = 6u;

/// With `SHADING_BUMP` the slope of the heights is seen, and so the vertices stay.
fn place(i: u32) -> vec3f {
    if SHADING == SHADING_BUMP {
        return vertices[i].position;
    }
    return displaced(i);
}

fn uses_normal_map() -> bool {
    let wanted = NORMALS == NORMALS_MAP || SHADING == SHADING_NORMAL_MAP;
    return wanted && (frame.has & HAS_NORMAL_MAP) != 0u;
}

@vertex
fn vs_mesh(@builtin(vertex_index) corner: u32) -> Corner {
    let wedge = wedges[wedge_of(corner)];
    let i = wedge.vertex;
    let k = corner % 3u;
    let first = corner - k;
    var out: Corner;
    out.position = place(i);
    out.clip = frame.clip_from_world * vec4f(out.position, 1.0);
    out.normal = wedge.normal;
    let flags = flags_of(first);
    let turned = select(1.0, -1.0, (flags & TURNED) != 0u);
    if NORMALS == NORMALS_DERIVED {
        let derived = derived_normals[i].xyz;
        if any(derived != vec3f(0.0)) {
            out.normal = turned * derived;
        }
    } else if uses_normal_map() && any(vertices[i].normal != vec3f(0.0)) {
        // A normal map is relative to the normals that the map displaces along.
        out.normal = turned * vertices[i].normal;
    }
    out.tangent = wedge.tangent;
    out.uv = wedge.uv;
    out.has = vec2f(0.0, wedge.has_uv);
    out.open = wedge.open;
    if SHADING == SHADING_HEIGHT {
        out.number = magnitude(i);
    } else if SHADING == SHADING_HEAT {
        out.number = extras[i].number;
        out.has.x = extras[i].has_number;
    }
    out.barycentric = select(vec3f(0.0), vec3f(1.0), vec3u(0u, 1u, 2u) == vec3u(k));
    out.sides = side_of(first) | (side_of(first + 1u) << 2u) | (side_of(first + 2u) << 4u);
    out.sides |= flags << SIDE_BITS;
    // Three vertices more are a price that not every picture has to pay.
    if SHADING == SHADING_FLAT || SHADING == SHADING_GOURAUD || SHADING == SHADING_BUMP || all(out.normal == vec3f(0.0)) {
        set_plane(&out, first);
    }
    if SHADING == SHADING_GOURAUD {
        let side = select(1.0, -1.0, dot(out.face_normal, to_eye(out.position)) < 0.0);
        let open = open_at(wedge.uv, wedge.has_uv > 0.5, wedge.open);
        out.lit = lit(frame.base_colour, out.position, side * out.normal, open);
    }
    return out;
}

/// Of the triangle whose corners begin at `first`.
fn set_plane(out: ptr<function, Corner>, first: u32) {
    let ring = array(wedges[wedge_of(first)], wedges[wedge_of(first + 1u)], wedges[wedge_of(first + 2u)]);
    let a = place(ring[0].vertex);
    let b = place(ring[1].vertex) - a;
    let c = place(ring[2].vertex) - a;
    let across = cross(b, c);
    (*out).face_normal = select(vec3f(0.0), normalize(across), any(across != vec3f(0.0)));
    // How the surface runs with u and v, by Cramer's rule.
    let s = ring[1].uv - ring[0].uv;
    let t = ring[2].uv - ring[0].uv;
    let area = s.x * t.y - s.y * t.x;
    let unit = select(0.0, 1.0 / area, area != 0.0);
    (*out).dp_du = (t.y * b - s.y * c) * unit;
    (*out).dp_dv = (s.x * c - t.x * b) * unit;
}

/// Normal under a height d over the surface: ∂p'/∂u × ∂p'/∂v with ∂p'/∂u = ∂p/∂u + ∂d/∂u n (Pharr, Jakob, Humphreys,
/// Physically Based Rendering, 3rd edition, section 9.3; the change of n itself is left out).
fn bumped(in: Corner, normal: vec3f) -> vec3f {
    let texel = 1.0 / vec2f(textureDimensions(height_map));
    let lift = -displacement.lambda * displacement.scale;
    let along_u = texel_at(in.uv + vec2f(texel.x, 0.0)).x - texel_at(in.uv - vec2f(texel.x, 0.0)).x;
    let along_v = texel_at(in.uv + vec2f(0.0, texel.y)).x - texel_at(in.uv - vec2f(0.0, texel.y)).x;
    let slope = lift * 0.5 * vec2f(along_u, along_v) / texel;
    let det = dot(normal, cross(in.dp_du, in.dp_dv));
    let n = det * normal + slope.x * cross(normal, in.dp_dv) + slope.y * cross(in.dp_du, normal);
    return select(normal, normalize(n) * sign(det), det != 0.0);
}

fn mapped(in: Corner, strength: f32) -> vec3f {
    let flat = vec3f(0.0, 0.0, 1.0);
    let n = mix(flat, tangent_normal_at(in.uv), strength);
    let bitangent = in.tangent.w * cross(in.normal, in.tangent.xyz);
    return normalize(n.x * in.tangent.xyz + n.y * bitangent + n.z * in.normal);
}

fn has_flag(in: Corner, flag: u32) -> bool {
    return ((in.sides >> SIDE_BITS) & flag) != 0u;
}

/// Unit normal, outwards.
fn shading_normal(in: Corner) -> vec3f {
    let has_uv = in.has.y > 0.999;
    if SHADING == SHADING_FLAT {
        return in.face_normal;
    }
    if uses_normal_map() && has_uv && has_flag(in, MAPPED) {
        return mapped(in, frame.normal_strength);
    }
    let normal = select(in.face_normal, normalize(in.normal), any(in.normal != vec3f(0.0)));
    if SHADING == SHADING_BUMP && (frame.has & HAS_HEIGHTS_IN_UV) != 0u && has_uv {
        return bumped(in, normal);
    }
    return normal;
}

/// Share of a pixel that a line along the sides of one kind covers.
fn line_cover(in: Corner, distances: vec3f) -> f32 {
    var cover = 0.0;
    for (var k = 0u; k < 3u; k++) {
        let side = (in.sides >> (2u * k)) & 3u;
        let drawn = select(side == SIDE_SEAM, side != SIDE_DIAGONAL, OVERLAY == OVERLAY_WIREFRAME);
        // The side from corner k lies opposite the corner before it.
        let distance = distances[(k + 2u) % 3u];
        cover = max(cover, select(0.0, clamp(0.5 * frame.line_width + 0.5 - distance, 0.0, 1.0), drawn));
    }
    return cover;
}

@fragment
fn fs_mesh(in: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let side = select(-1.0, 1.0, front);
    let duv_dx = dpdx(in.uv);
    let duv_dy = dpdy(in.uv);
    let widths = abs(dpdx(in.barycentric)) + abs(dpdy(in.barycentric));
    let outwards = shading_normal(in);
    let normal = side * outwards;
    let has_uv = in.has.y > 0.999;
    let open = open_at(in.uv, has_uv, in.open);
    var colour: vec3f;
    switch SHADING {
        case SHADING_GOURAUD: {
            colour = in.lit;
        }
        case SHADING_CLAY: {
            colour = clay(frame.base_colour, normal);
        }
        case SHADING_NORMALS: {
            colour = linear_from_srgb(0.5 * outwards + 0.5);
        }
        case SHADING_HEIGHT, SHADING_HEAT: {
            let t = (in.number - frame.heat_low) / (frame.heat_high - frame.heat_low);
            let known = frame.has_heat != 0u && (SHADING == SHADING_HEIGHT || in.has.x > 0.999);
            let base = select(frame.base_colour, heat_colour(t), known);
            colour = base * mix(vec3f(1.0), irradiance(in.position, normal, open), frame.heat_relief);
        }
        case SHADING_CHECKER: {
            let square = floor(in.uv * frame.checker_squares);
            let odd = fract(0.5 * (square.x + square.y)) > 0.25;
            let base = select(frame.base_colour, select(frame.checker_light, frame.checker_dark, odd), has_uv);
            colour = lit(base, in.position, normal, open);
        }
        case SHADING_TEXTURE: {
            let textured = has_flag(in, TEXTURED) && has_uv;
            let base = select(frame.base_colour, colour_at(in.uv, duv_dx, duv_dy), textured);
            colour = lit(base, in.position, normal, open);
        }
        case SHADING_MARBLE: {
            let base = mix(frame.base_colour, frame.vein_colour, vein(frame.vein_frequency * in.position));
            colour = lit(base, in.position, normal, open);
        }
        case SHADING_SOLID: {
            var base = frame.base_colour;
            if (frame.has & HAS_VOLUME) != 0u {
                base = solid_colour(in.position);
            }
            colour = lit(base, in.position, normal, open);
        }
        default: {
            colour = lit(frame.base_colour, in.position, normal, open);
        }
    }
    if OVERLAY != OVERLAY_NONE {
        let line = select(vec3f(0.02, 0.02, 0.025), vec3f(0.9, 0.2, 0.02), OVERLAY == OVERLAY_SEAMS);
        colour = mix(colour, line, line_cover(in, in.barycentric / widths));
    }
    return vec4f(over_volume_to(colour, in.position), 1.0);
}
