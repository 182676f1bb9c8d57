//! Reading files, with errors that name them.

use crate::failure::Failure;
use planish_geometry::obj::Obj;
use std::path::{Path, PathBuf};

/// All bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    if path.is_dir() {
        return Err(Failure::at(path, "is a directory, not a file"));
    }
    std::fs::read(path).map_err(|e| Failure::at(path, plain(&e)))
}

/// An OBJ file.
pub(crate) fn obj(path: &Path) -> Result<Obj, Failure> {
    Obj::parse(read(path)?).map_err(|e| Failure::at(path, e))
}

/// The words of an operating system error without its number.
pub(crate) fn plain(e: &std::io::Error) -> String {
    let text = e.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// A material library that a mesh names.
pub(crate) struct Library {
    /// As found, or as named where it is not there.
    pub(crate) path: PathBuf,
    /// None where it cannot be read.
    pub(crate) bytes: Option<Vec<u8>>,
}

/// The material libraries that a mesh names, looked for beside it.
pub(crate) fn libraries(mesh: &Path, obj: &Obj) -> Vec<Library> {
    let folder = mesh.parent().unwrap_or(Path::new(""));
    let mut found: Vec<Library> = Vec::new();
    let load = |name: &str| {
        let path = folder.join(name.replace('\\', "/"));
        let bytes = std::fs::read(&path).ok();
        Library { path, bytes }
    };
    for argument in &obj.extras().material_libraries {
        let argument = String::from_utf8_lossy(argument);
        // One name that may hold blanks, or several names.
        let whole = load(&argument);
        let libraries =
            if whole.bytes.is_some() { vec![whole] } else { argument.split_whitespace().map(load).collect() };
        for library in libraries {
            if found.iter().all(|known| known.path != library.path) {
                found.push(library);
            }
        }
    }
    found
}
