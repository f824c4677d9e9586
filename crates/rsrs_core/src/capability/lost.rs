//! Capabilities of which a factor has left next to nothing.
//!
//! A simulated robot that sees nothing is nowhere better than the measured one, and is no evidence
//! about it either.

use serde::Serialize;

use crate::quantity::Axis;
use crate::robot::harsher::{GAIN_SD_FACTOR, KEPT, MISS_FACTOR, TRUNCATED_SD, one_decimal};
use crate::robot::profile::RobotProfile;
use crate::robot::sensor::Sensing;

/// A capability that the measured robot has and the simulated one has all but lost.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error(
    "{capability}: the simulated robot has {simulated:.2}, which is {meaning}; the measured one has \
     {measured:.2}; set `harsher: {{{key}: {instead:.1}}}` or measure more precisely"
)]
pub struct LostCapability {
    /// Name of the capability.
    pub capability: &'static str,
    /// The measured robot's; dimensionless.
    pub measured: f64,
    /// The simulated robot's; dimensionless.
    pub simulated: f64,
    /// What the number means.
    pub meaning: &'static str,
    /// The factor that took it away.
    pub key: &'static str,
    /// What it can be set to, rounded down to one decimal: the capability is worse, and there.
    pub instead: f64,
}

/// A sensor that detects neighbours by no more than this share oftener than nothing is blind.
const BLIND: f64 = 0.1;

/// The capabilities that some factors take away from a measured robot: none if what was made of it
/// is worse and can still do everything. What the measured robot cannot do either is not listed.
///
/// # Example
///
/// A sensor that misses 12 of 100 neighbours misses all of them with the default factor of 10.
///
/// ```
/// # use rsrs_core::{capability::lost_capabilities, robot::harsher::HarsherFactors};
/// # use rsrs_core::robot::profile::RobotProfile;
/// # fn example(mut measured: RobotProfile) -> Result<(), rsrs_core::robot::harsher::NotHarsher> {
/// measured.sensing.true_positive = 0.88;
/// let simulated = HarsherFactors::default().apply(&measured)?;
/// assert_eq!(lost_capabilities(&measured, &simulated)[0].key, "miss_factor");
/// # Ok(())
/// # }
/// ```
pub fn lost_capabilities(measured: &RobotProfile, simulated: &RobotProfile) -> Vec<LostCapability> {
    let (speed, turn) = (&measured.actuation.speed, &measured.actuation.turn);
    let speeds = speed.gain_by_command.iter().map(|gain| gain.mean);
    let turns = turn.means();
    let least = |gains: &mut dyn Iterator<Item = f64>| gains.fold(f64::INFINITY, f64::min);
    let sds =
        |robot: &RobotProfile| [robot.actuation.speed.robot_sd, robot.actuation.turn.robot_sd];
    let motion = [
        gain("least speed gain", least(&mut { speeds }), sds(measured)[0], sds(simulated)[0]),
        gain("least turning gain", least(&mut { turns }), sds(measured)[1], sds(simulated)[1]),
    ];
    let sensors = measured.sensors().zip(simulated.sensors());
    let seen = sensors.flat_map(|((_, measured), (_, simulated))| sensor(measured, simulated));
    seen.chain(motion.into_iter().flatten()).collect()
}

fn sensor(measured: &Sensing, simulated: &Sensing) -> Vec<LostCapability> {
    let rates = |sensing: &Sensing| -> Vec<(f64, f64)> {
        sensing.true_positives().zip(sensing.false_positives()).collect()
    };
    let readings = rates(measured).into_iter().zip(rates(simulated));
    readings.filter_map(|(measured, simulated)| reading(measured, simulated)).collect()
}

/// A reading, by the probabilities of a true and of a false one.
fn reading(
    (true_positive, false_positive): (f64, f64),
    (simulated, simulated_false): (f64, f64),
) -> Option<LostCapability> {
    if simulated - simulated_false > BLIND || true_positive - false_positive <= BLIND {
        return None;
    }
    // What is to be kept must itself be more than the false detections.
    let kept = (KEPT * true_positive).max(simulated_false + 2.0 * BLIND);
    Some(LostCapability {
        capability: Axis::TruePositive.name(),
        measured: true_positive,
        simulated,
        meaning: "hardly more than its false detections",
        key: MISS_FACTOR,
        instead: one_decimal((1.0 - kept) / (1.0 - true_positive)),
    })
}

