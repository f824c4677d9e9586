//! What a sweep or an experiment fixes besides the robots.

use super::controller_table::ControllerTable;
use super::error::ConditionsError;
use super::{Placement, Walls};
use crate::document::nearest;
use crate::judge::behaviour::Behaviour;
use crate::quantity::{Axis, Cell};
use crate::robot::harsher::{Harsher, HarsherFactors};
use crate::robot::profile::RobotProfile;
use crate::world::WorldFile;

/// What a sweep or an experiment fixes besides the robots: settings that belong to `E`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Values by axis; of an axis that occurs twice the later one counts.
    pub values: Vec<(Axis, f64)>,
    /// What happens at the arena's border.
    pub walls: Walls,
    /// Where the robots start, if not in a disc of the radius among the values.
    pub placement: Option<Placement>,
    /// What the swarm is judged for.
    pub behaviour: Behaviour,
    /// The table of its controller, which has been checked; `None` for speeds and turning rates among the values.
    pub controller: Option<ControllerTable>,
    /// What is in the arena besides the robots.
    pub world: WorldFile,
    /// What is done to the profiles of the world's classes.
    pub class_changes: ClassChanges,
}

/// What is done to the profiles of classes before their robots are simulated: what was done to that of the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClassChanges {
    /// Capabilities in the place of the measured ones.
    pub capabilities: Vec<(Axis, f64)>,
    /// How the robots are made worse then, factors that are not given as each profile needs them; `None` for robots as
    /// measured.
    pub harsher: Option<Harsher>,
}

impl Settings {
    /// Whether its axes are those of its controller.
    pub fn check_axes(&self) -> Result<(), ConditionsError> {
        let axes = self.values.iter().map(|(axis, _)| *axis);
        axes.into_iter().try_for_each(|axis| check_axis(axis, self.controller.as_ref()))
    }

    /// The settings with the values of a cell on top.
    #[must_use]
    pub fn with_cell(&self, cell: &Cell) -> Self {
        let mut settings = self.clone();
        settings.values.extend(cell.iter());
        settings
    }
}

impl ClassChanges {
    /// Robots made worse by these factors, as those of the profile `measured` are.
    pub fn as_of(measured: &RobotProfile, factors: HarsherFactors) -> Self {
        let harsher = Some(Harsher::from(factors).decided(measured));
        Self { capabilities: Vec::new(), harsher }
    }

    /// A profile with these changes, which may not make a better robot.
    pub fn simulated(&self, measured: &RobotProfile) -> Result<RobotProfile, ConditionsError> {
        let robot = measured.with_capabilities(&self.capabilities)?;
        let Some(harsher) = &self.harsher else { return Ok(robot) };
        let factors = HarsherFactors {
            // A cone that is turned becomes a polygon, which is no reason to make it smaller.
            polygon_scale: harsher.factors(measured).polygon_scale,
            ..harsher.factors(&robot)
        };
        Ok(factors.apply(&robot)?)
    }
}

/// Whether an axis is one of a sweep with this table, or with none.
pub fn check_axis(axis: Axis, table: Option<&ControllerTable>) -> Result<(), ConditionsError> {
    let numbers =
        |table: &ControllerTable| table.axes().map(|axis| axis.key().to_owned()).collect();
    match (axis, table) {
        (Axis::Number(_), None) => Err(ConditionsError::NoTable(axis)),
        (Axis::Number(number), Some(table)) if !table.numbers.contains_key(number.name()) => {
            let nearest = nearest(axis.key(), table.axes().map(Axis::key)).map(str::to_owned);
            Err(ConditionsError::NoSuchNumber { axis, nearest, numbers: numbers(table) })
        }
        (
            Axis::Speed | Axis::TurnRate | Axis::UndetectedSpeed | Axis::UndetectedTurnRate,
            Some(table),
        ) => Err(ConditionsError::BesideTable { axis, numbers: numbers(table) }),
        _ => Ok(()),
    }
}
