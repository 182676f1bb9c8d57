// Compute passes over the wedges: where they are displaced, which can be read back, and the normals that follow.

@group(0) @binding(0) var<storage, read> wedges: array<Wedge>;
// Displaced positions; the fourth number is not used.
@group(0) @binding(1) var<storage, read_write> places: array<vec4f>;
// Where the corners of each vertex begin in `corners`, and of the last one end.
@group(0) @binding(2) var<storage, read> firsts: array<u32>;
// Wedges at the other two corners of the triangle, in its sense.
@group(0) @binding(3) var<storage, read> corners: array<vec2u>;
@group(0) @binding(4) var<storage, read_write> normals: array<vec4f>;

const GROUP = 256u;

/// Meshes of many millions of wedges need more than one row of work groups.
fn index(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * GROUP + id.x;
}

@compute @workgroup_size(GROUP)
fn cs_places(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = index(id, groups);
    if i < arrayLength(&wedges) {
        places[i] = vec4f(denoised(wedges[i]), 0.0);
    }
}

/// Angle-weighted over the displaced triangles around the vertex (Thürmer & Wüthrich 1998); zero where they cancel.
@compute @workgroup_size(GROUP)
fn cs_normals(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = index(id, groups);
    if i >= arrayLength(&wedges) {
        return;
    }
    let vertex = wedges[i].vertex;
    let p = places[i].xyz;
    var sum = vec3f(0.0);
    for (var c = firsts[vertex]; c < firsts[vertex + 1u]; c++) {
        // Of unit length, or the product of two short edges underflows.
        let a = unit_or(places[corners[c].x].xyz - p, vec3f(0.0));
        let b = unit_or(places[corners[c].y].xyz - p, vec3f(0.0));
        let across = cross(a, b);
        sum += atan2(length(across), dot(a, b)) * unit_or(across, vec3f(0.0));
    }
    normals[i] = vec4f(unit_or(sum, vec3f(0.0)), 0.0);
}
