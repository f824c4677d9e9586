//! Whether a simulated robot is at most as capable as the measured one, capability by capability.
//!
//! This is what "worse than the robots" can be checked for by a machine. It does not imply
//! `eq:simulatorreq`, which is about trajectories, nor `eq:finalgap`, which is about behaviours:
//! imperfection also helps (some false detections break up split groups).

use std::borrow::Cow;

use serde::Serialize;

use crate::conditions::{
    Conditions, ConditionsError, ROBOT_NUMBERS, Settings, SimulatedRobot, SimulatedSensor,
};
use crate::quantity::{Axis, Worse};
use crate::robot::controller::Command;
use crate::robot::profile::RobotProfile;
use crate::robot::region::Region;
use crate::robot::sensor::Sees;
use crate::statistics::interval::Interval;
use crate::trials::fit::{Rate, SensorMap, polygon_contains};

pub use lost::{LostCapability, lost_capabilities};

mod lost;

/// A capability in which a simulated robot is better than the measured one.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error(
    "{capability}: simulated {simulated}, measured {measured}; expected the simulated robot to be \
     at most as capable, so {expected}"
)]
pub struct CapabilityViolation {
    /// Name of the capability, with its unit.
    pub capability: Cow<'static, str>,
    /// The measured robot's.
    pub measured: String,
    /// The simulated robot's.
    pub simulated: String,
    /// What the simulated one must be, in words.
    pub expected: &'static str,
}

/// Lists where the robots of some conditions, made harsher and with the values of a cell's axes,
/// are better than the measured robot at the same commands, in the order of a profile.
///
/// # Source
///
/// `eq:simulatorreq` and §IV step 2: "purposefully exaggerated to be worse".
pub fn violations(
    measured: &RobotProfile,
    simulated: &Conditions,
) -> Result<Vec<CapabilityViolation>, ConditionsError> {
    // Of the controller a robot's gains follow its fastest command.
    let Command { speed_m_s, turn_rate_rad_s } = simulated.controller.fastest();
    let mut values = vec![
        (Axis::Speed, speed_m_s),
        (Axis::TurnRate, turn_rate_rad_s),
        (Axis::Robots, simulated.robots as f64),
    ];
    // What sensors detect must be there.
    let world = simulated.world.without_profiles();
    if world.arena.is_none() {
        values.push((Axis::Arena, simulated.arena.side_m));
    }
    let settings = Settings {
        values,
        walls: simulated.arena.walls,
        placement: Some(simulated.placement.clone()),
        world,
        ..Settings::default()
    };
    let measured = Conditions::resolve(measured, &settings)?;
    let mut found: Vec<CapabilityViolation> =
        numbers(&measured, simulated).into_iter().filter_map(Compared::violation).collect();
    found.extend(rotation(&measured.robot, &simulated.robot));
    found.extend(contact(&measured.robot, &simulated.robot));
    let [measured, simulated] = [&measured.robot, &simulated.robot];
    found.extend(region(&measured.sensors()[0], &simulated.sensors()[0]));
    found.extend(further_readings(measured, simulated));
    Ok(found)
}

/// One number of both robots.
struct Compared {
    capability: Cow<'static, str>,
    measured: f64,
    simulated: f64,
    /// Without it neither side is the worse one, so that it must be the same.
    worse: Option<Worse>,
}

/// What binary fractions may differ by where numbers are equal.
const ROUNDING: f64 = 1e-9;

impl Compared {
    fn violation(self) -> Option<CapabilityViolation> {
        let Self { capability, measured, simulated, worse } = self;
        let (is_kept, expected) = match worse {
            Some(Worse::More) => (simulated >= measured - ROUNDING, "the same or more"),
            Some(Worse::Less) => (simulated <= measured + ROUNDING, "the same or less"),
            None => ((simulated - measured).abs() <= ROUNDING, "the same"),
            Some(Worse::FartherFromOne) => {
                let (measured, simulated) = (measured - 1.0, simulated - 1.0);
                let is_farther = simulated.abs() >= measured.abs() - ROUNDING;
                let is_same_side = simulated * measured >= 0.0 || measured.abs() <= ROUNDING;
                (is_farther && is_same_side, "the same or farther from 1 on the same side")
            }
        };
        let (measured, simulated) = (measured.to_string(), simulated.to_string());
        (!is_kept).then_some(CapabilityViolation { capability, measured, simulated, expected })
    }
}

