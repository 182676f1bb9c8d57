//! Tests that need signals, resource limits or a shell.

use crate::folder::{Folder, Printed};
use crate::mesh::Mesh;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The binary with a line of arguments, started by a shell that does something first.
fn through_shell(folder: &Folder, prelude: &str, line: &str) -> Command {
    let planish = folder.planish(line);
    let mut shell = Command::new("sh");
    shell.current_dir(planish.get_current_dir().unwrap());
    shell.args(["-c", &format!("{prelude}; exec \"$0\" \"$@\"")]).arg(planish.get_program()).args(planish.get_args());
    shell
}

#[test]
fn a_disk_that_fills_up_leaves_nothing_behind() {
    let folder = Folder::with("in.obj", Mesh::grid(20).noisy(0.01).obj());
    folder.succeeds("bake in.obj -o baked");
    // Files of one block at most: writing fails part of the way, as on a full disk.
    let full = "trap '' XFSZ; ulimit -f 1";
    for (line, file) in [
        ("bake in.obj -o new/folder", "new/folder/in."),
        ("bake in.obj -o baked", "baked/in."),
        ("denoise in.obj -o new/out.obj", "new/out.obj"),
        ("denoise in.obj -o baked/in.obj", "baked/in.obj"),
        ("noise in.obj -o out.obj --sigma 0.1", "out.obj"),
        ("apply baked/in.planish.json -o out.obj", "out.obj"),
    ] {
        let err = folder.leaves_no_trace(&mut through_shell(&folder, full, line), 1);
        let clear = err.starts_with(&format!("error: {file}")) && err.contains("cannot be written: File too large");
        assert!(clear && err.lines().count() == 1, "{line}: {err}");
    }
}

#[test]
fn a_folder_without_permission_is_refused_before_any_work() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = Folder::with("in.obj", Mesh::grid(2).obj());
    folder.write("locked/x", "");
    let set = |mode| std::fs::set_permissions(folder.path("locked"), std::fs::Permissions::from_mode(mode)).unwrap();
    set(0o555);
    let root = std::fs::write(folder.path("locked/y"), "").is_ok();
    if !root {
        folder.refuses("denoise in.obj -o locked/out.obj", &["locked: cannot be written to"]);
        folder.refuses("bake in.obj -o locked", &["locked: cannot be written to"]);
        folder.refuses("bake in.obj -o locked/new", &["locked/new: cannot be created"]);
    }
    set(0o755);
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let folder = Folder::with("in.obj", Mesh::grid(20).obj());
    for line in ["info in.obj", "info in.obj --json", "bake in.obj -o out --json -v", "completions bash", "--help", ""]
    {
        // A pipe whose reader has closed it before anything is written.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let child = folder.planish(line).stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
        let printed = Printed::from(child.wait_with_output().unwrap());
        assert_eq!(printed.code, Some(if line.is_empty() { 2 } else { 0 }), "{line}: {}", printed.err);
        assert!(!printed.err.contains("panicked"), "{line}: {}", printed.err);
    }
}

#[test]
fn results_can_go_to_a_pipe() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    folder.succeeds("denoise in.obj -o out.obj");
    let printed = folder.succeeds("denoise in.obj -o /dev/stdout --quiet");
    assert!(printed.out == folder.text("out.obj"));
}

#[test]
fn names_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = Folder::with("in.obj", Mesh::grid(2).obj());
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.obj");
    let status = folder.planish("denoise in.obj --quiet -o").arg(name).status().unwrap();
    assert!(status.success());
    assert!(folder.path(".").join(name).is_file());
}

/// Runs until the output folder is there, which is after the mesh was read, and `delay` longer; then interrupts.
fn interrupted(folder: &Folder, line: &str, delay: Duration) -> Printed {
    let child = folder.planish(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while !folder.path("out").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "the output folder does not appear");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(delay);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    Printed::from(child.wait_with_output().unwrap())
}

