//! Every public module shows its main job in an example that is compiled and run with the documentation.

use crate::support::root;
use std::fs;
use std::path::{Path, PathBuf};

/// Crates with documentation for programmers, as the files of their roots.
const CRATES: [&str; 4] =
    ["crates/geometry/src/lib.rs", "crates/files/src/lib.rs", "crates/render/src/lib.rs", "shaders/lib.rs"];

/// Public modules whose example is compiled and not run, each with the reason.
const NOT_RUN: [(&str, &str); 3] = [
    ("crates/render/src/gpu.rs", "it opens a GPU"),
    ("crates/render/src/gpu/painter.rs", "it opens a GPU"),
    ("crates/render/src/gpu/renderer.rs", "it opens a GPU"),
];

/// Appends the file of a module and those of the public modules in it.
fn public_modules(file: PathBuf, modules: &mut Vec<PathBuf>) {
    let source = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let folder = if file.ends_with("lib.rs") { file.parent().unwrap().to_owned() } else { file.with_extension("") };
    let names = source.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    modules.push(file);
    names.for_each(|name| public_modules(folder.join(format!("{name}.rs")), modules));
}

/// Returns true if the documentation in a source has an example whose first line has this word; an example without any is run.
fn has_example(file: &Path, word: &str) -> bool {
    let source = fs::read_to_string(file).unwrap();
    let comments =
        source.lines().map(str::trim_start).filter_map(|l| l.strip_prefix("//! ").or(l.strip_prefix("/// ")));
    // Each second one ends an example.
    comments.filter_map(|comment| comment.strip_prefix("```")).step_by(2).any(|first| first == word)
}

#[test]
fn every_public_module_has_an_example() {
    let mut modules = Vec::new();
    CRATES.iter().for_each(|file| public_modules(root().join(file), &mut modules));
    assert!(modules.len() > 90, "only {} public modules were found", modules.len());
    for file in modules {
        let name = file.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
        let excuse = NOT_RUN.iter().find(|(listed, _)| *listed == name);
        match (has_example(&file, ""), excuse) {
            (false, None) => panic!("{name} has no example: show the main job of the module in its first comment"),
            (false, Some(_)) => assert!(has_example(&file, "no_run"), "{name} has no example that is compiled"),
            (true, Some((_, reason))) => {
                panic!("{name} has an example that is run, and is listed as not run: {reason}")
            }
            (true, None) => {}
        }
    }
    for (listed, _) in NOT_RUN {
        assert!(root().join(listed).is_file(), "{listed} is listed, and is not there");
    }
}