fn numbers(measured: &Conditions, simulated: &Conditions) -> Vec<Compared> {
    let period_s = [measured.period_s, simulated.period_s];
    let robots = [&measured.robot, &simulated.robot];
    let no_axis = |capability: &'static str, value: fn(&SimulatedRobot) -> f64, worse| {
        let [measured, simulated] = robots.map(value);
        Compared { capability: capability.into(), measured, simulated, worse }
    };
    let body = [
        no_axis("body radius (m)", |robot| robot.radius_m, None),
        no_axis("front sector (rad)", |robot| robot.front_half_angle_rad, Some(Worse::More)),
    ];
    let of_axes = ROBOT_NUMBERS.iter().map(|number| Compared {
        capability: number.name(),
        ..on_axis(number.axis, robots.map(number.get))
    });
    body.into_iter().chain(of_axes).chain([on_axis(Axis::Period, period_s)]).collect()
}

/// What both robots have on an axis.
fn on_axis(axis: Axis, [measured, simulated]: [f64; 2]) -> Compared {
    Compared { capability: axis.label().into(), measured, simulated, worse: axis.worse() }
}

fn rotation(measured: &SimulatedRobot, simulated: &SimulatedRobot) -> Option<CapabilityViolation> {
    let is_better = simulated.rotates_while_blocked && !measured.rotates_while_blocked;
    is_better.then(|| CapabilityViolation {
        capability: "turns while blocked".into(),
        measured: "no".to_owned(),
        simulated: "yes".to_owned(),
        expected: "no",
    })
}

/// No contact is worse than another, and what it does to a swarm may be either.
fn contact(measured: &SimulatedRobot, simulated: &SimulatedRobot) -> Option<CapabilityViolation> {
    let [measured, simulated] = [measured, simulated].map(|robot| robot.contact.name().to_owned());
    let capability = "what robots do when they touch".into();
    (measured != simulated).then_some(CapabilityViolation {
        capability,
        measured,
        simulated,
        expected: "the same",
    })
}

/// What the sensors of a list tell besides the first reading, which is among the numbers of every robot.
fn further_readings(
    measured: &SimulatedRobot,
    simulated: &SimulatedRobot,
) -> Vec<CapabilityViolation> {
    let mut found = Vec::new();
    for (place, (measured, simulated)) in
        measured.sensors().iter().zip(&simulated.sensors()).enumerate()
    {
        let of = |capability: &str| Cow::from(format!("sensor `{}`: {capability}", measured.name));
        let is_first = place == 0;
        let mut rows = Vec::new();
        if !is_first {
            let latency = [measured, simulated].map(|sensor| f64::from(sensor.latency_steps));
            let row = on_axis(Axis::LatencySteps, latency);
            rows.push(Compared { capability: of(&row.capability), ..row });
        }
        let readings = measured.readings().into_iter().zip(simulated.readings());
        for (one, other) in readings.skip(usize::from(is_first)) {
            for (axis, values) in [
                (Axis::TruePositive, [one.true_positive, other.true_positive]),
                (Axis::FalsePositive, [one.false_positive, other.false_positive]),
            ] {
                let row = on_axis(axis, values);
                let capability = format!("reading `{}`: {}", one.name, row.capability).into();
                rows.push(Compared { capability, ..row });
            }
        }
        found.extend(rows.into_iter().filter_map(Compared::violation));
        if !is_first {
            let violation = region(measured, simulated);
            found.extend(
                violation.map(|it| CapabilityViolation { capability: of(&it.capability), ..it }),
            );
        }
    }
    found
}

/// The simulated region must lie in the measured one, for what it must contain of a neighbour.
fn region(measured: &SimulatedSensor, simulated: &SimulatedSensor) -> Option<CapabilityViolation> {
    // A body that touches a region is seen from further away than its centre in the same region.
    if simulated.sees == Sees::Body && measured.sees == Sees::Centre {
        return Some(CapabilityViolation {
            capability: "what of a neighbour is seen".into(),
            measured: "its centre".to_owned(),
            simulated: "its body".to_owned(),
            expected: "its centre",
        });
    }
    let is_inside = match (&measured.region, &simulated.region) {
        (
            Region::Cone { half_angle_rad, range_m },
            Region::Cone { half_angle_rad: simulated_angle_rad, range_m: simulated_m },
        ) => {
            *simulated_angle_rad <= half_angle_rad + ROUNDING && *simulated_m <= range_m + ROUNDING
        }
        (_, simulated) => border_m(simulated).iter().all(|point| covers(&measured.region, *point)),
    };
    (!is_inside).then(|| CapabilityViolation {
        capability: "sensing region".into(),
        measured: described(&measured.region),
        simulated: described(&simulated.region),
        expected: "inside the measured one",
    })
}

