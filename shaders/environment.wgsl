// Light from all around.
struct Environment {
    // Its axes are left-handed: right, up, ahead.
    environment_from_world: mat4x4f,
    // Columns: to the right rim, the upper rim and the middle of the picture; in the environment.
    rays: mat4x4f,
    // Spherical harmonics of orders 0 to 2, times its strength.
    irradiance: array<vec4f, 9>,
    intensity: f32,
    reflectance: f32,
    roughness: f32,
    // Of the last level of detail.
    roughest: f32,
    // 1 where it is shown.
    background: f32,
    blur: f32,
    // 1 where it shines.
    ambient: f32,
    _pad: f32,
}

@group(0) @binding(3) var<uniform> environment: Environment;
@group(0) @binding(4) var environment_map: texture_cube<f32>;
@group(0) @binding(5) var environment_sampler: sampler;

/// Radiance from a direction of the environment, as a mirror of this roughness shows it.
fn surroundings(direction: vec3f, roughness: f32) -> vec3f {
    let level = roughness * environment.roughest;
    return environment.intensity * textureSampleLevel(environment_map, environment_sampler, direction, level).rgb;
}

/// Diffuse light from everywhere, in units of what makes a white surface white.
fn ambient(normal: vec3f) -> vec3f {
    if environment.ambient < 0.5 {
        return mix(frame.ground, frame.sky, 0.5 + 0.5 * dot(normal, frame.up_in_world));
    }
    let n = (environment.environment_from_world * vec4f(normal, 0.0)).xyz;
    let c = environment.irradiance;
    let sum = 0.28209479 * c[0] + 0.48860251 * (n.y * c[1] + n.z * c[2] + n.x * c[3])
        + 1.09254843 * (n.x * n.y * c[4] + n.y * n.z * c[5] + n.x * n.z * c[7])
        + 0.31539157 * (3.0 * n.z * n.z - 1.0) * c[6] + 0.54627422 * (n.x * n.x - n.y * n.y) * c[8];
    return max(sum.rgb, vec3f(0.0));
}

/// What a surface sends to the eye if it also mirrors the environment (Schlick 1994; rough surfaces shine less at grazing
/// angles).
fn mirroring(colour: vec3f, normal: vec3f, eye: vec3f) -> vec3f {
    if environment.reflectance == 0.0 {
        return colour;
    }
    let r = environment.reflectance;
    let grazing = pow(1.0 - clamp(dot(normal, eye), 0.0, 1.0), 5.0);
    let share = r + (max(1.0 - environment.roughness, r) - r) * grazing;
    let direction = (environment.environment_from_world * vec4f(reflect(-eye, normal), 0.0)).xyz;
    return mix(colour, surroundings(direction, environment.roughness), share);
}
