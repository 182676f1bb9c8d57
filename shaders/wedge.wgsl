// What the GPU calls a vertex: a place where a vertex of the surface, a normal and a texture coordinate meet.

// Twin of `Wedge` in crates/viewer/src/gpu_types.rs; the same bytes are a vertex buffer and a storage buffer.
struct Wedge {
    @location(0) position: vec3f,
    // Texel of the map with one for each `v` line; NOWHERE if the vertex does not sample the map.
    @location(1) texel: u32,
    // Along which maps displace: one for each vertex, unit.
    @location(2) normal: vec3f,
    // Vertex of the surface.
    @location(3) vertex: u32,
    // Where all wedges of the vertex sample maps that displace, v up.
    @location(4) dominant_uv: vec2f,
    // Where this one samples pictures, v up.
    @location(5) uv: vec2f,
    // Tangent frame of the vertex, for maps of vectors: the bitangent is w · n × t.
    @location(6) axis: vec4f,
}

const NOWHERE = 0xffffffffu;

/// Where the displacement map takes a vertex; all passes call this.
fn denoised(wedge: Wedge) -> vec3f {
    if wedge.texel == NOWHERE {
        return wedge.position;
    }
    var texel: vec3f;
    if (displacement.kind & 4u) != 0u {
        texel = texel_of(wedge.texel);
    } else {
        texel = texel_at(wedge.dominant_uv);
    }
    let offset = offset_from_texel(texel);
    let n = wedge.normal;
    switch displacement.kind & 3u {
        case 0u: {
            return displaced_position(wedge.position, n, offset.x);
        }
        case 1u: {
            return displaced_by_vector(wedge.position, mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), offset);
        }
        default: {
            let t = wedge.axis.xyz;
            return displaced_by_vector(wedge.position, mat3x3f(t, cross(n, t) * wedge.axis.w, n), offset);
        }
    }
}
