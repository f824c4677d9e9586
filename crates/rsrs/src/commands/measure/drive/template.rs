//! A table of detection trials that is filled in row by row, by robots that stand.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::trial::Neighbour;

use super::result::HEADERS;
use super::table_file::{self, TableLock};
use crate::failure::with_help;
use crate::files::read_text;
use crate::sensor_readings::Readings;

/// A table of detections, some rows of which are still without their count.
pub struct Template {
    path: PathBuf,
    lines: Vec<String>,
    /// No other process fills it in meanwhile.
    lock: TableLock,
}

/// A trial that is still to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Todo {
    /// Line of the table, from 1.
    pub line: usize,
    /// The robot that senses.
    pub robot: String,
    /// Where the other one stands; `None` if there is none.
    pub neighbour: Option<Neighbour>,
    /// Readings to take.
    pub samples: u64,
}

impl Template {
    /// Reads a table as `rsrs measure plan` makes it.
    ///
    /// # Errors
    ///
    /// If it cannot be read, has another header, or another process fills it in.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display();
        // Without a table there is nothing to lock.
        read_text(path)?;
        let lock = TableLock::take(path, table_file::PATIENCE)?;
        let text = read_text(path)?;
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let found = lines.first().map_or("", String::as_str);
        if found != HEADERS[2] {
            return Err(with_help(
                format!("{name}:1: the header is `{found}`, expected `{}`", HEADERS[2]),
                "`rsrs measure plan FLEET -o DIR` makes such a table: DIR/detection.csv",
            ));
        }
        Ok(Self { path: path.to_owned(), lines, lock })
    }

    /// The rows without a count, in their order.
    ///
    /// # Errors
    ///
    /// If a row does not say what to do, with its line.
    pub fn todo(&self) -> anyhow::Result<Vec<Todo>> {
        let rows = self.lines.iter().enumerate().skip(1);
        rows.filter(|(_, row)| !row.trim().is_empty())
            .filter_map(|(index, row)| self.row(index + 1, row).transpose())
            .collect()
    }

    /// What one row asks for; `None` if it is filled in.
    fn row(&self, line: usize, row: &str) -> anyhow::Result<Option<Todo>> {
        let place = format!("{}:{line}", self.path.display());
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let [robot, distance_m, bearing_rad, samples, detections] = fields[..] else {
            bail!("{place}: the row has {} fields, expected 5", fields.len());
        };
        if !detections.is_empty() {
            return Ok(None);
        }
        let number = |column: &str, field: &str| {
            field.parse::<f64>().ok().filter(|number| number.is_finite()).with_context(|| {
                format!("{place}: {column} is `{field}`, expected a number such as 0.3")
            })
        };
        let neighbour = match (distance_m, bearing_rad) {
            ("", "") => None,
            _ => Some(Neighbour {
                distance_m: number("distance_m", distance_m)?,
                bearing_rad: number("bearing_rad", bearing_rad)?,
            }),
        };
        let samples = samples.parse().ok().filter(|samples| *samples > 0);
        let samples = samples.with_context(|| {
            format!("{place}: samples is `{}`, expected a whole number above 0", fields[3])
        })?;
        Ok(Some(Todo { line, robot: robot.to_owned(), neighbour, samples }))
    }

    /// Fills in a row, on disk at once: what was counted is kept whatever comes next.
    ///
    /// # Errors
    ///
    /// If the table cannot be written.
    pub fn fill(&mut self, todo: &Todo, found: Readings) -> anyhow::Result<()> {
        let row = &mut self.lines[todo.line - 1];
        let kept: Vec<&str> = row.split(',').take(3).collect();
        *row = format!("{},{},{}", kept.join(","), found.samples, found.detections);
        let text = self.lines.join("\n") + "\n";
        let row = &self.lines[todo.line - 1];
        self.lock.replace(&text).with_context(|| format!("this row is not in the table: `{row}`"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn template(rows: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("detection.csv");
        std::fs::write(&path, format!("{}\n{rows}", HEADERS[2])).unwrap();
        (folder, path)
    }

    #[test]
    fn rows_without_a_count_are_still_to_be_made() {
        let (_folder, path) = template("a,0.3,-0.2,70,\na,0.4,0,70,12\n\nb,,,300,\n");

        let todo = Template::open(&path).unwrap().todo().unwrap();

        let near = Neighbour { distance_m: 0.3, bearing_rad: -0.2 };
        let expected = [
            Todo { line: 2, robot: "a".to_owned(), neighbour: Some(near), samples: 70 },
            Todo { line: 5, robot: "b".to_owned(), neighbour: None, samples: 300 },
        ];
        assert_eq!(todo, expected);
    }

    #[test]
    fn a_count_fills_its_row_and_no_other() {
        let (_folder, path) = template("a,0.3,-0.2,70,\na,0.4,0,70,12\nb,,,300,\n");
        let mut template = Template::open(&path).unwrap();
        let todo = template.todo().unwrap();

        template.fill(&todo[1], Readings { samples: 299, detections: 21 }).unwrap();
        drop(template);

        let text = std::fs::read_to_string(&path).unwrap();
        let rows = "a,0.3,-0.2,70,\na,0.4,0,70,12\nb,,,299,21\n";
        assert_eq!(text, format!("{}\n{rows}", HEADERS[2]));
        assert_eq!(Template::open(&path).unwrap().todo().unwrap(), todo[..1]);
    }

    #[test]
    fn rows_that_say_nothing_clear_are_refused_with_their_line() {
        for (row, expected) in [
            ("a,0.3,70,", "detection.csv:2: the row has 4 fields, expected 5"),
            ("a,near,0,70,", "detection.csv:2: distance_m is `near`, expected a number"),
            ("a,0.3,,70,", "detection.csv:2: bearing_rad is ``, expected a number"),
            ("a,0.3,NaN,70,", "detection.csv:2: bearing_rad is `NaN`, expected a number"),
            ("a,0.3,0,0,", "detection.csv:2: samples is `0`, expected a whole number above 0"),
        ] {
            let (_folder, path) = template(row);

            let error = Template::open(&path).unwrap().todo().unwrap_err().to_string();

            assert!(error.contains(expected), "{error}");
        }
    }
}
