//! Draws a mesh with its displacement map.
//!
//! A picture is a function of two values: a [`scene::Scene`] (one triangle mesh in f32, with its maps) and
//! [`settings::Settings`] (everything else, stored as JSON). [`software::render`] draws it on the CPU,
//! [`picture::render`] on a GPU, and [`renderer::Renderer`] into any texture view.
//!
//! ```
//! use glam::Vec3;
//! use planish_viewer::scene::{Mesh, Scene, SceneError, Triangle};
//! use planish_viewer::settings::{Settings, Size};
//! use planish_viewer::software;
//!
//! let scene = Scene::new(Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
//!     normals: vec![Vec3::Z],
//!     triangles: vec![Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: None }],
//!     ..Mesh::default()
//! })?;
//! let settings = Settings { size: Size { width: 64, height: 48 }, ..Settings::default() };
//! assert_eq!(software::render(&scene, &settings).dimensions(), (64, 48));
//! # Ok::<(), SceneError>(())
//! ```

pub mod baked;
pub mod camera;
pub mod colormap;
pub mod colour;
mod displaced;
mod frame;
pub mod gpu;
mod gpu_types;
mod heat;
pub mod input;
mod layouts;
mod legend;
pub mod lights;
mod noise;
pub mod painter;
mod passes;
pub mod picture;
mod render_mesh;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod shaders;
mod shading;
pub mod software;
mod targets;
pub mod texture;
mod textures;
mod wedges;
