//! Noise of single steps from trajectories, which whole trials average away.

use serde::Serialize;

use crate::statistics::variance::Estimate;
use crate::trials::trial::DrivenTrial;

/// Noise from step to step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StepNoise {
    /// Trajectories under a constant command that were used.
    pub n_trials: usize,
    /// Standard deviation of the heading's random change in one control period, in radians.
    pub heading_noise_sd_rad: Estimate,
    /// Standard deviation of the speed gain from step to step; `None` if no robot drove forward.
    pub speed_step_sd: Option<Estimate>,
}

/// Fewest steps of a trajectory from which noise is taken.
const LEAST_STEPS: usize = 20;

/// Separates noise of the robot, in a control period of `period_s`, from noise of the tracker;
/// `None` if no trajectory under a constant command has 20 steps.
///
/// Noise of the robot adds up; an error of the tracker is there in one sample and gone in the next,
/// so it moves two neighbouring differences apart. The variance of the differences plus twice their
/// covariance with the next ones keeps the first and cancels the second. Trajectories are evenly
/// sampled, and every one under a constant command counts alike; the interval is Student's over
/// trajectories. Gusts are part of the speed's noise.
///
/// # Source
///
/// R. Roll, "A simple implicit measure of the effective bid-ask spread", Journal of Finance 39, 1984,
/// has the same separation for prices.
pub fn step_noise(trials: &[DrivenTrial], period_s: f64) -> Option<StepNoise> {
    let (mut headings, mut gains) = (Vec::new(), Vec::new());
    for trial in trials {
        let n_steps = trial.samples.len() - 1;
        let Some(command) = trial.constant_command().filter(|_| n_steps >= LEAST_STEPS) else {
            continue;
        };
        let interval_s = trial.duration_s() / n_steps as f64;
        let turned: Vec<f64> = pairs(trial, |_, heading_rad| heading_rad);
        headings.push(lasting_variance(&turned) * period_s / interval_s);
        if command.speed_m_s > 0.0 {
            let driven: Vec<f64> = pairs(trial, |ahead_m, _| ahead_m / command.speed_m_s);
            gains.push(lasting_variance(&driven) / (period_s * interval_s));
        }
    }
    if headings.is_empty() {
        return None;
    }
    let sd = |variances: &[f64]| {
        let mean = Estimate::of_mean(variances);
        let floor = |bound: f64| bound.max(0.0);
        let Estimate { value, low, high } = mean;
        Estimate { value: floor(value), low: low.map(floor), high: high.map(floor) }.sd(1.0)
    };
    Some(StepNoise {
        n_trials: headings.len(),
        heading_noise_sd_rad: sd(&headings),
        speed_step_sd: (!gains.is_empty()).then(|| sd(&gains)),
    })
}

/// From each sample to the next: how far ahead, and how far turned.
fn pairs(trial: &DrivenTrial, of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let step = |pair: &[crate::trials::trial::DrivenSample]| {
        let moved = pair[1].pose.relative_to(pair[0].pose);
        of(moved.x_m, moved.heading_rad)
    };
    trial.samples.windows(2).map(step).collect()
}

/// Variance of what adds up, without what comes and goes; may be negative by chance.
fn lasting_variance(differences: &[f64]) -> f64 {
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let away = |difference: &f64| difference - mean;
    let own: f64 = differences.iter().map(|difference| away(difference) * away(difference)).sum();
    let next: f64 = differences.windows(2).map(|pair| away(&pair[0]) * away(&pair[1])).sum();
    // Taking off the mean costs three of n differences: one of the variance, two of the covariance.
    (own + 2.0 * next) / (n - 3.0)
}
