//! The kinds of tables of trials, in one table.

/// A kind of table of trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialKind {
    /// Straight runs.
    Speed,
    /// Turns in place.
    Turn,
    /// Turns while driving.
    Arc,
    /// Readings of robots that stand.
    Detection,
    /// Control periods.
    Period,
}

/// What is known of a kind.
struct Row {
    kind: TrialKind,
    file: &'static str,
    /// How many of the columns are of the trial; those behind them are of its result.
    n_asked: usize,
    required: &'static [&'static str],
    optional: &'static [&'static str],
}

/// The column of a trial in which commands paused: for how long, in seconds; empty if they did not.
pub(super) const PAUSED: &str = "paused_s";
/// The column of what moved the robot: `sim` or `fleet`; empty in what a person has filled in.
pub(super) const BACKEND: &str = "backend";

/// All kinds, in the order of [`TrialKind`].
const ROWS: [Row; 5] = [
    Row {
        kind: TrialKind::Speed,
        file: "speed.csv",
        n_asked: 2,
        required: &["robot", "commanded_m_s", "distance_m", "duration_s"],
        optional: &["lateral_m", "heading_change_rad", PAUSED, BACKEND],
    },
    Row {
        kind: TrialKind::Turn,
        file: "turn.csv",
        n_asked: 2,
        required: &["robot", "commanded_rad_s", "angle_rad", "duration_s"],
        optional: &[PAUSED, BACKEND],
    },
    Row {
        kind: TrialKind::Arc,
        file: "arcs.csv",
        n_asked: 3,
        required: &["robot", "commanded_m_s", "commanded_rad_s", "angle_rad", "duration_s"],
        optional: &[PAUSED, BACKEND],
    },
    Row {
        kind: TrialKind::Detection,
        file: "detection.csv",
        n_asked: 3,
        required: &["robot", "distance_m", "bearing_rad", "samples", "detections"],
        optional: &[BACKEND],
    },
    Row {
        kind: TrialKind::Period,
        file: "period.csv",
        n_asked: 1,
        required: &["robot", "period_s"],
        optional: &[BACKEND],
    },
];

impl TrialKind {
    /// Those that robots make, in the order in which they do; periods are measured besides.
    pub const MADE: [Self; 4] = [Self::Speed, Self::Turn, Self::Arc, Self::Detection];

    fn row(self) -> &'static Row {
        ROWS.iter().find(|row| row.kind == self).expect("each has a row")
    }

    /// Its table in the folder of a plan: `arcs.csv`.
    pub fn file(self) -> &'static str {
        self.row().file
    }

    /// The name of that table without its ending, which is also that of an option: `arcs`.
    pub fn name(self) -> &'static str {
        self.file().trim_end_matches(".csv")
    }

    /// Columns that are there in every table of this kind.
    pub fn required(self) -> &'static [&'static str] {
        self.row().required
    }

    /// Columns that may be there besides.
    pub fn optional(self) -> &'static [&'static str] {
        self.row().optional
    }

    /// All columns, in the order of a table that is to be filled in.
    pub fn columns(self) -> impl Iterator<Item = &'static str> {
        self.required().iter().chain(self.optional()).copied()
    }

    /// How many columns, from the first, are of the trial; those behind them are of its result.
    pub fn n_asked(self) -> usize {
        self.row().n_asked
    }

    /// The header of a table that is to be filled in.
    pub fn header(self) -> String {
        self.columns().collect::<Vec<_>>().join(",")
    }

    /// Whether robots drive in its trials, so that commands can pause.
    pub fn is_drive(self) -> bool {
        self.optional().contains(&PAUSED)
    }

    /// How many of the last columns a table to fill in does not have: none, or those that earlier versions did
    /// not know. `None` if the header is of no such table.
    pub fn n_missing(self, header: &[&str]) -> Option<usize> {
        let columns: Vec<&str> = self.columns().collect();
        let is_late = |column: &&&str| [PAUSED, BACKEND].contains(column);
        let n_late = columns.iter().rev().take_while(is_late).count();
        (0..=n_late).find(|n_missing| columns[..columns.len() - n_missing] == *header)
    }
}
