//! Draws a mesh.
//!
//! A picture is a function of two values: a [`scene::Scene`] (one triangle mesh in f32) and
//! [`settings::Settings`] (everything else, stored as JSON). [`software::render`] draws it on the CPU.
//!
//! ```
//! use glam::Vec3;
//! use planish_viewer::scene::{Mesh, Scene, SceneError, Side, Triangle};
//! use planish_viewer::settings::{Settings, Size};
//! use planish_viewer::software;
//!
//! let scene = Scene::new(Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
//!     normals: vec![Vec3::Z],
//!     triangles: vec![Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: None, sides: [Side::Edge; 3] }],
//!     ..Mesh::default()
//! })?;
//! let settings = Settings { size: Size { width: 64, height: 48 }, ..Settings::default() };
//! assert_eq!(software::render(&scene, &settings).dimensions(), (64, 48));
//! # Ok::<(), SceneError>(())
//! ```

pub mod app;
pub mod camera;
pub mod colour;
pub mod environment;
pub mod errors;
pub mod gpu;
mod gpu_types;
pub mod ground;
mod image_file;
pub mod input;
pub mod lights;
mod noise;
pub mod open;
pub mod painter;
pub mod relief;
mod render_mesh;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod shaders;
mod shading;
pub mod shadow;
pub mod software;
pub mod texture;
pub mod window;