/// Points that a convex region must contain in order to contain this one; also its outline for a
/// picture, counterclockwise, in metres.
pub fn border_m(region: &Region) -> Vec<[f64; 2]> {
    match region {
        Region::Polygon { corners_m } => corners_m.clone(),
        Region::Cone { half_angle_rad, range_m } => {
            let arc = (0..=64_u32).map(|step| {
                let bearing_rad = half_angle_rad * (f64::from(step) / 32.0 - 1.0);
                let (sine, cosine) = libm::sincos(bearing_rad);
                [range_m * cosine, range_m * sine]
            });
            std::iter::once([0.0, 0.0]).chain(arc).collect()
        }
    }
}

fn covers(region: &Region, [x_m, y_m]: [f64; 2]) -> bool {
    match region {
        Region::Polygon { corners_m } => polygon_contains(corners_m, [x_m, y_m]),
        Region::Cone { half_angle_rad, range_m } => {
            let is_near = libm::hypot(x_m, y_m) <= range_m + ROUNDING;
            is_near && y_m.abs() <= x_m * libm::tan(*half_angle_rad) + ROUNDING
        }
    }
}

fn described(region: &Region) -> String {
    match region {
        Region::Cone { half_angle_rad, range_m } => {
            format!("a cone of {half_angle_rad} rad to either side and {range_m} m")
        }
        Region::Polygon { corners_m } => {
            let corners: Vec<String> =
                corners_m.iter().map(|[x_m, y_m]| format!("({x_m:.3}, {y_m:.3})")).collect();
            format!("a polygon of {} m", corners.join(" "))
        }
    }
}

/// A place at which the detections that were counted contradict the simulated sensor.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum SensorViolation {
    /// The real sensor misses more where the simulated one sees.
    #[error(
        "at {distance_m} m, {bearing_rad} rad the robots detected {} of {} (at most {:.3}), the simulated \
         robot detects {simulated}",
        rate.detections, rate.samples, rate.high
    )]
    Missed {
        /// Distance of the centres, in metres.
        distance_m: f64,
        /// Bearing, in radians.
        bearing_rad: f64,
        /// What was counted.
        rate: Rate,
        /// The simulated true-positive rate.
        simulated: f64,
    },
    /// The real sensor reports more neighbours that are none.
    #[error(
        "without a neighbour the robots detected {} of {} (at least {:.4}), the simulated robot \
         detects {simulated}",
        rate.detections, rate.samples, rate.low
    )]
    FalseAlarms {
        /// What was counted.
        rate: Rate,
        /// The simulated false-positive rate.
        simulated: f64,
    },
}

/// Holds the detections that were counted against a simulated sensor, and lists its violations,
/// false alarms last.
///
/// A place in the simulated region is a violation if fewer were detected there than the simulated
/// sensor does, beyond chance: the upper bound of its share, at a level divided by the number of
/// places (Bonferroni), lies below. So a sensor that is exactly as simulated is accused in at most
/// 5 % of all fits.
///
/// With `sees: body`, places up to a body's radius beyond the region are not checked.
///
/// # Source
///
/// C. J. Clopper, E. S. Pearson, Biometrika 26, 1934.
pub fn sensor_violations(map: &SensorMap, simulated: &SimulatedRobot) -> Vec<SensorViolation> {
    let inside: Vec<_> =
        map.nodes.iter().filter(|node| covers(&simulated.region, node.place_m())).collect();
    let level = LEVEL / (inside.len() + 1) as f64;
    let missed = inside.iter().filter_map(|node| {
        let rate = node.rate;
        let bounds = Interval::with_tails(rate.detections, rate.samples, level);
        (bounds.high < simulated.true_positive).then_some(SensorViolation::Missed {
            distance_m: node.distance_m,
            bearing_rad: node.bearing_rad,
            rate,
            simulated: simulated.true_positive,
        })
    });
    let alarm = map.false_positive;
    let bounds = Interval::with_tails(alarm.detections, alarm.samples, level);
    let alarms = (bounds.low > simulated.false_positive).then_some(SensorViolation::FalseAlarms {
        rate: alarm,
        simulated: simulated.false_positive,
    });
    missed.chain(alarms).collect()
}

/// Most that a faultless fit may be accused.
const LEVEL: f64 = 0.05;
