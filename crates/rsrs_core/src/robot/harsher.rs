//! From the measured robot to the simulated one: deliberately worse.

use serde::{Deserialize, Serialize};

use crate::robot::profile::RobotProfile;

/// The factors that make the simulated robot worse than the measured one.
///
/// What a sweep file leaves out follows from the robot: [`HarsherFactors::for_robot`].
///
/// A robot that is worse in every capability does not by itself make `eq:finalgap` hold:
/// imperfection also helps (some false detections break up split groups). The comparison tests
/// that inequality; it is never assumed.
///
/// # Source
///
/// §IV step 2: "we expanded it such that the agents in the simulation would obtain their θᵃ values
/// from" a larger distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HarsherFactors {
    /// Times the standard deviations of both gains (default: 2.5, or less where a robot at three of
    /// them would hardly move; the Flockbot's 0.02 becomes 0.05).
    pub gain_sd_factor: f64,
    /// Times the probability of missing a neighbour (default: 10, or less where fewer than four fifths
    /// of the measured detections would be left; a miss of 0.02 becomes 0.20).
    pub miss_factor: f64,
    /// Times the false-positive rate (default: 1.23; 0.065 becomes the 0.08 at the measured
    /// interval's upper end).
    pub false_positive_factor: f64,
    /// Times the sensing polygon's size, at most 1 (default: 0.95; a cone is left as it is).
    pub polygon_scale: f64,
    /// Added sensor latency, in steps (default: 1 for a sensor that has some, else 0).
    pub latency_extra_steps: u32,
    /// Times the gusts (default: 1.5 where there are some).
    pub gust_factor: f64,
    /// Times the turn bias and the heading noise (default: 1.5 where there are some).
    pub drift_factor: f64,
    /// Times the time constant of the turning rate (default: 1.25 where there is one).
    #[serde(skip_serializing_if = "is_one")]
    pub yaw_lag_factor: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_one(factor: &f64) -> bool {
    factor.to_bits() == 1.0_f64.to_bits()
}

impl Default for HarsherFactors {
    fn default() -> Self {
        Self {
            gain_sd_factor: 2.5,
            miss_factor: 10.0,
            false_positive_factor: 1.23,
            polygon_scale: 1.0,
            latency_extra_steps: 0,
            gust_factor: 1.0,
            drift_factor: 1.0,
            yaw_lag_factor: 1.0,
        }
    }
}

/// Share of measured true positives that the default factors leave at least: a Flockbot keeps 0.80 of
/// 0.98.
pub(crate) const KEPT: f64 = 0.8;

/// Gains are drawn up to so many standard deviations from the mean.
pub(crate) const TRUNCATED_SD: f64 = 3.0;

/// A factor that would make the simulated robot better than the measured one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "harsher.{key} is {found}, expected {expected}: the simulated robot must not be the better one"
)]
pub struct NotHarsher {
    /// The factor.
    pub key: &'static str,
    /// Its value.
    pub found: f64,
    /// What it may be.
    pub expected: &'static str,
}

impl HarsherFactors {
    /// Leaves the measured robot as it is: `harsher: none`.
    pub const NONE: Self = Self {
        gain_sd_factor: 1.0,
        miss_factor: 1.0,
        false_positive_factor: 1.0,
        polygon_scale: 1.0,
        latency_extra_steps: 0,
        gust_factor: 1.0,
        drift_factor: 1.0,
        yaw_lag_factor: 1.0,
    };

