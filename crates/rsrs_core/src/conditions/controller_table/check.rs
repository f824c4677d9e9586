//! Whether a table is a controller, and one for these robots: each refusal with its line.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;

use super::{ControllerTable, NamedNumber, TableCommand, TableRow, Value};
use crate::conditions::limits::BeyondLimits;
use crate::document::file_error::FileError;
use crate::document::{self, did_you_mean, nearest};
use crate::help::Help;
use crate::numerals::rounded;
use crate::quantity::{Bounds, Number, NumberUnit};
use crate::robot::controller::state_machine::{Row, StateMachine, Transition};
use crate::robot::controller::structure::{Flaw, check_thoroughly, unknown_state};
use crate::robot::controller::{Command, Controller};
use crate::robot::profile::RobotProfile;
use crate::robot::sensor::ReadingNames;

/// Where in a table something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a row, from 0.
    Row(usize),
    /// At a named number.
    Number(String),
    /// At the start of a class.
    Start(String),
}

/// What is wrong with a table, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct TableFlaw {
    /// Where.
    pub place: Place,
    /// What.
    pub problem: TableProblem,
}

/// What is wrong with a table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableProblem {
    /// The rows are no machine.
    #[error(transparent)]
    Structure(#[from] Flaw),
    /// A named number that is not in the table.
    #[error("unknown number `${found}`{}", did_you_mean(nearest.as_deref()))]
    UnknownNumber {
        /// Its name.
        found: String,
        /// The named number closest in spelling.
        nearest: Option<String>,
    },
    /// A named number of another unit.
    #[error("`{key}` is `${name}`, which is {found}, expected {expected}")]
    Unit {
        /// What it was given for.
        key: &'static str,
        /// Its name.
        name: String,
        /// Its unit.
        found: NumberUnit,
        /// The unit of the key.
        expected: NumberUnit,
    },
    /// A number outside what it can mean.
    #[error("`{key}` is {found}, expected a number {bounds}")]
    OutOfRange {
        /// The key.
        key: String,
        /// The number, or what it may come to.
        found: String,
        /// What it may be.
        bounds: Bounds,
    },
    /// A named number without a unit that cannot be a probability.
    #[error(
        "`{name}` has no unit at its end, which makes it a probability, and `{key}` is {found}, which is not one"
    )]
    NoProbability {
        /// Its name.
        name: String,
        /// The key.
        key: &'static str,
        /// The number.
        found: f64,
    },
    /// A name that is none.
    #[error("`{0}` is no name of a number: expected small letters, digits and `_`, a letter first")]
    Name(String),
    /// A number that no row has.
    #[error("number `{0}` is in no row")]
    Unused(String),
    /// A command that is neither of a robot nor of its wheels.
    #[error(
        "`command` has {0}, expected `speed_m_s` and `turn_rate_rad_s`, or `left_m_s` and `right_m_s`"
    )]
    Command(String),
    /// Wheels are commanded, and nobody wrote down how far apart they are.
    #[error(
        "`left_m_s` and `right_m_s` are wheels, and the robots' profile has no `actuation.wheels`"
    )]
    NoWheels,
    /// A command that the robots must not be given.
    #[error(transparent)]
    Limits(BeyondLimits),
    /// Wheels that come to such a command.
    #[error("with wheels of {left_m_s} and {right_m_s} m/s, {source}")]
    WheelLimits {
        /// Speed of the left wheel, in metres per second.
        left_m_s: f64,
        /// Speed of the right wheel, in metres per second.
        right_m_s: f64,
        /// What they come to.
        source: BeyondLimits,
    },
}

/// Why a file is no controller.
pub type TableError = FileError<TableProblem>;

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row(place) => write!(out, "row {} of the controller", place + 1),
            Self::Number(name) => write!(out, "number `{name}` of the controller"),
            Self::Start(class) => write!(out, "start of class `{class}` of the controller"),
        }
    }
}

impl Help for TableProblem {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Structure(flaw) => return flaw.help(),
            Self::Limits(source) | Self::WheelLimits { source, .. } => return source.help(),
            Self::UnknownNumber { found, .. } => {
                format!("write it under `numbers`, as `{found}: {{value: 0.5, from: 0, to: 1}}`")
            }
            Self::Unit { expected, .. } => match expected {
                NumberUnit::None => "names of probabilities end with no unit".to_owned(),
                unit => format!("names of numbers in {unit} end with `{}`", unit.suffix()),
            },
            Self::NoProbability { name, .. } => {
                let speed = NumberUnit::MetresPerSecond.suffix();
                let others = [NumberUnit::RadiansPerSecond, NumberUnit::Seconds];
                let [turn, time] = others.map(NumberUnit::suffix);
                format!(
                    "call a speed `{name}{speed}`, a turning rate `{name}{turn}`, a time `{name}{time}`"
                )
            }
            Self::Unused(name) => format!("use it in a row as `${name}`, or leave it out"),
            Self::NoWheels => "add `wheels: {base_m: …, speed_max_m_s: …}` to `actuation` in the \
                               profile, or command `speed_m_s` and `turn_rate_rad_s`"
                .to_owned(),
            Self::OutOfRange { .. } | Self::Name { .. } | Self::Command { .. } => return None,
        })
    }
}

