//! Tables of trials that are filled in row by row.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::trials::trial::{
    Neighbour, SETTLING_TIME_S, TableLines, Trial, TrialBackend, TrialKind, TrialProblem,
};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::read_text;

use super::table_file::{self, TableLock};

/// A drive is at least this long, in seconds: with a usual control period, long enough for a gain.
const SHORTEST_S: f64 = 3.2;

/// The kind of a trial.
pub fn kind_of(trial: &Trial) -> TrialKind {
    let command = trial.command();
    match (trial, command.speed_m_s > 0.0, command.turn_rate_rad_s > 0.0) {
        (Trial::Stand { .. }, ..) => TrialKind::Detection,
        (Trial::Drive { .. }, true, false) => TrialKind::Speed,
        (Trial::Drive { .. }, true, true) => TrialKind::Arc,
        (Trial::Drive { .. }, false, _) => TrialKind::Turn,
    }
}

/// A table of trials, some rows of which are still without their result.
pub struct TrialTable {
    path: PathBuf,
    kind: TrialKind,
    lines: TableLines,
    /// No other process fills it in meanwhile.
    lock: TableLock,
}

/// A trial that is still to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Todo {
    /// Line of the table, from 1.
    pub line: usize,
    /// The robot that is measured.
    pub robot: String,
    /// What it does.
    pub trial: Trial,
}

/// How far a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowState {
    /// Its trial is still to be made.
    Open,
    /// It has its result, with what moved the robot where that is stated.
    Done(Option<TrialBackend>),
}

