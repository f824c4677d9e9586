//! What can be changed about a robot, and in which directions.

use rsrs_core::quantity::{Axis, Worse};
use rsrs_core::robot::harsher::tidy;
use rsrs_core::robot::profile::RobotProfile;

/// A capability, and values of it on the way to a better robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Improvement {
    /// The axis; speed and turning rate stand for the robot's limits.
    pub axis: Axis,
    /// What the robot has.
    pub now: f64,
    /// Values to try, the nearest first.
    pub values: Vec<f64>,
}

/// By which factors a range may grow.
const FARTHER: [f64; 4] = [1.3, 1.7, 2.4, 4.0];
/// By which factors a sensor may open.
const WIDER: [f64; 4] = [1.4, 2.0, 3.0, 5.0];
/// By which factors it may close.
const NARROWER: [f64; 4] = [0.7, 0.5, 0.35, 0.2];
/// By how much a sensor may be turned, in radians.
const TURNS_RAD: [f64; 5] = [0.06, 0.13, 0.22, 0.35, 0.55];
/// By which factors a period may become shorter.
const SHORTER: [f64; 2] = [0.5, 0.25];
/// Shortest period that is asked for, in seconds.
const SHORTEST_S: f64 = 0.02;
/// By which factors the greatest speed or turning rate may grow.
const FASTER: [f64; 3] = [1.5, 2.2, 3.5];
/// By which factors the least one may shrink.
const SLOWER: [f64; 2] = [0.5, 0.25];
/// A gain that is off by less than this is as good as 1.
const SAME_GAIN: f64 = 0.02;

/// Noise, errors and delays of a robot, each with its perfect value.
pub fn imperfections(robot: &RobotProfile) -> Vec<Improvement> {
    let improvement = |axis: Axis| {
        let (now, ideal) = (robot.capability(axis)?, axis.ideal()?);
        let is_gain = axis.worse() == Some(Worse::FartherFromOne);
        let same = if is_gain { SAME_GAIN } else { 1e-9 };
        ((now - ideal).abs() > same).then(|| Improvement { axis, now, values: vec![ideal] })
    };
    Axis::ALL.into_iter().filter_map(improvement).collect()
}

/// What has no perfect value: where the sensor points, how far and how wide it sees, how often the
/// robot decides, and how fast it may be.
pub fn designs(robot: &RobotProfile) -> Vec<Improvement> {
    let mut found = Vec::new();
    let mut add = |axis: Axis, now: f64, values: Vec<f64>| {
        if !values.is_empty() {
            found.push(Improvement { axis, now, values });
        }
    };
    let times = |now: f64, factors: &[f64]| -> Vec<f64> {
        factors.iter().map(|factor| tidy(factor * now)).collect()
    };
    for sign in [-1.0, 1.0] {
        add(Axis::SensorBearing, 0.0, TURNS_RAD.map(|turn_rad| sign * turn_rad).to_vec());
    }
    if let Some(now) = robot.capability(Axis::Range) {
        add(Axis::Range, now, times(now, &FARTHER));
    }
    // A line of sight has no factor by which it opens.
    if let Some(now) = robot.capability(Axis::HalfAngle).filter(|now| *now > 0.0) {
        let mut wider = times(now, &WIDER);
        wider.retain(|half_angle_rad| *half_angle_rad < 1.4);
        add(Axis::HalfAngle, now, wider);
        add(Axis::HalfAngle, now, times(now, &NARROWER));
    }
    let period_s = robot.computation.period_s;
    let mut shorter = times(period_s, &SHORTER);
    shorter.retain(|shorter_s| *shorter_s >= SHORTEST_S);
    add(Axis::Period, period_s, shorter);
    for (axis, [least, most]) in [
        (Axis::Speed, robot.actuation.speed.limits_m_s),
        (Axis::TurnRate, robot.actuation.turn.limits_rad_s),
    ] {
        add(axis, most, times(most, &FASTER));
        if least > 0.0 {
            add(axis, least, times(least, &SLOWER));
        }
    }
    found
}

/// Worse values of a robot's capabilities, as long as they are possible.
pub fn savings(robot: &RobotProfile) -> Vec<Improvement> {
    let worse = |axis: Axis| -> Option<Improvement> {
        let now = robot.capability(axis)?;
        let values: Vec<f64> = match axis.worse()? {
            Worse::More => {
                let (first, most) = more(axis, robot)?;
                let first = if now > 0.0 { 2.0 * now } else { first };
                let doubling = std::iter::successors(Some(first), |value| Some(2.0 * value));
                doubling.take_while(|value| *value <= most).map(tidy).collect()
            }
            Worse::Less if axis.ideal().is_some() => {
                RARER.into_iter().filter(|less| *less < now).collect()
            }
            Worse::Less => LESS.map(|factor| tidy(factor * now)).to_vec(),
            // Slower wheels and faster ones ask for other commands.
            Worse::FartherFromOne => Vec::new(),
        };
        (!values.is_empty()).then_some(Improvement { axis, now, values })
    };
    Axis::ALL.into_iter().filter_map(worse).collect()
}

