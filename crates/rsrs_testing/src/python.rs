//! A cached Python environment with a few packages, for tests that use other implementations.

use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Command;

/// Makes sure that an environment with these packages is there, and gives its interpreter.
///
/// It is kept under Cargo's target directory and made once; other test processes wait for it.
///
/// # Arguments
///
/// * `purpose` — names the environment.
/// * `packages` — exact requirements, installed with what they depend on.
/// * `files_only` — exact requirements of packages whose files alone matter.
///
/// # Panics
///
/// If this machine has no `python3` with `venv`, or reaches no package index.
pub fn python_with(purpose: &str, packages: &[&str], files_only: &[&str]) -> PathBuf {
    // Tests lie in `target/PROFILE/deps`.
    let test = std::env::current_exe().expect("a running test has an executable");
    let target = test.ancestors().nth(3).expect("the folder of a test lies in the target folder");
    let folder = target.join("tmp").join(format!(".venv-{purpose}"));
    fs::create_dir_all(target.join("tmp")).expect("the target folder is writable");
    let lock = File::create(folder.with_extension("lock")).expect("the target folder is writable");
    lock.lock().expect("the file system of the target folder has locks");

    let python = folder.join("bin/python");
    let ready = folder.join("ready");
    let wanted = [packages, files_only].concat().join("\n");
    if fs::read_to_string(&ready).is_ok_and(|installed| installed == wanted) {
        return python;
    }
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("a half-made environment can be removed");
    }
    must_run(Command::new("python3").args(["-m", "venv"]).arg(&folder));
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    must_run(Command::new(&python).args(install).args(packages));
    if !files_only.is_empty() {
        must_run(Command::new(&python).args(install).arg("--no-deps").args(files_only));
    }
    fs::write(&ready, wanted).expect("the new environment is writable");
    python
}

/// Runs a command to its end and gives what it printed.
///
/// # Panics
///
/// If it cannot start or fails; the message holds what it wrote to its standard error.
pub fn must_run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| {
        panic!("{command:?} does not start: {error}; this test needs python3 with venv and pip")
    });
    assert!(
        output.status.success(),
        "{command:?} failed; this test needs python3 with venv, and pip with a package index:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("the scripts print text")
}
