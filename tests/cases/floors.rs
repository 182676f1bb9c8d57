//! Imports go down: a module of geometry stands on modules below it alone, and so does a crate.

use crate::support::root;
use std::fs;
use std::path::{Path, PathBuf};

/// Modules of geometry and what each may import, from the lowest floor to the highest.
const MODULES: [(&str, &[&str]); 6] = [
    ("mesh", &[]),
    ("source", &["mesh"]),
    ("denoise", &["mesh", "source"]),
    ("metrics", &["mesh", "source"]),
    ("map", &["mesh", "source", "denoise"]),
    ("bake", &["mesh", "source", "denoise", "metrics", "map"]),
];

/// Packages of the workspace and which others each may depend on outside of its tests.
const PACKAGES: [(&str, &[&str]); 9] = [
    ("crates/memory", &[]),
    ("shaders", &[]),
    ("crates/geometry", &[]),
    ("crates/render", &["planish-geometry", "planish-shaders"]),
    ("crates/files", &["planish-geometry", "planish-memory"]),
    ("crates/bake", &["planish-geometry", "planish-files", "planish-memory"]),
    ("crates/python", &["planish", "planish-geometry", "planish-files", "planish-memory"]),
    ("crates/web", &["planish-geometry", "planish-files"]),
    ("crates/viewer", &["planish-geometry", "planish-files", "planish-memory", "planish-render", "planish-shaders"]),
];

/// Files of Rust in a folder and below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect()
}

/// Modules of the crate that a source names, whether in an import or within a path; tests at its end do not count.
fn named_modules(source: &str) -> impl Iterator<Item = &str> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.flat_map(|line| line.split("crate::").skip(1)).map(|rest| {
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        &rest[..end]
    })
}

#[test]
fn modules_of_geometry_import_modules_below_them_alone() {
    let src = root().join("crates/geometry/src");
    let mut count = 0;
    for (module, below) in MODULES {
        let mut files = sources(&src.join(module));
        files.push(src.join(format!("{module}.rs")));
        let is_test = |file: &Path| {
            let inside = file.strip_prefix(&src).unwrap();
            inside.ends_with("tests.rs") || inside.components().any(|part| part.as_os_str() == "tests")
        };
        files.retain(|file| !is_test(file));
        for file in files {
            let source = fs::read_to_string(&file).unwrap();
            for named in named_modules(&source).filter(|named| MODULES.iter().any(|(other, _)| other == named)) {
                let may = named == module || below.contains(&named);
                assert!(may, "{}: {module} must not import {named}", file.display());
                count += usize::from(named != module);
            }
        }
    }
    assert!(count > 100, "only {count} imports were found");
}

#[test]
fn packages_depend_on_packages_below_them_alone() {
    for (folder, below) in PACKAGES {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
        let product = manifest.split("[dev-dependencies]").next().unwrap();
        let dependencies = product.split("[dependencies]").nth(1).unwrap_or_default();
        let ours = dependencies.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
        for name in ours.filter(|name| name.starts_with("planish")) {
            assert!(below.contains(&name), "{folder} must not depend on {name}");
        }
    }
}
