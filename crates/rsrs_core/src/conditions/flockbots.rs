//! The robots of the paper, without a file.

use std::collections::BTreeMap;

use super::{Arena, Conditions, GainDistribution, Placement, SimulatedRobot, Walls};
use crate::judge::behaviour::Behaviour;
use crate::robot::contact::ContactModel;
use crate::robot::controller::ControllerParameters;
use crate::robot::region::Region;
use crate::robot::sensor::{Sees, SensorDetails};
use crate::world::WorldFile;

impl Conditions {
    /// Flockbots that are made worse than they are, at 0.15 m/s and 0.75 rad/s, which start in a disc as
    /// dense as that of nine within 0.825 m. All else is set by struct update.
    ///
    /// # Examples
    ///
    /// ```
    /// use rsrs_core::conditions::Conditions;
    /// use rsrs_core::robot::controller::ControllerParameters;
    ///
    /// let slower = Conditions {
    ///     controller: ControllerParameters::mirrored(0.10, 0.75).into(),
    ///     ..Conditions::flockbots(6)
    /// };
    ///
    /// assert_eq!(slower.check(), Ok(()));
    /// ```
    ///
    /// # Source
    ///
    /// §IV and `fig:phase_plot2`.
    pub fn flockbots(n_robots: usize) -> Self {
        let gain = GainDistribution { mean: 0.97, robot_sd: 0.05, step_sd: 0.0 };
        Self {
            robots: n_robots,
            controller: ControllerParameters::mirrored(0.15, 0.75).into(),
            behaviour: Behaviour::MILLING,
            placement: Placement::DiscFacingOut {
                radius_m: 0.825 * libm::sqrt(n_robots as f64 / 9.0),
            },
            arena: Arena { side_m: 15.0, walls: Walls::Stop },
            world: WorldFile::NOTHING,
            robot: SimulatedRobot {
                radius_m: 0.075,
                front_half_angle_rad: 70_f64.to_radians(),
                rotates_while_blocked: true,
                contact: ContactModel::Stop,
                contact_friction: 0.0,
                speed_gain: gain,
                turn_gain: gain,
                turn_bias_sd_rad_s: 0.0,
                heading_noise_sd_rad: 0.0,
                gust_sd_m_s: 0.0,
                gust_time_constant_s: 2.0,
                yaw_lag_s: 0.0,
                sees: Sees::Body,
                region: Region::Cone { half_angle_rad: 0.2, range_m: 0.75 },
                true_positive: 0.80,
                false_positive: 0.08,
                latency_steps: 0,
                details: SensorDetails::default(),
                further_sensors: Vec::new(),
            },
            own_robots: BTreeMap::new(),
            period_s: 0.13,
        }
    }
}