    /// The factors of a sweep that names none: everything that this robot has gets worse, and nothing
    /// comes to nothing.
    ///
    /// # Source
    ///
    /// §IV: the simulated robots are "less capable in every aspect".
    pub fn for_robot(measured: &RobotProfile) -> Self {
        let usual = Self::default();
        let (actuation, sensing) = (&measured.actuation, &measured.sensing);
        let (speed, turn) = (&actuation.speed, &actuation.turn);
        let speeds = speed.gain_by_command.iter().map(|gain| gain.mean);
        let turns = turn.means();
        // A robot at the edge of the distribution keeps half of its gain.
        let slowest = |gains: &mut dyn Iterator<Item = f64>, sd: f64| {
            gains.fold(f64::INFINITY, f64::min) / 2.0 / (TRUNCATED_SD * sd)
        };
        let gain_sd_factor = usual
            .gain_sd_factor
            .min(slowest(&mut { speeds }, speed.robot_sd))
            .min(slowest(&mut { turns }, turn.robot_sd));
        let least_detections = (1.0 - KEPT * sensing.true_positive) / (1.0 - sensing.true_positive);
        let if_any = |has: bool, factor: f64| if has { factor } else { 1.0 };
        let drifts = turn.bias_sd_rad_s > 0.0 || turn.heading_noise_sd_rad > 0.0;
        Self {
            gain_sd_factor: one_decimal(gain_sd_factor),
            miss_factor: one_decimal(usual.miss_factor.min(least_detections)),
            false_positive_factor: usual.false_positive_factor,
            polygon_scale: if_any(sensing.polygon_m.is_some(), 0.95),
            latency_extra_steps: sensing.latency_steps.min(1),
            gust_factor: if_any(actuation.gust.sd_m_s > 0.0, 1.5),
            drift_factor: if_any(drifts, 1.5),
            yaw_lag_factor: if_any(actuation.yaw_lag_s > 0.0, 1.25),
        }
    }

    /// What each factor does by itself, and what is left without it: of those that change this robot.
    pub fn ablations(&self, measured: &RobotProfile) -> Vec<Ablation> {
        type Set = fn(HarsherFactors, HarsherFactors) -> HarsherFactors;
        let sets: [(&'static str, Set); 8] = [
            ("gain_sd_factor", |to, of| Self { gain_sd_factor: of.gain_sd_factor, ..to }),
            ("miss_factor", |to, of| Self { miss_factor: of.miss_factor, ..to }),
            ("false_positive_factor", |to, of| Self {
                false_positive_factor: of.false_positive_factor,
                ..to
            }),
            ("polygon_scale", |to, of| Self { polygon_scale: of.polygon_scale, ..to }),
            ("latency_extra_steps", |to, of| Self {
                latency_extra_steps: of.latency_extra_steps,
                ..to
            }),
            ("gust_factor", |to, of| Self { gust_factor: of.gust_factor, ..to }),
            ("drift_factor", |to, of| Self { drift_factor: of.drift_factor, ..to }),
            ("yaw_lag_factor", |to, of| Self { yaw_lag_factor: of.yaw_lag_factor, ..to }),
        ];
        sets.into_iter()
            .map(|(key, set)| Ablation {
                key,
                alone: set(Self::NONE, *self),
                without: set(*self, Self::NONE),
            })
            .filter(|ablation| {
                ablation.alone.apply(measured).is_ok_and(|simulated| simulated != *measured)
            })
            .collect()
    }

    /// Makes a measured robot worse.
    ///
    /// # Returns
    ///
    /// The profile of the simulated robot: every capability at most the measured one's.
    ///
    /// # Errors
    ///
    /// [`NotHarsher`] if a factor points the other way.
    pub fn apply(&self, measured: &RobotProfile) -> Result<RobotProfile, NotHarsher> {
        self.check()?;
        let mut simulated = measured.clone();
        let actuation = &mut simulated.actuation;
        for sd in [
            &mut actuation.speed.robot_sd,
            &mut actuation.speed.step_sd,
            &mut actuation.turn.robot_sd,
            &mut actuation.turn.step_sd,
        ] {
            *sd = tidy(*sd * self.gain_sd_factor);
        }
        actuation.gust.sd_m_s = tidy(actuation.gust.sd_m_s * self.gust_factor);
        for sd in [&mut actuation.turn.bias_sd_rad_s, &mut actuation.turn.heading_noise_sd_rad] {
            *sd = tidy(*sd * self.drift_factor);
        }
        actuation.yaw_lag_s = tidy(actuation.yaw_lag_s * self.yaw_lag_factor);
        let sensing = &mut simulated.sensing;
        let miss = (1.0 - sensing.true_positive) * self.miss_factor;
        sensing.true_positive = tidy((1.0 - miss).clamp(0.0, 1.0));
        sensing.false_positive =
            tidy((sensing.false_positive * self.false_positive_factor).clamp(0.0, 1.0));
        sensing.latency_steps += self.latency_extra_steps;
        if let Some(polygon) = &mut sensing.polygon_m {
            for coordinate in polygon.iter_mut().flatten() {
                *coordinate = tidy(*coordinate * self.polygon_scale);
            }
        }
        Ok(simulated)
    }

    fn check(&self) -> Result<(), NotHarsher> {
        for (key, found) in [
            ("gain_sd_factor", self.gain_sd_factor),
            ("miss_factor", self.miss_factor),
            ("false_positive_factor", self.false_positive_factor),
            ("gust_factor", self.gust_factor),
            ("drift_factor", self.drift_factor),
            ("yaw_lag_factor", self.yaw_lag_factor),
        ] {
            if !(found >= 1.0 && found.is_finite()) {
                return Err(NotHarsher { key, found, expected: "1 or more" });
            }
        }
        if self.polygon_scale > 0.0 && self.polygon_scale <= 1.0 {
            return Ok(());
        }
        let found = self.polygon_scale;
        Err(NotHarsher { key: "polygon_scale", found, expected: "above 0 and at most 1" })
    }
}

/// Rounds away what binary fractions add behind the twelfth decimal, so that 0.02 × 2.5 is the
/// number a person would write.
pub fn tidy(number: f64) -> f64 {
    (number * 1e12).round() / 1e12
}

/// A factor in one decimal, and at least 1: below it, it would make the better robot.
pub(crate) fn one_decimal(factor: f64) -> f64 {
    ((factor * 10.0 + 1e-9).floor() / 10.0).max(1.0)
}

/// One factor by itself, and all the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ablation {
    /// The factor.
    pub key: &'static str,
    /// This factor, with the robot else as measured.
    pub alone: HarsherFactors,
    /// All factors but this one.
    pub without: HarsherFactors,
}

