//! What the tests of physics share: Flockbots, changed in one way or another, and how often they
//! mill.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rsrs_core::conditions::{
    Arena, Conditions, GainDistribution, Placement, Region, SimulatedRobot, Walls,
};
use rsrs_core::controller::ControllerParameters;
use rsrs_core::phase::Phase;
use rsrs_core::profile::Sees;
use rsrs_sim::batch::{Batch, Judged};

/// Nine harsher Flockbots at 0.15 m/s and 0.75 rad/s, placed in a disc of 0.825 m.
pub fn harsher_flockbots() -> Conditions {
    let gain = GainDistribution { mean: 0.97, robot_sd: 0.05, step_sd: 0.0 };
    Conditions {
        robots: 9,
        controller: ControllerParameters { speed_m_s: 0.15, turn_rate_rad_s: 0.75 },
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
            true_positive: 0.80,
            false_positive: 0.08,
            latency_steps: 0,
        },
        period_s: 0.13,
    }
}

/// Robots without noise, each delivering exactly what it is told.
pub fn perfect_flockbots() -> Conditions {
    let mut conditions = harsher_flockbots();
    let gain = GainDistribution { mean: 1.0, robot_sd: 0.0, step_sd: 0.0 };
    (conditions.robot.speed_gain, conditions.robot.turn_gain) = (gain, gain);
    (conditions.robot.true_positive, conditions.robot.false_positive) = (1.0, 0.0);
    conditions
}

/// How many replicates of each cell end in stable milling; two cells at a time.
pub fn n_milling(cells: &[Conditions], replicates: u64, duration_s: f64) -> Vec<u64> {
    let next = AtomicUsize::new(0);
    let counts: Vec<AtomicU64> = cells.iter().map(|_| AtomicU64::new(0)).collect();
    let work = || {
        let mut batch = Batch::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(cell) = cells.get(index) else {
                return;
            };
            let judged = batch.judge(cell, (1, 0..replicates), duration_s).expect("fit and long");
            let is_mill = |judged: &&Judged| judged.verdict.phase == Phase::StableMilling;
            counts[index].store(judged.iter().filter(is_mill).count() as u64, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    counts.into_iter().map(AtomicU64::into_inner).collect()
}
