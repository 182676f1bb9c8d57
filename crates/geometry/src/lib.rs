//! Mesh denoising and displacement maps: values in, values out. No files, no printing, no clock, no GPU.
//!
//! A noisy mesh goes in; how far the noise lifted each vertex, hᵢ = ⟨pᵢ − p*ᵢ, nᵢ⟩, comes out as a texture, and a vertex
//! shader takes it off again: p' = p − λ · (bias + scale · texel) · n.
//!
//! From OBJ text to a height map:
//!
//! ```
//! use planish_geometry::denoise::{Denoiser, Laplacian};
//! use planish_geometry::source::model::{Model, NormalSource};
//! use planish_geometry::source::obj::Obj;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::map::{self, Coverage, Interpolation, Size, TextureLayout};
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::mesh::normals;
//!
//! // A pyramid over a square: its tip is lifted by one.
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\n\
//!             vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n\
//!             f 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let (surface, atlas) = (model.surface(), model.atlas()?);
//!
//! let one_full_step = Denoiser::Laplacian(Laplacian { iterations: 1, step: 1.0, ..Laplacian::default() });
//! let deltas = one_full_step.deltas(surface, &Silent)?;
//! let normals = model.displacement_normals(NormalSource::Angle)?;
//! let heights = normals::heights(&deltas, &normals);
//! assert_eq!(heights, [0.0, 0.0, 0.0, 0.0, 1.0]); // the boundary stays, the tip goes down to the square
//!
//! let coverage = Coverage::new(surface, &atlas, Size::square(65), &Silent)?;
//! let layout = TextureLayout { surface, atlas: &atlas, coverage: &coverage };
//! let map = map::interpolate_heights(layout, &heights, Interpolation::Barycentric, &Silent)?;
//! assert_eq!(map.texels[32 * 65 + 32], 1.0); // the texel in the middle
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`bake::bake`] does all of this and gives the files that `planish bake` writes.
//!
//! Vertices are what connectivity speaks of, after welding ([`weld`]); a uv vertex is one texture coordinate, and a
//! wedge a pair of both ([`atlas`]). Geometry is in f64; from the GPU border on ([`displacement`], [`apply`]) it is f32.
//! The same input gives the same bits, whatever the number of threads.

pub mod bake;
pub mod denoise;
pub mod map;
pub mod mesh;
pub mod metrics;
pub mod named;
pub mod progress;
pub mod source;
