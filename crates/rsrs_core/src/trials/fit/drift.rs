//! Bias, heading noise and gusts from straight runs: how far they ended from straight.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::statistics::variance::{Estimate, MeanSquare};
use crate::trials::trial::{SpeedTrial, Trials};

/// How a robot strays from a straight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Straight runs that were used.
    pub n_trials: usize,
    /// Which column was used.
    pub from: DriftSource,
    /// Standard deviation between robots, about zero, of a turning-rate bias; in
    /// radians per second.
    pub bias_sd_rad_s: Estimate,
    /// Standard deviation of the heading's random change in one control period, in radians; `None`
    /// if no robot drove twice.
    pub heading_noise_sd_rad: Option<Estimate>,
    /// Standard deviation of gusts on each axis, in metres per second, for the assumed correlation
    /// time; `None` without both columns.
    pub gust_sd_m_s: Option<Estimate>,
}

/// Which column gives how a robot strayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DriftSource {
    /// `heading_change_rad`.
    HeadingChangeRad,
    /// `lateral_m`, where headings were not measured.
    LateralM,
}

/// Times that a bag or a stopwatch gives, and straight runs do not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Control period, in seconds.
    pub period_s: f64,
    /// Correlation time of gusts, in seconds.
    pub gust_time_constant_s: f64,
}

/// A straight run as a mean turning rate.
struct Stray {
    robot: usize,
    rate_rad_s: f64,
    duration_s: f64,
}

/// Separates bias, heading noise and gusts; `None` if no run gives its end point.
///
/// With bias `b` and heading noise `s` per period `Δt`, a run of `T` changes the heading by `bT` and
/// noise of variance `s²T/Δt`. Over a length `L` it ends beside the line by `LbT/2` and noise of
/// variance `L²s²T/(3Δt)`. What the heading change does not explain of the lateral distance,
/// `L²s²T/(12Δt)`, is exceeded by gusts of `2g²τ(T - τ(1 - exp(-T/τ)))`.
///
/// # Source
///
/// The moments of a random walk, of its integral and of a Brownian bridge's; small angles.
pub fn drift(trials: &Trials<SpeedTrial>, times: Times) -> Option<Drift> {
    let with_heading: Vec<Stray> = trials.rows.iter().filter_map(by_heading).collect();
    let with_lateral = || trials.rows.iter().filter_map(by_lateral).collect::<Vec<Stray>>();
    // Variance of the rate times T, over s²/Δt.
    let (from, strays, noise_factor) = if with_heading.is_empty() {
        (DriftSource::LateralM, with_lateral(), 4.0 / 3.0)
    } else {
        (DriftSource::HeadingChangeRad, with_heading, 1.0)
    };
    if strays.is_empty() {
        return None;
    }
    let (bias, noise) = components(&strays);
    let mut terms = vec![bias.own];
    terms.extend(noise.map(|noise| MeanSquare { weight: -bias.noise_share, ..noise }));
    let per_step = (times.period_s / noise_factor).sqrt();
    Some(Drift {
        n_trials: strays.len(),
        from,
        bias_sd_rad_s: Estimate::of_variance(&terms).sd(1.0),
        heading_noise_sd_rad: noise.map(|noise| Estimate::of_variance(&[noise]).sd(per_step)),
        gust_sd_m_s: match from {
            DriftSource::HeadingChangeRad => gust(trials, noise, times),
            DriftSource::LateralM => None,
        },
    })
}

fn by_heading(trial: &SpeedTrial) -> Option<Stray> {
    let rate_rad_s = trial.heading_change_rad? / trial.duration_s;
    Some(Stray { robot: trial.robot, rate_rad_s, duration_s: trial.duration_s })
}

fn by_lateral(trial: &SpeedTrial) -> Option<Stray> {
    let lateral_m = trial.lateral_m.filter(|_| trial.distance_m > 0.0)?;
    let rate_rad_s = 2.0 * lateral_m / (trial.distance_m * trial.duration_s);
    Some(Stray { robot: trial.robot, rate_rad_s, duration_s: trial.duration_s })
}

struct Bias {
    /// Mean square of the robots' mean rates.
    own: MeanSquare,
    /// How much of the noise's mean square is in it.
    noise_share: f64,
}

/// Mean squares between robots, about zero, and within robots; runs count by their duration.
fn components(strays: &[Stray]) -> (Bias, Option<MeanSquare>) {
    let mut robots: BTreeMap<usize, Vec<&Stray>> = BTreeMap::new();
    for stray in strays {
        robots.entry(stray.robot).or_default().push(stray);
    }
    let n_robots = robots.len() as f64;
    let (mut between, mut within, mut noise_share) = (0.0, 0.0, 0.0);
    for strays in robots.values() {
        let duration_s: f64 = strays.iter().map(|stray| stray.duration_s).sum();
        let mean_rad_s: f64 =
            strays.iter().map(|stray| stray.rate_rad_s * stray.duration_s).sum::<f64>()
                / duration_s;
        between += mean_rad_s * mean_rad_s / n_robots;
        noise_share += 1.0 / duration_s / n_robots;
        for stray in strays {
            let away_rad_s = stray.rate_rad_s - mean_rad_s;
            within += away_rad_s * away_rad_s * stray.duration_s;
        }
    }
    let df = strays.len() as f64 - n_robots;
    let noise = (df > 0.0).then(|| MeanSquare { weight: 1.0, value: within / df, df });
    (Bias { own: MeanSquare { weight: 1.0, value: between, df: n_robots }, noise_share }, noise)
}

fn gust(trials: &Trials<SpeedTrial>, noise: Option<MeanSquare>, times: Times) -> Option<Estimate> {
    let noise = noise?;
    let (mut value, mut noise_share, mut n) = (0.0, 0.0, 0.0);
    for trial in &trials.rows {
        let (Some(lateral_m), Some(change_rad)) = (trial.lateral_m, trial.heading_change_rad)
        else {
            continue;
        };
        let unexplained_m = lateral_m - trial.distance_m * change_rad / 2.0;
        let (length_m, duration_s, tau_s) =
            (trial.distance_m, trial.duration_s, times.gust_time_constant_s);
        let calm_share = 1.0 - libm::exp(-duration_s / tau_s);
        let per_gust_s2 = 2.0 * tau_s * (duration_s - tau_s * calm_share);
        value += unexplained_m * unexplained_m / per_gust_s2;
        noise_share += length_m * length_m * duration_s / 12.0 / per_gust_s2;
        n += 1.0;
    }
    if n == 0.0 {
        return None;
    }
    let terms = [
        MeanSquare { weight: 1.0, value: value / n, df: n },
        MeanSquare { weight: -noise_share / n, ..noise },
    ];
    Some(Estimate::of_variance(&terms).sd(1.0))
}
