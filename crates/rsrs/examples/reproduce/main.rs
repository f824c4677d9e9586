//! Reproduces the paper's case study and writes `docs/REPRODUCTION.md` with its pictures.
//!
//! ```text
//! cargo run --release --example reproduce [FOLDER]
//! ```
//!
//! `FOLDER` is `docs` if not said. All that is in the document comes from this run: every statement of
//! the paper beside what was measured. The commands of `rsrs` are started as a person starts them; the
//! robots of step 4 are a stand-in ([`reality`]).

mod document;
mod experiments;
mod findings;
mod program;
mod reality;
mod swept;

use std::path::{Path, PathBuf};

use anyhow::Context;

fn main() -> anyhow::Result<()> {
    let docs = std::env::args_os().nth(1).map_or_else(|| root().join("docs"), PathBuf::from);
    let pictures = docs.join("reproduction");
    std::fs::create_dir_all(&pictures).with_context(|| pictures.display().to_string())?;
    let work = tempfile::tempdir().context("a temporary folder")?;

    let findings = findings::find(work.path(), &root())?;

    document::draw(&findings, &pictures)?;
    let path = docs.join("REPRODUCTION.md");
    std::fs::write(&path, document::markdown(&findings)).with_context(|| path.display().to_string())
}

/// The folder of the project.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
