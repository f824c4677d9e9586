//! The command line, run to its end, and what it printed.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rsrs_testing::network;

/// Runs the program in a folder; nobody's robots are driven by a test.
pub fn rsrs(folder: &Path, arguments: &[&str]) -> Output {
    let _processors = network::share_processors();
    Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("RSRS_INTERFACE")
        .output()
        .expect("the binary was built for this test")
}

/// Types a line in a folder; its words are without spaces.
pub fn run_line(folder: &Path, line: &str) -> Output {
    rsrs(folder, &line.split_whitespace().collect::<Vec<_>>())
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

/// Copies a folder with all that is in it.
pub fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("it is writable");
    for entry in from.read_dir().expect("the folder is there") {
        let path = entry.expect("it can be listed").path();
        let target = to.join(path.file_name().expect("it has a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).expect("it is writable");
        }
    }
}

/// What a command that must succeed answers to another program.
pub fn answer(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    serde_json::from_str(&done(folder, arguments)).expect("answers are JSON")
}

/// The text of a file in a folder.
pub fn text_in(folder: &Path, name: &str) -> String {
    let path = folder.join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The path of a shipped example file.
pub fn shipped(file: &str) -> String {
    let path = repository().join("launch_configs").join(file);
    path.to_str().expect("the path is text").to_owned()
}

/// Copies a shipped example file to a path.
pub fn bring(file: &str, to: &Path) {
    std::fs::copy(shipped(file), to).expect("it is shipped");
}

/// Types a line that must succeed, and returns what it prints.
pub fn done_line(folder: &Path, line: &str) -> String {
    done(folder, &line.split_whitespace().collect::<Vec<_>>())
}
