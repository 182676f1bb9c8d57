//! The WGSL of planish as text: one constant for each file beside this one.
//!
//! # Displacing a mesh in a renderer of your own
//!
//! [`DISPLACE`] is all that an engine needs. Append a vertex stage to it, create one shader module from the whole text
//! (WGSL does not care about the order of declarations), and bind two resources:
//!
//! | binding | resource |
//! | --- | --- |
//! | `@group(1) @binding(0)` | the map, `texture_2d<f32>` that is not filtered: `R32Float` for heights, `Rgba32Float` for vectors, texels 0..1, the first row on top, no levels of detail |
//! | `@group(1) @binding(1)` | the uniform `Displacement`, 16 bytes: `bias`, `scale` and `lambda` as f32, `kind` as u32 (0 for heights, 1 for vectors in model space, 2 for vectors in tangent space) |
//!
//! `bias`, `scale` and the kind of the map are in the manifest that was written with the map; bias and scale are model
//! units. λ is the strength: 0 draws the noisy surface and 1 the denoised one. The functions are
//!
//! | function | meaning |
//! | --- | --- |
//! | `height_at(uv) -> f32` | height at a texture coordinate (v up, as in OBJ), bilinear, clamped to the edge |
//! | `height_of(i) -> f32` | height of the i-th `v` line, for maps with one texel for each vertex |
//! | `displaced_position(position, normal, height) -> vec3f` | p' = p − λ · height · n |
//! | `texel_at(uv)`, `texel_of(i)`, `offset_from_texel(texel) -> vec3f` | the same lookups for maps of vectors |
//! | `displaced_by_vector(position, axes, offset) -> vec3f` | p' = p − λ · axes · δ |
//!
//! The normal must be the one that the map was baked for, the `vn` of the exported mesh, and there must be one per vertex:
//! vertices that share a position but not a texture coordinate must sample at one and the same coordinate, or the surface
//! cracks at the seams. The exported mesh and its manifest name that coordinate.
//!
//! ```
//! let module = [planish_shaders::DISPLACE, r#"
//!     @group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
//!
//!     @vertex
//!     fn vs(@location(0) p: vec3f, @location(1) n: vec3f, @location(2) uv: vec2f) -> @builtin(position) vec4f {
//!         return clip_from_world * vec4f(displaced_position(p, n, height_at(uv)), 1.0);
//!     }
//! "#]
//! .concat();
//! naga::front::wgsl::parse_str(&module)?;
//! # Ok::<(), naga::front::wgsl::ParseError>(())
//! ```
//!
//! # Programs of planish's own renderer
//!
//! The renderer appends constants for the choices of its settings (`SHADING`, `NORMALS`, `OVERLAY`, `SAMPLING`, `FILTER`,
//! `OUTSIDE`, `VOLUME`) to these files:
//!
//! | program | files |
//! | --- | --- |
//! | background | [`FRAME`], [`SHADOW`], [`ENVIRONMENT`], [`LIGHT`], [`VOLUME`], [`BACKGROUND`] |
//! | mesh | [`FRAME`], [`DISPLACE`], [`SURFACE`], [`SHADOW`], [`ENVIRONMENT`], [`LIGHT`], [`VOLUME`], [`TEXTURES`], [`NOISE`], [`MESH`] |
//! | normals | [`DISPLACE`], [`SURFACE`], [`NORMALS`] |
//! | shadow map | [`DISPLACE`], [`SURFACE`], [`SHADOW_MAP`] |
//! | view of a shadow map | [`FRAME`], [`SHADOW`], [`SHADOW_VIEW`] |
//! | ground | [`FRAME`], [`SHADOW`], [`ENVIRONMENT`], [`LIGHT`], [`VOLUME`], [`GROUND`] |
//!
//! Bind group 0 holds the frame and what lights it, 1 the map, 2 the mesh, and 3 textures or the results of computations.

#![no_std]

/// The gradient or the environment behind the model: `vs_background` and `fs_background`.
pub const BACKGROUND: &str = include_str!("background.wgsl");
/// The lookup of the map and the displaced position, without an entry point; see the [crate's page](crate).
pub const DISPLACE: &str = include_str!("displace.wgsl");
/// The light of an environment: ambient light, background and mirror images, from a prefiltered cube map.
pub const ENVIRONMENT: &str = include_str!("environment.wgsl");
/// The uniforms that are the same for a whole picture, and the lights.
pub const FRAME: &str = include_str!("frame.wgsl");
/// The plane under the model: `vs_ground` and `fs_ground`.
pub const GROUND: &str = include_str!("ground.wgsl");
/// The shading of a point on a surface: Blinn-Phong with shadows and an environment, and clay.
pub const LIGHT: &str = include_str!("light.wgsl");
/// The displaced surface in colour: `vs_mesh` and `fs_mesh`.
pub const MESH: &str = include_str!("mesh.wgsl");
/// Perlin noise in three dimensions, and the veins of marble made from it.
pub const NOISE: &str = include_str!("noise.wgsl");
/// Displaced positions and their angle-weighted normals, computed: `cs_positions` and `cs_normals`.
pub const NORMALS: &str = include_str!("normals.wgsl");
/// The lookup of shadow maps: hard, percentage-closer and soft.
pub const SHADOW: &str = include_str!("shadow.wgsl");
/// The depth that a light sees: `vs_shadow`.
pub const SHADOW_MAP: &str = include_str!("shadow_map.wgsl");
/// A shadow map shown in place of the picture: `vs_shadow_view` and `fs_shadow_view`.
pub const SHADOW_VIEW: &str = include_str!("shadow_view.wgsl");
/// The mesh in storage buffers, fetched by number, and its displacement.
pub const SURFACE: &str = include_str!("surface.wgsl");
/// The textures of materials and their filters, the normal map and the colour map.
pub const TEXTURES: &str = include_str!("textures.wgsl");
/// A volume on a grid: its value at a position, its colours, and what a ray through it sees.
pub const VOLUME: &str = include_str!("volume.wgsl");
