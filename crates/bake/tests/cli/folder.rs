//! A folder to run the binary in.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder with one file in it.
    pub(crate) fn with(name: &str, bytes: impl AsRef<[u8]>) -> Self {
        let folder = Self::new();
        folder.write(name, bytes);
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and makes the folders it needs.
    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// Removes the checksums of the files from a manifest, as those of earlier versions had none.
    pub(crate) fn without_checksums(&self, manifest: &str) {
        let mut json = self.json(manifest);
        json.as_object_mut().unwrap().shift_remove("files");
        self.write(manifest, json.to_string());
    }

    /// All there is below a subfolder (`.` for everything), hidden files too; folders have no bytes.
    pub(crate) fn contents(&self, below: &str) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        let mut open = vec![self.path(below)];
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(self.path(below)).unwrap().to_path_buf();
                found.insert(name, (!path.is_dir()).then(|| fs::read(&path).unwrap()));
                if path.is_dir() {
                    open.push(path);
                }
            }
        }
        found
    }

    /// Names of what lies directly in a subfolder, sorted.
    pub(crate) fn names(&self, below: &str) -> Vec<String> {
        let direct = |path: &PathBuf| path.parent() == Some(Path::new(""));
        self.contents(below).into_keys().filter(direct).map(|path| path.display().to_string()).collect()
    }

    /// The binary with the words of `line` as its arguments.
    pub(crate) fn planish(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_planish"));
        command.current_dir(&self.0).args(line.split_whitespace());
        command
    }

    /// Runs the binary, however it ends.
    pub(crate) fn run(&self, line: &str) -> Printed {
        Printed::from(self.planish(line).output().unwrap())
    }

    #[track_caller]
    pub(crate) fn succeeds(&self, line: &str) -> Printed {
        let printed = Printed::from(self.planish(line).output().unwrap());
        assert_eq!(printed.code, Some(0), "{line}: {}", printed.err);
        printed
    }

    /// Runs a command with `--json` and takes all that it prints.
    #[track_caller]
    pub(crate) fn succeeds_with_json(&self, line: &str) -> Value {
        let out = self.succeeds(&format!("{line} --json")).out;
        serde_json::from_str(&out).unwrap_or_else(|e| panic!("{line}: {e} in {out}"))
    }

    /// Expects bad input: exit code 2, one line on stderr with all of `words`, and not a trace in the folder.
    #[track_caller]
    pub(crate) fn refuses(&self, line: &str, words: &[&str]) {
        let err = self.leaves_no_trace(&mut self.planish(line), 2);
        assert_eq!(err.lines().count(), 1, "{line}: {err}");
        assert!(err.starts_with("error: ") && err.ends_with('\n'), "{line}: {err}");
        for word in words {
            assert!(err.contains(word), "{line}: no `{word}` in: {err}");
        }
    }

    /// Expects bad usage, which comes with a few lines of advice after the one that says what is wrong.
    #[track_caller]
    pub(crate) fn refuses_usage(&self, line: &str, words: &[&str]) {
        let err = self.leaves_no_trace(&mut self.planish(line), 2);
        let first = err.lines().next().unwrap_or_default();
        assert!(first.starts_with("error: "), "{line}: {err}");
        for word in words {
            assert!(first.contains(word), "{line}: no `{word}` in: {first}");
        }
    }

    /// Runs a command that must fail, print nothing on stdout and change no file; gives its complaint.
    #[track_caller]
    pub(crate) fn leaves_no_trace(&self, command: &mut Command, code: i32) -> String {
        let before = self.contents(".");
        let printed = Printed::from(command.output().unwrap());
        assert_eq!(printed.code, Some(code), "{command:?}: {}", printed.err);
        assert_eq!(printed.out, "", "{command:?}");
        // Only the names: a failed comparison of contents would print them.
        let after = self.contents(".");
        assert_eq!(after.keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>(), "{command:?}");
        assert!(after == before, "{command:?} changed a file");
        printed.err
    }
}

/// Output and exit code of a finished process.
pub(crate) struct Printed {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl From<Output> for Printed {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }
}
