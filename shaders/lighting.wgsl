// James F. Blinn. Models of light reflection for computer synthesized pictures. SIGGRAPH 1977.
// Linear light, world space. Twin of crates/viewer/src/shading.rs.

struct Incoming {
    // Unit, towards the light.
    towards: vec3f,
    // Linear RGB that arrives.
    light: vec3f,
}

fn incoming(light: Light, position: vec3f) -> Incoming {
    if light.place.w == 0.0 {
        return Incoming(light.place.xyz, light.radiance);
    }
    let way = light.place.xyz - position;
    let towards = unit_or(way, vec3f(0.0));
    let fading = light.nominal * light.nominal / max(dot(way, way), 1.17549435e-38);
    let t = clamp((-dot(towards, light.axis) - light.cone_outer) / (light.cone_inner - light.cone_outer), 0.0, 1.0);
    return Incoming(towards, fading * (t * t * (3.0 - 2.0 * t)) * light.radiance);
}

struct Lit {
    // What is scattered evenly by a white surface.
    diffuse: vec3f,
    // The highlight.
    specular: vec3f,
}

/// Light from everywhere: a hemisphere about the up axis.
fn ambient(normal: vec3f) -> vec3f {
    return mix(lights.ground, lights.sky, 0.5 + 0.5 * dot(normal, frame.up));
}

fn lit(position: vec3f, normal: vec3f, to_eye: vec3f) -> Lit {
    var sum = Lit(ambient(normal), vec3f(0.0));
    for (var i = 0u; i < lights.count; i++) {
        let from = incoming(lights.lights[i], position);
        let arriving = from.light * visibility(i, position, normal, from.towards);
        let facing = dot(normal, from.towards);
        sum.diffuse += max(facing, 0.0) * arriving;
        if facing > 0.0 {
            let half_way = unit_or(from.towards + to_eye, vec3f(0.0));
            let cosine = max(dot(normal, half_way), 0.0);
            // pow(0, x) is log2(0) on the way.
            if cosine > 0.0 {
                sum.specular += pow(cosine, material.exponent) * arriving;
            }
        }
    }
    sum.specular *= material.specular;
    return sum;
}

/// Unit vector from a point of the surface to the eye.
fn to_eye_from(position: vec3f) -> vec3f {
    return unit_or(frame.eye.xyz - frame.eye.w * position, vec3f(0.0));
}
