//! Results of `batch`: each mesh as the commands for one mesh make it, errors by name, parts, and going on after an end.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;
use std::collections::BTreeSet;

/// A folder `in` with six meshes, one of them deep and two of them bad.
fn meshes() -> Folder {
    let folder = Folder::new();
    for i in 0..3 {
        folder.write(&format!("in/{i}.obj"), Mesh::sphere(6 + i).noisy(0.02).obj());
    }
    folder.write("in/deep/deeper/3.obj", Mesh::grid(6).noisy(0.02).obj());
    folder.write("in/bad.obj", "v 0 0 x\n");
    folder.write("in/deep/empty.ply", "");
    folder.write("in/notes.txt", "no mesh");
    folder
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Places of the results in lines, by whether they are done.
fn places(lines: &[Value], ok: bool) -> BTreeSet<String> {
    lines
        .iter()
        .filter(|line| line["ok"] == ok)
        .map(|line| line["place"].as_str().unwrap().replace('\\', "/"))
        .collect()
}

fn set(places: &[&str]) -> BTreeSet<String> {
    places.iter().map(|place| (*place).to_owned()).collect()
}

const GOOD: [&str; 4] = ["0.obj", "1.obj", "2.obj", "deep/deeper/3.obj"];

#[test]
fn each_mesh_is_whole_or_named_with_its_error() {
    let folder = meshes();
    let printed = folder.run("batch in -o out --method taubin --jobs 2");
    assert_eq!(printed.code, Some(1));
    let all = lines(&printed.out);
    assert_eq!((places(&all, true), places(&all, false)), (set(&GOOD), set(&["bad.obj", "deep/empty.ply"])));
    let bad = all.iter().find(|line| line["place"] == "bad.obj").unwrap();
    assert!(bad["error"].as_str().unwrap().contains("bad.obj: line 1"), "{bad}");
    assert_eq!(bad["exit_code"], 2);
    assert!(printed.err.ends_with("error: 2 of 6 meshes failed\n"), "{}", printed.err);
    assert!(printed.err.contains("6 meshes: 4 done, 2 failed, in "), "{}", printed.err);
    for place in GOOD {
        folder.succeeds(&format!("denoise in/{place} -o one.obj --method taubin"));
        assert!(folder.bytes("one.obj") == folder.bytes(&format!("out/{place}")), "{place}");
        let line = all.iter().find(|line| line["mesh"] == format!("in/{place}")).unwrap();
        assert!(line["seconds"].as_f64().unwrap() > 0.0 && line["max_displacement"].as_f64().unwrap() > 0.0);
        assert_eq!(line["method"]["name"], "taubin");
    }
    assert_eq!(lines(&folder.text("out/planish-batch.jsonl")), all);
    assert_eq!(folder.names("out").len(), 5, "nothing but results and the journal: {:?}", folder.names("out"));
}

#[test]
fn auto_says_what_it_chose_and_the_summary_is_json_if_asked() {
    let folder = Folder::with("a.obj", Mesh::sphere(8).noisy(0.02).obj());
    let printed = folder.succeeds("batch a.obj -o out --json");
    let all = lines(&printed.out);
    assert!(all[0]["choice"]["candidates"].is_array(), "{}", all[0]);
    assert_eq!(all[1]["summary"]["done"], 1);
    assert_eq!(folder.succeeds("batch a.obj -o out --quiet").out, "");
}

#[test]
fn a_bake_gives_each_mesh_a_folder() {
    let folder = meshes();
    let printed = folder.run("batch in -o out --bake --method taubin --size 64");
    assert_eq!(printed.code, Some(1));
    let done = places(&lines(&printed.out), true);
    assert_eq!(done, set(&["0-planish", "1-planish", "2-planish", "deep/deeper/3-planish"]));
    folder.succeeds("bake in/deep/deeper/3.obj -o out/deep/deeper/one --method taubin --size 64");
    for name in folder.names("out/deep/deeper/one") {
        let [one, ours] = ["one", "3-planish"].map(|f| folder.bytes(&format!("out/deep/deeper/{f}/{name}")));
        assert!(one == ours, "{name}");
    }
}

#[test]
fn parts_together_are_all_meshes_and_each_is_done_once() {
    let folder = meshes();
    let parts = [1, 2, 3].map(|i| lines(&folder.run(&format!("batch in -o out --method laplacian --shard {i}/3")).out));
    assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
    let all = parts.concat();
    assert_eq!(places(&all, true), set(&GOOD));
    // Another division of the work knows what all parts have done.
    let again = lines(&folder.run("batch in -o out --method laplacian --resume").out);
    assert_eq!((places(&again, true), places(&again, false).len()), (set(&[]), 2));
}

#[test]
fn what_is_done_is_not_done_again_unless_something_changed() {
    let folder = meshes();
    let run = |options: &str| {
        let printed = folder.run(&format!("batch in -o out --method laplacian {options}"));
        places(&lines(&printed.out), true)
    };
    assert_eq!(run(""), set(&GOOD));
    assert_eq!(run("--resume"), set(&[]));
    let printed = folder.run("batch in -o out --method laplacian --resume");
    assert!(printed.err.contains("6 meshes: 0 done, 2 failed, 4 done before"), "{}", printed.err);
    folder.write("in/bad.obj", Mesh::grid(3).noisy(0.01).obj());
    std::fs::remove_file(folder.path("out/1.obj")).unwrap();
    folder.write("in/2.obj", Mesh::sphere(9).noisy(0.03).obj());
    assert_eq!(run("--resume"), set(&["1.obj", "2.obj", "bad.obj"]));
    assert_eq!(run("--resume --step 0.25").len(), 5, "other settings give other results");
    assert_eq!(run("").len(), 5, "without --resume everything is done");
}

#[test]
fn a_journal_that_was_cut_off_is_gone_on_with() {
    let folder = meshes();
    folder.run("batch in -o out --method laplacian --jobs 1");
    let journal = folder.text("out/planish-batch.jsonl");
    let done: Vec<&str> = journal.lines().filter(|line| line.contains("\"ok\":true")).collect();
    // Killed in the middle of the third line.
    let cut = format!("{}\n{}\n{}", done[0], done[1], &done[2][..40]);
    folder.write("out/planish-batch.jsonl", cut);
    let again = lines(&folder.run("batch in -o out --method laplacian --resume").out);
    assert_eq!(places(&again, true).len(), 2);
    let whole: Vec<Value> =
        folder.text("out/planish-batch.jsonl").lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    assert_eq!(places(&whole, true), set(&GOOD));
    assert_eq!(whole.iter().filter(|line| line["ok"] == true).count(), 4, "no mesh is done twice");
}

#[test]
fn two_hundred_meshes_with_seven_bad_ones_are_gone_on_with_after_a_kill() {
    let folder = Folder::new();
    let is_bad = |i: usize| i % 30 == 11;
    let place = |i: usize| format!("{i:03}.obj");
    for i in 0..200 {
        let good = || Mesh::sphere(5 + i % 7).noisy(0.01 + 0.0001 * i as f64).obj();
        folder.write(&format!("in/{}", place(i)), if is_bad(i) { "v 0 0\nf 1 2 3\n".to_owned() } else { good() });
    }
    let line = "batch in -o out --method taubin --jobs 2 --resume";
    let mut killed =
        folder.planish(line).stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn();
    let journal = folder.path("out/planish-batch.jsonl");
    let count = || std::fs::read_to_string(&journal).map_or(0, |text| text.matches("\"ok\":true").count());
    let child = killed.as_mut().unwrap();
    // However fast the machine is: either it is killed in the middle, or it has ended.
    while count() < 20 && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = count();
    let again = folder.run(line);
    assert_eq!(again.code, Some(1));
    let again = lines(&again.out);
    assert_eq!(before + places(&again, true).len(), 193, "no mesh is done twice, none is lost");
    let bad: BTreeSet<String> = (0..200).filter(|i| is_bad(*i)).map(place).collect();
    assert_eq!((places(&again, false), bad.len()), (bad, 7));
    let whole: Vec<Value> =
        folder.text("out/planish-batch.jsonl").lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let done: Vec<&str> = whole.iter().filter(|line| line["ok"] == true).filter_map(|l| l["place"].as_str()).collect();
    assert_eq!((done.len(), done.iter().collect::<BTreeSet<_>>().len()), (193, 193));
    for i in (0..200).filter(|i| !is_bad(*i)).step_by(20) {
        folder.succeeds(&format!("denoise in/{0} -o one.obj --method taubin", place(i)));
        assert!(folder.bytes("one.obj") == folder.bytes(&format!("out/{}", place(i))), "{i}");
    }
}

#[test]
fn patterns_and_lists_name_meshes() {
    let folder = meshes();
    let printed = folder.succeeds("batch in/*.obj in/deep/**/3.obj -o out --method laplacian --shard 2/5");
    assert_eq!(lines(&printed.out).len(), 1);
    folder.write("list.txt", "in/0.obj\n\nin/deep/deeper/3.obj\n");
    let printed = folder.succeeds("batch --list list.txt -o listed --method laplacian");
    assert_eq!(places(&lines(&printed.out), true), set(&["0.obj", "3.obj"]));
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let folder = meshes();
    folder.write("other/0.obj", Mesh::grid(2).obj());
    for (line, words) in [
        ("batch in other -o out", "would have the same result as"),
        ("batch none/*.obj -o out", "none/*.obj: no mesh has such a name"),
        ("batch -o out", "required"),
        ("batch in -o out --shard 3/2", "a shard is I/N"),
        ("batch in -o out --shard 0/2", "a shard is I/N"),
        ("batch in -o out --jobs 0", "--jobs"),
        ("batch in -o out --size 64", "--bake"),
        ("batch in -o out --bake --update-normals", "cannot be used with"),
        ("batch in -o out --method sun --radius 3", "--radius goes with --method"),
        ("batch in -o in/0.obj", "in/0.obj"),
    ] {
        let printed = folder.run(line);
        assert_eq!(printed.code, Some(2), "{line}: {}", printed.err);
        assert!(printed.err.contains(words), "{line}: {}", printed.err);
    }
    assert!(!folder.path("out").exists());
    std::fs::create_dir(folder.path("nothing")).unwrap();
    folder.refuses("batch nothing -o out", &["there are no meshes"]);
}

#[test]
fn results_below_the_meshes_are_not_taken_for_meshes() {
    let folder = meshes();
    let run = || lines(&folder.run("batch in -o in/out --method laplacian").out).len();
    assert_eq!((run(), run()), (6, 6));
    let inputs_stay = folder.run("batch in -o in --method laplacian");
    assert_eq!(places(&lines(&inputs_stay.out), true), set(&[]), "no mesh is written over itself");
}
