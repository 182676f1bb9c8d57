// How light leaves a surface. Twin of software/shading.rs of planish-render, formula by formula.

struct Incoming {
    // Unit, towards the light.
    direction: vec3f,
    radiance: vec3f,
}

/// Light of one lamp at a place, if nothing is in the way.
fn arriving(light: Light, position: vec3f) -> Incoming {
    let way = light.place.xyz - light.place.w * position;
    let direction = normalize(way);
    // The intensity of a lamp that is somewhere falls with the square of the distance.
    let reach = select(1.0, 1.0 / dot(way, way), light.place.w > 0.0);
    let cosine = dot(-direction, light.axis);
    let cone = select(smoothstep(light.cos_outer, light.cos_inner, cosine), 1.0, light.cos_outer <= -1.0);
    return Incoming(direction, light.radiance * (reach * cone));
}

/// Light of the i-th lamp at a place on a surface. What faces away from it gets none, and need not be looked for in its map.
fn incoming(i: u32, position: vec3f, normal: vec3f) -> Incoming {
    var light = arriving(frame.lights[i], position);
    if dot(normal, light.direction) > 0.0 {
        light.radiance *= unshadowed(i, position, normal, light.direction);
    }
    return light;
}

/// Light that arrives, in units of what makes a white surface white; `open` is the fraction of the ambient light that arrives.
fn irradiance(position: vec3f, normal: vec3f, open: f32) -> vec3f {
    var sum = open * ambient(normal);
    for (var i = 0u; i < frame.light_count; i++) {
        let light = incoming(i, position, normal);
        sum += max(dot(normal, light.direction), 0.0) * light.radiance;
    }
    return sum;
}

/// Blinn-Phong: what is scattered evenly, plus highlights (Blinn 1977).
fn lit(base: vec3f, position: vec3f, normal: vec3f, open: f32) -> vec3f {
    let eye = to_eye(position);
    var scattered = open * ambient(normal);
    var highlights = vec3f(0.0);
    for (var i = 0u; i < frame.light_count; i++) {
        let light = incoming(i, position, normal);
        let half_way = normalize(light.direction + eye);
        let cosine = dot(normal, light.direction);
        scattered += max(cosine, 0.0) * light.radiance;
        if cosine > 0.0 {
            highlights += pow(max(dot(normal, half_way), 0.0), frame.exponent) * light.radiance;
        }
    }
    return mirroring(base * scattered, normal, eye) + frame.specular * highlights;
}

/// Clay in a studio: depends on the normal as the eye sees it alone.
fn clay(base: vec3f, normal: vec3f) -> vec3f {
    let n = transpose(frame.world_from_view) * vec4f(normal, 0.0);
    let key = max(dot(n.xyz, normalize(vec3f(-0.5, 0.6, 0.62))), 0.0);
    let fill = max(dot(n.xyz, normalize(vec3f(0.8, 0.1, 0.6))), 0.0);
    let top = 0.5 + 0.5 * n.y;
    let rim = pow(1.0 - clamp(n.z, 0.0, 1.0), 3.0);
    return base * (0.05 + 0.75 * key + 0.16 * fill + 0.12 * top) + 0.06 * rim;
}
