//! Geometry of planish.

pub mod atlas;
pub mod denoise;
pub mod laplacian;
pub mod materials;
pub mod metrics;
pub mod model;
pub mod noise;
pub mod normals;
pub mod obj;
pub mod polygon;
pub mod progress;
pub mod ragged;
pub mod shapes;
pub mod sparse;
pub mod surface;
pub mod topology;
pub mod weld;
