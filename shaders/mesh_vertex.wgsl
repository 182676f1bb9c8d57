// The vertex stage of all passes that draw the mesh.

// Twin of `Surfel` in crates/viewer/src/gpu_types.rs.
struct Surfel {
    // MikkTSpace: the bitangent is w · n × t.
    @location(8) tangent: vec4f,
    // Lengths of ∂p/∂u and ∂p/∂v; negative where there are no texture coordinates.
    @location(9) stretch: vec2f,
    // A number of the vertex, and 1 if it has one.
    @location(10) scalar: vec2f,
}

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) tangent: vec4f,
    // Stretch, scalar.
    @location(4) stretch_scalar: vec4f,
}

// Entries of `Shading` and `Normals`.
const BUMP = 5u;
const DISPLACEMENT = 6u;
const FROM_MAP = 1u;

/// Where a vertex is drawn: denoised, and then lifted by the relief.
fn drawn_position(wedge: Wedge) -> vec3f {
    let position = denoised(wedge);
    if frame.shading != DISPLACEMENT || pictures.has_relief == 0u {
        return position;
    }
    let height = material.relief_bias + material.relief_scale * relief_at(wedge.dominant_uv);
    return position + material.relief_lambda * height * wedge.normal;
}

fn varyings(wedge: Wedge, shading_normal: vec3f, surfel: Surfel) -> Varyings {
    var out: Varyings;
    out.position = drawn_position(wedge);
    out.clip = frame.clip_from_world * vec4f(out.position, 1.0);
    // A baked normal map lies in frames about the normals along which the map displaces.
    let is_carrier = frame.normals == FROM_MAP && pictures.has_normals == 2u;
    out.normal = select(shading_normal, wedge.normal, is_carrier);
    out.uv = wedge.uv;
    out.tangent = surfel.tangent;
    out.stretch_scalar = vec4f(surfel.stretch, surfel.scalar);
    return out;
}

@vertex
fn vs_mesh(wedge: Wedge, @location(7) shading_normal: vec3f, surfel: Surfel) -> Varyings {
    return varyings(wedge, shading_normal, surfel);
}
