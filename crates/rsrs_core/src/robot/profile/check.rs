//! Whether a profile can describe a robot: every number against what it can mean.

use super::{MAX_CORNERS, ProfileError, RobotProfile, Sees};
use crate::out_of_range::OutOfRange;
use crate::plane::{left_of, sides};
use crate::robot::contact::ContactModel;

impl RobotProfile {
    /// Checks every number against what it can mean.
    pub fn check(&self) -> Result<(), ProfileError> {
        positive("body.radius_m", self.body.radius_m)?;
        within("body.front_half_angle_rad", self.body.front_half_angle_rad, 0.0, 3.15)?;
        self.check_contact()?;
        self.check_actuation()?;
        if self.has_one_plain_sensor() {
            self.check_sensing()?;
        } else {
            self.check_sensors()?;
        }
        let period_s = self.computation.period_s;
        let is_period = |it| (PERIOD_BOUNDS_S[0]..=PERIOD_BOUNDS_S[1]).contains(&it);
        check("computation.period_s", period_s, is_period, "a time from 0.001 to 2 s")
    }

    fn check_contact(&self) -> Result<(), ProfileError> {
        let contact = self.body.contact;
        let Some(found) = self.body.contact_friction else { return Ok(()) };
        if contact != ContactModel::Push {
            return Err(ProfileError::Friction { found, contact });
        }
        let is_friction = |it| (0.0..=MOST_FRICTION).contains(&it);
        check("body.contact_friction", found, is_friction, "a coefficient from 0 to 2")
    }

    fn check_actuation(&self) -> Result<(), ProfileError> {
        let speed = &self.actuation.speed;
        let turn = &self.actuation.turn;
        limits("actuation.speed.limits_m_s", speed.limits_m_s)?;
        limits("actuation.turn.limits_rad_s", turn.limits_rad_s)?;
        gains(
            "actuation.speed.gain_by_command",
            speed.gain_by_command.iter().map(|gain| (gain.commanded_m_s, gain.mean)),
        )?;
        gains(
            "actuation.turn.gain_by_command",
            turn.gain_by_command.iter().map(|gain| (gain.commanded_rad_s, gain.mean)),
        )?;
        if let Some(driving) = &turn.driving_gain_by_command {
            gains(
                "actuation.turn.driving_gain_by_command",
                driving.iter().map(|gain| (gain.commanded_rad_s, gain.mean)),
            )?;
        }
        for (key, number) in [
            ("actuation.speed.robot_sd", speed.robot_sd),
            ("actuation.speed.step_sd", speed.step_sd),
            ("actuation.turn.robot_sd", turn.robot_sd),
            ("actuation.turn.step_sd", turn.step_sd),
            ("actuation.turn.bias_sd_rad_s", turn.bias_sd_rad_s),
            ("actuation.turn.heading_noise_sd_rad", turn.heading_noise_sd_rad),
            ("actuation.gust.sd_m_s", self.actuation.gust.sd_m_s),
            ("actuation.yaw_lag_s", self.actuation.yaw_lag_s),
        ] {
            not_negative(key, number)?;
        }
        if let Some(wheels) = self.actuation.wheels {
            positive("actuation.wheels.base_m", wheels.base_m)?;
            positive("actuation.wheels.speed_max_m_s", wheels.speed_max_m_s)?;
        }
        positive("actuation.gust.time_constant_s", self.actuation.gust.time_constant_s)
    }

    fn check_sensing(&self) -> Result<(), ProfileError> {
        let sensing = &self.sensing;
        within("sensing.true_positive", sensing.true_positive, 0.0, 1.0)?;
        within("sensing.false_positive", sensing.false_positive, 0.0, 1.0)?;
        match (&sensing.cone, &sensing.polygon_m) {
            (Some(cone), None) => {
                positive("sensing.cone.range_m", cone.range_m)?;
                let is_seen = cone.half_angle_rad != 0.0 || sensing.sees == Sees::Body;
                let expected = if is_seen {
                    "from 0, a line of sight, to 1.5 rad"
                } else {
                    "above 0: no centre lies on a line of sight, which needs `sees: body`"
                };
                let is_cone = |it| is_seen && (0.0..=MAX_HALF_ANGLE_RAD).contains(&it);
                check("sensing.cone.half_angle_rad", cone.half_angle_rad, is_cone, expected)
            }
            (None, Some(polygon)) if is_convex(polygon) => Ok(()),
            (None, Some(polygon)) => Err(ProfileError::Polygon(polygon.len())),
            _ => Err(ProfileError::Region),
        }
    }
}