#[test]
fn an_interrupt_stops_the_work_and_leaves_nothing_behind() {
    let folder = Folder::with("in.obj", Mesh::grid(300).noisy(0.001).obj());
    // Hours of denoising; and seconds of images, of which the delay lands somewhere in the middle.
    for (work, delay) in [("--method laplacian --iterations 100000", 0), ("--size 4096 --interpolation natural", 300)] {
        let line = format!("bake in.obj -o out/deep {work}");
        let Printed { code, out, err } = interrupted(&folder, &line, Duration::from_millis(delay));
        assert_eq!((code, out.as_str()), (Some(1), ""), "{work}: {err}");
        assert_eq!(err, "error: interrupted; nothing was written\n", "{work}");
        assert_eq!(folder.names("."), ["in.obj"], "{work}");
    }
}

#[test]
fn an_interrupted_bench_writes_no_file() {
    let mesh = Mesh::grid(300);
    let folder = Folder::with("pairs/a_clean.obj", mesh.obj());
    folder.write("pairs/a_noisy.obj", mesh.noisy(0.001).obj());
    for (mode, head) in [("", "  method "), ("--noise white", "  mesh ")] {
        // Hours of denoising.
        let work = "--methods laplacian --set iterations=100000 --csv out/deep/q.csv";
        let Printed { code, out, err } =
            interrupted(&folder, &format!("bench-quality pairs {mode} {work}"), Duration::ZERO);
        assert_eq!((code, err.as_str()), (Some(1), "error: interrupted; nothing was written\n"));
        // The table of what was measured before, which is nothing.
        let is_empty = !out.contains("\n  laplacian ") && !out.contains("\n  a_clean ");
        assert!(out.starts_with(head) && is_empty, "{out}");
        assert_eq!(folder.names("."), ["pairs"]);
    }
}

#[test]
fn a_result_goes_where_a_shell_has_opened_a_file() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    folder.succeeds("denoise in.obj --method laplacian -o out.obj");
    let whole = folder.text("out.obj");
    let shell = |script: &str| {
        let mut shell = Command::new("bash");
        let line = "denoise in.obj --method laplacian -q -o";
        shell.current_dir(folder.path(".")).env("PLANISH", folder.planish(line).get_program());
        let output = shell.args(["-c", &script.replace("DENOISE", &format!("\"$PLANISH\" {line}"))]).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && err.is_empty(), "{script}: {err}");
    };
    for (script, head) in [
        ("DENOISE /dev/stdout > a.obj", ""),
        ("DENOISE - > a.obj", ""),
        ("DENOISE /proc/self/fd/1 > a.obj", ""),
        ("echo head > a.obj; DENOISE /dev/stdout >> a.obj", "head\n"),
        ("(echo head; DENOISE -) > a.obj", "head\n"),
        ("DENOISE /dev/fd/7 7> a.obj", ""),
        ("echo head > a.obj; DENOISE /dev/fd/7 7>> a.obj", "head\n"),
        // Bash waits for a process substitution only where it is named.
        ("DENOISE >(cat > a.obj); wait $!", ""),
        ("DENOISE - | cat > a.obj", ""),
        ("mkfifo pipe; cat pipe > a.obj & DENOISE pipe; wait", ""),
    ] {
        shell(script);
        assert!(folder.text("a.obj") == format!("{head}{whole}"), "{script}");
        std::fs::remove_file(folder.path("a.obj")).unwrap();
    }
    assert!(std::fs::symlink_metadata("/dev/stdout").unwrap().is_symlink());
}

#[test]
fn a_result_that_cannot_be_printed_is_a_failure() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for line in [
        "info in.obj --json",
        "info in.obj",
        "bake in.obj --method laplacian -o out --json",
        "compare in.obj in.obj --csv -",
        "denoise in.obj --method laplacian -o -",
        "methods",
        "completions bash",
        "--help",
        "--version",
    ] {
        let child = folder.planish(line).stdout(full()).stderr(Stdio::piped()).spawn().unwrap();
        let printed = Printed::from(child.wait_with_output().unwrap());
        assert_eq!(printed.code, Some(1), "{line}");
        assert_eq!(
            printed.err.lines().last(),
            Some("error: standard output cannot be written: No space left on device")
        );
    }
    let err = folder.leaves_no_trace(&mut folder.planish("denoise in.obj --method laplacian -o /dev/full"), 1);
    assert_eq!(err, "error: /dev/full: cannot be written: No space left on device\n");
}

