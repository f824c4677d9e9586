//! Names the commit that this binary was built from, which the results that it makes name. The Python
//! package does so by the same script.

use std::fs;
use std::process::Command;

fn main() {
    let commit = packed().or_else(|| git(&["rev-parse", "--short=12", "HEAD"]));
    println!("cargo:rustc-env=RSRS_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    for (folder, name) in [("--git-dir", "HEAD"), ("--git-common-dir", "refs/heads")] {
        if let Some(folder) = git(&["rev-parse", folder]) {
            println!("cargo:rerun-if-changed={folder}/{name}");
        }
    }
}

/// The commit that a package of sources was made from (`.ci/wheels`): it has no repository, and may lie
/// in one of something else.
fn packed() -> Option<String> {
    fs::read_to_string("COMMIT").ok().map(|text| text.trim().to_owned())
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(text.trim().to_owned())
}
