//! Pages in a browser without a window.

use std::path::Path;
use std::process::Command;

use rsrs_testing::chromium::chromium;
use rsrs_testing::python::{BROWSER, must_run, python_with};

use crate::command::repository;

mod report;
mod simulator;

/// Lets a script of this folder use a page, and gives what it found, which `--nocapture` shows: how long
/// things took, too. The script is given the browser, the page, and `more`.
#[expect(clippy::print_stdout, reason = "for who measures")]
fn browse(script: &str, page: &Path, more: &[&Path]) -> String {
    let python = python_with(&BROWSER);
    let script = repository().join("tests/browser").join(script);
    let found = must_run(Command::new(python).arg(script).arg(chromium()).arg(page).args(more));
    print!("{found}");
    found
}