#[test]
fn links_lead_to_the_file_that_is_written_and_modes_stay() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    folder.write("shared/latest.obj", "old");
    symlink("shared/latest.obj", folder.path("link.obj")).unwrap();
    symlink("shared/new.obj", folder.path("dangling.obj")).unwrap();
    symlink("link.obj", folder.path("second.obj")).unwrap();
    folder.succeeds("denoise in.obj --method laplacian -o out.obj");
    let whole = folder.text("out.obj");
    for (link, target) in
        [("link.obj", "shared/latest.obj"), ("dangling.obj", "shared/new.obj"), ("second.obj", "shared/latest.obj")]
    {
        folder.write(target, "old");
        if link == "dangling.obj" {
            std::fs::remove_file(folder.path(target)).unwrap();
        }
        folder.succeeds(&format!("denoise in.obj --method laplacian -o {link}"));
        assert!(folder.path(link).symlink_metadata().unwrap().is_symlink(), "{link}");
        assert!(folder.text(target) == whole, "{link}");
    }
    let looped = folder.path("loop.obj");
    symlink("loop.obj", &looped).unwrap();
    let refused = Printed::from(folder.planish("denoise in.obj -o loop.obj").output().unwrap());
    assert!(
        refused.code == Some(2) && refused.err.contains("loop.obj: cannot be written: too many links"),
        "{}",
        refused.err
    );
    std::fs::remove_file(looped).unwrap();

    let mode = |name: &str| folder.path(name).metadata().unwrap().permissions().mode() & 0o777;
    let set = |name: &str, mode| {
        std::fs::set_permissions(folder.path(name), std::fs::Permissions::from_mode(mode)).unwrap();
    };
    for wanted in [0o600, 0o640, 0o666] {
        set("out.obj", wanted);
        folder.succeeds("denoise in.obj --method laplacian -o out.obj");
        assert_eq!(mode("out.obj"), wanted);
    }
    set("out.obj", 0o444);
    folder.refuses("denoise in.obj --method laplacian -o out.obj", &["error: out.obj: is read-only"]);
    folder.succeeds("bake in.obj --method laplacian -o out");
    set("out/in.mtl", 0o444);
    folder.refuses("bake in.obj --method laplacian --iterations 3 -o out", &["error: out/in.mtl: is read-only"]);
}

#[test]
fn names_cannot_write_lines_or_send_commands_to_a_terminal() {
    let mesh = Mesh::grid(4).noisy(0.01).obj();
    let folder = Folder::with("a\nb.obj", format!("mtllib \x1b[2Jevil.mtl\n{mesh}"));
    let run = |args: &[&str]| {
        let output = folder.planish("").args(args).output().unwrap();
        let printed = Printed::from(output);
        let text = printed.out.clone() + &printed.err;
        assert!(!text.contains('\x1b'), "{args:?}: {text}");
        printed
    };
    let baked = run(&["bake", "a\nb.obj", "-o", "out", "--method", "laplacian"]);
    assert_eq!(baked.code, Some(0), "{}", baked.err);
    assert!(baked.err.lines().all(|line| line.starts_with("warning: ")), "{}", baked.err);
    assert!(baked.out.contains("source    a\\nb.obj: 25 vertices"), "{}", baked.out);
    // A name is one line in the files too.
    assert_eq!(folder.names("out").iter().filter(|name| name.contains('\n')).count(), 0);
    assert!(folder.text("out/a_b.obj").starts_with("mtllib a_b.mtl\nv "));
    assert_eq!(run(&["check", "out/a_b.planish.json"]).code, Some(0));
    run(&["info", "a\nb.obj"]);
    run(&["denoise", "a\nb.obj", "-o", "c\n\x1bd.obj", "--method", "laplacian"]);
    let missing = run(&["info", "no\nsuch\x1b.obj"]);
    assert_eq!(missing.err, "error: no\\nsuch\\u{1b}.obj: No such file or directory\n");
    let mut manifest = folder.json("out/a_b.planish.json");
    manifest["displacement"]["file"] = "x\x1b\ny.png".into();
    manifest.as_object_mut().unwrap().shift_remove("files");
    folder.write("out/a_b.planish.json", manifest.to_string());
    let refused = run(&["apply", "out/a_b.planish.json", "-o", "x.obj"]);
    assert_eq!((refused.code, refused.err.lines().count()), (Some(2), 1), "{}", refused.err);
}

