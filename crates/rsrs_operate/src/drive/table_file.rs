//! A table of trials on disk: written by one process at a time, and never half-written.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::lock_file::try_lock;
use rsrs_pipeline::files::write_durably;

/// How long a row waits for another process that adds one, which takes milliseconds.
pub const TIMEOUT: Duration = Duration::from_secs(10);

/// The right to write a table; no other process has it meanwhile.
#[derive(Debug)]
pub struct TableLock {
    table: PathBuf,
    lock: PathBuf,
    /// Held open, for it is the lock.
    _file: File,
}

impl TableLock {
    /// Takes the right to write a table, and waits up to `timeout` for another process that has it.
    pub fn take(table: &Path, timeout: Duration) -> anyhow::Result<Self> {
        // `.speed.csv.lock` beside `speed.csv`.
        let name = table.file_name().unwrap_or_default().to_string_lossy();
        let lock = table.with_file_name(format!(".{name}.lock"));
        let start = Instant::now();
        loop {
            let locked = try_lock(&lock)
                .with_context(|| format!("{} cannot be filled in", table.display()))?;
            if let Some(file) = locked {
                return Ok(Self { table: table.to_owned(), lock, _file: file });
            }
            if start.elapsed() >= timeout {
                return Err(with_help(
                    format!("another process is filling in {}", table.display()),
                    "wait until it ends, or give another table",
                ));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Replaces the table by a text, on disk at once: there is the whole old one or the whole new
    /// one, whatever happens meanwhile, a full disk included.
    pub fn replace(&self, text: &str) -> anyhow::Result<()> {
        // What a link points to is replaced, and not the link.
        let table = self.table.canonicalize().unwrap_or_else(|_| self.table.clone());
        write_durably(&table, text.as_bytes())
            .with_context(|| format!("cannot write {}; it is as it was", table.display()))
    }
}

impl Drop for TableLock {
    fn drop(&mut self) {
        // Whoever finds it left over locks it all the same.
        drop(std::fs::remove_file(&self.lock));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_many_add_at_once_are_all_there() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("speed.csv");
        std::fs::write(&table, "header\n").unwrap();
        let add = |who: usize| {
            for row in 0..20 {
                let lock = TableLock::take(&table, Duration::from_secs(60)).unwrap();
                let text = std::fs::read_to_string(&table).unwrap();
                lock.replace(&format!("{text}{who},{row}\n")).unwrap();
            }
        };

        std::thread::scope(|scope| {
            for who in 0..4 {
                scope.spawn(move || add(who));
            }
        });

        let text = std::fs::read_to_string(&table).unwrap();
        assert_eq!(text.lines().count(), 1 + 4 * 20, "{text}");
        let left: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
        assert_eq!(left.len(), 1, "nothing is left beside the table");
    }

    #[test]
    fn a_table_that_another_one_fills_in_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("speed.csv");
        let first = TableLock::take(&table, Duration::ZERO).unwrap();

        let error = TableLock::take(&table, Duration::ZERO).unwrap_err().to_string();

        assert!(error.starts_with("another process is filling in"), "{error}");
        drop(first);
        assert!(TableLock::take(&table, Duration::ZERO).is_ok());
    }
}
