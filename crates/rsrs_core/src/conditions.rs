//! The conditions of one experiment: everything that the outcome may depend on, the paper's `E`.

use serde::{Deserialize, Serialize};

use crate::axis::{Axis, Cell};
use crate::controller::ControllerParameters;
use crate::digest::Digest;
use crate::profile::{ProfileError, RobotProfile, Sees, Sensing};
use crate::trajectory::Bodies;

/// All aspects of a world, resolved to numbers: the paper's `E`.
///
/// # Source
///
/// "Lumping all aspects of the simulator into a variable `E`", before `eq:finalgap`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Number of robots `N`.
    pub robots: usize,
    /// What every robot's controller is set to.
    pub controller: ControllerParameters,
    /// Where the robots start.
    pub placement: Placement,
    /// Where they may go.
    pub arena: Arena,
    /// What the robots are.
    pub robot: SimulatedRobot,
    /// Control period `Δt`, in seconds.
    pub period_s: f64,
}

/// Where the robots start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Placement {
    /// Uniform in a disc, facing away from its centre, as in §IV step 3.
    DiscFacingOut {
        /// Radius of the disc, in metres.
        radius_m: f64,
    },
}

/// A square arena around the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arena {
    /// Side of the square, in metres.
    pub side_m: f64,
    /// What happens at its border.
    pub walls: Walls,
}

/// What happens at the arena's border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Walls {
    /// There is no border.
    None,
    /// A robot slides along it.
    Clamp,
    /// A robot that would cross it stays where it is.
    #[default]
    Stop,
}

/// A robot as the world moves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedRobot {
    /// Radius of the body, in metres.
    pub radius_m: f64,
    /// Front sector of contact, in radians.
    pub front_half_angle_rad: f64,
    /// Whether a blocked robot still turns.
    pub rotates_while_blocked: bool,
    /// Gain of the speed, `θᵃ₁`.
    pub speed_gain: GainDistribution,
    /// Gain of the turning rate, `θᵃ₂`.
    pub turn_gain: GainDistribution,
    /// Standard deviation between robots of a turning rate nobody asked for, in radians per second.
    pub turn_bias_sd_rad_s: f64,
    /// Standard deviation of the heading's random change per step, in radians.
    pub heading_noise_sd_rad: f64,
    /// Standard deviation of the velocity disturbance on each axis, in metres per second.
    pub gust_sd_m_s: f64,
    /// Its correlation time, in seconds.
    pub gust_time_constant_s: f64,
    /// Time constant of the turning rate, in seconds; 0 is at once.
    pub yaw_lag_s: f64,
    /// What of a neighbour must lie in the region.
    pub sees: Sees,
    /// Where a neighbour is detected.
    pub region: Region,
    /// Probability of a detection when a neighbour is in the region.
    pub true_positive: f64,
    /// Probability of a detection when none is.
    pub false_positive: f64,
    /// Steps by which a detection arrives late.
    pub latency_steps: u32,
}

/// How a gain varies: normal, truncated at three standard deviations; dimensionless.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainDistribution {
    /// Mean over robots at the commanded value.
    pub mean: f64,
    /// Standard deviation between robots.
    pub robot_sd: f64,
    /// Standard deviation from step to step.
    pub step_sd: f64,
}

/// Where a neighbour is detected, in the robot's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// A cone in front.
    Cone {
        /// Half of the opening angle, in radians.
        half_angle_rad: f64,
        /// Reach, in metres.
        range_m: f64,
    },
    /// A convex polygon, counterclockwise, in metres.
    Polygon {
        /// Corners `[x, y]`, x forward, y left.
        corners_m: Vec<[f64; 2]>,
    },
}

impl Region {
    /// The region of a checked profile's sensor.
    ///
    /// # Panics
    ///
    /// If the profile has neither a cone nor a polygon: then it was not checked.
    pub fn of(sensing: &Sensing) -> Self {
        match (&sensing.cone, &sensing.polygon_m) {
            (Some(cone), _) => {
                Self::Cone { half_angle_rad: cone.half_angle_rad, range_m: cone.range_m }
            }
            (None, Some(corners)) => Self::Polygon { corners_m: corners.clone() },
            (None, None) => unreachable!("a checked profile has a region"),
        }
    }

    /// The greatest distance at which a centre can lie in the region, in metres.
    pub fn range_m(&self) -> f64 {
        match self {
            Self::Cone { range_m, .. } => *range_m,
            Self::Polygon { corners_m } => {
                corners_m.iter().map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max)
            }
        }
    }
}