impl Help for Flaw {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Rows { .. } | Self::Sensors { .. } => return None,
            Self::NoRow { state, .. } => format!(
                "add a row with `state: {state}` and without `when` behind its others: it is for all that is left"
            ),
            Self::NeverMatches { .. } => {
                "put it before them, or leave it out: of the rows of a state the first that matches counts".to_owned()
            }
            Self::Unreachable(state) => {
                format!(
                    "let a row's `next` lead to `{state}`, or a class of robots start there, as in \
                     `starts: {{CLASS: {state}}}`, or leave its rows out"
                )
            }
            Self::UnknownState { found, .. } => {
                format!("a state is there once a row has it: `state: {found}`")
            }
            Self::UnknownSensor { known, .. } => format!("these robots report {known}"),
            Self::NoChance { .. } => "give it a `probability` above 0, or leave it out".to_owned(),
            Self::NeverHappens { .. } => {
                "put it before that one, or give that one a `probability` or `after_s`".to_owned()
            }
        })
    }
}

impl Help for TableFlaw {
    fn help(&self) -> Option<String> {
        self.problem.help()
    }
}

/// Where the parts of a table are in its file.
#[derive(Deserialize)]
struct Lines {
    #[serde(default)]
    numbers: BTreeMap<String, Spanned<NamedNumber>>,
    #[serde(default)]
    starts: BTreeMap<String, Spanned<IgnoredAny>>,
    rows: Vec<Spanned<TableRow>>,
}

impl ControllerTable {
    /// Reads a table for these robots; `file` is its name, for errors.
    pub fn parse(file: &str, text: &str, robot: &RobotProfile) -> Result<Self, TableError> {
        let table: Self = document::parse(file, text)?;
        let refuse = |flaw: TableFlaw| {
            let TableFlaw { place, problem } = flaw;
            FileError::flaw((file, text), problem, |lines: &Lines| {
                Some(match &place {
                    Place::Row(place) => lines.rows.get(*place)?.defined.line(),
                    Place::Number(name) => lines.numbers.get(name)?.defined.line(),
                    Place::Start(class) => lines.starts.get(class)?.defined.line(),
                })
            })
        };
        let check = table.check().and_then(|()| table.check_rows(&robot.reading_names()));
        check.and_then(|()| table.check_robot(robot)).map_err(refuse)?;
        Ok(table)
    }

    /// The table as a YAML document.
    pub fn to_yaml(&self) -> String {
        document::to_yaml(self)
    }

    /// Whether each part of the table can be; [`Self::check_rows`] says whether all together are a controller.
    pub fn check(&self) -> Result<(), TableFlaw> {
        for (name, number) in &self.numbers {
            let flaw = |problem| TableFlaw { place: Place::Number(name.clone()), problem };
            check_number(name, *number).map_err(flaw)?;
        }
        for (place, row) in self.rows.iter().enumerate() {
            let flaw = |problem| TableFlaw { place: Place::Row(place), problem };
            self.check_row(row).map_err(flaw)?;
        }
        for name in self.numbers.keys() {
            let is_it =
                |value: &Value| matches!(value, Value::Named { name: other, .. } if other == name);
            if !self.rows.iter().flat_map(values).any(|(_, _, value)| is_it(value)) {
                let problem = TableProblem::Unused(name.clone());
                return Err(TableFlaw { place: Place::Number(name.clone()), problem });
            }
        }
        Ok(())
    }

    /// Whether the rows are a controller of robots that report this.
    pub fn check_rows(&self, sensors: &ReadingNames) -> Result<(), TableFlaw> {
        let outline = StateMachine { sensors: sensors.clone(), ..self.outline() };
        let states = outline.states();
        let unknown = self.starts.iter().find(|(_, start)| !states.contains(&start.as_str()));
        if let Some((class, start)) = unknown {
            let problem = unknown_state(start, &states).into();
            return Err(TableFlaw { place: Place::Start(class.clone()), problem });
        }
        check_thoroughly(&outline)
            .map_err(|(place, flaw)| TableFlaw { place: Place::Row(place), problem: flaw.into() })
    }

    /// Whether the robots may be given its commands, with the values that its numbers have in the table.
    fn check_robot(&self, robot: &RobotProfile) -> Result<(), TableFlaw> {
        let machine = self.machine(&[], robot.actuation.wheels, robot.computation.period_s)?;
        if let Some(parameters) = machine.as_parameters() {
            let limits = robot.check_limits(&Controller::Parameters(parameters));
            if limits.is_ok() {
                return Ok(());
            }
        }
        let wheels_of = |row: &Row, written: &TableRow| {
            written.command.left_m_s.as_ref()?;
            Some(robot.actuation.wheels?.speeds_m_s(row.command))
        };
        for (place, (row, written)) in machine.rows.iter().zip(&self.rows).enumerate() {
            robot.check_command(row.command).map_err(|source| TableFlaw {
                place: Place::Row(place),
                problem: match wheels_of(row, written) {
                    Some(speeds) => {
                        let [left_m_s, right_m_s] = speeds.map(rounded);
                        TableProblem::WheelLimits { left_m_s, right_m_s, source }
                    }
                    None => TableProblem::Limits(source),
                },
            })?;
        }
        Ok(())
    }