#[test]
fn a_name_that_is_no_unicode_is_told_because_a_manifest_cannot_hold_it() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = Folder::new();
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.obj");
    std::fs::write(folder.path(".").join(name), Mesh::grid(2).obj()).unwrap();
    let baked = Printed::from(folder.planish("bake -o out --method laplacian").arg(name).output().unwrap());
    assert!(baked.code == Some(0) && baked.err.contains("not UTF-8") && baked.err.contains("--mesh"), "{}", baked.err);
    let checked = folder.planish("check out/caf\u{fffd}.planish.json --mesh").arg(name).output().unwrap();
    assert!(checked.status.success(), "{checked:?}");
}

#[test]
fn a_mesh_from_a_pipe_has_no_path_in_the_manifest() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    let mut bake = folder.planish("bake /dev/stdin -o out --method laplacian --json");
    let child = bake.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), &folder.bytes("in.obj")).unwrap();
    assert_eq!(Printed::from(child.wait_with_output().unwrap()).code, Some(0));
    assert_eq!(folder.json("out/stdin.planish.json")["source"]["file"], "stdin");
    folder.succeeds("check out/stdin.planish.json --mesh in.obj");
}

#[test]
fn pipes_and_devices_are_read_if_the_user_names_them_and_not_if_a_file_does() {
    let folder = Folder::with("in.obj", format!("mtllib pipe\nmtllib /dev/zero\n{}", Mesh::grid(4).obj()));
    assert!(Command::new("mkfifo").arg(folder.path("pipe")).status().unwrap().success());
    for trust in ["", "--trust"] {
        let err = folder.succeeds(&format!("bake in.obj -o out --method laplacian {trust}")).err;
        assert!(err.contains("warning: pipe: is a pipe or a device"), "{err}");
        assert!(trust.is_empty() || err.contains("warning: /dev/zero: is a pipe or a device"), "{err}");
        assert!(folder.succeeds(&format!("info in.obj {trust}")).out.contains("pipe: is a pipe or a device"));
    }
    let whole = folder.json("out/in.planish.json");
    for (pointer, file) in [
        ("/displacement/file", "/dev/zero"),
        ("/carrier/obj", "/dev/zero"),
        ("/source/file", "/dev/zero"),
        ("/source/file", "../pipe"),
    ] {
        let mut manifest = whole.clone();
        *manifest.pointer_mut(pointer).unwrap() = file.into();
        manifest.as_object_mut().unwrap().shift_remove("files");
        folder.write("out/in.planish.json", manifest.to_string());
        let check = |options: &str| {
            let output = folder.planish(&format!("check out/in.planish.json {options}")).output().unwrap();
            let printed = Printed::from(output);
            assert_eq!((printed.code, printed.err.lines().count()), (Some(2), 1), "{pointer}: {}", printed.err);
            printed.err
        };
        check("");
        let err = check("--trust");
        assert!(err.contains("is a pipe or a device, and another file may name plain files only"), "{err}");
    }
}

#[test]
fn what_a_killed_bake_leaves_is_removed_by_the_next_one() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.01).obj());
    // Killed while it wrote, and while it renamed into a new folder.
    folder.write("out/.planish-Ab3xYz", "half a file");
    folder.write("out/in.displacement.png", "of the killed bake");
    folder.write("out/.planish-lock", "in.displacement.png\nin.planish.json\n");
    folder.succeeds("bake in.obj --method laplacian -o out");
    let whole = ["in.displacement.png", "in.glb", "in.mtl", "in.normal.png", "in.obj", "in.planish.json"];
    assert_eq!(folder.names("out"), whole);
    folder.succeeds("check out/in.planish.json");
    // Any command that writes there does the same.
    folder.write("out/.planish-Ab3xYz", "half a file");
    folder.succeeds("denoise in.obj --method laplacian -o out/denoised.obj");
    assert!(!folder.path("out/.planish-Ab3xYz").exists() && !folder.path("out/.planish-lock").exists());
}

