//! Geometry of planish.

pub mod apply;
pub mod atlas;
pub mod bundle;
pub mod denoise;
pub mod displacement;
pub mod laplacian;
pub mod manifest;
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
pub mod texture;
pub mod topology;
pub mod weld;
