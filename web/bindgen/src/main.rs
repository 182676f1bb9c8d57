//! Called with a WebAssembly library and a folder, writes `planish_web.js` and `planish_web_bg.wasm` into the folder, for modules of
//! browsers.

use anyhow::{Context as _, Result};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1);
    let library = arguments.next().context("the library is missing")?;
    let folder = arguments.next().context("the folder is missing")?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(library).web(true)?.typescript(false).remove_name_section(true).remove_producers_section(true);
    bindgen.generate(folder)
}
