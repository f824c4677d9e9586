//! Pages in a browser without a window.

use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_testing::python::{Environment, must_run, python_with};

use crate::command::repository;

mod report;
mod simulator;

const PLAYWRIGHT: Environment = Environment {
    name: "browser",
    packages: &["playwright==1.65.2", "axe-playwright-python==0.1.8"],
    files_only: &[],
};

/// The system's Chromium, installed if this machine lacks it and may.
fn chromium() -> PathBuf {
    let find = || {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let names = ["chromium", "chromium-browser", "google-chrome"];
        std::env::split_paths(&path)
            .flat_map(|folder| names.map(|name| folder.join(name)))
            .find(|file| file.is_file())
    };
    find().unwrap_or_else(|| {
        // Others may be installing something.
        let install = [
            "-o",
            "DPkg::Lock::Timeout=600",
            "install",
            "-y",
            "-qq",
            "--no-install-recommends",
            "chromium",
        ];
        let mut apt = Command::new("apt-get");
        let installed = apt.args(install).env("DEBIAN_FRONTEND", "noninteractive").output();
        find().unwrap_or_else(|| {
            panic!(
                "this test needs Chromium, and could not install it: `apt-get install chromium`: \
                 {installed:?}"
            )
        })
    })
}

/// Lets a script of this folder use a page, and gives what it found, which `--nocapture` shows: how long
/// things took, too. The script is given the browser, the page, and `more`.
#[expect(clippy::print_stdout, reason = "for who measures")]
fn browse(script: &str, page: &Path, more: &[&Path]) -> String {
    let python = python_with(&PLAYWRIGHT);
    let script = repository().join("tests/browser").join(script);
    let found = must_run(Command::new(python).arg(script).arg(chromium()).arg(page).args(more));
    print!("{found}");
    found
}
