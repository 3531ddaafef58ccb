//! Runs the program in a temporary folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A folder to work in, with the fixture `parallel` as `capture`.
pub struct Bench {
    folder: TempDir,
}

/// The outcome of a command.
pub struct Ran {
    pub code: i32,
    pub out: String,
    pub err: String,
}

pub fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures")
}

impl Bench {
    pub fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.bring("parallel", "capture");
        bench
    }

    /// Copies a fixture.
    pub fn bring(&self, fixture: &str, name: &str) {
        fs::create_dir_all(self.path(name)).unwrap();
        for entry in fs::read_dir(fixtures().join(fixture)).unwrap() {
            let from = entry.unwrap().path();
            fs::copy(&from, self.path(name).join(from.file_name().unwrap())).unwrap();
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Replaces a part of a text file; the part must exist.
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let text = self.text(name);
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, text.replacen(from, to, 1));
    }

    /// Names of the files in a folder, sorted; none where there is no folder.
    pub fn files(&self, folder: &str) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.path(folder)) else { return Vec::new() };
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `facerecon` with arguments separated by blanks.
    pub fn run(&self, arguments: &str) -> Ran {
        let done = Command::new(env!("CARGO_BIN_EXE_facerecon"))
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path())
            .env_remove("RUST_BACKTRACE")
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let code = done.status.code().unwrap_or(-1);
        Ran { code, out: text(done.stdout), err: text(done.stderr) }
    }

    /// Runs a command that must succeed.
    pub fn done(&self, arguments: &str) -> Ran {
        let ran = self.run(arguments);
        assert_eq!(ran.code, 0, "facerecon {arguments}\n{}{}", ran.out, ran.err);
        ran
    }
}
