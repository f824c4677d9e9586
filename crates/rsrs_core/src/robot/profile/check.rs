//! Whether a profile can describe a robot: every number against what it can mean.

use super::{ProfileError, RobotProfile};
use crate::bounds::Bounds;
use crate::out_of_range::OutOfRange;
use crate::robot::contact::ContactModel;
use crate::robot::sensor::file::sensors;
use crate::robot::sensor::{SensorFlaw, half_angle, is_convex};

impl RobotProfile {
    /// Checks every number against what it can mean.
    pub fn check(&self) -> Result<(), ProfileError> {
        let angle = |it| format!("an angle {it} rad");
        let front_rad = self.body.front_half_angle_rad;
        within("body.radius_m", self.body.radius_m, Bounds::SIZE, Bounds::number)?;
        within("body.front_half_angle_rad", front_rad, Bounds::SECTOR, angle)?;
        self.check_contact()?;
        self.check_actuation()?;
        if self.has_one_plain_sensor() {
            self.check_sensing()?;
        } else {
            self.check_sensors()?;
        }
        let time = |it| format!("a time {it} s");
        within("computation.period_s", self.computation.period_s, Bounds::PERIOD, time)
    }

    fn check_contact(&self) -> Result<(), ProfileError> {
        let contact = self.body.contact;
        let Some(found) = self.body.contact_friction else { return Ok(()) };
        if contact != ContactModel::Push {
            return Err(ProfileError::Friction { found, contact });
        }
        let coefficient = |it| format!("a coefficient {it}");
        within("body.contact_friction", found, Bounds::FRICTION, coefficient)
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
            within(key, number, Bounds::AMOUNT, Bounds::number)?;
        }
        if let Some(wheels) = self.actuation.wheels {
            positive("actuation.wheels.base_m", wheels.base_m)?;
            positive("actuation.wheels.speed_max_m_s", wheels.speed_max_m_s)?;
        }
        let fades_s = self.actuation.gust.time_constant_s;
        within("actuation.gust.time_constant_s", fades_s, Bounds::SIZE, Bounds::number)
    }

    /// Whether its sensors, changed since they were read, are a list that can be.
    fn check_sensors(&self) -> Result<(), SensorFlaw> {
        sensors(&self.sensor_entries()).map(|_| ())
    }

    fn check_sensing(&self) -> Result<(), ProfileError> {
        let sensing = &self.sensing;
        for (key, found) in [
            ("sensing.true_positive", sensing.true_positive),
            ("sensing.false_positive", sensing.false_positive),
        ] {
            within(key, found, Bounds::PROBABILITY, Bounds::probability)?;
        }
        let latency_steps = sensing.latency_steps.into();
        within("sensing.latency_steps", latency_steps, Bounds::AMOUNT, Bounds::number)?;
        match (&sensing.cone, &sensing.polygon_m) {
            (Some(cone), None) => {
                within("sensing.cone.range_m", cone.range_m, Bounds::SIZE, Bounds::number)?;
                half_angle(cone.half_angle_rad, sensing.sees).map_err(|expected| {
                    let (name, found) = ("sensing.cone.half_angle_rad", cone.half_angle_rad);
                    OutOfRange { name, found, expected }.into()
                })
            }
            (None, Some(corners_m)) => {
                for coordinate in corners_m.iter().flatten() {
                    let bounds = Bounds::COORDINATE;
                    within("sensing.polygon_m", *coordinate, bounds, Bounds::number)?;
                }
                if is_convex(corners_m) {
                    return Ok(());
                }
                Err(ProfileError::Polygon(corners_m.len()))
            }
            _ => Err(ProfileError::Region),
        }
    }
}

fn within(
    name: &'static str,
    found: f64,
    bounds: Bounds,
    expected: impl Fn(Bounds) -> String,
) -> Result<(), ProfileError> {
    if bounds.contains(found) {
        return Ok(());
    }
    Err(OutOfRange { name, found, expected: expected(bounds).into() }.into())
}

fn positive(name: &'static str, found: f64) -> Result<(), ProfileError> {
    if found > 0.0 && found.is_finite() {
        return Ok(());
    }
    Err(OutOfRange { name, found, expected: "a finite number above 0".into() }.into())
}

fn limits(name: &'static str, [least, found]: [f64; 2]) -> Result<(), ProfileError> {
    if least >= 0.0 && found > least && found.is_finite() {
        return Ok(());
    }
    Err(OutOfRange { name, found, expected: "limits with 0 <= least < most".into() }.into())
}

fn gains(key: &'static str, table: impl Iterator<Item = (f64, f64)>) -> Result<(), ProfileError> {
    let table: Vec<(f64, f64)> = table.collect();
    let ascending = table.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if table.is_empty() || !ascending {
        return Err(ProfileError::GainTable(key));
    }
    for (command, mean) in table {
        positive(key, command)?;
        within(key, mean, Bounds::GAIN, Bounds::number)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::sensor::Sees;

    #[test]
    fn what_no_sweep_could_simulate_is_refused_by_its_key() {
        let flockbot = include_str!("../../../../../launch_configs/profiles/flockbot.yaml");
        let flockbot = RobotProfile::parse("flockbot.yaml", flockbot).unwrap();
        let refusal = |change: fn(&mut RobotProfile)| {
            let mut robot = flockbot.clone();
            change(&mut robot);
            robot.check().expect_err("it cannot be simulated").to_string()
        };

        assert_eq!(
            refusal(|robot| robot.actuation.yaw_lag_s = 2000.0),
            "actuation.yaw_lag_s is 2000, expected a number from 0 to 1000"
        );
        assert_eq!(
            refusal(|robot| robot.sensing.latency_steps = 1001),
            "sensing.latency_steps is 1001, expected a number from 0 to 1000"
        );
        assert_eq!(
            refusal(|robot| robot.body.radius_m = 1e7),
            "body.radius_m is 10000000, expected a number from 0.000001 to 1000000"
        );
    }

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
