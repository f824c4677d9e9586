//! Pages in a browser without a window.

use std::path::Path;
use std::process::Command;

use rsrs_testing::chromium::chromium;
use rsrs_testing::network::share_processors;
use rsrs_testing::python::{BROWSER, must_run, python_with};

use crate::command::repository;

mod report;
mod simulator;

/// Lets a script of this folder use a page, and gives what it found, which `--nocapture` shows: how long
/// things took, too. The script is given the browser, which gives way to robots of other tests, the page,
/// and `more`.
#[expect(clippy::print_stdout, reason = "for who measures")]
fn browse(script: &str, page: &Path, more: &[&Path]) -> String {
    let python = python_with(&BROWSER);
    let folder = repository().join("tests/browser");
    let mut command = Command::new(python);
    command.arg(folder.join(script)).arg(folder.join("giving_way")).arg(page).args(more);
    let _processors = share_processors();
    let found = must_run(command.env("CHROMIUM", chromium()));
    print!("{found}");
    found
}
