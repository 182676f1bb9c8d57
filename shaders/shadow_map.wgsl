// The displaced surface as a light sees it: depth alone.
struct Caster {
    clip_from_world: mat4x4f,
    // 0 with bumps, where the vertices stay.
    moves: u32,
    _pad_a: u32,
    _pad_b: u32,
    _pad_c: u32,
}

@group(0) @binding(0) var<uniform> caster: Caster;

@vertex
fn vs_shadow(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let i = wedges[wedge_of(corner)].vertex;
    var position = vertices[i].position;
    if caster.moves != 0u {
        position = displaced(i);
    }
    return caster.clip_from_world * vec4f(position, 1.0);
}
