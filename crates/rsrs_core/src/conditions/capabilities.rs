//! A robot with other capabilities.

use super::resolve::ConditionsError;
use crate::quantity::{Axis, Bounds};
use crate::robot::profile::RobotProfile;

/// What changes the region of a sensor, in the order in which it does.
const OF_THE_REGION: [Axis; 4] =
    [Axis::PolygonScale, Axis::HalfAngle, Axis::Range, Axis::SensorBearing];

impl RobotProfile {
    /// The robot with other capabilities; of an axis that occurs twice the later value counts.
    ///
    /// The region of a sensor is scaled, opened, given its range and turned, in this order, whatever
    /// the order of the values. A cone that is turned becomes a polygon
    /// ([`crate::robot::shape::turned_cone`]).
    ///
    /// # Panics
    ///
    /// If an axis is a setting, as the speed is.
    pub fn with_capabilities(&self, values: &[(Axis, f64)]) -> Result<Self, ConditionsError> {
        let mut robot = self.clone();
        for (axis, value) in values {
            check_value(*axis, *value)?;
        }
        let others = values.iter().filter(|(axis, _)| !OF_THE_REGION.contains(axis));
        let of_the_region = OF_THE_REGION
            .iter()
            .filter_map(|wanted| values.iter().rev().find(|(axis, _)| axis == wanted));
        for (axis, value) in others.chain(of_the_region) {
            axis.set(&mut robot, *value)
                .map_err(|which| ConditionsError::NotOfThisRobot { axis: *axis, which })?;
        }
        robot.check()?;
        Ok(robot)
    }
}

/// Refuses a value outside what the axis can mean.
pub(super) fn check_value(axis: Axis, found: f64) -> Result<(), ConditionsError> {
    check_bounds(axis, found, axis.bounds())
}

/// Refuses a value outside bounds.
pub(super) fn check_bounds(axis: Axis, found: f64, bounds: Bounds) -> Result<(), ConditionsError> {
    let whole = !axis.is_count() || found.fract() == 0.0;
    if bounds.contains(found) && whole {
        return Ok(());
    }
    let kind = if axis.is_count() { "a whole number" } else { "a number" };
    Err(ConditionsError::OutOfRange { axis, found, expected: format!("{kind} {bounds}") })
}
