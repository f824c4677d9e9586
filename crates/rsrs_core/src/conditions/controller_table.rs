//! A controller as a table: what a person writes in a file, and what it comes to on a robot.

mod check;
mod value;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::source::{InFile, Source};
use crate::quantity::{Axis, Number};
use crate::robot::controller::state_machine::{Row, StateMachine, Transition};
use crate::robot::controller::{Command, Controller};
use crate::robot::sensor::ReadingNames;
use crate::robot::wheels::Wheels;

pub use check::{Place, TableError, TableFlaw, TableProblem};
pub use value::{Next, Value};

/// A controller's table: rows in order, of which the first that matches counts.
///
/// It is a probabilistic finite-state machine over what a robot detects. With one state and constant commands it
/// is two commands over one detection, [`crate::robot::controller::ControllerParameters`].
///
/// # Example
///
/// ```
/// use rsrs_core::conditions::controller_table::ControllerTable;
/// # use rsrs_core::robot::profile::RobotProfile;
/// # const FLOCKBOT: &str = include_str!("../../../../launch_configs/profiles/flockbot.yaml");
/// # let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT)?;
///
/// let text = "
/// numbers: {turn_rad_s: {value: 0.75, from: 0.1, to: 2.5}}
/// rows:
///   - {when: {detection: true}, command: {speed_m_s: 0.15, turn_rate_rad_s: $turn_rad_s}}
///   - {command: {speed_m_s: 0.15, turn_rate_rad_s: -$turn_rad_s}}
/// ";
/// let table = ControllerTable::parse("mirrored.yaml", text, &profile)?;
/// let controller = table.resolve(&[], None, 0.13)?;
/// assert_eq!(controller.parameters().map(|it| it.turn_rate_rad_s), Some(0.75));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerTable {
    /// Numbers that rows have as `$NAME`, and sweeps as the axis `controller.NAME`. A name ends with its unit: `_m_s`,
    /// `_rad_s`, `_s`, or nothing for a probability.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, NamedNumber>,
    /// The rows; the state of the first one is the start.
    pub rows: Vec<TableRow>,
    /// The states in which robots of classes start instead, by class: so each class has a controller of its own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub starts: BTreeMap<String, String>,
}

/// A named number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedNumber {
    /// Its value where nobody sets another.
    pub value: f64,
    /// The least that it may be set to.
    pub from: f64,
    /// The greatest that it may be set to.
    pub to: f64,
}

/// What a robot does in a state for what it detects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableRow {
    /// The state (default: `start`).
    #[serde(default = "start")]
    pub state: String,
    /// What sensors must report, as `detection: true`; one that is left out may report anything.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub when: BTreeMap<String, bool>,
    /// The command for this control period.
    pub command: TableCommand,
    /// Where the robot goes after this period: the first that happens; without it, it stays.
    #[serde(default, skip_serializing_if = "Next::is_empty")]
    pub next: Next,
}

/// What robots of a sweep or an experiment decide by.
pub type ControllerSource = Source<ControllerTable>;

impl InFile for ControllerTable {
    const WHAT: &'static str = "controller";
    const SOURCE: &'static str = "ControllerSource";
}

fn start() -> String {
    "start".to_owned()
}

/// A command: of the robot, or of its two wheels. Each is a number, `$NAME` or `-$NAME`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableCommand {
    /// Forward speed, in metres per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<Value>,
    /// Turning rate, in radians per second; left is positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_rate_rad_s: Option<Value>,
    /// Speed of the left wheel over the floor, in metres per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_m_s: Option<Value>,
    /// Speed of the right wheel over the floor, in metres per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_m_s: Option<Value>,
}

/// A way out of a state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableTransition {
    /// Where to.
    pub state: String,
    /// How likely it happens after each period in which none before it in the list did (default: 1).
    #[serde(default = "always", skip_serializing_if = "Value::is_one")]
    pub probability: Value,
    /// It cannot happen sooner after the state was entered, in seconds, rounded up to whole control periods (default: 0).
    #[serde(default, skip_serializing_if = "Value::is_zero")]
    pub after_s: Value,
}

fn always() -> Value {
    Value::Number(1.0)
}

impl ControllerTable {
    /// Its numbers as axes of a sweep.
    pub fn axes(&self) -> impl Iterator<Item = Axis> + '_ {
        self.numbers.keys().filter_map(|name| Number::new(name)).map(Axis::Number)
    }

    /// The number of an axis; `None` if it is not one of this table.
    pub fn number(&self, axis: Axis) -> Option<NamedNumber> {
        let Axis::Number(number) = axis else { return None };
        self.numbers.get(number.name()).copied()
    }

    /// What the table comes to, with these numbers, on a robot with these wheels and this control period, whose
    /// one reading is `detection` ([`Controller::for_robots_with`] for others). A row that commands wheels is
    /// refused for a robot without.
    ///
    /// # Panics
    ///
    /// If the table was not checked.
    pub fn resolve(
        &self,
        numbers: &[(Number, f64)],
        wheels: Option<Wheels>,
        period_s: f64,
    ) -> Result<Controller, TableFlaw> {
        let machine = self.machine(numbers, wheels, period_s)?;
        let parameters = machine.as_parameters();
        Ok(parameters.map_or(Controller::Machine(machine), Controller::Parameters))
    }

    /// The same, always as a machine.
    fn machine(
        &self,
        numbers: &[(Number, f64)],
        wheels: Option<Wheels>,
        period_s: f64,
    ) -> Result<StateMachine, TableFlaw> {
        let mut values: BTreeMap<String, f64> =
            self.numbers.iter().map(|(name, number)| (name.clone(), number.value)).collect();
        values.extend(numbers.iter().map(|(number, value)| (number.name().to_owned(), *value)));
        let at = |value: &Value| value.at(&values);
        let transition = |next: &TableTransition| Transition {
            state: next.state.clone(),
            probability: at(&next.probability),
            after_periods: periods(at(&next.after_s), period_s),
        };
        let row = |(place, row): (usize, &TableRow)| {
            let TableCommand { speed_m_s, turn_rate_rad_s, left_m_s, right_m_s } = &row.command;
            let command = match (speed_m_s, turn_rate_rad_s, left_m_s, right_m_s) {
                (Some(speed), Some(turn), None, None) => {
                    Command { speed_m_s: at(speed), turn_rate_rad_s: at(turn) }
                }
                (None, None, Some(left), Some(right)) => wheels
                    .ok_or(TableFlaw { place: Place::Row(place), problem: TableProblem::NoWheels })?
                    .command(at(left), at(right)),
                _ => unreachable!("commands of a checked table are of one kind"),
            };
            let next = row.next.0.iter().map(transition).collect();
            Ok(Row { state: row.state.clone(), when: row.when.clone(), command, next })
        };
        let rows = self.rows.iter().enumerate().map(row).collect::<Result<_, TableFlaw>>()?;
        let starts = self.starts.clone();
        Ok(StateMachine { rows, numbers: values, starts, sensors: ReadingNames::default() })
    }
}

/// A time in whole periods, rounded up; a rounding error is no period.
fn periods(after_s: f64, period_s: f64) -> u32 {
    (after_s / period_s - 1e-9).ceil().max(0.0) as u32
}
