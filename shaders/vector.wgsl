/// A unit vector, or another where there is none.
fn unit_or(v: vec3f, other: vec3f) -> vec3f {
    // Scaled first: the square of a short vector underflows.
    let largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if largest > 0.0 {
        return normalize(v / largest);
    }
    return other;
}