/// The value of `harsher:` in a sweep file: some of the factors, or the word `none`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harsher(Given);

/// The factors that a file gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Given {
    #[serde(skip_serializing_if = "Option::is_none")]
    gain_sd_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    miss_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    false_positive_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    polygon_scale: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    latency_extra_steps: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gust_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drift_factor: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_lag_factor: Option<f64>,
}

impl Harsher {
    /// All factors, those that are not given as this robot needs them.
    pub fn factors(&self, measured: &RobotProfile) -> HarsherFactors {
        let left_out = HarsherFactors::for_robot(measured);
        let or = |given: Option<f64>, left_out: f64| given.unwrap_or(left_out);
        HarsherFactors {
            gain_sd_factor: or(self.0.gain_sd_factor, left_out.gain_sd_factor),
            miss_factor: or(self.0.miss_factor, left_out.miss_factor),
            false_positive_factor: or(self.0.false_positive_factor, left_out.false_positive_factor),
            polygon_scale: or(self.0.polygon_scale, left_out.polygon_scale),
            latency_extra_steps: self.0.latency_extra_steps.unwrap_or(left_out.latency_extra_steps),
            gust_factor: or(self.0.gust_factor, left_out.gust_factor),
            drift_factor: or(self.0.drift_factor, left_out.drift_factor),
            yaw_lag_factor: or(self.0.yaw_lag_factor, left_out.yaw_lag_factor),
        }
    }
}

impl Harsher {
    /// What was decided for a robot: the factors other than those that follow from it.
    ///
    /// The copy of a sweep in its result folder states all factors, whoever has set them; that a robot is
    /// not made worse is a decision about all of them.
    #[must_use]
    pub fn decided(self, measured: &RobotProfile) -> Self {
        if self == HarsherFactors::NONE.into() {
            return self;
        }
        let Self(given) = self;
        let Self(follows) = HarsherFactors::for_robot(measured).into();
        let other = |given: Option<f64>, follows| given.filter(|_| given != follows);
        Self(Given {
            gain_sd_factor: other(given.gain_sd_factor, follows.gain_sd_factor),
            miss_factor: other(given.miss_factor, follows.miss_factor),
            false_positive_factor: other(
                given.false_positive_factor,
                follows.false_positive_factor,
            ),
            polygon_scale: other(given.polygon_scale, follows.polygon_scale),
            latency_extra_steps: given
                .latency_extra_steps
                .filter(|_| given.latency_extra_steps != follows.latency_extra_steps),
            gust_factor: other(given.gust_factor, follows.gust_factor),
            drift_factor: other(given.drift_factor, follows.drift_factor),
            yaw_lag_factor: other(given.yaw_lag_factor, follows.yaw_lag_factor),
        })
    }
}

