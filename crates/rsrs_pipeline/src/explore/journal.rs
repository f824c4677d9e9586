//! What was tried so far, a line each.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use super::trial::Trial;
use crate::files::{cannot_write, read_if_there};

/// A journal of trials, which a search reads before it simulates.
pub struct Journal {
    path: PathBuf,
    known: Vec<Trial>,
    file: File,
}

impl Journal {
    /// Opens a journal, and makes it if it is not there. A last line that was not finished is
    /// dropped; any other line that is no trial is an error.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let text = read_if_there(path)?.unwrap_or_default();
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut known = Vec::new();
        for (number, line) in text[..whole].lines().enumerate() {
            let trial: Trial = serde_json::from_str(line)
                .with_context(|| format!("{}: line {}", path.display(), number + 1))?;
            known.push(trial);
        }
        let file = File::options()
            .create(true)
            .append(true)
            .open(path)
            .with_context(|| cannot_write(path))?;
        file.set_len(whole as u64).with_context(|| cannot_write(path))?;
        Ok(Self { path: path.to_owned(), known, file })
    }

    /// Trials that were made before, from this number on, as many as are asked for or are there.
    pub fn known(&self, first: usize, n: usize) -> &[Trial] {
        let end = self.known.len().min(first + n);
        self.known.get(first..end).unwrap_or_default()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// Adds trials.
    pub fn add(&mut self, trials: &[Trial]) -> anyhow::Result<()> {
        let mut lines = String::new();
        for trial in trials {
            lines += &serde_json::to_string(trial).context("a trial as JSON")?;
            lines.push('\n');
        }
        let written = self.file.write_all(lines.as_bytes()).and_then(|()| self.file.sync_data());
        written.with_context(|| cannot_write(&self.path))?;
        self.known.extend_from_slice(trials);
        Ok(())
    }
}
