//! The command line, run to its end, and what it printed.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program in a folder; nobody's robots are driven by a test.
pub fn rsrs(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("RSRS_INTERFACE")
        .output()
        .expect("the binary was built for this test")
}

/// How the program ended.
pub fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ended by itself")
}

/// What the program printed on standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("messages are UTF-8")
}

/// What the program answered.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("results are UTF-8")
}

/// What the program answered to another program.
pub fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}{}", stdout(output), stderr(output)))
}

/// Writes files into a folder, by name and text.
pub fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("the folder is writable");
    }
}

/// Types a command that must succeed, and returns what it prints.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = rsrs(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}{}", stdout(&output), stderr(&output));
    stdout(&output)
}

/// The root of the repository, with its example files.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