impl TrialTable {
    /// Reads a table as `rsrs measure plan` makes it, and refuses it while another process fills it
    /// in.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        // Without a table there is nothing to lock.
        read_text(path)?;
        let lock = TableLock::take(path, table_file::TIMEOUT)?;
        let text = read_text(path)?;
        Self::of_text(path, &text, lock)
    }

    /// Reads a table for one more row; one that is not there is empty.
    pub fn open_for(path: &Path, kind: TrialKind) -> anyhow::Result<Self> {
        let lock = TableLock::take(path, table_file::TIMEOUT)?;
        if !path.exists() {
            let lines = TableLines::empty(kind);
            return Ok(Self { path: path.to_owned(), kind, lines, lock });
        }
        let table = Self::of_text(path, &read_text(path)?, lock)?;
        if table.kind != kind {
            bail!(
                "{}: the header is `{}`, expected `{}`",
                path.display(),
                table.lines.line(1),
                kind.header()
            );
        }
        Ok(table)
    }

    fn of_text(path: &Path, text: &str, lock: TableLock) -> anyhow::Result<Self> {
        let mut lines = TableLines::parse(text);
        let known = |kind| Some((kind, lines.n_missing(kind)?));
        let Some((kind, n_missing)) = TrialKind::MADE.into_iter().find_map(known) else {
            let headers = TrialKind::MADE.map(TrialKind::header);
            return Err(with_help(
                format!(
                    "{}:1: the header is `{}`, expected one of\n  {}",
                    path.display(),
                    lines.line(1),
                    headers.join("\n  ")
                ),
                "`rsrs measure plan FLEET -o DIR` makes such tables",
            ));
        };
        lines.add_columns(kind, n_missing);
        Ok(Self { path: path.to_owned(), kind, lines, lock })
    }

    /// What its rows are.
    pub fn kind(&self) -> TrialKind {
        self.kind
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The rows without a result, and those in which commands paused, in their order.
    pub fn todo(&self) -> anyhow::Result<Vec<Todo>> {
        let open = self.rows()?.into_iter().filter(|(_, row)| *row == RowState::Open);
        Ok(open.map(|(todo, _)| todo).collect())
    }

    /// Refuses to add trials of the simulator to those of robots, or the other way round, with the
    /// line of the first row that does not match.
    pub fn check_mixture(&self, adds: TrialBackend) -> anyhow::Result<()> {
        let rows = self.rows()?;
        let is_other = |state: RowState| match (state, adds) {
            (RowState::Open, _) => false,
            (RowState::Done(found), TrialBackend::Simulator) => found != Some(adds),
            (RowState::Done(found), TrialBackend::Fleet) => found == Some(TrialBackend::Simulator),
        };
        let Some((Todo { line, .. }, _)) = rows.iter().find(|(_, state)| is_other(*state)) else {
            return Ok(());
        };
        let (found, adds) = match adds {
            TrialBackend::Simulator => ("of a robot, or made by hand", "the simulator"),
            TrialBackend::Fleet => ("of the simulator", "a robot"),
        };
        Err(with_help(
            format!(
                "{}:{line} is a trial {found}, expected one of {adds} as those that are to be added",
                self.path.display()
            ),
            "a profile of both describes neither: take another table, or another plan of `rsrs measure \
             plan`",
        ))
    }

    /// All trials of the table, and how far each is.
    pub fn rows(&self) -> anyhow::Result<Vec<(Todo, RowState)>> {
        self.lines.rows().map(|line| self.row(line)).collect()
    }

    /// What one row asks for, and how far it is.
    fn row(&self, line: usize) -> anyhow::Result<(Todo, RowState)> {
        let place = format!("{}:{line}", self.path.display());
        let open_quote = || format!("{place}: {}", TrialProblem::OpenQuote);
        let fields = self.lines.fields(line).with_context(open_quote)?;
        let expected = self.kind.columns().count();
        if fields.len() != expected {
            bail!("{place}: the row has {} fields, expected {expected}", fields.len());
        }
        let fields = Fields { kind: self.kind, place: &place, texts: fields };
        let robot = fields.at(0).to_owned();
        let (trial, is_done) = match self.kind {
            TrialKind::Detection => (fields.stand()?, !fields.at(4).is_empty()),
            kind => {
                // Length or angle is planned until the row is filled in, and measured then.
                let (command, duration) = match kind {
                    TrialKind::Speed => ([fields.number(1)?, 0.0], 3),
                    TrialKind::Turn => ([0.0, fields.number(1)?], 3),
                    _ => ([fields.number(1)?, fields.number(2)?], 4),
                };
                let is_done = !fields.at(duration).is_empty() && fields.paused().is_empty();
                let [speed_m_s, turn_rate_rad_s] = command;
                let command = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s);
                let rate = if kind == TrialKind::Speed { speed_m_s } else { turn_rate_rad_s };
                let lasts_s = if fields.at(duration).is_empty() {
                    fields.number(duration - 1)? / rate
                } else {
                    fields.number(duration)?
                };
                let duration_s = (lasts_s + SETTLING_TIME_S).max(SHORTEST_S);
                // To a hundredth: the record of the run is read by people.
                let duration_s = (duration_s * 100.0).ceil() / 100.0;
                (Trial::Drive { command, duration_s }, is_done)
            }
        };
        let state = if is_done { RowState::Done(fields.backend()?) } else { RowState::Open };
        Ok((Todo { line, robot, trial }, state))
    }

    /// Fills in the fields behind those of the trial, on disk at once: what was measured is kept
    /// whatever comes next.
    pub fn fill(&mut self, todo: &Todo, found: &[String]) -> anyhow::Result<()> {
        let open_quote =
            || format!("{}:{}: {}", self.path.display(), todo.line, TrialProblem::OpenQuote);
        let row = self.lines.fields(todo.line).with_context(open_quote)?;
        // Readings that came may be fewer than were planned, so that their number is a result.
        let asked = row.into_iter().take(self.kind.n_asked());
        let fields: Vec<String> = asked.map(str::to_owned).chain(found.iter().cloned()).collect();
        self.lines.set(todo.line, &fields);
        self.write(todo.line)
    }

    /// Adds a row, on disk at once.
    pub fn append(&mut self, row: &[String]) -> anyhow::Result<()> {
        self.lines.push(row);
        self.write(self.lines.last())
    }

    fn write(&self, changed: usize) -> anyhow::Result<()> {
        let row = self.lines.line(changed);
        let lost = || format!("the row of this trial is not in the table: `{row}`");
        self.lock.replace(&self.lines.to_string()).with_context(lost)
    }
}

/// The fields of a row, with its place for errors.
struct Fields<'a> {
    kind: TrialKind,
    place: &'a str,
    texts: Vec<&'a str>,
}

