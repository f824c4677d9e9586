//! Trials that do not belong to the others.

use std::collections::BTreeMap;

use serde::Serialize;

use super::observation::Observation;
use crate::statistics::quantile::{student, student_two_sided};
use crate::statistics::variance::{mean, squared_deviations};

/// A trial that is too far from the others of its robot and command to be one of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// Line of the table.
    pub line: u64,
    /// Position of the robot's name.
    #[serde(skip)]
    pub robot: usize,
    /// The command.
    pub command: f64,
    /// The trial's gain.
    pub gain: f64,
    /// Mean gain of all trials of this robot at this command, this one included.
    pub mean_gain: f64,
    /// Probability that the farthest of as many good trials is at least so far out: the smaller,
    /// the stranger.
    pub p_value: f64,
}

/// Most that [`Outlier::p_value`] may be for a trial to be named.
const LEVEL: f64 = 0.05;

/// Names trials by their externally studentised residuals about the mean of their robot and
/// command, with Bonferroni's correction for how many trials there are.
///
/// # Source
///
/// R. D. Cook, S. Weisberg, "Residuals and Influence in Regression", 1982, 2.2.2; the `outlier_test`
/// of statsmodels, against which it is checked.
pub fn outliers(observations: &[Observation]) -> Vec<Outlier> {
    let mut cells: BTreeMap<(usize, u64), Vec<f64>> = BTreeMap::new();
    for observation in observations {
        cells
            .entry((observation.robot, observation.command.to_bits()))
            .or_default()
            .push(observation.gain);
    }
    let df = observations.len() as f64 - cells.len() as f64;
    let squares: f64 = cells.values().map(|gains| squared_deviations(gains)).sum();
    if df < 2.0 || squares == 0.0 {
        return Vec::new();
    }
    let cells: BTreeMap<(usize, u64), (usize, f64)> =
        cells.into_iter().map(|(cell, gains)| (cell, (gains.len(), mean(&gains)))).collect();
    // Most trials are near enough for their probability not to be worth computing.
    let n = observations.len() as f64;
    let near = 0.99 * student(df - 1.0, 1.0 - LEVEL / n / 2.0);
    let outlier = |observation: &Observation| {
        let (n_trials, mean_gain) = cells[&(observation.robot, observation.command.to_bits())];
        if n_trials < 2 {
            return None;
        }
        let spare = 1.0 - 1.0 / n_trials as f64;
        let residual = observation.gain - mean_gain;
        let without = squares - residual * residual / spare;
        // All others agree exactly: then any distance is too far.
        let p_value = if without <= 1e-12 * squares {
            0.0
        } else {
            let t = residual / (without / (df - 1.0) * spare).sqrt();
            if t.abs() < near {
                return None;
            }
            (student_two_sided(df - 1.0, t) * n).min(1.0)
        };
        (p_value < LEVEL).then_some(Outlier {
            line: observation.line,
            robot: observation.robot,
            command: observation.command,
            gain: observation.gain,
            mean_gain,
            p_value,
        })
    };
    observations.iter().filter_map(outlier).collect()
}
