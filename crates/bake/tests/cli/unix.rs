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
        let err = folder.leaves_no_trace(&mut through_shell(&folder, full, line), 2);
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
