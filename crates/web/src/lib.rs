//! planish in a browser: reads, bakes and displaces meshes that the page has put into memory. All of it is what the command line
//! does, by the same functions, in the working folder `/` whose files the function `put` makes.
//!
//! Functions run to their end, so the page calls them in a worker. They tell progress to the function `planishProgress` of the
//! worker, and are cancelled by ending it. Errors are the lines that the command line prints.

#[cfg(target_family = "wasm")]
mod functions;
pub mod request;

#[cfg(target_family = "wasm")]
pub use functions::*;
