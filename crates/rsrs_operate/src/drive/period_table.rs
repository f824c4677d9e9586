//! The table of control periods of a plan, which every trial fills in besides.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::trials::trial::{TableLines, TrialBackend, TrialKind};
use rsrs_pipeline::files::read_text;

use super::table_file::{self, TableLock};

/// The table of control periods.
pub struct PeriodTable {
    path: PathBuf,
    lines: TableLines,
    lock: TableLock,
}

impl PeriodTable {
    /// Reads it as `rsrs measure plan` makes it, and refuses it while another process fills it in.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let lock = TableLock::take(path, table_file::TIMEOUT)?;
        let mut lines = TableLines::parse(&read_text(path)?);
        let kind = TrialKind::Period;
        let Some(n_missing) = lines.n_missing(kind) else {
            let (found, expected) = (lines.line(1), kind.header());
            bail!("{}:1: the header is `{found}`, expected `{expected}`", path.display());
        };
        lines.add_columns(kind, n_missing);
        Ok(Self { path: path.to_owned(), lines, lock })
    }

    /// The mean of the periods that are filled in, in seconds.
    pub fn mean_s(&self) -> Option<f64> {
        let rows = self.lines.rows().filter_map(|line| self.lines.fields(line));
        let periods: Vec<f64> = rows.filter_map(|row| row.get(1)?.parse().ok()).collect();
        let is_any = !periods.is_empty();
        is_any.then(|| periods.iter().sum::<f64>() / periods.len() as f64)
    }

    /// Fills in the rows of a robot that are still empty, on disk at once.
    pub fn fill(
        &mut self,
        robot: &str,
        periods_s: &[f64],
        backend: TrialBackend,
    ) -> anyhow::Result<()> {
        let is_open = |line: &usize| {
            let fields = self.lines.fields(*line).unwrap_or_default();
            fields.starts_with(&[robot, ""])
        };
        let open: Vec<usize> = self.lines.rows().filter(is_open).collect();
        let n_filled = open.len().min(periods_s.len());
        for (line, period_s) in open.into_iter().zip(periods_s) {
            let fields = [robot.to_owned(), format!("{period_s:.6}"), backend.key().to_owned()];
            self.lines.set(line, &fields);
        }
        if n_filled == 0 {
            return Ok(());
        }
        self.lock.replace(&self.lines.to_string()).with_context(|| {
            format!("{}: the periods of {robot} are not kept", self.path.display())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_fill_the_empty_rows_of_their_robot() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("period.csv");
        std::fs::write(&path, "robot,period_s\na,0.2\na,\na,\nb,\n").unwrap();
        let mut table = PeriodTable::open(&path).unwrap();

        table.fill("a", &[0.1, 0.3, 0.5], TrialBackend::Fleet).unwrap();

        assert!(table.mean_s().is_some_and(|mean_s| (mean_s - 0.2).abs() < 1e-9));
        let text = std::fs::read_to_string(&path).unwrap();
        let rows = "a,0.2,\na,0.100000,fleet\na,0.300000,fleet\nb,,\n";
        assert_eq!(text, format!("{}\n{rows}", TrialKind::Period.header()));
    }
}