impl From<HarsherFactors> for Harsher {
    fn from(factors: HarsherFactors) -> Self {
        Self(Given {
            gain_sd_factor: Some(factors.gain_sd_factor),
            miss_factor: Some(factors.miss_factor),
            false_positive_factor: Some(factors.false_positive_factor),
            polygon_scale: Some(factors.polygon_scale),
            latency_extra_steps: Some(factors.latency_extra_steps),
            gust_factor: Some(factors.gust_factor),
            drift_factor: Some(factors.drift_factor),
            yaw_lag_factor: Some(factors.yaw_lag_factor),
        })
    }
}

impl Serialize for Harsher {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Harsher {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(HarsherVisitor)
    }
}

struct HarsherVisitor;

impl<'de> serde::de::Visitor<'de> for HarsherVisitor {
    type Value = Harsher;

    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("harsher factors or `none`")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Harsher, E> {
        if word == "none" {
            return Ok(HarsherFactors::NONE.into());
        }
        Err(E::invalid_value(serde::de::Unexpected::Str(word), &self))
    }

    fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Harsher, A::Error> {
        Given::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Harsher)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOCKBOT: &str = include_str!("../../../../launch_configs/profiles/flockbot.yaml");

    fn drifting() -> RobotProfile {
        let mut profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        profile.actuation.turn.bias_sd_rad_s = 0.004;
        profile.actuation.turn.heading_noise_sd_rad = 0.01;
        profile
    }

    #[test]
    fn the_drift_factor_widens_bias_and_heading_noise_and_nothing_else() {
        let factors = HarsherFactors { drift_factor: 3.0, ..HarsherFactors::NONE };

        let simulated = factors.apply(&drifting()).unwrap();

        let mut expected = drifting();
        expected.actuation.turn.bias_sd_rad_s = 0.012;
        expected.actuation.turn.heading_noise_sd_rad = 0.03;
        assert_eq!(simulated, expected);
    }

    #[test]
    fn without_a_drift_factor_drift_is_as_measured() {
        let factors: HarsherFactors = serde_json::from_str("{}").unwrap();

        let simulated = factors.apply(&drifting()).unwrap();

        let turn = |profile: &RobotProfile| {
            let turn = &profile.actuation.turn;
            (turn.bias_sd_rad_s.to_bits(), turn.heading_noise_sd_rad.to_bits())
        };
        assert_eq!(turn(&simulated), turn(&drifting()));
    }

    #[test]
    fn factors_that_follow_from_the_robot_are_no_decision_whoever_states_them() {
        let decided = |text: &str| {
            let given: Harsher = serde_json::from_str(text).unwrap();
            let stated = Harsher::from(given.factors(&drifting()));
            serde_json::to_string(&stated.decided(&drifting())).unwrap()
        };

        assert_eq!(decided("{}"), "{}");
        assert_eq!(decided(r#"{"miss_factor":5.0}"#), r#"{"miss_factor":5.0}"#);
        assert_eq!(
            Harsher::from(HarsherFactors::NONE).decided(&drifting()),
            HarsherFactors::NONE.into()
        );
    }

    #[test]
    fn a_drift_factor_below_one_is_refused() {
        let factors = HarsherFactors { drift_factor: 0.5, ..HarsherFactors::NONE };

        let error = factors.apply(&drifting()).unwrap_err();

        assert_eq!(
            error.to_string(),
            "harsher.drift_factor is 0.5, expected 1 or more: the simulated robot must not be the \
             better one"
        );
    }
}
