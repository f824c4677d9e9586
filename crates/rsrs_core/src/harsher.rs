//! From the measured robot to the simulated one: deliberately worse.

use serde::{Deserialize, Serialize};

use crate::profile::RobotProfile;

/// The factors that make the simulated robot worse than the measured one.
///
/// A robot that is worse in every capability does not by itself make `eq:finalgap` hold:
/// imperfection also helps (some false detections break up split groups). The comparison tests
/// that inequality; it is never assumed.
///
/// # Source
///
/// §IV step 2: "we expanded it such that the agents in the simulation would obtain their θᵃ values
/// from" a larger distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HarsherFactors {
    /// Times the standard deviations of both gains (default: 2.5; the Flockbot's 0.02 becomes 0.05).
    pub gain_sd_factor: f64,
    /// Times the probability of missing a neighbour (default: 10; a miss of 0.02 becomes 0.20).
    pub miss_factor: f64,
    /// Times the false-positive rate (default: 1.23; 0.065 becomes the 0.08 at the measured
    /// interval's upper end).
    pub false_positive_factor: f64,
    /// Times the sensing polygon's size, at most 1 (default: 1).
    pub polygon_scale: f64,
    /// Added sensor latency, in steps (default: 0).
    pub latency_extra_steps: u32,
    /// Times the gusts (default: 1).
    pub gust_factor: f64,
    /// Times the turn bias and the heading noise (default: 1).
    pub drift_factor: f64,
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
        }
    }
}

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
    };

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
pub(crate) fn tidy(number: f64) -> f64 {
    (number * 1e12).round() / 1e12
}

/// The value of `harsher:` in a sweep file: factors, or the word `none`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harsher(pub HarsherFactors);

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
            return Ok(Harsher(HarsherFactors::NONE));
        }
        Err(E::invalid_value(serde::de::Unexpected::Str(word), &self))
    }

    fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Harsher, A::Error> {
        HarsherFactors::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Harsher)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOCKBOT: &str = include_str!("../../../launch_configs/profiles/flockbot.yaml");

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
