// Bind group 0: what is the same for the whole picture.

struct Frame {
    // Clip space (depth 0..1) from world space, and back.
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    // Rotations: columns are right, up and back (towards the eye).
    world_from_view: mat4x4f,
    // Homogeneous: a point in perspective, a direction (w = 0) if rays are parallel.
    eye: vec4f,
    // Unit, world space.
    up: vec3f,
    // Of the model's bounds: lengths in settings are multiples of it.
    radius: f32,
    centre: vec3f,
    // The entry of `Shading`, in the order of settings/shading.rs.
    shading: u32,
    // Pixels of the target that is drawn into.
    viewport: vec2f,
    // Pixels of that target along a pixel of the picture.
    supersampling: f32,
    // 0 base, 1 map, 2 derived.
    normals: u32,
}

struct Light {
    // Homogeneous: a unit vector towards the light (w = 0), or where it is (w = 1).
    place: vec4f,
    // Linear RGB at the distance `nominal`.
    radiance: vec3f,
    nominal: f32,
    // Unit, along the middle of its rays.
    axis: vec3f,
    // Cosines of the angles off the axis at which light begins to fade and has faded.
    cone_inner: f32,
    cone_outer: f32,
    // Layer of its first shadow map, or −1.
    shadow: i32,
    _pad: vec2f,
}

struct Lights {
    lights: array<Light, 4>,
    // Linear RGB from above and below.
    sky: vec3f,
    count: u32,
    ground: vec3f,
    _pad: f32,
}

struct Material {
    // Linear RGB.
    colour: vec3f,
    specular: f32,
    // Of the veins of noise, linear RGB.
    vein: vec3f,
    exponent: f32,
    checker_light: vec3f,
    // Squares along the unit square's side.
    checker_squares: f32,
    checker_dark: vec3f,
    // Waves across the model; 0 is no noise.
    noise_frequency: f32,
    // λ, bias and scale of the relief, model units; how much of its slope tilts normals.
    relief_lambda: f32,
    relief_bias: f32,
    relief_scale: f32,
    relief_bump: f32,
    // Numbers at the ends of the colour map, how much the lights show, and how many samples the map has.
    heat_low: f32,
    heat_high: f32,
    heat_relief: f32,
    heat_samples: u32,
    // Encoded sRGB.
    heat_colours: array<vec4f, 17>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> lights: Lights;
@group(0) @binding(2) var<uniform> material: Material;
