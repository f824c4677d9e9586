//! Steps 1 and 2 on the command line: trials to a profile, and a simulator that is worse than the
//! robots; over DDS too.

#[path = "measure/drive.rs"]
mod drive;
#[path = "measure/tables.rs"]
mod tables;
#[path = "measure/validate.rs"]
mod validate;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn rsrs(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .args(arguments)
        .current_dir(folder)
        // Nobody's robots are driven by a test.
        .env_remove("RSRS_INTERFACE")
        .output()
        .expect("the binary was built for this test")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ended by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("results are UTF-8")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("messages are UTF-8")
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        panic!("{error} in {}{}", stdout(output), stderr(output));
    })
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

/// A folder with the Flockbot's trials.
fn trials() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for table in ["speed", "turn", "detection", "period"] {
        let from =
            repository().join(format!("launch_configs/profiles/flockbot_trials/{table}.csv"));
        std::fs::copy(from, folder.path().join(format!("{table}.csv")))
            .expect("the trials are there");
    }
    folder
}

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    std::fs::write(folder.join(name), text).expect("the folder is writable");
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}