    fn check_row(&self, row: &TableRow) -> Result<(), TableProblem> {
        let TableCommand { speed_m_s, turn_rate_rad_s, left_m_s, right_m_s } = &row.command;
        let has = [speed_m_s, turn_rate_rad_s, left_m_s, right_m_s].map(Option::is_some);
        if has != [true, true, false, false] && has != [false, false, true, true] {
            let keys = ["`speed_m_s`", "`turn_rate_rad_s`", "`left_m_s`", "`right_m_s`"];
            let found: Vec<&str> =
                keys.into_iter().zip(has).filter(|it| it.1).map(|it| it.0).collect();
            let found = if found.is_empty() { "nothing".to_owned() } else { found.join(", ") };
            return Err(TableProblem::Command(found));
        }
        values(row).into_iter().try_for_each(|(key, expected, value)| match value {
            Value::Number(found) => within(key, *found, expected.bounds()),
            Value::Named { name, .. } if !self.numbers.contains_key(name) => {
                let nearest = nearest(name, self.numbers.keys().map(String::as_str));
                let nearest = nearest.map(|name| format!("${name}"));
                Err(TableProblem::UnknownNumber { found: name.clone(), nearest })
            }
            Value::Named { name, is_negated } => {
                let found = NumberUnit::new(name);
                if found != expected {
                    let name = name.clone();
                    return Err(TableProblem::Unit { key, name, found, expected });
                }
                let number = self.numbers[name];
                let [from, to] =
                    [number.from, number.to].map(|end| if *is_negated { -end } else { end });
                let bounds = expected.bounds();
                if bounds.contains(from) && bounds.contains(to) {
                    return Ok(());
                }
                let found =
                    format!("{value}, which goes from {} to {}", rounded(from), rounded(to));
                Err(TableProblem::OutOfRange { key: key.to_owned(), found, bounds })
            }
        })
    }

    /// The rows without their numbers: what is named can happen, and need not.
    fn outline(&self) -> StateMachine {
        let number = |value: &Value, named: f64| match value {
            Value::Number(number) => *number,
            Value::Named { .. } => named,
        };
        let row = |row: &TableRow| Row {
            state: row.state.clone(),
            when: row.when.clone(),
            command: Command::STOP,
            next: (row.next.0.iter())
                .map(|next| Transition {
                    state: next.state.clone(),
                    probability: number(&next.probability, 0.5),
                    after_periods: if number(&next.after_s, 1.0) > 0.0 { 2 } else { 0 },
                })
                .collect(),
        };
        let rows = self.rows.iter().map(row).collect();
        let (numbers, starts) = (BTreeMap::new(), self.starts.clone());
        StateMachine { rows, numbers, starts, sensors: ReadingNames::default() }
    }
}

fn check_number(name: &str, number: NamedNumber) -> Result<(), TableProblem> {
    if Number::new(name).is_none() {
        return Err(TableProblem::Name(name.to_owned()));
    }
    let NamedNumber { value, from, to } = number;
    let unit = NumberUnit::new(name);
    let bounds = unit.bounds();
    if unit == NumberUnit::None {
        let numbers = [("from", from), ("to", to), ("value", value)];
        if let Some((key, found)) = numbers.into_iter().find(|(_, it)| !bounds.contains(*it)) {
            return Err(TableProblem::NoProbability { name: name.to_owned(), key, found });
        }
    }
    let of = |key| format!("{name}.{key}");
    within(&of("from"), from, bounds)?;
    within(&of("to"), to, Bounds { least: from, ..bounds })?;
    within(&of("value"), value, Bounds { least: from, most: to })
}

fn within(key: &str, found: f64, bounds: Bounds) -> Result<(), TableProblem> {
    if bounds.contains(found) {
        return Ok(());
    }
    let (key, found) = (key.to_owned(), found.to_string());
    Err(TableProblem::OutOfRange { key, found, bounds })
}

/// All numbers of a row, with their keys and units.
fn values(row: &TableRow) -> Vec<(&'static str, NumberUnit, &Value)> {
    let TableCommand { speed_m_s, turn_rate_rad_s, left_m_s, right_m_s } = &row.command;
    let command = [
        ("speed_m_s", NumberUnit::MetresPerSecond, speed_m_s),
        ("turn_rate_rad_s", NumberUnit::RadiansPerSecond, turn_rate_rad_s),
        ("left_m_s", NumberUnit::MetresPerSecond, left_m_s),
        ("right_m_s", NumberUnit::MetresPerSecond, right_m_s),
    ];
    let command =
        command.into_iter().filter_map(|(key, unit, value)| Some((key, unit, value.as_ref()?)));
    let next = row.next.0.iter().flat_map(|next| {
        [
            ("probability", NumberUnit::None, &next.probability),
            ("after_s", NumberUnit::Seconds, &next.after_s),
        ]
    });
    command.chain(next).collect()
}