#[test]
fn bakes_into_one_folder_at_once_end_with_one_whole_bundle() {
    let folder = Folder::with("in.obj", Mesh::grid(12).noisy(0.01).obj());
    let bake = |iterations: usize| {
        let line = format!("bake in.obj -o out --method laplacian -q --iterations {iterations}");
        folder.planish(&line).stderr(Stdio::piped()).spawn().unwrap()
    };
    for _ in 0..4 {
        let children: Vec<_> = (1..5).map(bake).collect();
        for child in children {
            let printed = Printed::from(child.wait_with_output().unwrap());
            assert_eq!(printed.code, Some(0), "{}", printed.err);
        }
        assert_eq!(folder.names("out").len(), 6);
        folder.succeeds("check out/in.planish.json");
    }
}

#[test]
fn without_memory_or_threads_there_is_one_line_or_a_result() {
    let folder = Folder::with("in.obj", Mesh::grid(150).noisy(0.001).obj());
    folder.succeeds("denoise in.obj --method laplacian -o whole.obj");
    let mut refused = 0;
    for kilobytes in [400_000, 90_000, 60_000, 50_000, 40_000, 35_000, 30_000] {
        for line in ["bake in.obj --method laplacian -o new/deep", "denoise in.obj --method laplacian -o new.obj"] {
            let mut command = through_shell(&folder, &format!("ulimit -v {kilobytes}"), line);
            let printed = Printed::from(command.output().unwrap());
            if printed.code == Some(0) {
                let _ = std::fs::remove_dir_all(folder.path("new"));
                let _ = std::fs::remove_file(folder.path("new.obj"));
                continue;
            }
            // The C library ends the program itself if it cannot note a thread's destructor.
            if printed.err.contains("Fatal glibc error") {
                assert_eq!(folder.names("."), ["in.obj", "whole.obj"], "{kilobytes}");
                continue;
            }
            assert_eq!(printed.code, Some(1), "{kilobytes}: {}", printed.err);
            // Memory may end before a file has been opened.
            let named = ["error: in.obj: out of memory while ", "error: out of memory while "];
            let is_clear = named.iter().any(|beginning| printed.err.starts_with(beginning));
            assert!(is_clear && printed.err.lines().count() == 1, "{kilobytes}: {}", printed.err);
            assert_eq!(folder.names("."), ["in.obj", "whole.obj"], "{kilobytes}");
            refused += 1;
        }
    }
    assert!(refused > 2, "only {refused} runs were short of memory");
    for threads in ["1", "7", "100000"] {
        let mut command = folder.planish("denoise in.obj --method laplacian -o out.obj");
        assert!(
            command.env("RAYON_NUM_THREADS", threads).stdout(Stdio::null()).status().unwrap().success(),
            "{threads}"
        );
        assert!(folder.bytes("out.obj") == folder.bytes("whole.obj"), "{threads}");
    }
}

/// Waits until a process has a handler of SIGINT of its own, as Linux tells; a signal before that ends it without a word.
#[cfg(target_os = "linux")]
fn until_interrupts_are_handled(child: &std::process::Child) {
    let start = Instant::now();
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        // The mask has a bit for each signal, from 1.
        if u64::from_str_radix(caught.trim(), 16).unwrap() & 1 << (2 - 1) != 0 {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "interrupts are not handled: {status}");
        std::thread::yield_now();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_is_heard_while_a_pipe_is_silent() {
    let folder = Folder::with("in.obj", Mesh::grid(4).obj());
    assert!(Command::new("mkfifo").arg(folder.path("pipe")).status().unwrap().success());
    for line in
        ["info pipe", "bake pipe -o out", "denoise pipe -o new/out.obj", "denoise in.obj --method laplacian -o pipe"]
    {
        let child = folder.planish(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        until_interrupts_are_handled(&child);
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let printed = Printed::from(child.wait_with_output().unwrap());
        assert_eq!(
            (printed.code, printed.err.as_str()),
            (Some(1), "error: interrupted; nothing was written\n"),
            "{line}"
        );
        // Only the names: reading the pipe would wait.
        let mut names: Vec<_> = std::fs::read_dir(folder.path(".")).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["in.obj", "pipe"], "{line}");
    }
}
