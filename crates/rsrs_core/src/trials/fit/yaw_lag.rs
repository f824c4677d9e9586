//! How a turning rate follows a command that has changed.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::statistics::variance::{Estimate, mean};
use crate::trials::trial::DrivenTrial;

/// The time constant with which the turning rate follows its command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct YawLag {
    /// Trajectories in which the commanded turning rate changed.
    pub n_trials: usize,
    /// Robots that drove them.
    pub n_robots: usize,
    /// The time constant, in seconds, with Student's interval over robots, or over the trajectories
    /// of one robot.
    pub lag_s: Estimate,
    /// The gain with which the robots turned, apart from the lag; dimensionless, with its interval.
    pub gain: Estimate,
    /// Control period of the simulated robot that lags, in seconds: a lag of one period or less is
    /// none.
    pub period_s: f64,
    /// How much more likely the trajectories are with the lag than without one, as a difference of
    /// log likelihoods, in nats.
    pub log_likelihood_gain: f64,
}

impl YawLag {
    /// Whether the lag is significant: the whole interval lies above one control period, with
    /// which the simulated robot follows at once, and it explains more than chance does. Of robots
    /// that follow at once any lag explains equally much, so that their interval means nothing.
    pub fn is_certain(&self) -> bool {
        let is_above = self.lag_s.low.is_some_and(|low_s| low_s > self.period_s * (1.0 + ROUNDING));
        is_above && self.log_likelihood_gain > CHANCE.0 + CHANCE.1 * self.n_trials as f64
    }
}

/// What headings and times that are written with a few digits may make of no lag; a share of a period.
const ROUNDING: f64 = 0.02;
/// What a lag that is none explains at most by chance, in nats: altogether, and for each trajectory. A
/// free parameter explains half a nat on average.
const CHANCE: (f64, f64) = (6.0, 2.0);
/// What rounding leaves over at least; a share of the sum of squares.
const LEAST_LEFT_OVER: f64 = 1e-6;
/// Fewest samples of a trajectory from which a lag is taken.
const LEAST_SAMPLES: usize = 10;
/// Shares of the way to its target that a turning rate goes in one period, between which the best is
/// searched. More than 1 would swing, and is allowed so that robots without a lag are not all on one
/// side of it.
const SHARES: [f64; 2] = [0.02, 1.5];
/// Steps of the search; each makes the gap smaller by the golden ratio.
const STEPS: u32 = 40;

/// Fits the time constant of the turning rate to trajectories of robots that stood at their first
/// sample; `None` if nothing is to turn in any of them.
///
/// In each control period the simulated rate goes the share period/lag of the way to what is
/// commanded. For each trajectory that share is searched with which the command, delayed so, explains
/// the changes of the heading best, by least squares with a free gain. A command that arrives up to
/// one period late is identified by a second gain, of the delayed command one period earlier.
pub fn yaw_lag(from_rest: &[DrivenTrial], period_s: f64) -> Option<YawLag> {
    let mut lags_s: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut gains: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut log_likelihood_gain = 0.0;
    for trial in from_rest {
        let rates = Rates::new(trial, period_s);
        if let Some(share) = best_share(&rates) {
            log_likelihood_gain += rates.log_likelihood_gain(share);
            lags_s.entry(&trial.robot).or_default().push(period_s / share);
            gains.entry(&trial.robot).or_default().push(rates.delayed(share).gain);
        }
    }
    let n_trials = lags_s.values().map(Vec::len).sum();
    let (lag_s, gain) = (over_robots(&lags_s)?, over_robots(&gains)?);
    Some(YawLag { n_trials, n_robots: lags_s.len(), lag_s, gain, period_s, log_likelihood_gain })
}

/// The mean over robots, or over the trials of one.
fn over_robots(robots: &BTreeMap<&str, Vec<f64>>) -> Option<Estimate> {
    let means: Vec<f64> = robots.values().map(|numbers| mean(numbers)).collect();
    match (means.len(), robots.values().next()?) {
        (1, numbers) => Some(Estimate::of_mean(numbers)),
        _ => Some(Estimate::of_mean(&means)),
    }
}

/// A trajectory in steps of one control period.
struct Rates {
    /// Commanded turning rates, in radians per second; shape `[n_steps]`.
    commanded_rad_s: Vec<f64>,
    /// Turning rates that were seen, in radians per second; shape `[n_steps]`.
    seen_rad_s: Vec<f64>,
}

