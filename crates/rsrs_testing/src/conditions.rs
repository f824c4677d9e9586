//! Conditions that tests and benchmarks share: nine harsher Flockbots at (0.15 m/s, 0.75 rad/s).

use rsrs_core::conditions::{
    Arena, Conditions, GainDistribution, Placement, SimulatedRobot, Walls,
};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;

/// What both gains are.
pub const GAIN: GainDistribution = GainDistribution { mean: 0.97, robot_sd: 0.05, step_sd: 0.0 };

/// Nine harsher Flockbots: detection 0.80, false positives 0.08, gain sd 0.05.
pub fn flockbot_conditions() -> Conditions {
    Conditions {
        robots: 9,
        controller: ControllerParameters::mirrored(0.15, 0.75),
        behaviour: Behaviour::Milling,
        placement: Placement::DiscFacingOut { radius_m: 0.825 },
        arena: Arena { side_m: 15.0, walls: Walls::Stop },
        robot: SimulatedRobot {
            radius_m: 0.075,
            front_half_angle_rad: 70_f64.to_radians(),
            rotates_while_blocked: true,
            contact: ContactModel::Stop,
            contact_friction: 0.0,
            speed_gain: GAIN,
            turn_gain: GAIN,
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
        },
        own_robots: std::collections::BTreeMap::new(),
        period_s: 0.13,
    }
}
