//! Compares two OBJ texts that join the same vertices: angles between their normals and distances between their surfaces.
//!
//! `cargo run --release --example compare_meshes`
#![allow(clippy::print_stdout)]

use planish_geometry::metrics::{self, Triangles};
use planish_geometry::source::obj::Obj;

/// A tent over a square.
const CLEAN: &str = "\
v 0 0 0
v 2 0 0
v 2 2 0
v 0 2 0
v 1 1 1
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
f 4 3 2 1
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let flattened = CLEAN.replace("v 1 1 1", "v 1 1 0.8");
    let clean = Triangles::from(Obj::parse(CLEAN.into())?.data());
    let result = Triangles::from(Obj::parse(flattened.into())?.data());
    let errors = metrics::compare(&clean, &result)?;
    println!("{} vertices, {} triangles", errors.vertices, errors.faces);
    println!("angle between normals: mean {:.2}°, 95th percentile {:.2}°", errors.ea, errors.ea_p95);
    println!("distance to the clean surface: mean {:.4}, largest {:.4} edges", errors.d_mean, errors.d_max);
    if let Some(percentage) = errors.vol_change_pct {
        println!("volume: {percentage:+.1} %");
    }
    Ok(())
}