/// What a command delayed by a share explains.
struct Delayed {
    /// The rate over what was commanded; dimensionless.
    gain: f64,
    /// What is left of the seen rates, as a sum of squares.
    left_over: f64,
}

impl Rates {
    fn new(trial: &DrivenTrial, period_s: f64) -> Self {
        let n_steps = (trial.duration_s() / period_s + 1e-6) as usize;
        let heading_rad = |step: usize| trial.displacement_at(step as f64 * period_s).heading_rad;
        let seen = |step: usize| (heading_rad(step + 1) - heading_rad(step)) / period_s;
        let commanded = |step: usize| trial.command_at(step as f64 * period_s).turn_rate_rad_s;
        Self {
            commanded_rad_s: (0..n_steps).map(commanded).collect(),
            seen_rad_s: (0..n_steps).map(seen).collect(),
        }
    }

    /// How much more likely the seen rates are with a share than with all of the way at once, in nats.
    fn log_likelihood_gain(&self, share: f64) -> f64 {
        let least = LEAST_LEFT_OVER * self.seen_rad_s.iter().map(|rate| rate * rate).sum::<f64>();
        if least <= 0.0 {
            return 0.0;
        }
        let left_over = |share| self.delayed(share).left_over.max(least);
        let ratio = left_over(1.0) / left_over(share);
        self.seen_rad_s.len() as f64 / 2.0 * libm::log(ratio)
    }

    /// What the command delayed by a share explains of the seen rates.
    fn delayed(&self, share: f64) -> Delayed {
        let mut rate_rad_s = 0.0;
        let mut before_rad_s = 0.0;
        // Normal equations of two gains: of the delayed command, and of it one period earlier.
        let (mut own, mut both, mut earlier) = (0.0, 0.0, 0.0);
        let (mut own_seen, mut earlier_seen, mut seen_seen) = (0.0, 0.0, 0.0);
        for (commanded_rad_s, seen_rad_s) in self.commanded_rad_s.iter().zip(&self.seen_rad_s) {
            rate_rad_s += share * (commanded_rad_s - rate_rad_s);
            own += rate_rad_s * rate_rad_s;
            both += rate_rad_s * before_rad_s;
            earlier += before_rad_s * before_rad_s;
            own_seen += rate_rad_s * seen_rad_s;
            earlier_seen += before_rad_s * seen_rad_s;
            seen_seen += seen_rad_s * seen_rad_s;
            before_rad_s = rate_rad_s;
        }
        let determinant = own * earlier - both * both;
        if determinant > 1e-9 * own * earlier {
            // The second may be below zero by chance: kept above it, it would take from the lag.
            let first = (own_seen * earlier - earlier_seen * both) / determinant;
            let second = (earlier_seen * own - own_seen * both) / determinant;
            let left_over = seen_seen - first * own_seen - second * earlier_seen;
            return Delayed { gain: first + second, left_over };
        }
        let gain = if own > 0.0 { own_seen / own } else { 0.0 };
        Delayed { gain, left_over: seen_seen - gain * own_seen }
    }
}

/// The share of the way that explains the rates best; `None` if nothing was to turn.
fn best_share(rates: &Rates) -> Option<f64> {
    let turns = rates.commanded_rad_s.iter().any(|rate_rad_s| *rate_rad_s != 0.0);
    if !turns || rates.commanded_rad_s.len() < LEAST_SAMPLES {
        return None;
    }
    // On a coarse grid first, in the logarithm: what is left over may have two valleys.
    let [low, high] = SHARES.map(libm::log);
    let left_over = |logarithm: f64| rates.delayed(libm::exp(logarithm)).left_over;
    let n = 24_u32;
    let at = |place: u32| low + (high - low) * f64::from(place) / f64::from(n);
    let best = (0..=n).min_by(|left, right| left_over(at(*left)).total_cmp(&left_over(at(*right))));
    let best = best.expect("there is a grid");
    let (mut from, mut to) = (at(best.saturating_sub(1)), at((best + 1).min(n)));
    let golden = (5_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..STEPS {
        let (left, right) = (to - golden * (to - from), from + golden * (to - from));
        if left_over(left) < left_over(right) { to = right } else { from = left }
    }
    Some(libm::exp(f64::midpoint(from, to)))
}
