//! Draws a mesh, displaced by its map.
//!
//! A picture is a function of two values: a [`scene::Scene`] (one triangle mesh in f32 with its map and textures) and
//! [`settings::Settings`] (everything else, stored as JSON). [`software::render`] draws it on the processor and
//! [`gpu::renderer::Renderer`] on a GPU, to any texture; both draw the same. There is no window here, and nothing reads a
//! file: a scene is made of arrays, or of a model by [`input::scene`].
//!
//! ```
//! use glam::Vec3;
//! use planish_render::mesh::{Mesh, Side, Triangle};
//! use planish_render::scene::{Scene, SceneError};
//! use planish_render::settings::{Settings, Size};
//! use planish_render::software;
//!
//! let scene = Scene::new(Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
//!     normals: vec![Vec3::Z],
//!     triangles: vec![Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: None, sides: [Side::Edge; 3], ..Triangle::default() }],
//!     ..Mesh::default()
//! })?;
//! let settings = Settings { size: Size { width: 64, height: 48 }, ..Settings::default() };
//! assert_eq!(software::render(&scene, &settings).dimensions(), (64, 48));
//! # Ok::<(), SceneError>(())
//! ```
//!
//! From below to above, no floor names one above it:
//!
//! | floor | modules |
//! | --- | --- |
//! | plain data | [`bounds`], [`colour`], [`mesh`], [`settings`] |
//! | what is drawn | [`texture`], [`volume`], [`displaced_mesh`], [`environment`], [`scene`], [`input`] |
//! | what both renderers ask | `camera`, `draw_parameters`, `lights`, `ground`, `shadow`, `marble`, `volume_rays`, `legend` |
//! | renderers | [`gpu`], [`software`] |

pub mod bounds;
pub mod camera;
pub mod colour;
pub mod displaced_mesh;
mod draw_parameters;
pub mod environment;
pub mod gpu;
mod ground;
pub mod input;
mod legend;
mod lights;
mod marble;
pub mod mesh;
pub mod scene;
pub mod settings;
mod shadow;
pub mod software;
pub mod texture;
pub mod volume;
mod volume_rays;
