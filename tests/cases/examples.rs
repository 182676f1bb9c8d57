//! Every public module shows its main job in an example that is compiled and run with the documentation.

use crate::support::root;
use std::fs;
use std::path::{Path, PathBuf};

/// Crates with documentation for programmers, and the files of their roots.
const CRATES: [&str; 2] = ["crates/geometry/src/lib.rs", "shaders/lib.rs"];

/// Public modules without an example, each with the reason.
const WITHOUT: [(&str, &str); 0] = [];

/// Appends the file of a module and those of the public modules in it.
fn public_modules(file: PathBuf, modules: &mut Vec<PathBuf>) {
    let source = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let folder = if file.ends_with("lib.rs") { file.parent().unwrap().to_owned() } else { file.with_extension("") };
    let names = source.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    modules.push(file);
    names.for_each(|name| public_modules(folder.join(format!("{name}.rs")), modules));
}

/// Returns true if the documentation in a source has an example that is run: one whose first line has no words such as `no_run`.
fn has_example(file: &Path) -> bool {
    let source = fs::read_to_string(file).unwrap();
    let comments =
        source.lines().map(str::trim_start).filter_map(|l| l.strip_prefix("//! ").or(l.strip_prefix("/// ")));
    // Each second one ends an example.
    comments.filter_map(|comment| comment.strip_prefix("```")).step_by(2).any(str::is_empty)
}

#[test]
fn every_public_module_has_an_example() {
    let mut modules = Vec::new();
    CRATES.iter().for_each(|file| public_modules(root().join(file), &mut modules));
    assert!(modules.len() > 40, "only {} public modules were found", modules.len());
    for file in modules {
        let name = file.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
        let excuse = WITHOUT.iter().find(|(without, _)| *without == name);
        match (has_example(&file), excuse) {
            (false, None) => panic!("{name} has no example: show the main job of the module in its first comment"),
            (true, Some((_, reason))) => panic!("{name} has an example, and is listed as without: {reason}"),
            _ => {}
        }
    }
    for (without, _) in WITHOUT {
        assert!(root().join(without).is_file(), "{without} is listed, and is not there");
    }
}