/// What a sweep or an experiment fixes besides the robots: settings that belong to `E`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Values by axis; of an axis that occurs twice the later one counts.
    pub values: Vec<(Axis, f64)>,
    /// What happens at the arena's border.
    pub walls: Walls,
}

/// Why a profile and settings do not make conditions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConditionsError {
    /// The robot is impossible.
    #[error(transparent)]
    Robot(#[from] ProfileError),
    /// A setting without which there is no experiment.
    #[error("no value for {axis}")]
    Missing {
        /// The axis.
        axis: Axis,
    },
    /// A value outside what the axis can mean.
    #[error("{axis} is {found}, expected {expected}")]
    OutOfRange {
        /// The axis.
        axis: Axis,
        /// The value found.
        found: f64,
        /// What it may be.
        expected: String,
    },
    /// An axis that this robot's sensor does not have.
    #[error("{axis} does not apply to a robot whose sensor is a {sensor}")]
    NotOfThisSensor {
        /// The axis.
        axis: Axis,
        /// `cone` or `polygon`.
        sensor: &'static str,
    },
}

/// Most robots in one world; beyond it, memory and not the method would end the run.
pub const MAX_ROBOTS: usize = 1_000_000;

impl Conditions {
    /// Resolves a robot and settings to numbers.
    ///
    /// Precedence is profile, then harsher (already in `robot`), then the settings in order. Gain
    /// means are read at the commanded speed and turning rate.
    ///
    /// # Arguments
    ///
    /// * `robot` — the simulated robot: a measured profile, made harsher or not.
    /// * `settings` — at least speed, turning rate and number of robots.
    ///
    /// # Errors
    ///
    /// [`ConditionsError`], the first problem found.
    pub fn resolve(robot: &RobotProfile, settings: &Settings) -> Result<Self, ConditionsError> {
        let mut robot = robot.clone();
        let mut operator = OperatorSettings::default();
        for (axis, value) in &settings.values {
            check_value(*axis, *value)?;
            if !operator.set(*axis, *value) {
                set_capability(&mut robot, *axis, *value)?;
            }
        }
        robot.check()?;
        let required = |value: Option<f64>, axis| value.ok_or(ConditionsError::Missing { axis });
        let controller = ControllerParameters {
            speed_m_s: required(operator.speed_m_s, Axis::Speed)?,
            turn_rate_rad_s: required(operator.turn_rate_rad_s, Axis::TurnRate)?,
        };
        let simulated = simulated_robot(&robot, controller);
        let default_radius_m = PLACEMENT_OVER_RANGE * simulated.region.range_m();
        Ok(Self {
            robots: required(operator.robots, Axis::Robots)? as usize,
            controller,
            placement: Placement::DiscFacingOut {
                radius_m: operator.placement_radius_m.unwrap_or(default_radius_m),
            },
            arena: Arena { side_m: operator.arena_m.unwrap_or(ARENA_M), walls: settings.walls },
            robot: simulated,
            period_s: robot.computation.period_s,
        })
    }

    /// Names these conditions: equal digests mean equal worlds. The duration is not part of it, so
    /// that a longer run passes through the states of a shorter one.
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::new("conditions");
        let text = serde_json::to_string(self).expect("conditions are plain data");
        digest.text(&text);
        digest.value()
    }

    /// Steps of a run: `floor(duration / Δt)`.
    pub fn steps(&self, duration_s: f64) -> u64 {
        // A duration that is a whole number of periods may fall short of it by a rounding error.
        (duration_s / self.period_s + 1e-9).floor() as u64
    }

    /// What the judge must know of the robots.
    pub fn bodies(&self) -> Bodies {
        Bodies { radius_m: Some(self.robot.radius_m), range_m: Some(self.robot.region.range_m()) }
    }
}

/// Robots start in a circle "slightly larger than their maximum vision distance" (§IV step 3).
const PLACEMENT_OVER_RANGE: f64 = 1.1;

/// Side of the arena where none is given, in metres: large enough never to be reached in a run.
const ARENA_M: f64 = 15.0;

#[derive(Default)]
struct OperatorSettings {
    speed_m_s: Option<f64>,
    turn_rate_rad_s: Option<f64>,
    robots: Option<f64>,
    placement_radius_m: Option<f64>,
    arena_m: Option<f64>,
}