/// A gain whose spread reaches down to a robot that does not move.
fn gain(
    capability: &'static str,
    mean: f64,
    measured_sd: f64,
    simulated_sd: f64,
) -> Option<LostCapability> {
    let least = |sd: f64| (mean - TRUNCATED_SD * sd).max(0.0);
    if least(simulated_sd) > BLIND * mean || least(measured_sd) <= BLIND * mean {
        return None;
    }
    Some(LostCapability {
        capability,
        measured: least(measured_sd),
        simulated: least(simulated_sd),
        meaning: "a robot that hardly moves",
        key: GAIN_SD_FACTOR,
        instead: one_decimal(mean / 2.0 / (TRUNCATED_SD * measured_sd)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::harsher::{Ablation, Harsher, HarsherFactors};

    const PROFILES: [&str; 3] = [
        rsrs_testing::conditions::FLOCKBOT,
        include_str!("../../../../launch_configs/profiles/lta.yaml"),
        include_str!("../../../../launch_configs/profiles/smars.yaml"),
    ];

    fn lost(measured: &RobotProfile, factors: HarsherFactors) -> Vec<LostCapability> {
        lost_capabilities(measured, &factors.apply(measured).unwrap())
    }

    #[test]
    fn the_factors_of_a_flockbot_blind_the_made_up_smars_and_no_other() {
        let lost = PROFILES.map(|text| {
            lost(&RobotProfile::parse("robot.yaml", text).unwrap(), HarsherFactors::default())
        });

        assert_eq!(lost.each_ref().map(Vec::len), [0, 0, 1], "{lost:?}");
        assert_eq!(
            lost[2][0].to_string(),
            "true positive rate: the simulated robot has 0.00, which is hardly more than its false \
             detections; the measured one has 0.89; set `harsher: {miss_factor: 2.6}` or measure \
             more precisely"
        );
    }

    #[test]
    fn the_factors_that_are_left_out_blind_no_robot_and_make_everything_worse() {
        for text in PROFILES {
            let measured = RobotProfile::parse("robot.yaml", text).unwrap();
            let factors = HarsherFactors::for_robot(&measured);

            let simulated = factors.apply(&measured).unwrap();

            assert_eq!(lost_capabilities(&measured, &simulated), []);
            let of = |robot: &RobotProfile| {
                let (actuation, sensing) = (&robot.actuation, &robot.sensing);
                let corner = sensing.polygon_m.as_ref().map_or(0.0, |corners| corners[2][0]);
                [
                    actuation.speed.robot_sd,
                    actuation.speed.step_sd,
                    actuation.turn.robot_sd,
                    actuation.turn.step_sd,
                    actuation.turn.bias_sd_rad_s,
                    actuation.turn.heading_noise_sd_rad,
                    actuation.gust.sd_m_s,
                    actuation.yaw_lag_s,
                    1.0 - sensing.true_positive,
                    sensing.false_positive,
                    -corner,
                    f64::from(sensing.latency_steps),
                ]
            };
            for (index, (worse, as_measured)) in
                of(&simulated).iter().zip(of(&measured)).enumerate()
            {
                let has_it = as_measured.abs() > 0.0;
                assert!(!has_it || *worse > as_measured, "{} {index}: {worse}", measured.name);
            }
        }
    }

    #[test]
    fn each_factor_that_changes_a_robot_is_tried_alone_and_left_out() {
        let measured = RobotProfile::parse("smars.yaml", PROFILES[2]).unwrap();
        let factors = HarsherFactors::for_robot(&measured);

        for harsher in [Harsher::default(), Harsher::from(factors)] {
            let changes = |it: &Ablation| it.alone.factors(&measured) != HarsherFactors::NONE;
            let ablations: Vec<Ablation> = harsher.ablations().filter(changes).collect();

            let keys: Vec<&str> = ablations.iter().map(|ablation| ablation.key).collect();
            assert_eq!(
                keys,
                [
                    "gain_sd_factor",
                    "miss_factor",
                    "false_positive_factor",
                    "polygon_scale",
                    "drift_factor"
                ]
            );
            let missing = ablations[1];
            assert_eq!(
                missing.alone.factors(&measured),
                HarsherFactors { miss_factor: factors.miss_factor, ..HarsherFactors::NONE }
            );
            assert_eq!(
                missing.without.factors(&measured),
                HarsherFactors { miss_factor: 1.0, ..factors }
            );
        }
    }

    #[test]
    fn what_is_proposed_instead_is_worse_and_loses_nothing() {
        let mut measured = RobotProfile::parse("flockbot.yaml", PROFILES[0]).unwrap();
        for true_positive in [0.85, 0.88, 0.9, 0.905] {
            measured.sensing.true_positive = true_positive;
            measured.actuation.speed.robot_sd = 0.125;
            let mut factors = HarsherFactors::default();

            let found = lost(&measured, factors);

            assert_eq!(found.len(), 2, "{found:?}");
            factors.miss_factor = found[0].instead;
            factors.gain_sd_factor = found[1].instead;
            assert!(factors.miss_factor > 1.0 && factors.gain_sd_factor > 1.0, "{found:?}");
            assert_eq!(lost(&measured, factors), []);
        }
    }

    #[test]
    fn what_the_measured_robot_has_not_cannot_be_lost() {
        let mut blind = RobotProfile::parse("flockbot.yaml", PROFILES[0]).unwrap();
        blind.sensing.true_positive = 0.1;

        assert_eq!(lost(&blind, HarsherFactors::default()), []);
    }
}
