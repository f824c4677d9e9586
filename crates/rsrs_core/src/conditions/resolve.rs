//! From a profile and settings to conditions.

use std::collections::BTreeMap;

use super::controller_table::{ControllerTable, NamedNumber};
use super::error::ConditionsError;
use super::settings::Settings;
use super::{Arena, Conditions, GainDistribution, Placement, SimulatedRobot, SimulatedSensor};
use crate::quantity::{Axis, Bounds, Number};
use crate::robot::controller::{Command, Controller, ControllerParameters};
use crate::robot::profile::RobotProfile;
use crate::robot::sensor::DETECTION;

impl Conditions {
    /// Resolves a simulated robot, as measured or made harsher, and settings to numbers.
    ///
    /// Precedence is profile, then harsher (already in `robot`), then the settings in order: at
    /// least speed, turning rate and number of robots. Gain means are read at the commanded speed
    /// and turning rate.
    pub fn resolve(robot: &RobotProfile, settings: &Settings) -> Result<Self, ConditionsError> {
        settings.check_axes()?;
        let mut operator = BTreeMap::new();
        let (mut numbers, mut capabilities) = (Vec::new(), Vec::new());
        for (axis, value) in &settings.values {
            check_value(*axis, *value)?;
            if let Axis::Number(number) = axis {
                numbers.push((*number, *value));
            } else if axis.is_capability() {
                capabilities.push((*axis, *value));
            } else {
                operator.insert(*axis, *value);
            }
        }
        let robot = robot.with_capabilities(&capabilities)?;
        let set = |axis| operator.get(&axis).copied();
        let required = |axis| set(axis).ok_or(ConditionsError::Missing(axis));
        let controller = if let Some(table) = &settings.controller {
            table.check_values(&numbers)?;
            let (wheels, period_s) = (robot.actuation.wheels, robot.computation.period_s);
            table.resolve(&numbers, wheels, period_s)?.for_robots_with(robot.reading_names())
        } else {
            let detected = Command {
                speed_m_s: required(Axis::Speed)?,
                turn_rate_rad_s: required(Axis::TurnRate)?,
            };
            commands(detected, [Axis::UndetectedSpeed, Axis::UndetectedTurnRate].map(set))?.into()
        };
        if let (Some(side_m), Some(arena)) = (set(Axis::Arena), &settings.world.arena) {
            return Err(ConditionsError::ArenaTwice { side_m, arena: arena.in_words() });
        }
        let simulated = simulated_robot(&robot, &controller);
        let default_radius_m = PLACEMENT_OVER_RANGE * simulated.region.range_m();
        let mut conditions = Self {
            robots: required(Axis::Robots)? as usize,
            controller,
            behaviour: settings.behaviour,
            placement: settings.placement.clone().unwrap_or(Placement::DiscFacingOut {
                radius_m: set(Axis::PlacementRadius).unwrap_or(default_radius_m),
            }),
            arena: Arena {
                side_m: settings.world.side_m().or(set(Axis::Arena)).unwrap_or(ARENA_M),
                walls: settings.walls,
            },
            world: settings.world.clone(),
            robot: simulated,
            own_robots: BTreeMap::new(),
            period_s: robot.computation.period_s,
        };
        conditions.check()?;
        if conditions.world.classes.iter().any(|class| class.profile.is_some()) {
            conditions.put_classes(settings)?;
            conditions.check()?;
        }
        Ok(conditions)
    }
}

impl ControllerTable {
    /// Refuses values outside the bounds of its numbers.
    pub fn check_values(&self, values: &[(Number, f64)]) -> Result<(), ConditionsError> {
        values.iter().try_for_each(|(number, found)| match self.numbers.get(number.name()) {
            Some(NamedNumber { from, to, .. }) if !(*from..=*to).contains(found) => {
                let expected =
                    format!("a number from {from} to {to}, its bounds in the controller");
                Err(ConditionsError::OutOfRange {
                    axis: Axis::Number(*number),
                    found: *found,
                    expected,
                })
            }
            _ => Ok(()),
        })
    }
}

/// Robots start in a circle "slightly larger than their maximum vision distance" (§IV step 3).
pub const PLACEMENT_OVER_RANGE: f64 = 1.1;

/// Side of the arena where none is given, in metres: large enough never to be reached in a run.
pub const ARENA_M: f64 = 15.0;

/// The controller with this command where something is detected: mirrored, unless another speed or turning rate is
/// set where nothing is.
fn commands(
    detected: Command,
    undetected: [Option<f64>; 2],
) -> Result<ControllerParameters, ConditionsError> {
    let Command { speed_m_s, turn_rate_rad_s } = detected;
    if undetected == [None; 2] {
        check_bounds(Axis::Speed, speed_m_s, Bounds::AMOUNT)?;
        check_bounds(Axis::TurnRate, turn_rate_rad_s, Bounds::AMOUNT)?;
    }
    let undetected = Command {
        speed_m_s: undetected[0].unwrap_or(speed_m_s),
        turn_rate_rad_s: undetected[1].unwrap_or(-turn_rate_rad_s),
    };
    Ok(ControllerParameters::new(detected, undetected))
}

pub(super) fn simulated_robot(robot: &RobotProfile, controller: &Controller) -> SimulatedRobot {
    let (speed, turn) = (&robot.actuation.speed, &robot.actuation.turn);
    // One gain serves all commands: that of the fastest, which moves the robot most.
    let Command { speed_m_s, turn_rate_rad_s } = controller.fastest();
    let first = SimulatedSensor::new(DETECTION, &robot.sensing);
    SimulatedRobot {
        radius_m: robot.body.radius_m,
        front_half_angle_rad: robot.body.front_half_angle_rad,
        rotates_while_blocked: robot.body.rotates_while_blocked,
        contact: robot.body.contact,
        contact_friction: robot.body.contact_friction.unwrap_or_default(),
        speed_gain: GainDistribution {
            mean: speed.gain_at(speed_m_s).mean,
            robot_sd: speed.robot_sd,
            step_sd: speed.step_sd,
        },
        turn_gain: GainDistribution {
            mean: turn.gain_at(turn_rate_rad_s, speed_m_s).mean,
            robot_sd: turn.robot_sd,
            step_sd: turn.step_sd,
        },
        turn_bias_sd_rad_s: turn.bias_sd_rad_s,
        heading_noise_sd_rad: turn.heading_noise_sd_rad,
        gust_sd_m_s: robot.actuation.gust.sd_m_s,
        gust_time_constant_s: robot.actuation.gust.time_constant_s,
        yaw_lag_s: robot.actuation.yaw_lag_s,
        sees: first.sees,
        region: first.region,
        true_positive: first.true_positive,
        false_positive: first.false_positive,
        latency_steps: first.latency_steps,
        details: first.details,
        further_sensors: (robot.further_sensors.iter())
            .map(|sensor| SimulatedSensor::new(&sensor.name, &sensor.sensing))
            .collect(),
    }
}

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
fn check_value(axis: Axis, found: f64) -> Result<(), ConditionsError> {
    check_bounds(axis, found, axis.bounds())
}

/// Refuses a value outside bounds.
fn check_bounds(axis: Axis, found: f64, bounds: Bounds) -> Result<(), ConditionsError> {
    let whole = !axis.is_count() || found.fract() == 0.0;
    if bounds.contains(found) && whole {
        return Ok(());
    }
    let kind = if axis.is_count() { "a whole number" } else { "a number" };
    Err(ConditionsError::OutOfRange { axis, found, expected: format!("{kind} {bounds}") })
}
