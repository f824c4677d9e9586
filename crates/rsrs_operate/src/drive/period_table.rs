//! The table of control periods of a plan, which every trial fills in besides.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::trials::plan::PERIOD_HEADER;
use rsrs_core::trials::trial::TrialBackend;
use rsrs_pipeline::files::read_text;

use super::table_file::{self, TableLock};

/// The last column; tables of earlier versions do not have it.
const BACKEND: &str = ",backend";

/// The table of control periods.
pub struct PeriodTable {
    path: PathBuf,
    lines: Vec<String>,
    lock: TableLock,
}

impl PeriodTable {
    /// Reads it as `rsrs measure plan` makes it, and refuses it while another process fills it in.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let lock = TableLock::take(path, table_file::TIMEOUT)?;
        let mut lines: Vec<String> = read_text(path)?.lines().map(str::to_owned).collect();
        let found = lines.first().map_or("", String::as_str);
        if Some(found) == PERIOD_HEADER.strip_suffix(BACKEND) {
            // A table of an earlier version.
            PERIOD_HEADER.clone_into(&mut lines[0]);
            lines.iter_mut().skip(1).filter(|line| !line.trim().is_empty()).for_each(|line| {
                line.push(',');
            });
        } else if found != PERIOD_HEADER {
            bail!("{}:1: the header is `{found}`, expected `{PERIOD_HEADER}`", path.display());
        }
        Ok(Self { path: path.to_owned(), lines, lock })
    }

    /// The mean of the periods that are filled in, in seconds.
    pub fn mean_s(&self) -> Option<f64> {
        let periods = self.lines.iter().skip(1).filter_map(|row| row.split(',').nth(1));
        let periods: Vec<f64> = periods.filter_map(|field| field.trim().parse().ok()).collect();
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
        let is_open = |row: &&mut String| {
            let mut fields = row.split(',').map(str::trim);
            fields.next() == Some(robot) && fields.next().is_some_and(str::is_empty)
        };
        let open = self.lines.iter_mut().filter(is_open);
        let mut n_filled = 0;
        for (row, period_s) in open.zip(periods_s) {
            *row = format!("{robot},{period_s:.6},{}", backend.key());
            n_filled += 1;
        }
        if n_filled == 0 {
            return Ok(());
        }
        let text = self.lines.join("\n") + "\n";
        self.lock.replace(&text).with_context(|| {
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
        assert_eq!(text, format!("{PERIOD_HEADER}\n{rows}"));
    }
}
