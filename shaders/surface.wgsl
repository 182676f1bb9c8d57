// Bind group 2: the mesh. Vertices are fetched by number, so that each is displaced by the same numbers wherever it is
// drawn, and no crack can open at a seam.
struct Vertex {
    position: vec3f,
    // How it finds its texel: PLACE_NONE, PLACE_UV or PLACE_TEXEL.
    place: u32,
    // Unit; what the map displaces along.
    normal: vec3f,
    texel: u32,
}

// What not every picture needs of a vertex, in a buffer of its own: the size of one buffer is limited.
struct Extra {
    // Unit tangent, and the side of the bitangent.
    tangent: vec4f,
    uv: vec2f,
    // For heat maps.
    number: f32,
    // 1 where there is a number, 0 where not.
    has_number: f32,
}

struct Wedge {
    // Unit; of the mesh before it was displaced.
    normal: vec3f,
    vertex: u32,
    tangent: vec4f,
    uv: vec2f,
    // 1 where there is one.
    has_uv: f32,
    // Fraction of the ambient light that arrives, where no picture says it.
    open: f32,
}

@group(2) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(2) @binding(1) var<storage, read> extras: array<Extra>;
@group(2) @binding(2) var<storage, read> wedges: array<Wedge>;
// Three a triangle: the wedge, above it what lies along the side to the next corner, and two of the triangle's flags.
@group(2) @binding(3) var<storage, read> corners: array<u32>;
// Of the displaced surface, from `cs_normals`.
@group(2) @binding(4) var<storage, read> derived_normals: array<vec4f>;

const PLACE_NONE = 0u;
const PLACE_UV = 1u;
const WEDGE_BITS = 28u;
const FLAG_BITS = 30u;
const SIDE_EDGE = 0u;
const SIDE_SEAM = 1u;
const SIDE_DIAGONAL = 2u;

fn wedge_of(corner: u32) -> u32 {
    return corners[corner] & ((1u << WEDGE_BITS) - 1u);
}

fn side_of(corner: u32) -> u32 {
    return (corners[corner] >> WEDGE_BITS) & 3u;
}

// Flags: the triangle has a texture, it has a normal map, it is the back of another one.
const TEXTURED = 1u;
const MAPPED = 2u;
const TURNED = 4u;

/// Flags of the triangle whose corners begin at `first`.
fn flags_of(first: u32) -> u32 {
    return (corners[first] >> FLAG_BITS) | ((corners[first + 1u] >> FLAG_BITS) << 2u);
}

/// What the map says at the i-th vertex, model units: the height in x, or a vector.
fn offset_at(i: u32) -> vec3f {
    if vertices[i].place == PLACE_UV {
        return offset_from_texel(texel_at(extras[i].uv));
    }
    return offset_from_texel(texel_of(vertices[i].texel));
}

/// p' = p − λ · height · n, or p − λ · δ with a map of vectors. A vertex that samples nowhere stays.
fn displaced(i: u32) -> vec3f {
    let v = vertices[i];
    if v.place == PLACE_NONE {
        return v.position;
    }
    let offset = offset_at(i);
    if displacement.kind == KIND_SCALAR {
        return displaced_position(v.position, v.normal, offset.x);
    }
    var axes = mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    if displacement.kind == KIND_VECTOR_TANGENT {
        let tangent = extras[i].tangent;
        axes = mat3x3f(tangent.xyz, cross(v.normal, tangent.xyz) * tangent.w, v.normal);
    }
    return displaced_by_vector(v.position, axes, offset);
}

/// What a heat map of the map itself shows.
fn magnitude(i: u32) -> f32 {
    if vertices[i].place == PLACE_NONE {
        return 0.0;
    }
    let offset = offset_at(i);
    return select(length(offset), offset.x, displacement.kind == KIND_SCALAR);
}
