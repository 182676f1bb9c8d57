//! The native part of the Python package `planish`. It takes and gives arrays of NumPy and JSON; the modules in `planish/` make
//! keyword arguments, classes and meshes of other packages of them.

#![allow(clippy::needless_pass_by_value, reason = "PyO3 hands arguments over by value")]

mod arrays;
mod bundle;
mod errors;
mod mesh;
mod options;
mod tiles;
mod work;

use planish_memory::WatchedAllocator;
use pyo3::prelude::*;

// The command line ends in order when memory is exhausted; functions of the package end the program as the allocator of the
// system does.
#[global_allocator]
static ALLOCATOR: WatchedAllocator = WatchedAllocator;

/// Functions and classes that the modules of the package call.
#[pymodule]
mod _planish {
    use super::{Python, pyfunction};
    use std::ffi::OsString;

    #[pymodule_export]
    use super::bundle::Bundle;
    #[pymodule_export]
    use super::mesh::{Mesh, apply, denoise};
    #[pymodule_export]
    use super::tiles::{
        tile_denoise, tile_heights, tile_lengths, tile_page, tile_round, tiles_bundle, tiles_check, tiles_check_map,
        tiles_end_round, tiles_job, tiles_last_round, tiles_measure, tiles_merge, tiles_spread, tiles_take_positions,
        tiles_write,
    };

    /// Runs one command line, whose first argument is the name of the program, and returns its exit code. Ctrl-C belongs to the
    /// command line from then on.
    #[pyfunction]
    fn main(py: Python, args: Vec<OsString>) -> u8 {
        py.detach(|| planish::status(args))
    }

    /// Returns all methods and their parameters as JSON.
    #[pyfunction]
    fn methods() -> String {
        planish::methods().to_string()
    }

    /// Returns the version of the package.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