/// Probabilities of a true detection that a cheaper sensor may have.
const RARER: [f64; 3] = [0.9, 0.75, 0.55];
/// By which factors a range may shrink.
const LESS: [f64; 3] = [0.8, 0.6, 0.4];

/// Where more of something is worse: what is tried first on a robot that has none of it, and the most.
fn more(axis: Axis, robot: &RobotProfile) -> Option<(f64, f64)> {
    let speed_m_s = robot.actuation.speed.limits_m_s[1];
    let turn_rad_s = robot.actuation.turn.limits_rad_s[1];
    Some(match axis {
        Axis::FalsePositive | Axis::HeadingNoise => (0.02, 0.7),
        Axis::LatencySteps => (1.0, 16.0),
        Axis::Heterogeneity | Axis::GainNoise => (0.05, 0.3),
        Axis::TurnBias => (0.02 * turn_rad_s, 0.5 * turn_rad_s),
        Axis::Gust => (0.05 * speed_m_s, speed_m_s),
        Axis::YawLag => (0.1, 5.0),
        Axis::Period => (0.1, axis.bounds().most),
        // Nothing is saved by rougher bodies.
        _ => return None,
    })
}

impl Improvement {
    /// A value on the way from what the robot has, where `share` is 0, to a better one, where it is
    /// 1: rounded towards the better one, so that it can be written down.
    pub fn towards(&self, better: f64, share: f64) -> f64 {
        if share >= 1.0 {
            return better;
        }
        let value = self.now + share * (better - self.now);
        let step = if self.axis.is_count() {
            1.0
        } else {
            // A hundredth of the way or less, as one digit.
            libm::pow(10.0, libm::floor(libm::log10((better - self.now).abs())) - 2.0)
        };
        let steps = value / step;
        let rounded = if better > self.now {
            libm::ceil(steps - 1e-9) * step
        } else {
            libm::floor(steps + 1e-9) * step
        };
        let (least, most) = (self.now.min(better), self.now.max(better));
        tidy(rounded).clamp(least, most)
    }

    /// How much of a change a value is, so that changes of different capabilities can be put in order:
    /// the share of the way to perfection, the logarithm of a factor, or the angle over half
    /// a radian: aiming is cheaper than another sensor.
    pub fn effort(&self, value: f64) -> f64 {
        if self.axis.ideal().is_some() {
            let perfect = self.values.last().copied().unwrap_or(value);
            ((value - self.now) / (perfect - self.now)).abs()
        } else if self.axis == Axis::SensorBearing {
            value.abs() / 0.5
        } else {
            libm::log(value / self.now).abs()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_saved_is_the_worse_robot_in_all_that_has_a_direction_but_gains_and_friction() {
        let flockbot = include_str!("../../../../launch_configs/profiles/flockbot.yaml");
        let flockbot = RobotProfile::parse("flockbot.yaml", flockbot).unwrap();

        let savings = savings(&flockbot);

        for Improvement { axis, now, values } in &savings {
            let is_worse = |value: &f64| match axis.worse() {
                Some(Worse::More) => value > now,
                Some(Worse::Less) => value < now,
                _ => false,
            };
            assert!(values.iter().all(is_worse), "{axis} from {now}: {values:?}");
        }
        let left_out = Axis::ALL.into_iter().filter(|axis| {
            axis.worse().is_some() && savings.iter().all(|saving| saving.axis != *axis)
        });
        let left_out: Vec<Axis> = left_out.collect();
        assert_eq!(left_out, [Axis::SpeedGain, Axis::TurnGain, Axis::ContactFriction]);
    }

    #[test]
    fn values_on_the_way_are_rounded_towards_the_better_end() {
        let range = Improvement { axis: Axis::Range, now: 0.45, values: vec![0.72] };
        let errors = Improvement { axis: Axis::FalsePositive, now: 0.145, values: vec![0.0] };
        let latency = Improvement { axis: Axis::LatencySteps, now: 5.0, values: vec![0.0] };

        assert!((range.towards(0.72, 0.501) - 0.586).abs() < 1e-9);
        assert!((errors.towards(0.0, 0.5) - 0.072).abs() < 1e-9);
        assert!((latency.towards(0.0, 0.3) - 3.0).abs() < 1e-9);
        assert!((range.towards(0.72, 1.0) - 0.72).abs() < 1e-9);
    }
}
