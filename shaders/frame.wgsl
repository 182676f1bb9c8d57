// Bind group 0: what is the same for the whole picture. Choices (SHADING and so on) are constants that are appended. Colours are linear unless said otherwise.
struct Light {
    // Towards the light (w = 0), or where it is (w = 1); world space.
    place: vec4f,
    // Of a white surface that faces it: from afar, or at a distance of one unit.
    radiance: vec3f,
    // Cosine of half the opening angle of a spot; −1 shines everywhere.
    cos_outer: f32,
    // Unit, where a spot points.
    axis: vec3f,
    // Cosine of the angle within which a spot has its full strength.
    cos_inner: f32,
}

struct Frame {
    clip_from_world: mat4x4f,
    // Columns: right, up and back, world space.
    world_from_view: mat4x4f,
    // A point (w = 1), or a direction where rays are parallel (w = 0).
    eye_in_world: vec4f,
    up_in_world: vec3f,
    light_count: u32,
    // Times its strength.
    sky: vec3f,
    specular: f32,
    // Times its strength.
    ground: vec3f,
    exponent: f32,
    base_colour: vec3f,
    // Of overlays, pixels.
    line_width: f32,
    checker_light: vec3f,
    checker_squares: f32,
    checker_dark: vec3f,
    // How much of the normal map shows.
    normal_strength: f32,
    // sRGB, as stored.
    background_top: vec3f,
    // 1 where the scene has numbers to show.
    has_heat: u32,
    // sRGB, as stored.
    background_bottom: vec3f,
    // Bits: HAS_NORMAL_MAP and those below it.
    has: u32,
    heat_low: f32,
    heat_high: f32,
    heat_relief: f32,
    // Per world unit.
    vein_frequency: f32,
    vein_colour: vec3f,
    // How much of the ambient occlusion shows.
    occlusion: f32,
    lights: array<Light, 4>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

const HAS_NORMAL_MAP = 1u;
const HAS_HEIGHTS_IN_UV = 2u;
const HAS_OCCLUSION_MAP = 4u;
const HAS_VOLUME = 8u;

/// Unit vector to the eye.
fn to_eye(position: vec3f) -> vec3f {
    return normalize(frame.eye_in_world.xyz - frame.eye_in_world.w * position);
}

fn linear_from_srgb(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}
