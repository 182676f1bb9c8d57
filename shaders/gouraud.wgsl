// Henri Gouraud. Continuous shading of curved surfaces. 1971: light at the vertices is interpolated.

struct Gouraud {
    @builtin(position) @invariant clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) tangent: vec4f,
    @location(4) stretch_scalar: vec4f,
    // Which side is seen is known at the pixel only.
    @location(5) front_diffuse: vec3f,
    @location(6) front_specular: vec3f,
    @location(7) back_diffuse: vec3f,
    @location(8) back_specular: vec3f,
}

@vertex
fn vs_gouraud(wedge: Wedge, @location(7) shading_normal: vec3f, surfel: Surfel) -> Gouraud {
    let v = varyings(wedge, shading_normal, surfel);
    let n = unit_or(v.normal, vec3f(0.0));
    let to_eye = to_eye_from(v.position);
    let front = lit(v.position, n, to_eye);
    let back = lit(v.position, -n, to_eye);
    return Gouraud(
        v.clip, v.position, v.normal, v.uv, v.tangent, v.stretch_scalar,
        front.diffuse, front.specular, back.diffuse, back.specular,
    );
}

@fragment
fn fs_gouraud(in: Gouraud, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    let v = Varyings(in.clip, in.position, in.normal, in.uv, in.tangent, in.stretch_scalar);
    let base = base_colour(v);
    if is_front {
        return painted(base, Lit(in.front_diffuse, in.front_specular));
    }
    return painted(base, Lit(in.back_diffuse, in.back_specular));
}
