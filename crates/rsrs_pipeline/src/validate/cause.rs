//! Whether real robots leave the simulated reach because they turn otherwise: with a lag, or with
//! another gain while they drive than in place.

use rsrs_core::conditions::Settings;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::{RobotProfile, TurnGain};
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::{YawLag, yaw_lag};
use rsrs_core::trials::trial::DrivenTrial;
use rsrs_sim::reachable_set::validate;

use super::Case;
use super::file::Turning;

/// Looks for what the trajectories show of turning, and whether a profile with it contains them.
///
/// It is the least that does: a lag, another gain while driving, or both; `None` if they turn as
/// the profile states, or leave for another reason.
pub fn turning(
    measured: &RobotProfile,
    factors: HarsherFactors,
    settings: &Settings,
    case: &Case,
) -> anyhow::Result<Option<Turning>> {
    let period_s = measured.computation.period_s;
    // Who pushes something turns as that lets them.
    let free: Vec<DrivenTrial> =
        case.from_rest.iter().filter(|trial| !trial.moves_object()).cloned().collect();
    let drive: Vec<DrivenTrial> = free.iter().filter(|trial| drives(trial)).cloned().collect();
    let lag = yaw_lag(&free, period_s).filter(|lag| is_longer(lag, measured));
    let gain = yaw_lag(&drive, period_s)
        .and_then(|found| Some((found.gain, turn_rate_rad_s(&drive)?)))
        .filter(|(gain, rate_rad_s)| is_another(*gain, measured, &drive, *rate_rad_s));
    let (lag_s, gain) = (lag.map(|lag| lag.lag_s), gain);
    let only_lag = lag_s.map(|lag_s| (Some(lag_s), None));
    let only_gain = gain.map(|gain| (None, Some(gain)));
    let both = lag_s.zip(gain).map(|(lag_s, gain)| (Some(lag_s), Some(gain)));
    for (yaw_lag_s, gain) in [only_lag, only_gain, both].into_iter().flatten() {
        let mut robot = measured.clone();
        if let Some(lag_s) = yaw_lag_s {
            robot.actuation.yaw_lag_s = lag_s.value;
        }
        if let Some((gain, commanded_rad_s)) = gain {
            let gain = TurnGain { commanded_rad_s, mean: gain.value };
            robot.actuation.turn.driving_gain_by_command = Some(vec![gain]);
        }
        let simulated = factors.apply(&robot)?;
        if validate(&simulated, settings, &case.trials, &case.options)?.is_contained {
            let driving_gain = gain.map(|(gain, _)| gain);
            return Ok(Some(Turning { yaw_lag_s, driving_gain }));
        }
    }
    Ok(None)
}

/// Whether a trial goes forward while it turns.
fn drives(trial: &DrivenTrial) -> bool {
    let turns = |rate_rad_s: f64, speed_m_s: f64| rate_rad_s != 0.0 && speed_m_s != 0.0;
    let samples = &trial.samples[..trial.samples.len() - 1];
    samples.iter().any(|sample| turns(sample.command.turn_rate_rad_s, sample.command.speed_m_s))
}

/// The largest turning rate that was commanded, in radians per second.
fn turn_rate_rad_s(trials: &[DrivenTrial]) -> Option<f64> {
    let samples = trials.iter().flat_map(|trial| &trial.samples);
    samples.map(|sample| sample.command.turn_rate_rad_s.abs()).reduce(f64::max)
}

/// Whether a lag differs from that of the profile.
fn is_longer(lag: &YawLag, measured: &RobotProfile) -> bool {
    lag.is_certain() && lag.lag_s.low.is_some_and(|low_s| low_s > measured.actuation.yaw_lag_s)
}

/// Whether a gain differs from that of the profile while driving.
fn is_another(
    gain: Estimate,
    measured: &RobotProfile,
    trials: &[DrivenTrial],
    rate_rad_s: f64,
) -> bool {
    let speed_m_s = trials.iter().flat_map(|trial| &trial.samples);
    let speed_m_s = speed_m_s.map(|sample| sample.command.speed_m_s).fold(0.0, f64::max);
    let expected = measured.actuation.turn.gain_at(rate_rad_s, speed_m_s).mean;
    let (low, high) = (gain.low.unwrap_or(gain.value), gain.high.unwrap_or(gain.value));
    expected < low || expected > high
}
