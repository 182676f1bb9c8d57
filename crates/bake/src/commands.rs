//! The commands, one in each file.

pub(crate) mod apply;
pub(crate) mod bake;
pub(crate) mod batch;
pub(crate) mod bench_quality;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod denoise;
pub(crate) mod info;
pub(crate) mod methods;
pub(crate) mod noise;

use planish_files::input::model;
use planish_files::text::{count, measure, one_line};