impl OperatorSettings {
    /// Takes a value if the axis is one of the operator's.
    fn set(&mut self, axis: Axis, value: f64) -> bool {
        let place = match axis {
            Axis::Speed => &mut self.speed_m_s,
            Axis::TurnRate => &mut self.turn_rate_rad_s,
            Axis::Robots => &mut self.robots,
            Axis::PlacementRadius => &mut self.placement_radius_m,
            Axis::Arena => &mut self.arena_m,
            _ => return false,
        };
        *place = Some(value);
        true
    }
}

fn set_capability(robot: &mut RobotProfile, axis: Axis, value: f64) -> Result<(), ConditionsError> {
    let sensing = &mut robot.sensing;
    match axis {
        Axis::Range | Axis::HalfAngle => {
            let cone = sensing
                .cone
                .as_mut()
                .ok_or(ConditionsError::NotOfThisSensor { axis, sensor: "polygon" })?;
            if axis == Axis::Range {
                cone.range_m = value;
            } else {
                cone.half_angle_rad = value;
            }
        }
        Axis::PolygonScale => {
            let polygon = sensing
                .polygon_m
                .as_mut()
                .ok_or(ConditionsError::NotOfThisSensor { axis, sensor: "cone" })?;
            for coordinate in polygon.iter_mut().flatten() {
                *coordinate *= value;
            }
        }
        Axis::TruePositive => sensing.true_positive = value,
        Axis::FalsePositive => sensing.false_positive = value,
        Axis::LatencySteps => sensing.latency_steps = value as u32,
        Axis::Heterogeneity => {
            robot.actuation.speed.robot_sd = value;
            robot.actuation.turn.robot_sd = value;
        }
        Axis::Gust => robot.actuation.gust.sd_m_s = value,
        Axis::YawLag => robot.actuation.yaw_lag_s = value,
        Axis::Period => robot.computation.period_s = value,
        Axis::Speed | Axis::TurnRate | Axis::Robots | Axis::PlacementRadius | Axis::Arena => {
            unreachable!("operator settings are taken before capabilities")
        }
    }
    Ok(())
}

fn check_value(axis: Axis, found: f64) -> Result<(), ConditionsError> {
    let (least, most) = match axis {
        Axis::Robots => (0.0, MAX_ROBOTS as f64),
        Axis::TruePositive | Axis::FalsePositive => (0.0, 1.0),
        Axis::HalfAngle => (1e-6, 1.5),
        Axis::Speed
        | Axis::TurnRate
        | Axis::Heterogeneity
        | Axis::LatencySteps
        | Axis::Gust
        | Axis::YawLag => (0.0, 1e3),
        Axis::PlacementRadius | Axis::Arena | Axis::Range | Axis::PolygonScale => (1e-6, 1e6),
        Axis::Period => (1e-6, 60.0),
    };
    let whole = !axis.is_count() || found.fract() == 0.0;
    if (least..=most).contains(&found) && whole {
        return Ok(());
    }
    let kind = if axis.is_count() { "a whole number" } else { "a number" };
    Err(ConditionsError::OutOfRange {
        axis,
        found,
        expected: format!("{kind} from {least} to {most}"),
    })
}

fn simulated_robot(robot: &RobotProfile, controller: ControllerParameters) -> SimulatedRobot {
    let (speed, turn) = (&robot.actuation.speed, &robot.actuation.turn);
    let sensing = &robot.sensing;
    SimulatedRobot {
        radius_m: robot.body.radius_m,
        front_half_angle_rad: robot.body.front_half_angle_rad,
        rotates_while_blocked: robot.body.rotates_while_blocked,
        speed_gain: GainDistribution {
            mean: speed.gain_at(controller.speed_m_s).mean,
            robot_sd: speed.robot_sd,
            step_sd: speed.step_sd,
        },
        turn_gain: GainDistribution {
            mean: turn.gain_at(controller.turn_rate_rad_s).mean,
            robot_sd: turn.robot_sd,
            step_sd: turn.step_sd,
        },
        turn_bias_sd_rad_s: turn.bias_sd_rad_s,
        heading_noise_sd_rad: turn.heading_noise_sd_rad,
        gust_sd_m_s: robot.actuation.gust.sd_m_s,
        gust_time_constant_s: robot.actuation.gust.time_constant_s,
        yaw_lag_s: robot.actuation.yaw_lag_s,
        sees: sensing.sees,
        region: Region::of(sensing),
        true_positive: sensing.true_positive,
        false_positive: sensing.false_positive,
        latency_steps: sensing.latency_steps,
    }
}

impl Settings {
    /// The settings with the values of a cell on top.
    #[must_use]
    pub fn with_cell(&self, cell: &Cell) -> Self {
        let mut settings = self.clone();
        settings.values.extend(cell.iter());
        settings
    }
}
