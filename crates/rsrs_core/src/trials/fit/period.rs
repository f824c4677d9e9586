//! How often robots decide, and how regularly.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Estimate, MeanSquare, sd};
use crate::statistics::variance::{mean, squared_deviations};
use crate::trials::trial::{PeriodTrial, Trials};

/// The control period of a kind of robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PeriodFit {
    /// Mean over robots, in seconds, with Student's interval over robots; for one robot, or for one
    /// reading of each, over the readings.
    pub period_s: Estimate,
    /// Standard deviation of one robot's period from reading to reading, in seconds; `None` if no
    /// robot was read twice.
    pub jitter_s: Option<Estimate>,
    /// Longest reading, in seconds.
    pub longest_s: f64,
}

/// Mean period and jitter.
///
/// # Panics
///
/// If there is no reading: a parsed table has one.
pub fn period(trials: &Trials<PeriodTrial>) -> PeriodFit {
    let mut robots: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for trial in &trials.rows {
        robots.entry(trial.robot).or_default().push(trial.period_s);
    }
    let all: Vec<f64> = trials.rows.iter().map(|trial| trial.period_s).collect();
    let means: Vec<f64> = robots.values().map(|periods_s| mean(periods_s)).collect();
    let df = (all.len() - robots.len()) as f64;
    let squares: f64 = robots.values().map(|periods_s| squared_deviations(periods_s)).sum();
    let jitter = MeanSquare { weight: 1.0, value: squares / df, df };
    PeriodFit {
        period_s: Estimate::of_mean(if sd(&means).is_some() { &means } else { &all }),
        jitter_s: (df > 0.0).then(|| Estimate::of_variance(&[jitter]).sd(1.0)),
        longest_s: all.iter().copied().fold(0.0, f64::max),
    }
}
