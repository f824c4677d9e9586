//! Conditions that the tests share: nine Flockbots, without the gain table and the provenance of
//! their profile.

use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::{
    Arena, Conditions, GainDistribution, Placement, Region, SimulatedRobot, Walls,
};
use rsrs_core::controller::ControllerParameters;
use rsrs_core::profile::Sees;
use rsrs_sim::sweep::{Runs, Swept, Watch, sweep};

/// A robot's imperfections: standard deviation of both gains, detection, false positives.
pub struct Imperfection {
    pub gain_sd: f64,
    pub true_positive: f64,
    pub false_positive: f64,
}

pub const PERFECT: Imperfection =
    Imperfection { gain_sd: 0.0, true_positive: 1.0, false_positive: 0.0 };

pub const HARSHER: Imperfection =
    Imperfection { gain_sd: 0.05, true_positive: 0.80, false_positive: 0.08 };

/// Nine Flockbots at a speed and turning rate, placed in a disc of 0.825 m.
pub fn flockbots(speed_m_s: f64, turn_rate_rad_s: f64, imperfection: &Imperfection) -> Conditions {
    let gain = GainDistribution { mean: 0.97, robot_sd: imperfection.gain_sd, step_sd: 0.0 };
    Conditions {
        robots: 9,
        controller: ControllerParameters { speed_m_s, turn_rate_rad_s },
        placement: Placement::DiscFacingOut { radius_m: 0.825 },
        arena: Arena { side_m: 15.0, walls: Walls::Stop },
        robot: SimulatedRobot {
            radius_m: 0.075,
            front_half_angle_rad: 70_f64.to_radians(),
            rotates_while_blocked: true,
            speed_gain: gain,
            turn_gain: gain,
            turn_bias_sd_rad_s: 0.0,
            heading_noise_sd_rad: 0.0,
            gust_sd_m_s: 0.0,
            gust_time_constant_s: 2.0,
            yaw_lag_s: 0.0,
            sees: Sees::Body,
            region: Region::Cone { half_angle_rad: 0.2, range_m: 0.75 },
            true_positive: imperfection.true_positive,
            false_positive: imperfection.false_positive,
            latency_steps: 0,
        },
        period_s: 0.13,
    }
}

/// Sweeps without anybody looking on.
pub fn quietly(conditions: &[Conditions], runs: Runs) -> Swept {
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
    sweep(conditions, runs, watch).expect("the robots fit and the runs are long enough")
}
