//! Prints everything `planish-geometry` computes about a mesh as JSON, for the cross-checks in `tests/python`.
//! Welding is off, so indices are those of the file.
#![allow(clippy::print_stdout, reason = "printing is all it does")]

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("usage: quantities MESH.obj")?;
    println!("{}", planish_tests::quantities::of(std::fs::read(path)?)?);
    Ok(())
}
