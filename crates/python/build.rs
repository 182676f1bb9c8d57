//! Tells the linker that the symbols of Python come from the process that loads the library, where a system wants to be told.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
