//! Steps 1 and 2 on the command line: trials to a profile, and a simulator that is worse than the
//! robots; over DDS too.

mod drive;
mod interrupted;
mod tables;
mod validate;

use std::path::Path;

use crate::command::repository;

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
