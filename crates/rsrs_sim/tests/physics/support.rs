//! What the tests of physics share: Flockbots, changed in one way or another, and how often they
//! mill.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rsrs_core::conditions::{Conditions, GainDistribution};
use rsrs_core::judge::phase::{Phase, Verdict};
use rsrs_sim::batch::Batch;

use rsrs_testing::conditions::flockbot_conditions;

/// Robots without noise, each executing its commands exactly.
pub fn perfect_flockbots() -> Conditions {
    let mut conditions = flockbot_conditions();
    let gain = GainDistribution { mean: 1.0, robot_sd: 0.0, step_sd: 0.0 };
    (conditions.robot.speed_gain, conditions.robot.turn_gain) = (gain, gain);
    (conditions.robot.true_positive, conditions.robot.false_positive) = (1.0, 0.0);
    conditions
}

/// How many replicates of each cell end in stable milling; two cells at a time.
pub fn n_milling(cells: &[Conditions], replicates: u64, duration_s: f64) -> Vec<u64> {
    count(cells, replicates, duration_s, |judged| judged.phase == Phase::STABLE_MILLING)
}

/// How many replicates of each cell are such as is asked for; two cells at a time.
pub fn count(
    cells: &[Conditions],
    replicates: u64,
    duration_s: f64,
    is_such: impl Fn(&Verdict) -> bool + Sync,
) -> Vec<u64> {
    let next = AtomicUsize::new(0);
    let counts: Vec<AtomicU64> = cells.iter().map(|_| AtomicU64::new(0)).collect();
    let work = || {
        let mut batch = Batch::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(cell) = cells.get(index) else {
                return;
            };
            let judged = batch.judge(cell, 1, 0..replicates, duration_s).expect("fit and long");
            let n_such = judged.iter().filter(|judged| is_such(judged)).count();
            counts[index].store(n_such as u64, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    counts.into_iter().map(AtomicU64::into_inner).collect()
}
