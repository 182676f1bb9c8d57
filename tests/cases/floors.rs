//! Imports go down: a module of geometry stands on modules below it alone, and so does a crate; no file imports another one that
//! imports it, but for a file and those in the folder of its name.

use crate::support::root;
use std::collections::{BTreeMap, BTreeSet};
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

/// A file of a crate as the names of its module, from the root of the crate.
type Module = Vec<String>;

/// Splits `a::{b, c::d as e}` into paths: a::b and a::c::d. Each has the name by which it is known in the end.
fn paths(tree: &str) -> Vec<(Module, String)> {
    let tree = tree.trim();
    if let Some((before, inside)) = tree.split_once('{') {
        let prefix: Module = before.split("::").map(|name| name.trim().to_owned()).filter(|n| !n.is_empty()).collect();
        let inside = inside.trim_end().trim_end_matches('}');
        let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
        for (at, c) in inside.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    parts.push(&inside[start..at]);
                    start = at + 1;
                }
                _ => {}
            }
        }
        parts.push(&inside[start..]);
        let parts = parts.into_iter().filter(|part| !part.trim().is_empty());
        let joined = |(path, name): (Module, String)| (prefix.iter().cloned().chain(path).collect(), name);
        return parts.flat_map(paths).map(joined).collect();
    }
    let (path, renamed) = tree.split_once(" as ").map_or((tree, None), |(path, name)| (path, Some(name)));
    let path: Module = path.split("::").map(|name| name.trim().to_owned()).collect();
    let name = renamed.map_or_else(|| path.last().unwrap().clone(), |name| name.trim().to_owned());
    vec![(path, name)]
}

/// Imports of a source that are not those of its tests: the path, the name, and whether others may take it from here.
fn imports(source: &str) -> Vec<(Module, String, bool)> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code: String = lines.map(|line| format!("{line}\n")).collect();
    let mut found = Vec::new();
    let statements = code.split(';').filter_map(|statement| {
        let at = statement.rfind("use ").filter(|at| *at == 0 || statement[..*at].ends_with(['\n', ' ']))?;
        Some((&statement[..at], &statement[at + 4..]))
    });
    for (before, tree) in statements.filter(|(_, tree)| !tree.contains(['(', '=', '"'])) {
        let is_public = before.split('\n').next_back().is_some_and(|line| line.trim_start().starts_with("pub"));
        found.extend(paths(tree).into_iter().map(|(path, name)| (path, name, is_public)));
    }
    // Paths that are written out where they are used.
    for rest in code.split("crate::").skip(1) {
        let end = rest.find(|c: char| !c.is_alphanumeric() && !"_:".contains(c)).unwrap_or(rest.len());
        let path: Module = std::iter::once("crate")
            .chain(rest[..end].split("::"))
            .map(str::to_owned)
            .filter(|n| !n.is_empty())
            .collect();
        found.push((path, String::new(), false));
    }
    found
}

/// The files of a crate and what they import.
struct Imports(BTreeMap<Module, Vec<(Module, String, bool)>>);

impl Imports {
    fn of(src: &Path) -> Self {
        let files = sources(src).into_iter().filter_map(|file| {
            let inside = file.strip_prefix(src).unwrap().with_extension("");
            let names: Module = inside.components().map(|part| part.as_os_str().to_str().unwrap().to_owned()).collect();
            let module = if names == ["lib"] { Vec::new() } else { names };
            (!module.iter().any(|name| name == "tests")).then(|| (module, imports(&fs::read_to_string(&file).unwrap())))
        });
        Self(files.collect())
    }

    /// The file that a path from within a module leads to, whatever files pass it on; `None` outside of the crate.
    fn resolved(&self, from: &[String], path: &[String], depth: usize) -> Option<Module> {
        let mut at = from.to_vec();
        let mut rest = path;
        match path[0].as_str() {
            "crate" => (at, rest) = (Vec::new(), &path[1..]),
            "self" | "super" => {
                while let Some(name) = rest.first().filter(|name| *name == "self" || *name == "super") {
                    if name == "super" {
                        at.pop();
                    }
                    rest = &rest[1..];
                }
            }
            name => {
                at.push(name.to_owned());
                if !self.0.contains_key(&at) {
                    return None;
                }
                rest = &path[1..];
            }
        }
        while let Some(name) = rest.first() {
            at.push(name.clone());
            if !self.0.contains_key(&at) {
                at.pop();
                break;
            }
            rest = &rest[1..];
        }
        let passed_on =
            |name: &String| self.0.get(&at)?.iter().find(|(_, known, is_public)| *is_public && known == name);
        match rest.first().and_then(passed_on) {
            Some((path, _, _)) if depth < 8 => self.resolved(&at, path, depth + 1).or(Some(at)),
            _ => Some(at),
        }
    }

    /// Files that each file imports, without those in the folder of its name and those in whose folder it is.
    fn arrows(&self) -> BTreeMap<&Module, BTreeSet<Module>> {
        let of_file = |(module, imports): (&Module, &Vec<(Module, String, bool)>)| {
            let targets = imports.iter().filter_map(|(path, _, _)| self.resolved(module, path, 0));
            targets.filter(|target| !target.starts_with(module) && !module.starts_with(target)).collect()
        };
        self.0.iter().map(|entry| (entry.0, of_file(entry))).collect()
    }
}

/// A circle of files that import each other, if there is one.
fn circle(arrows: &BTreeMap<&Module, BTreeSet<Module>>) -> Option<Vec<String>> {
    // Files that import only files which are done are done, until none is left, or none but those of circles and above.
    let mut left: BTreeSet<&Module> = arrows.keys().copied().collect();
    loop {
        let waits = |module: &&Module| arrows[*module].iter().any(|target| left.contains(target));
        let next: BTreeSet<&Module> = left.iter().copied().filter(waits).collect();
        if next.len() == left.len() {
            break;
        }
        left = next;
    }
    (!left.is_empty()).then(|| left.iter().map(|module| module.join("::")).collect())
}

#[test]
fn no_file_imports_itself_through_others() {
    let mut count = 0;
    for (folder, _) in PACKAGES {
        let imports = Imports::of(&root().join(folder).join("src"));
        let arrows = imports.arrows();
        count += arrows.values().map(BTreeSet::len).sum::<usize>();
        assert_eq!(circle(&arrows), None, "{folder}: these files import each other, or files that do");
    }
    assert!(count > 800, "only {count} imports were found");
}

#[test]
fn a_circle_of_files_is_found_even_through_a_file_that_passes_a_name_on() {
    let name = |path: &str| path.split("::").map(str::to_owned).collect::<Module>();
    let file = |path: &str, source: &str| (name(path), imports(source));
    let files = [
        file("a", "mod b;\nmod c;\npub use b::{self, Thing};\nuse c::Other;\n"),
        file("a::b", "use super::c::Other;\npub struct Thing(Other);\n"),
        file("a::c", "use crate::a::Thing;\npub struct Other(Box<Thing>);\n"),
        file("d", "use crate::a;\n"),
    ];
    let imports = Imports(files.into_iter().collect());
    assert_eq!(circle(&imports.arrows()), Some(vec!["a::b".to_owned(), "a::c".to_owned()]));
    let straight = [
        file("a", "mod b;\npub use b::Thing;\n"),
        file("a::b", "pub struct Thing;\n"),
        file("c", "use crate::a::Thing;"),
    ];
    assert_eq!(circle(&Imports(straight.into_iter().collect()).arrows()), None);
}