/// Greatest coefficient of friction between two bodies: rubber on rubber has half of it.
pub const MOST_FRICTION: f64 = 2.0;

/// Shortest and longest control period, in seconds: nobody drives by detections that are rarer.
pub const PERIOD_BOUNDS_S: [f64; 2] = [0.001, 2.0];

/// Widest cone: its edges must stay in front of the robot.
pub const MAX_HALF_ANGLE_RAD: f64 = 1.5;

fn check(
    name: &'static str,
    found: f64,
    is_meant: impl Fn(f64) -> bool,
    expected: &'static str,
) -> Result<(), ProfileError> {
    if is_meant(found) { Ok(()) } else { Err(OutOfRange { name, found, expected }.into()) }
}

fn positive(key: &'static str, found: f64) -> Result<(), ProfileError> {
    check(key, found, |it| it > 0.0 && it.is_finite(), "a finite number above 0")
}

fn not_negative(key: &'static str, found: f64) -> Result<(), ProfileError> {
    check(key, found, |it| it >= 0.0 && it.is_finite(), "a finite number, 0 or more")
}

fn within(key: &'static str, found: f64, least: f64, most: f64) -> Result<(), ProfileError> {
    let expected = if most > 3.0 { "an angle from 0 to pi" } else { "a probability from 0 to 1" };
    check(key, found, |it| (least..=most).contains(&it), expected)
}

fn limits(key: &'static str, [least, most]: [f64; 2]) -> Result<(), ProfileError> {
    let is_most = |most: f64| least >= 0.0 && most > least && most.is_finite();
    check(key, most, is_most, "limits with 0 <= least < most")
}

fn gains(key: &'static str, table: impl Iterator<Item = (f64, f64)>) -> Result<(), ProfileError> {
    let table: Vec<(f64, f64)> = table.collect();
    let ascending = table.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if table.is_empty() || !ascending {
        return Err(ProfileError::GainTable(key));
    }
    for (command, mean) in table {
        positive(key, command)?;
        positive(key, mean)?;
    }
    Ok(())
}

/// Whether corners form a convex polygon, counterclockwise, of a size that the simulator takes.
///
/// Every corner must lie to the left of every side that it is no end of: that is where the world looks
/// for a neighbour.
pub(crate) fn is_convex(corners: &[[f64; 2]]) -> bool {
    let n = corners.len();
    let others = |side: usize| (2..n).map(move |further| corners[(side + further) % n]);
    (3..=MAX_CORNERS).contains(&n)
        && corners.iter().flatten().all(|number| number.is_finite())
        && (sides(corners).enumerate())
            .all(|(number, side)| others(number).all(|corner| left_of(side, corner) > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_sight_sees_bodies_and_no_cone_opens_backward() {
        let flockbot = rsrs_testing::conditions::FLOCKBOT;
        let flockbot = RobotProfile::parse("flockbot.yaml", flockbot).unwrap();
        let checked = |half_angle_rad: f64, sees: Sees| {
            let mut robot = flockbot.clone();
            robot.sensing.sees = sees;
            robot.sensing.cone.as_mut().unwrap().half_angle_rad = half_angle_rad;
            robot.check().map_err(|error| error.to_string())
        };

        assert_eq!(checked(0.0, Sees::Body), Ok(()));
        let centres = checked(0.0, Sees::Centre).unwrap_err();
        assert!(centres.ends_with("which needs `sees: body`"), "{centres}");
        for impossible in [-0.1, 1.6, f64::NAN] {
            let refused = checked(impossible, Sees::Body).unwrap_err();
            assert!(refused.ends_with("from 0, a line of sight, to 1.5 rad"), "{refused}");
        }
    }
}
