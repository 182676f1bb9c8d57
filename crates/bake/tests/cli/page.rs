//! `docs/commands.md` says what `planish help` says.
//!
//! `docs/make` writes the page anew: it runs this test with `PLANISH_UPDATE` set.

use crate::folder::Folder;
use std::fmt::Write as _;
use std::path::Path;

/// The words above this line are written by hand.
const MARK: &str = "<!-- docs/make writes what follows, from `planish help`. -->\n";

/// The help of a command, as it is printed on a terminal of 100 columns.
fn help(folder: &Folder, command: &str) -> String {
    let output = folder.planish(command).arg("--help").env("COLUMNS", "100").output().unwrap();
    assert!(output.status.success(), "{command}");
    let text = String::from_utf8(output.stdout).unwrap().replace("planish.exe", "planish");
    // Some lines end in blanks, which editors take away.
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Names of the commands, in the order of the overview.
fn commands(overview: &str) -> Vec<&str> {
    let (_, after) = overview.split_once("Commands:\n").unwrap();
    let listed = after.lines().take_while(|line| line.starts_with("  "));
    let names = listed.filter(|line| !line.starts_with("   ")).map(|line| line.split_whitespace().next().unwrap());
    names.filter(|name| *name != "help").collect()
}

#[test]
fn the_page_of_commands_is_what_help_prints() {
    let folder = Folder::new();
    let overview = help(&folder, "");
    let names = commands(&overview);
    assert!(names.len() >= 9, "{names:?}");
    let mut printed = format!("\n## planish\n\n```text\n{overview}```\n");
    for name in names {
        write!(printed, "\n## planish {name}\n\n```text\n{}```\n", help(&folder, name)).unwrap();
    }

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/commands.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (by_hand, committed) =
        page.split_once(MARK).expect("docs/commands.md has lost the line that ends its introduction");
    if std::env::var_os("PLANISH_UPDATE").is_some() {
        std::fs::write(&path, format!("{by_hand}{MARK}{printed}")).unwrap();
        return;
    }
    let differs = printed.lines().zip(committed.lines().chain(std::iter::repeat(""))).find(|(new, old)| new != old);
    assert!(
        committed == printed,
        "docs/commands.md is out of date, run docs/make; the first line that differs: {differs:?}"
    );
}
