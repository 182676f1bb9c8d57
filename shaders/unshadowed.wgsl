/// How much of a light reaches a point, 0..1: all of it, where there are no shadow maps.
fn visibility(light: u32, position: vec3f, normal: vec3f, towards: vec3f) -> f32 {
    return 1.0;
}
