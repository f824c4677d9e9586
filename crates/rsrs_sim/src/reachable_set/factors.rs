//! Which factors would contain real trajectories.

use rsrs_core::conditions::Settings;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::trials::trial::DrivenTrial;

use super::{ReachError, ReachOptions, validate};

/// The smallest factors with which trajectories are contained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallestFactors {
    /// The factors; only those of motion differ from what was given.
    pub factors: HarsherFactors,
    /// Probability that as many simulated trials leave, with them.
    pub p_value: f64,
}

/// Largest factor that is tried: a gain that varies by more is no model any more.
const MOST_FACTOR: f64 = 64.0;

/// Searches the smallest spread of gains, drift or gusts that contains real trajectories, as
/// [`validate`] holds them against the robot; all other factors are as given.
///
/// One factor at a time is raised: the spread of the gains first, with drift and gusts as they were
/// measured; if no spread helps, drift; then gusts; and at last all three together. Each is found to
/// 5 %. What the robot does not have is not raised alone.
///
/// `None` if none helps up to a factor of 64: then the robots do what the profile has no disturbance
/// for (no bias, no heading noise, no gusts, no lag), and no factor can widen what is not there.
pub fn smallest_factors(
    measured: &RobotProfile,
    factors: HarsherFactors,
    settings: &Settings,
    trials: &[DrivenTrial],
    options: &ReachOptions,
) -> Result<Option<SmallestFactors>, ReachError> {
    let tried = |factors: HarsherFactors| {
        let robot = factors.apply(measured)?;
        let found = validate(&robot, settings, trials, options)?;
        Ok(found.is_contained.then_some(SmallestFactors { factors, p_value: found.p_value }))
    };
    for raised in ways(measured) {
        let found = smallest(|factor| tried(raised(factors, factor)))?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// Raises some factors of motion.
type Way = fn(HarsherFactors, f64) -> HarsherFactors;

/// What can be raised for a robot, in the order in which it is tried.
fn ways(measured: &RobotProfile) -> Vec<Way> {
    let turn = &measured.actuation.turn;
    let drifts = turn.bias_sd_rad_s > 0.0 || turn.heading_noise_sd_rad > 0.0;
    let is_gusty = measured.actuation.gust.sd_m_s > 0.0;
    let mut ways: Vec<Way> = vec![|factors, factor| HarsherFactors {
        gain_sd_factor: factor,
        drift_factor: 1.0,
        gust_factor: 1.0,
        ..factors
    }];
    if drifts {
        ways.push(|factors, factor| HarsherFactors { drift_factor: factor, ..factors });
    }
    if is_gusty {
        ways.push(|factors, factor| HarsherFactors { gust_factor: factor, ..factors });
    }
    if drifts || is_gusty {
        ways.push(|factors, factor| HarsherFactors {
            gain_sd_factor: factors.gain_sd_factor.max(factor),
            drift_factor: factor,
            gust_factor: factor,
            ..factors
        });
    }
    ways
}

/// Doubles a factor from 1 until it helps, then halves the gap until it is 5 %.
fn smallest(
    tried: impl Fn(f64) -> Result<Option<SmallestFactors>, ReachError>,
) -> Result<Option<SmallestFactors>, ReachError> {
    let (mut low, mut high) = (1.0, 1.0);
    let mut best = tried(high)?;
    if best.is_some() {
        return Ok(best);
    }
    while best.is_none() {
        if high >= MOST_FACTOR {
            return Ok(None);
        }
        low = high;
        high *= 2.0;
        best = tried(high)?;
    }
    while high / low > 1.05 {
        let middle = (low * high).sqrt();
        match tried(middle)? {
            None => low = middle,
            found => (best, high) = (found, middle),
        }
    }
    Ok(best)
}
