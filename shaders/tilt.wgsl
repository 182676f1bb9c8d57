// Normals from pictures, in the tangent frame of MikkTSpace. Twin of crates/viewer/src/shading/tilt.rs.

/// The frame is interpolated and not normalised, the bitangent is sign · n × t, as bakers have it (Mikkelsen 2008).
fn tilted_by_normal_map(in: Varyings, smooth_normal: vec3f) -> vec3f {
    let t = in.tangent.xyz;
    if dot(t, t) == 0.0 {
        return smooth_normal;
    }
    let local = 2.0 * bilinear(normal_map, in.uv) - 1.0;
    let b = sign(in.tangent.w) * cross(in.normal, t);
    return unit_or(local.x * t + local.y * b + local.z * in.normal, smooth_normal);
}

/// The surface lifted by `height` · texel: with p' = p + h n, and dropping the change of n, ∂p'/∂u × ∂p'/∂v is along
/// n − (∂h/∂u)/|∂p/∂u| t − (∂h/∂v)/|∂p/∂v| b in an orthonormal frame.
/// James F. Blinn. Simulation of wrinkled surfaces. SIGGRAPH 1978. Pharr, Jakob, Humphreys. Physically Based Rendering,
/// section 10.5.3 (4th edition).
fn tilted_by_heights(in: Varyings, smooth_normal: vec3f) -> vec3f {
    let stretch = in.stretch_scalar.xy;
    let across = in.tangent.xyz - smooth_normal * dot(smooth_normal, in.tangent.xyz);
    if dot(across, across) == 0.0 || min(stretch.x, stretch.y) <= 0.0 {
        return smooth_normal;
    }
    let t = normalize(across);
    let b = sign(in.tangent.w) * cross(smooth_normal, t);
    let step = 1.0 / vec2f(textureDimensions(relief_map));
    let difference = vec2f(
        relief_at(in.uv + vec2f(step.x, 0.0)) - relief_at(in.uv - vec2f(step.x, 0.0)),
        relief_at(in.uv + vec2f(0.0, step.y)) - relief_at(in.uv - vec2f(0.0, step.y)),
    );
    let height = material.relief_bump * material.relief_lambda * material.relief_scale;
    let slope = height * difference / (2.0 * step) / stretch;
    return unit_or(smooth_normal - slope.x * t - slope.y * b, smooth_normal);
}
