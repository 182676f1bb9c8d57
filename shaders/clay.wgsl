// A lump of clay in the light of a studio, as a function of the normal in view space alone (a matcap). Twin of
// crates/viewer/src/shading/clay.rs.

// Towards a large soft light, up on the left; towards a weaker one, down on the right; half-way to the eye.
const CLAY_KEY = vec3f(-0.4767313, 0.6674238, 0.5720776);
const CLAY_FILL = vec3f(0.8295614, -0.2073903, 0.5184758);
const CLAY_HIGHLIGHT = vec3f(-0.2688572, 0.3764001, 0.8865883);

/// Linear RGB of clay of a base colour; the normal is unit, in view space (right, up, towards the eye).
fn clay(base: vec3f, normal: vec3f) -> vec3f {
    // A large light reaches round the edge.
    let key = 0.5 + 0.5 * dot(normal, CLAY_KEY);
    let fill = max(dot(normal, CLAY_FILL), 0.0);
    let rim = 1.0 - clamp(normal.z, 0.0, 1.0);
    let scattered = vec3f(0.09, 0.085, 0.09) + key * key * vec3f(0.86, 0.83, 0.78) + fill * vec3f(0.10, 0.12, 0.16);
    let gloss = pow(max(dot(normal, CLAY_HIGHLIGHT), 1e-6), 32.0);
    return base * scattered + 0.12 * gloss + rim * rim * rim * vec3f(0.07, 0.09, 0.12);
}
