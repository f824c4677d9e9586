//! The program `rsrs` itself, as a person starts it.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};
use serde_json::Value;

/// The binary, and the folder in which it is started.
pub struct Program {
    binary: PathBuf,
    folder: PathBuf,
}

/// What a command said, and how it ended.
pub struct Said {
    /// What it reported as JSON; `null` if it reports nothing.
    pub json: Value,
    /// Its exit code: 0 done, 3 done with a negative answer.
    pub code: i32,
}

impl Program {
    /// Builds the binary beside this one, in the same way.
    ///
    /// # Errors
    ///
    /// If it does not build.
    pub fn build(folder: &Path) -> anyhow::Result<Self> {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.args(["build", "--package", "rsrs", "--bin", "rsrs"]);
        if !cfg!(debug_assertions) {
            cargo.arg("--release");
        }
        let status = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).status();
        if !status.context("starting cargo")?.success() {
            bail!("the program does not build");
        }
        let this = std::env::current_exe().context("where this program is")?;
        // …/examples/reproduce beside …/rsrs.
        let profile = this.parent().and_then(Path::parent).context("examples lie in a folder")?;
        let binary = profile.join(format!("rsrs{}", std::env::consts::EXE_SUFFIX));
        Ok(Self { binary, folder: folder.to_path_buf() })
    }

    /// Runs a command and waits for its end.
    ///
    /// # Arguments
    ///
    /// * `arguments` — as on a command line, parted by blanks.
    ///
    /// # Errors
    ///
    /// If it fails; what it said of that is in the error.
    pub fn run(&self, arguments: &str) -> anyhow::Result<Said> {
        let output = Command::new(&self.binary)
            .args(arguments.split_whitespace())
            .current_dir(&self.folder)
            .output()
            .with_context(|| format!("starting {}", self.binary.display()))?;
        let code = output.status.code().unwrap_or(1);
        if !matches!(code, 0 | 3) {
            let stderr = String::from_utf8_lossy(&output.stderr);
            bail!("rsrs {arguments} ended with {code}: {stderr}");
        }
        let json = if output.stdout.is_empty() || !arguments.contains("--format json") {
            Value::Null
        } else {
            serde_json::from_slice(&output.stdout)
                .with_context(|| format!("what `rsrs {arguments}` reported"))?
        };
        Ok(Said { json, code })
    }
}
