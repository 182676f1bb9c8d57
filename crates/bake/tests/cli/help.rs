//! Help, version and completions.

use crate::folder::Folder;

const COMMANDS: [(&str, &[&str]); 9] = [
    (
        "bake",
        &[
            "--output",
            "--method",
            "--preset",
            "--iterations",
            "--step",
            "--weights",
            "--boundary",
            "--fix",
            "--max-displacement",
            "--preserve-volume",
            "--weld",
            "--lambda",
            "--normals",
            "--size",
            "--interpolation",
            "--texels",
            "--bits",
            "--format",
            "--normal-convention",
        ],
    ),
    ("apply", &["--mesh", "--lambda", "--output"]),
    (
        "denoise",
        &[
            "--output",
            "--method",
            "--preset",
            "--iterations",
            "--step",
            "--weights",
            "--sigma-range",
            "--vertex-iterations",
            "--motion",
            "--boundary",
            "--fix",
            "--max-displacement",
            "--preserve-volume",
            "--weld",
            "--update-normals",
        ],
    ),
    ("compare", &["<CLEAN>", "<RESULT>...", "--csv", "--heatmap", "--heat", "--heat-max"]),
    ("bench-quality", &["<DIR>", "--methods", "--pairs", "--noise", "--per-mesh", "--max-faces", "--set", "--csv"]),
    (
        "noise",
        &[
            "--output",
            "--kind",
            "--sigma",
            "--share",
            "--correlation",
            "--towards",
            "--direction",
            "--impulsive",
            "--seed",
            "--weld",
        ],
    ),
    ("info", &["<MESH>", "--weld"]),
    ("methods", &["[METHOD]", "--markdown"]),
    ("completions", &["<SHELL>"]),
];

#[test]
fn the_help_of_each_command_has_its_options_and_an_example() {
    let folder = Folder::new();
    let overview = folder.succeeds("--help").out;
    for (command, options) in COMMANDS {
        assert!(overview.contains(&format!("\n  {command} ")), "{command} in {overview}");
        for flag in ["--help", "-h"] {
            let help = folder.succeeds(&format!("{command} {flag}")).out;
            for word in options.iter().chain(&["--json", "--quiet", "--verbose"]) {
                assert!(help.contains(word), "{command} {flag}: no {word}");
            }
            assert!(help.contains(&format!("Example:\n  planish {command} ")), "{command} {flag}: no example");
        }
    }
    assert!(overview.contains("Exit codes: 0 done, 1 failed, 2 bad input or usage."));
}

#[test]
fn the_examples_name_options_that_exist() {
    // An option that clap does not know is refused before any file is looked for.
    let folder = Folder::new();
    for (command, _) in COMMANDS.iter().filter(|c| !["methods", "completions"].contains(&c.0)) {
        let help = folder.succeeds(&format!("{command} --help")).out;
        let example = help.split("Example:\n  planish ").nth(1).unwrap().trim();
        folder.refuses(example, &["error: ", "o such file"]);
    }
}

#[test]
fn without_arguments_there_is_help_and_exit_code_2() {
    let folder = Folder::new();
    let err = folder.leaves_no_trace(&mut folder.planish(""), 2);
    assert!(err.contains("Usage: planish") && err.contains("Commands:") && err.contains("  bake "), "{err}");
}

#[test]
fn the_version_is_that_of_the_package() {
    let folder = Folder::new();
    let version = format!("planish {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(folder.succeeds("--version").out, version);
    assert_eq!(folder.succeeds("-V").out, version);
}

#[test]
fn completions_know_every_command() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.succeeds(&format!("completions {shell}")).out;
        for (command, options) in COMMANDS {
            let names = std::iter::once(&command).chain(options).filter(|name| !name.starts_with(['<', '[']));
            for name in names {
                // fish writes `-l json`, not `--json`.
                assert!(script.contains(name.trim_start_matches('-')), "{shell}: {name}");
            }
        }
    }
    folder.refuses_usage("completions tcsh", &["tcsh"]);
}