impl Fields<'_> {
    fn at(&self, column: usize) -> &str {
        self.texts[column]
    }

    /// How long commands paused, in a table of drives.
    fn paused(&self) -> &str {
        self.texts[self.texts.len() - 2]
    }

    /// What moved the robot; `None` in a row that a person has filled in.
    fn backend(&self) -> anyhow::Result<Option<TrialBackend>> {
        let (found, place) = (self.texts[self.texts.len() - 1], self.place);
        if found.is_empty() {
            return Ok(None);
        }
        TrialBackend::from_key(found).map(Some).with_context(|| {
            format!("{place}: backend is `{found}`, expected `sim`, `fleet`, or nothing")
        })
    }

    fn number(&self, column: usize) -> anyhow::Result<f64> {
        let (field, place) = (self.texts[column], self.place);
        let name = self.kind.columns().nth(column).unwrap_or_default();
        field
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite())
            .with_context(|| format!("{place}: {name} is `{field}`, expected a number such as 0.3"))
    }

    fn stand(&self) -> anyhow::Result<Trial> {
        let is_alone = self.texts[1].is_empty() && self.texts[2].is_empty();
        let neighbour = if is_alone {
            None
        } else {
            let (distance_m, bearing_rad) = (self.number(1)?, self.number(2)?);
            Some(Neighbour { distance_m, bearing_rad })
        };
        let samples = self.texts[3].parse().ok().filter(|samples| *samples > 0);
        let samples = samples.with_context(|| {
            let (place, found) = (self.place, self.texts[3]);
            format!("{place}: samples is `{found}`, expected a whole number above 0")
        })?;
        Ok(Trial::Stand { neighbour, samples })
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::trials::trial::turn_trials;

    use super::*;

    fn table(kind: TrialKind, rows: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("{}.csv", kind.name()));
        std::fs::write(&path, format!("{}\n{rows}", kind.header())).unwrap();
        (folder, path)
    }

    fn stand(neighbour: Option<Neighbour>, samples: u64) -> Trial {
        Trial::Stand { neighbour, samples }
    }

    #[test]
    fn rows_without_a_count_are_still_to_be_made() {
        let rows = "a,0.3,-0.2,70,,\na,0.4,0,70,12,\n\nb,,,300,,\n";
        let (_folder, path) = table(TrialKind::Detection, rows);

        let todo = TrialTable::open(&path).unwrap().todo().unwrap();

        let near = Neighbour { distance_m: 0.3, bearing_rad: -0.2 };
        let expected = [
            Todo { line: 2, robot: "a".to_owned(), trial: stand(Some(near), 70) },
            Todo { line: 5, robot: "b".to_owned(), trial: stand(None, 300) },
        ];
        assert_eq!(todo, expected);
    }

    #[test]
    fn drives_without_a_time_and_those_that_paused_are_still_to_be_made() {
        let drive = |speed_m_s, turn_rate_rad_s, duration_s| Trial::Drive {
            command: ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s),
            duration_s,
        };
        for (kind, rows, expected) in [
            (
                TrialKind::Speed,
                "a,0.1,2,,,,,\na,0.1,1.9,20,,,,sim\na,0.1,1.5,20,0.1,0,0.445,sim\n",
                [(2, drive(0.1, 0.0, 20.5)), (4, drive(0.1, 0.0, 20.5))],
            ),
            (
                TrialKind::Turn,
                "a,0.5,6,,,\na,0.5,6,12.4,,\na,2,6.1,3.1,0.4,fleet\n",
                [(2, drive(0.0, 0.5, 12.5)), (4, drive(0.0, 2.0, 3.6))],
            ),
            (
                TrialKind::Arc,
                "a,0.1,4,2,,,\na,0.1,0.5,6,12.4,,fleet\na,0.1,2,6.1,3.1,0.4,\n",
                [(2, drive(0.1, 4.0, 3.2)), (4, drive(0.1, 2.0, 3.6))],
            ),
        ] {
            let (_folder, path) = table(kind, rows);

            let todo = TrialTable::open(&path).unwrap().todo().unwrap();

            let found: Vec<(usize, Trial)> =
                todo.into_iter().map(|todo| (todo.line, todo.trial)).collect();
            assert_eq!(found, expected, "{kind:?}");
        }
    }

    #[test]
    fn a_result_fills_its_row_and_no_other() {
        let rows = "a,0.3,-0.2,70,,\na,0.4,0,70,12,\nb,,,300,,\n";
        let (_folder, path) = table(TrialKind::Detection, rows);
        let mut table = TrialTable::open(&path).unwrap();
        let todo = table.todo().unwrap();

        table.fill(&todo[1], &["299", "21", "fleet"].map(str::to_owned)).unwrap();
        drop(table);

        let text = std::fs::read_to_string(&path).unwrap();
        let rows = "a,0.3,-0.2,70,,\na,0.4,0,70,12,\nb,,,299,21,fleet\n";
        assert_eq!(text, format!("{}\n{rows}", TrialKind::Detection.header()));
        assert_eq!(TrialTable::open(&path).unwrap().todo().unwrap(), todo[..1]);
    }

    #[test]
    fn a_table_of_a_spreadsheet_is_filled_in_with_its_separators() {
        for (separator, mark) in [(";", "\u{feff}"), ("\t", "")] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("turn.csv");
            let rows = "robot,commanded_rad_s,angle_rad,duration_s\r\n\"a\",0.5,6,\r\n,,,\r\n";
            std::fs::write(&path, format!("{mark}{rows}").replace(',', separator)).unwrap();
            let mut table = TrialTable::open(&path).unwrap();
            let todo = table.todo().unwrap();

            table.fill(&todo[0], &["6.1", "12.4", "", "fleet"].map(str::to_owned)).unwrap();
            drop(table);

            assert_eq!((todo.len(), todo[0].line, todo[0].robot.as_str()), (1, 2, "a"));
            let text = std::fs::read_to_string(&path).unwrap();
            let expected = format!("{}\na,0.5,6.1,12.4,,fleet\n,,,\n", TrialKind::Turn.header());
            assert_eq!(text, expected.replace(',', separator));
            let table = TrialTable::open(&path).unwrap();
            assert_eq!(table.rows().unwrap()[0].1, RowState::Done(Some(TrialBackend::Fleet)));
            assert_eq!(turn_trials("turn.csv", &text).unwrap().rows.len(), 1);
        }
    }

    #[test]
    fn a_table_of_an_earlier_version_gets_the_columns_that_it_does_not_have() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn.csv");
        std::fs::write(&path, "robot,commanded_rad_s,angle_rad,duration_s\na,0.5,6,12\n").unwrap();

        let mut table = TrialTable::open_for(&path, TrialKind::Turn).unwrap();
        table.append(&["b", "0.5", "6", "12", "0.445", "sim"].map(str::to_owned)).unwrap();
        drop(table);

        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            format!("{}\na,0.5,6,12,,\nb,0.5,6,12,0.445,sim\n", TrialKind::Turn.header())
        );
        assert_eq!(TrialTable::open(&path).unwrap().todo().unwrap().len(), 1);
    }

    #[test]
    fn ambiguous_rows_are_refused_with_their_line() {
        for (kind, row, expected) in [
            (
                TrialKind::Detection,
                "a,0.3,70,,",
                "detection.csv:2: the row has 5 fields, expected 6",
            ),
            (
                TrialKind::Detection,
                "a,near,0,70,,",
                "csv:2: distance_m is `near`, expected a number",
            ),
            (TrialKind::Detection, "a,0.3,,70,,", "csv:2: bearing_rad is ``, expected a number"),
            (
                TrialKind::Detection,
                "a,0.3,NaN,70,,",
                "csv:2: bearing_rad is `NaN`, expected a number",
            ),
            (
                TrialKind::Detection,
                "a,0.3,0,0,,",
                "csv:2: samples is `0`, expected a whole number above",
            ),
            (TrialKind::Speed, "a,0.3,,,,,,", "speed.csv:2: distance_m is ``, expected a number"),
            (
                TrialKind::Turn,
                "a,fast,6,,,",
                "turn.csv:2: commanded_rad_s is `fast`, expected a number",
            ),
            (
                TrialKind::Turn,
                "a,0.5,6,12,,floor",
                "turn.csv:2: backend is `floor`, expected `sim`",
            ),
        ] {
            let (_folder, path) = table(kind, row);

            let error = TrialTable::open(&path).unwrap().todo().unwrap_err().to_string();

            assert!(error.contains(expected), "{error}");
        }
    }
}
