//! Why a table of trials was refused, and where.

use crate::help::Help;

/// Why a table of trials was refused, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}: {problem}")]
pub struct TrialError {
    /// Name of the table, as the user gave it.
    pub file: String,
    /// Line, from 1; the header's for problems of the whole table.
    pub line: u64,
    /// What is wrong.
    pub problem: TrialProblem,
}

/// What is wrong with a table of trials.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrialProblem {
    /// There is no header.
    #[error("the table is empty, expected the header `{}`", expected.join(","))]
    Empty {
        /// The columns of this kind of table.
        expected: Vec<String>,
    },
    /// A column that this kind of table needs.
    #[error(
        "no column `{column}` in the header `{header}`{}",
        nearest.as_ref().map(|name| format!("; is it `{name}`?")).unwrap_or_default()
    )]
    MissingColumn {
        /// The column.
        column: &'static str,
        /// The header found.
        header: String,
        /// The column found whose name is closest, if any is close.
        nearest: Option<String>,
    },
    /// A column that this kind of table does not have.
    #[error(
        "unknown column `{column}`{}",
        match nearest {
            Some(name) => format!("; did you mean `{name}`?"),
            None => format!("; expected {}", expected.join(",")),
        }
    )]
    UnknownColumn {
        /// The column found.
        column: String,
        /// The valid column whose name is closest, if any is close.
        nearest: Option<String>,
        /// All columns of this kind of table.
        expected: Vec<String>,
    },
    /// A column that occurs twice.
    #[error("column `{column}` occurs twice")]
    ColumnTwice {
        /// The column.
        column: String,
    },
    /// There is a header and nothing below it.
    #[error("the table has a header and no rows")]
    NoRows,
    /// A row of another width than the header.
    #[error(
        "the row has {found} fields, expected {expected} as in the header{}",
        if found > expected { "; are there decimal commas? numbers have a decimal point" } else { "" }
    )]
    Fields {
        /// Fields of the header.
        expected: usize,
        /// Fields found.
        found: usize,
    },
    /// A quote that is opened and not closed in its line.
    #[error("a quote is opened and not closed in this line")]
    OpenQuote,
    /// A field that must not be empty.
    #[error("{column} is empty, expected {expected}")]
    EmptyField {
        /// The column.
        column: &'static str,
        /// What it may be.
        expected: &'static str,
    },
    /// A field that is not a number.
    #[error(
        "{column} is `{found}`, expected a number{}",
        if *decimal_comma { " with a decimal point, not a comma" } else { "" }
    )]
    NotANumber {
        /// The column.
        column: &'static str,
        /// The field.
        found: String,
        /// Whether a point for its comma would make it one.
        decimal_comma: bool,
    },
    /// A word that names nothing that moves robots.
    #[error("backend is `{found}`, expected `sim`, `fleet`, or nothing for a trial made by hand")]
    NoBackend {
        /// The field.
        found: String,
    },
    /// A number that is infinite or none.
    #[error("{column} is {found}, expected a finite number")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// The field.
        found: String,
    },
    /// A number outside what it can mean.
    #[error("{column} is {found}, expected {expected}")]
    OutOfRange {
        /// The column.
        column: &'static str,
        /// The number.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A number that is likely in another unit.
    #[error("{column} is {found}: this looks like {likely}, expected {expected}")]
    Unit {
        /// The column.
        column: &'static str,
        /// The number.
        found: f64,
        /// The unit that it is likely in.
        likely: &'static str,
        /// The unit that it must be in.
        expected: &'static str,
    },
    /// Two samples of one trajectory at the same time.
    #[error("trial `{trial}` of {robot} has two samples at {time_s} s")]
    TimeTwice {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
        /// The time, in seconds.
        time_s: f64,
    },
    /// A trajectory of one sample.
    #[error("trial `{trial}` of {robot} has one sample, expected 2 or more")]
    OneSample {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
    },
    /// One coordinate of the place of an object.
    #[error("{column} is not there, and the other coordinate of the object is")]
    HalfPlace {
        /// The column.
        column: &'static str,
    },
    /// A trajectory of which an object is known in some rows only.
    #[error("trial `{trial}` of {robot} has an object in some of its rows only")]
    ObjectAtTimes {
        /// The robot.
        robot: String,
        /// The trial.
        trial: String,
    },
}

impl Help for TrialError {
    fn help(&self) -> Option<String> {
        match &self.problem {
            TrialProblem::Unit { expected, likely, .. } => {
                Some(format!("convert the column from {likely} to {expected}"))
            }
            TrialProblem::EmptyField { .. } => Some(
                "delete the rows of trials that were not run, or have them made: `rsrs measure drive \
                 FLEET --plan DIR`; `rsrs measure plan` writes the rest"
                    .to_owned(),
            ),
            TrialProblem::HalfPlace { .. } => {
                Some("give `object_x_m` and `object_y_m`, or neither".to_owned())
            }
            TrialProblem::ObjectAtTimes { .. } => Some(
                "give the place of the object in every row, or two trials: without it, and with it".to_owned(),
            ),
            TrialProblem::Empty { .. } | TrialProblem::NoRows => {
                Some("`rsrs measure plan` writes tables to fill in".to_owned())
            }
            _ => None,
        }
    }
}

/// The unit of a column, by its name.
pub(super) fn unit_of(column: &str) -> &'static str {
    for (ending, unit) in [
        ("_rad_s", "rad/s"),
        ("_m_s", "m/s"),
        ("_rad", "radians"),
        ("_m", "metres"),
        ("_s", "seconds"),
    ] {
        if column.ends_with(ending) {
            return unit;
        }
    }
    "a number without unit"
}
