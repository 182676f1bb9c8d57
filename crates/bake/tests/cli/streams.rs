//! Standard output and standard error.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;

/// A folder in which every command of [`COMMANDS`] succeeds, and would have a warning to give where it can.
fn prepared() -> Folder {
    let mesh = Mesh::grid(6).noisy(0.02);
    let folder = Folder::with("clean.obj", Mesh::grid(6).obj());
    // Normals make `denoise` warn, a missing library makes `bake` warn.
    folder.write("in.obj", format!("mtllib none.mtl\n{}vn 0 0 1\n", mesh.obj()));
    folder.succeeds("bake in.obj --method laplacian -o baked");
    folder
}

/// Each with a field of its JSON and a word of its text.
const COMMANDS: [(&str, &str, &str); 6] = [
    ("bake in.obj --method laplacian -o out", "/manifest/report/max_error", "\nerror "),
    ("apply baked/in.planish.json -o out/applied.obj", "/max_displacement", "wrote out/applied.obj\n"),
    ("denoise in.obj --method laplacian -o out/denoised.obj", "/mean_displacement", "wrote out/denoised.obj\n"),
    ("compare clean.obj in.obj clean.obj", "/results/1/Ea_deg", "Ea"),
    ("noise clean.obj -o out/noisy.obj --sigma 0.3", "/rms_displacement", "wrote out/noisy.obj\n"),
    ("info in.obj", "/defects/boundary_edges", "surface"),
];

#[test]
fn json_is_one_value_and_nothing_else() {
    let folder = prepared();
    for (line, field, _) in COMMANDS {
        let value = folder.succeeds_with_json(line);
        assert!(value.pointer(field).is_some_and(Value::is_number), "{line}: {field} in {value}");
        assert!(value.pointer("/seconds").is_none(), "{line}");
        // The option may come first as well.
        let first: Value = serde_json::from_str(&folder.succeeds(&format!("--json {line}")).out).unwrap();
        assert_eq!(first, value, "{line}");
        let printed = folder.planish(&format!("{line} --json --step nonsense --weld nonsense")).output().unwrap();
        assert!(printed.stdout.is_empty() && !printed.stderr.is_empty(), "{line}: complaints are no JSON");
    }
}

#[test]
fn the_text_is_for_people() {
    let folder = prepared();
    for (line, _, word) in COMMANDS {
        let printed = folder.succeeds(line);
        assert!(printed.out.contains(word), "{line}: {}", printed.out);
        assert!(printed.out.ends_with('\n') && !printed.out.contains("NaN"), "{line}: {}", printed.out);
        assert!(!printed.out.contains("  total "), "{line}");
    }
}

#[test]
fn quiet_is_silent() {
    let folder = prepared();
    for (line, ..) in COMMANDS {
        for flag in ["--quiet", "-q"] {
            let printed = folder.succeeds(&format!("{line} {flag}"));
            assert_eq!((printed.out.as_str(), printed.err.as_str()), ("", ""), "{line}");
        }
    }
    folder.refuses("info none.obj --quiet", &["none.obj"]);
}

#[test]
fn verbose_adds_the_stages() {
    let folder = prepared();
    for (line, ..) in COMMANDS {
        let text = folder.succeeds(&format!("{line} --verbose")).out;
        assert!(text.contains("\n  reading ") && text.contains("\n  total ") && text.ends_with(" 100.0 %\n"), "{text}");
        let seconds = &folder.succeeds_with_json(&format!("{line} -v"))["seconds"];
        let stages: Vec<f64> = seconds.as_object().unwrap().values().map(|s| s.as_f64().unwrap()).collect();
        let (total, stages) = stages.split_last().unwrap();
        // Stages follow each other without gaps; before the first one only arguments are read.
        assert!(stages.iter().all(|s| *s >= 0.0) && stages.iter().sum::<f64>() <= *total, "{line}: {seconds}");
        assert!(seconds["reading"].is_number(), "{line}: {seconds}");
    }
}

#[test]
fn without_a_terminal_there_is_no_progress_bar_and_no_colour() {
    let folder = prepared();
    for (line, ..) in COMMANDS {
        let printed = folder.succeeds(line);
        assert!(!(printed.out + &printed.err).contains(['\r', '\x1b']), "{line}");
        let expected = |err: &&str| err.starts_with("warning: ");
        assert_eq!(printed.err.lines().filter(|l| !expected(l)).count(), 0, "{line}: {}", printed.err);
    }
    let printed = folder.planish("info none.obj --bad").output().unwrap();
    assert!(!printed.stderr.contains(&b'\x1b'));
}

#[test]
fn warnings_say_what_the_result_lacks() {
    let folder = prepared();
    let warns = |line: &str, words: &[&str]| {
        let err = folder.succeeds(line).err;
        let fits = |warning: &str| warning.starts_with("warning: ") && words.iter().all(|word| warning.contains(word));
        assert_eq!(err.lines().filter(|warning| fits(warning)).count(), 1, "{line}: {err}");
    };
    warns("bake in.obj --method laplacian -o out", &["none.mtl", "materials"]);
    warns("denoise in.obj --method laplacian -o out.obj", &["`vn`", "--update-normals"]);
    warns("denoise clean.obj --method laplacian -o out.obj --update-normals", &["clean.obj", "no `vn` lines"]);
    warns(
        "bake in.obj --method laplacian -o out --layout uv --size 4",
        &["vertices", "off by more than", "larger size"],
    );
    warns("bake in.obj --method laplacian -o out --size 4", &["one texel for each vertex", "share texels even at 4"]);

    let mesh = Mesh::grid(6);
    let [mut overlapping, mut outside, mut unmapped] = [0, 1, 2].map(|_| mesh.clone());
    overlapping.uvs.iter_mut().for_each(|uv| uv[0] = (uv[0] - 0.5).abs());
    outside.uvs.iter_mut().for_each(|uv| uv[0] += 0.5);
    unmapped.positions.extend([[9.0, 0.0, 0.0], [9.0, 1.0, 0.0], [9.0, 0.0, 1.0]]);
    folder.write("overlapping.obj", overlapping.obj());
    folder.write("folded.obj", overlapping.noisy(0.02).obj());
    folder.write("outside.obj", outside.obj());
    folder.write("unmapped.obj", unmapped.obj() + "f -1 -2 -3\n");
    warns("bake overlapping.obj --method laplacian -o out --layout uv --size 256", &["charts overlap"]);
    warns("bake outside.obj --method laplacian -o out --layout uv --size 256", &["21 vertices are outside [0, 1]"]);
    warns(
        "bake folded.obj --method laplacian -o out",
        &["private texels for ", "charts overlap", "knows only the mesh's own UVs puts "],
    );
    warns(
        "bake unmapped.obj --method laplacian -o out --layout uv --size 256",
        &["3 vertices are without texture coordinates"],
    );
    warns("bake unmapped.obj --method laplacian -o out --size 256", &["private texels for 3 vertices", "have no UVs"]);
}
