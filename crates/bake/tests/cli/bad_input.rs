//! Errors: whatever is wrong with a mesh, a path or an option gives one clear line, exit code 2, and leaves no files behind.

use crate::folder::Folder;
use crate::mesh::{Mesh, TRIANGLE};

#[test]
fn a_bad_mesh_is_refused_with_the_file_and_the_line() {
    let with = |more: &str| format!("{TRIANGLE}{more}\n").into_bytes();
    let cases: Vec<(Vec<u8>, &[&str])> = vec![
        (Vec::new(), &["empty"]),
        (b"\x7fELF\x02\x01\0\0\0\0".to_vec(), &["binary"]),
        (b"BMF\x02\0\0\0".to_vec(), &["binary"]),
        (b"glTF\x02\0\0\0".to_vec(), &["no GLB file"]),
        (b"PK is no mesh\n".to_vec(), &["no vertices"]),
        (b"f 1 2 3\n".to_vec(), &["no vertices"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_vec(), &["no faces"]),
        (with("v nan 0 0\nf 1 2 4"), &["line 8", "`nan`", "not finite"]),
        (with("v 0 -inf 0\nf 1 2 4"), &["line 8", "`-inf`", "not finite"]),
        (with("v 0 0 1e999\nf 1 2 4"), &["line 8", "`1e999`", "not finite"]),
        (with("v 0 zero 0"), &["line 8", "`zero`", "not a number"]),
        (with("v 0 0,5 0"), &["line 8", "`0,5`", "not a number"]),
        (with("v 0 0"), &["line 8", "`v` needs 3 numbers, found 2"]),
        (with("vt"), &["line 8", "`vt` needs 1"]),
        (with("vn 0 1"), &["line 8", "`vn` needs 3 numbers, found 2"]),
        (with("f 1 2 4"), &["line 8", "index 4", "`v`", "there are 3"]),
        (with("f -1 -2 -4"), &["line 8", "index -4", "`v`"]),
        (with("f 0 1 2"), &["line 8", "index 0"]),
        (with("f 1 2 99999999999999999999"), &["line 8", "`99999999999999999999`"]),
        (with("f 1 2 x"), &["line 8", "`x`", "face corner"]),
        (with("f 1/1/1/1 2 3"), &["line 8", "`1/1/1/1`", "face corner"]),
        // The line that is shown is the one of the statement, also behind continuations and comments.
        (with("# a\\\nf 1 \\\n2 3\nv 1 2 x"), &["line 11", "`x`"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\n".to_vec(), &["no face has three different vertices"]),
    ];
    let commands = ["info bad.obj", "denoise bad.obj -o new/out.obj", "bake bad.obj -o new/folder", "bake bad.obj"];
    for (bytes, words) in cases {
        let folder = Folder::with("bad.obj", &bytes);
        for command in commands {
            folder.refuses(command, &[&["error: bad.obj: "], words].concat());
        }
    }
}

#[test]
fn every_command_names_the_mesh_it_cannot_read() {
    let folder = Folder::with("in.obj", TRIANGLE);
    folder.write("bad.obj", "v 0 0 0\nv 0 nan 0\nf 1 2 1\n");
    for line in ["noise bad.obj -o new/out.obj --sigma 0.1", "compare bad.obj in.obj", "compare in.obj in.obj bad.obj"]
    {
        folder.refuses(line, &["error: bad.obj: line 2: coordinate `nan`"]);
    }
    folder.write("other.obj", Mesh::grid(2).obj());
    folder.refuses("compare in.obj other.obj", &["error: other.obj: "]);
}

#[test]
fn a_layout_that_is_not_there_is_refused_and_the_way_out_named() {
    let folder = Folder::with("in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let words = ["in.obj: ", "no texture coordinates", "--layout vertex", "unwrap"];
    folder.refuses("bake in.obj -o out --layout uv", &words);
    folder.refuses("bake in.obj -o out --map vector --space tangent", &["in.obj: ", "--space object"]);
    let baked = folder.succeeds_with_json("bake in.obj -o out");
    assert_eq!(baked["manifest"]["displacement"]["layout"], "vertex");
    assert_eq!(baked["layout_reason"], "the mesh has no texture coordinates");
}

#[test]
fn what_a_surface_can_do_without_stops_nothing_and_is_told_with_its_line() {
    let folder = Folder::new();
    for (text, words) in [
        (format!("{TRIANGLE}vt nan 0\n"), ""),
        (TRIANGLE.replace("vt 1 0", "vt 1 nan"), "1 corner names a `vt` or `vn` that does not exist or is not finite"),
        (TRIANGLE.replace("3/3", "3/9"), "1 corner names a `vt` or `vn`"),
        (TRIANGLE.replace("3/3", "3/3/7"), "1 corner names a `vt` or `vn`"),
        (TRIANGLE.replace("3/3", "3/3/0"), "1 corner has an index 0 for `vt` or `vn`"),
        (format!("{TRIANGLE}f 1/1 2/2\n"), "1 `f` line has fewer than three corners"),
        (format!("{TRIANGLE}v -nan(ind) 0 0\n"), "1 `v` line that no face uses is not finite"),
    ] {
        folder.write("in.obj", &text);
        for command in ["bake in.obj -o out", "bake in.obj -o out --layout vertex", "denoise in.obj -o out.obj"] {
            let err = folder.succeeds(command).err;
            assert!(err.contains(words), "{command}: {err}");
        }
        folder.succeeds("check out/in.planish.json");
        let notes = folder.succeeds_with_json("info in.obj")["notes"].to_string();
        assert!(notes.contains(words) && (words.is_empty() || notes.contains("first in line")), "{notes}");
    }
}

#[test]
fn bake_with_the_normals_of_a_file_without_any_names_the_way_out() {
    let folder = Folder::with("in.obj", TRIANGLE);
    folder.refuses("bake in.obj -o out --normals file", &["in.obj: ", "no normals", "--normals angle"]);
}

#[test]
fn inputs_must_be_files() {
    let folder = Folder::with("in.obj", TRIANGLE);
    folder.write("folder/in.obj", TRIANGLE);
    for (input, word) in [("folder", "is a directory"), ("none.obj", "o such file"), ("in.obj/x.obj", "in.obj/x.obj: ")]
    {
        for line in [
            format!("info {input}"),
            format!("denoise {input} -o new/out.obj"),
            format!("bake {input} -o new"),
            format!("bake {input}"),
            format!("noise {input} -o new/out.obj --sigma 1"),
            format!("compare in.obj {input}"),
            format!("apply {input} -o new/out.obj"),
        ] {
            folder.refuses(&line, &[&format!("error: {input}: "), word]);
        }
    }
}

#[test]
fn outputs_must_have_a_place() {
    let folder = Folder::with("in.obj", TRIANGLE);
    folder.write("folder/x", "");
    for command in ["denoise in.obj", "noise in.obj --sigma 1"] {
        folder.refuses(&format!("{command} -o folder"), &["error: folder: ", "is a directory"]);
        folder.refuses(&format!("{command} -o in.obj/x.obj"), &["error: in.obj: ", "is a file"]);
        folder.refuses(&format!("{command} -o in.obj/new/x.obj"), &["error: in.obj/new: "]);
        folder.refuses(&format!("{command} -o ./folder/../in.obj"), &["in.obj: ", "is an input"]);
        folder.refuses(&format!("{command} -o new/.."), &["new/..: "]);
    }
    folder.refuses("bake in.obj -o in.obj", &["error: in.obj: ", "is a file"]);
    folder.refuses("bake in.obj -o in.obj/new", &["error: in.obj/new: "]);
    folder.write("out/in.planish.json/x", "");
    folder.refuses("bake in.obj -o out", &["out/in.planish.json: ", "is a directory"]);
}

#[test]
fn bad_options_name_themselves_and_what_they_take() {
    let folder = Folder::with("in.obj", Mesh::grid(2).obj());
    let bake: &[(&str, &str)] = &[
        ("--size 0", "1 to 16384"),
        ("--size 1000000", "1 to 16384"),
        ("--size -3", "1 to 16384"),
        ("--size foo", "1 to 16384"),
        ("--size 1.5", "1 to 16384"),
        ("--bits 12", "8, 16 or 32"),
        ("--bits x", "8, 16 or 32"),
        ("--lambda nan", "number"),
        ("--lambda 1e7", "number"),
        ("--lambda=-inf", "number"),
        ("--format jpg", "jpg"),
        ("--interpolation cubic", "cubic"),
        ("--texels blurred", "blurred"),
        ("--layout round", "round"),
        ("--map bump", "bump"),
        ("--map vector --space world", "world"),
        ("--tolerance 0.5", "0.625"),
        ("--max-size 0", "from 1 to"),
        ("--max-size auto", "from 1 to"),
        ("--normals best", "best"),
        ("--normal-convention vulkan", "vulkan"),
    ];
    let method: &[(&str, &str)] = &[
        ("--method magic", "magic"),
        ("--step 2", "between 0 and 1"),
        ("--step -0.1", "between 0 and 1"),
        ("--step nan", "between 0 and 1"),
        ("--iterations -1", "a whole number between 0 and 100000"),
        ("--iterations 1000000", "a whole number between 0 and 100000"),
        ("--iterations 1.5", "1.5"),
        ("--weights heavy", "heavy"),
        ("--boundary open", "open"),
        ("--preset best", "best"),
        ("--method sun --threshold 2", "between 0 and 1"),
        ("--method implicit --time -1", "between 0 and"),
        ("--method guided-normals --sigma-range 0", "between 0.000001 and"),
        ("--method bilateral-normals --smoothness 0", "between 0.000001 and 1"),
        ("--method sun --motion sideways", "sideways"),
        ("--noise -1", "between 0 and"),
        ("--candidates flat,round", "round"),
        ("--noise-kind loud", "loud"),
        ("--method map --prior square", "square"),
        ("--weld -1", "greater than 0"),
        ("--weld 0", "greater than 0"),
        ("--weld inf", "greater than 0"),
        ("--weld some", "greater than 0"),
    ];
    let noise: &[(&str, &str)] = &[
        ("--sigma -1", "between 0 and"),
        ("--sigma nan", "between 0 and"),
        ("--sigma 1 --impulsive 2", "between 0 and 1"),
        ("--sigma 1 --seed -1", "-1"),
        ("--sigma 1 --direction up", "up"),
    ];
    let commands = [
        ("bake in.obj -o new", [bake, method].concat()),
        ("denoise in.obj -o new/out.obj", method.to_vec()),
        ("noise in.obj -o new/out.obj", noise.to_vec()),
    ];
    for (command, options) in commands {
        for (option, word) in options {
            let name = option.split([' ', '=']).rev().find(|w| w.starts_with("--")).unwrap();
            folder.refuses_usage(&format!("{command} {option}"), &[name, word]);
        }
    }
}

#[test]
fn options_that_contradict_each_other_or_the_mesh_are_refused() {
    let folder = Folder::with("in.obj", Mesh::grid(2).obj());
    folder.refuses("bake in.obj -o new --format png --bits 32", &["PNG", "--bits 8 or 16", "--format tiff or exr"]);
    folder.refuses("bake in.obj -o new --format exr --bits 8", &["EXR", "--bits 16 or 32", "--format png"]);
    folder.refuses("bake in.obj -o new --layout vertex --size 64", &["--size", "--layout vertex"]);
    folder.refuses("bake in.obj -o new --space tangent", &["--space", "--map vector"]);
    for command in ["bake in.obj -o new", "denoise in.obj -o new/out.obj", "info in.obj"] {
        folder.refuses(&format!("{command} --weld 1e9"), &["in.obj: ", "--weld 1000000000", "at most 1.414e-2"]);
    }
    folder.refuses_usage("info in.obj --quiet --json", &["--quiet", "--json"]);
    folder.refuses_usage("info in.obj --quiet --verbose", &["--quiet", "--verbose"]);
}

#[test]
fn missing_arguments_are_named() {
    let folder = Folder::with("in.obj", TRIANGLE);
    for (line, missing) in [
        ("bake", "<MESH>"),
        ("denoise in.obj", "--output <OUT|->"),
        ("apply", "<MAP.planish.json>"),
        ("compare in.obj", "<RESULT>"),
        ("noise in.obj -o out.obj", "--sigma <S>"),
        ("completions", "<SHELL>"),
    ] {
        let err = folder.leaves_no_trace(&mut folder.planish(line), 2);
        assert!(err.starts_with("error: ") && err.contains(missing), "{line}: {err}");
    }
    folder.refuses_usage("polish in.obj", &["polish"]);
    folder.refuses_usage("info in.obj --fast", &["--fast"]);
}
