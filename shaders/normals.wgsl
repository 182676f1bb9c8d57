// Where the vertices go, and the normals there. Twin of `Relief::normals`.
@group(3) @binding(0) var<storage, read_write> places: array<vec4f>;
@group(3) @binding(1) var<storage, read_write> normals: array<vec4f>;
// One more than there are vertices: where the ring of each begins in this array, and ends. Then pairs: the other two corners
// of the triangles around a vertex, counter-clockwise.
@group(3) @binding(2) var<storage, read> rings: array<u32>;

/// Vertices in rows of 65,535 groups of 64, as many as there may be in one direction.
fn vertex_index(group: vec3u, local: u32) -> u32 {
    return (group.y * 65535u + group.x) * 64u + local;
}

@compute @workgroup_size(64)
fn cs_positions(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let i = vertex_index(group, local);
    if i < arrayLength(&vertices) {
        places[i] = vec4f(displaced(i), 1.0);
    }
}

@compute @workgroup_size(64)
fn cs_normals(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let i = vertex_index(group, local);
    if i >= arrayLength(&vertices) {
        return;
    }
    let p = places[i].xyz;
    var sum = vec3f(0.0);
    for (var k = rings[i]; k < rings[i + 1u]; k += 2u) {
        let a = places[rings[k]].xyz - p;
        let b = places[rings[k + 1u]].xyz - p;
        let across = cross(a, b);
        let size = length(across);
        if size > 0.0 {
            sum += across * (atan2(size, dot(a, b)) / size);
        }
    }
    let size = length(sum);
    normals[i] = vec4f(select(vec3f(0.0), sum / size, size > 0.0), 0.0);
}
