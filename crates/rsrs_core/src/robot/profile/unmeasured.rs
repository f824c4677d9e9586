//! What stands in for a profile while there is none.

use super::{
    Actuation, Body, Computation, Gust, Provenance, RobotProfile, SpeedActuation, SpeedGain,
    TurnActuation, TurnGain,
};
use crate::robot::contact::ContactModel;
use crate::robot::sensor::{Cone, Sees, Sensing, SensorDetails};

/// Stands in for a limit of 0, which no profile may have: that of robots that only turn, or only drive.
const LEAST_LIMIT: f64 = 1e-3;

impl RobotProfile {
    /// A robot of which nothing is known but how fast it may be commanded, in m/s and rad/s, and
    /// how often it senses, in seconds: it executes commands exactly, is a point, and detects
    /// nothing.
    pub fn unmeasured([most_m_s, most_rad_s]: [f64; 2], period_s: f64) -> Self {
        let (most_m_s, most_rad_s) = (most_m_s.max(LEAST_LIMIT), most_rad_s.max(LEAST_LIMIT));
        Self {
            name: "unmeasured".to_owned(),
            body: Body {
                radius_m: 1e-3,
                front_half_angle_rad: 0.0,
                rotates_while_blocked: true,
                contact: ContactModel::Stop,
                contact_friction: None,
            },
            actuation: Actuation {
                speed: SpeedActuation {
                    limits_m_s: [0.0, most_m_s],
                    gain_by_command: vec![SpeedGain { commanded_m_s: most_m_s, mean: 1.0 }],
                    robot_sd: 0.0,
                    step_sd: 0.0,
                },
                turn: TurnActuation {
                    limits_rad_s: [0.0, most_rad_s],
                    gain_by_command: vec![TurnGain { commanded_rad_s: most_rad_s, mean: 1.0 }],
                    driving_gain_by_command: None,
                    robot_sd: 0.0,
                    step_sd: 0.0,
                    bias_sd_rad_s: 0.0,
                    heading_noise_sd_rad: 0.0,
                },
                wheels: None,
                gust: Gust { sd_m_s: 0.0, time_constant_s: 1.0 },
                yaw_lag_s: 0.0,
            },
            sensing: Sensing {
                sees: Sees::Centre,
                cone: Some(Cone { half_angle_rad: 0.1, range_m: 0.1 }),
                polygon_m: None,
                true_positive: 0.0,
                false_positive: 0.0,
                latency_steps: 0,
                details: SensorDetails::default(),
            },
            further_sensors: Vec::new(),
            computation: Computation { period_s },
            provenance: Provenance {
                source: "nothing was measured yet: the limits are the greatest commands of the \
                         trials, all else stands for nothing"
                    .to_owned(),
                ..Provenance::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_of_which_nothing_is_known_is_one() {
        for limits in [[0.3, 2.5], [0.0, 1.0], [0.2, 0.0]] {
            assert_eq!(RobotProfile::unmeasured(limits, 0.13).check(), Ok(()), "{limits:?}");
        }
    }
}
