//! From the measured robot to the simulated one: deliberately worse.

use serde::de::Error as _;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize};

use crate::bounds::Bounds;
use crate::robot::profile::RobotProfile;
use crate::robot::sensor::Sensing;

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
    /// Times the friction of bodies that push each other, 1 or more; what comes out is at most 2 (default: 1).
    #[serde(skip_serializing_if = "is_one")]
    pub friction_factor: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_one(factor: &f64) -> bool {
    factor.to_bits() == 1.0_f64.to_bits()
}

impl Default for HarsherFactors {
    fn default() -> Self {
        Self { gain_sd_factor: 2.5, miss_factor: 10.0, false_positive_factor: 1.23, ..Self::NONE }
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
        friction_factor: 1.0,
    };

    /// The factors of a sweep that names none: everything that this robot has gets worse, and nothing
    /// comes to nothing.
    ///
    /// # Source
    ///
    /// §IV: the simulated robots are "less capable in every aspect".
    pub fn for_robot(measured: &RobotProfile) -> Self {
        let usual = Self::default();
        let actuation = &measured.actuation;
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
        let probabilities = || measured.sensors().flat_map(|(_, it)| it.true_positives());
        let least_detections = probabilities()
            .map(|true_positive| (1.0 - KEPT * true_positive) / (1.0 - true_positive))
            .fold(f64::INFINITY, f64::min);
        let has_polygon = measured.sensors().any(|(_, sensing)| sensing.polygon_m.is_some());
        let latency_steps = measured.sensors().map(|(_, sensing)| sensing.latency_steps).max();
        let if_any = |has: bool, factor: f64| if has { factor } else { 1.0 };
        let drifts = turn.bias_sd_rad_s > 0.0 || turn.heading_noise_sd_rad > 0.0;
        Self {
            gain_sd_factor: one_decimal(gain_sd_factor),
            miss_factor: one_decimal(usual.miss_factor.min(least_detections)),
            false_positive_factor: usual.false_positive_factor,
            polygon_scale: if_any(has_polygon, 0.95),
            latency_extra_steps: latency_steps.unwrap_or_default().min(1),
            gust_factor: if_any(actuation.gust.sd_m_s > 0.0, 1.5),
            drift_factor: if_any(drifts, 1.5),
            yaw_lag_factor: if_any(actuation.yaw_lag_s > 0.0, 1.25),
            friction_factor: usual.friction_factor,
        }
    }

    /// Makes a measured robot worse: every capability of the simulated one is at most the measured
    /// one's. A factor that points the other way is refused.
    pub fn apply(&self, measured: &RobotProfile) -> Result<RobotProfile, NotHarsher> {
        self.check()?;
        let mut simulated = measured.clone();
        if let Some(friction) = &mut simulated.body.contact_friction {
            *friction = tidy((*friction * self.friction_factor).min(Bounds::FRICTION.most));
        }
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
        for sensing in simulated.sensings_mut() {
            self.apply_to_sensor(sensing);
        }
        Ok(simulated)
    }

    fn apply_to_sensor(&self, sensing: &mut Sensing) {
        let alarms: f64 = sensing.false_positives().sum();
        // Of several readings one at most is reported.
        let false_positive_factor = match sensing.details.or.as_slice() {
            [] => self.false_positive_factor,
            _ => self.false_positive_factor.min(1.0 / alarms),
        };
        let details = &mut sensing.details;
        let first =
            (&mut sensing.true_positive, &mut sensing.false_positive, &mut details.taken_for);
        let or = details.or.iter_mut();
        let or = or.map(|it| (&mut it.true_positive, &mut it.false_positive, &mut it.taken_for));
        for (true_positive, false_positive, taken_for) in std::iter::once(first).chain(or) {
            let measured = 1.0 - *true_positive;
            let miss = measured * self.miss_factor;
            *true_positive = tidy((1.0 - miss).clamp(0.0, 1.0));
            // What is missed is taken for something else as often as it was.
            let factor = if measured > 0.0 { (1.0 - *true_positive) / measured } else { 1.0 };
            for mistaken in taken_for.values_mut() {
                *mistaken = tidy(*mistaken * factor);
            }
            *false_positive = tidy((*false_positive * false_positive_factor).clamp(0.0, 1.0));
        }
        sensing.latency_steps += self.latency_extra_steps;
        if let Some(polygon) = &mut sensing.polygon_m {
            for coordinate in polygon.iter_mut().flatten() {
                *coordinate = tidy(*coordinate * self.polygon_scale);
            }
        }
    }

    fn check(&self) -> Result<(), NotHarsher> {
        for Factor { key, range, get, .. } in &FACTORS {
            let found = get(self);
            let (is_worse, expected) = match range {
                FactorRange::From(least) => (found >= *least && found.is_finite(), "1 or more"),
                FactorRange::UpToOne => (found > 0.0 && found <= 1.0, "above 0 and at most 1"),
            };
            if !is_worse {
                return Err(NotHarsher { key, found, expected });
            }
        }
        Ok(())
    }
}

/// What is known of a factor, besides what it does.
struct Factor {
    key: &'static str,
    /// What it makes of the robots.
    meaning: &'static str,
    range: FactorRange,
    written: Written,
    get: fn(&HarsherFactors) -> f64,
    set: fn(&mut HarsherFactors, f64),
}

/// Between which values a factor makes no better robot.
enum FactorRange {
    /// From this one on, which changes nothing.
    From(f64),
    /// Up to 1, which changes nothing.
    UpToOne,
}

/// How a file has it.
#[derive(PartialEq)]
enum Written {
    /// As a number.
    Number,
    /// As a whole number.
    Count,
    /// As a number other than 1, which is what robots have that are given none: copies of sweeps are what they
    /// were.
    UnlessOne,
}

impl Factor {
    /// A value as it is kept.
    fn kept(&self, value: f64) -> Option<f64> {
        Some(value).filter(|value| self.written != Written::UnlessOne || !is_one(value))
    }
}

macro_rules! factor {
    ($key:ident, $meaning:literal, $range:expr, $written:ident) => {
        Factor {
            key: stringify!($key),
            meaning: $meaning,
            range: $range,
            written: Written::$written,
            get: |factors| f64::from(factors.$key),
            set: |factors, value| factors.$key = value as _,
        }
    };
}

const GAIN_SD: Factor =
    factor!(gain_sd_factor, "robots differ more", FactorRange::From(1.0), Number);
/// The key of the factor that has robots differ more.
pub(crate) const GAIN_SD_FACTOR: &str = GAIN_SD.key;

const MISS: Factor =
    factor!(miss_factor, "more neighbours are missed", FactorRange::From(1.0), Number);
/// The key of the factor that has more neighbours missed.
pub(crate) const MISS_FACTOR: &str = MISS.key;

/// All factors, in the order of [`HarsherFactors`].
const FACTORS: [Factor; 9] = [
    GAIN_SD,
    MISS,
    factor!(
        false_positive_factor,
        "more is detected that is not there",
        FactorRange::From(1.0),
        Number
    ),
    factor!(polygon_scale, "a smaller sensing region", FactorRange::UpToOne, Number),
    factor!(latency_extra_steps, "later detections", FactorRange::From(0.0), Count),
    factor!(gust_factor, "stronger gusts", FactorRange::From(1.0), Number),
    factor!(drift_factor, "more drift in heading", FactorRange::From(1.0), Number),
    factor!(yaw_lag_factor, "turns that follow later", FactorRange::From(1.0), Number),
    factor!(
        friction_factor,
        "bodies that slide less along each other",
        FactorRange::From(1.0),
        UnlessOne
    ),
];

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
    /// What it makes of the robots.
    pub meaning: &'static str,
    /// This factor, with robots else as measured.
    pub alone: Harsher,
    /// All factors but this one.
    pub without: Harsher,
}

/// The value of `harsher:` in a sweep file: some of the factors, or the word `none`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harsher {
    /// Those that are given, in the order of [`FACTORS`].
    given: [Option<f64>; FACTORS.len()],
}

impl Harsher {
    /// All factors, those that are not given as this robot needs them.
    pub fn factors(&self, measured: &RobotProfile) -> HarsherFactors {
        let mut factors = HarsherFactors::for_robot(measured);
        for (factor, given) in FACTORS.iter().zip(self.given) {
            if let Some(value) = given {
                (factor.set)(&mut factors, value);
            }
        }
        factors
    }

    /// What was decided for a robot: the factors other than those that follow from it.
    ///
    /// The copy of a sweep in its result folder states all factors, whoever has set them; that a robot is
    /// not made worse is a decision about all of them.
    #[must_use]
    pub fn decided(mut self, measured: &RobotProfile) -> Self {
        if self == HarsherFactors::NONE.into() {
            return self;
        }
        let follows = Self::from(HarsherFactors::for_robot(measured));
        for (given, follows) in self.given.iter_mut().zip(follows.given) {
            *given = given.filter(|_| *given != follows);
        }
        self
    }

    /// Each factor by itself, and what is left without it; where it is not given, it is still as each robot needs it.
    pub fn ablations(self) -> impl Iterator<Item = Ablation> {
        let none = Self::from(HarsherFactors::NONE);
        FACTORS.iter().enumerate().map(move |(place, Factor { key, meaning, .. })| {
            let (mut alone, mut without) = (none, self);
            alone.given[place] = self.given[place];
            without.given[place] = none.given[place];
            Ablation { key, meaning, alone, without }
        })
    }

    /// The keys and values of those that are given.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        FACTORS.iter().zip(self.given).filter_map(|(factor, given)| Some((factor.key, given?)))
    }
}

impl From<HarsherFactors> for Harsher {
    fn from(factors: HarsherFactors) -> Self {
        Self { given: FACTORS.each_ref().map(|factor| factor.kept((factor.get)(&factors))) }
    }
}

impl Serialize for Harsher {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (factor, given) in FACTORS.iter().zip(self.given) {
            match (given, &factor.written) {
                (None, _) => {}
                (Some(value), Written::Count) => {
                    map.serialize_entry(factor.key, &(value as u32))?;
                }
                (Some(value), Written::Number | Written::UnlessOne) => {
                    map.serialize_entry(factor.key, &value)?;
                }
            }
        }
        map.end()
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

    fn visit_map<A: serde::de::MapAccess<'de>>(self, mut map: A) -> Result<Harsher, A::Error> {
        const KEYS: [&str; FACTORS.len()] = {
            let mut keys = [""; FACTORS.len()];
            let mut index = 0;
            while index < keys.len() {
                keys[index] = FACTORS[index].key;
                index += 1;
            }
            keys
        };
        let mut harsher = Harsher::default();
        while let Some(key) = map.next_key::<String>()? {
            let place = KEYS.iter().position(|other| **other == key);
            let place = place.ok_or_else(|| A::Error::unknown_field(&key, &KEYS))?;
            if harsher.given[place].is_some() {
                return Err(A::Error::duplicate_field(KEYS[place]));
            }
            let factor = &FACTORS[place];
            let value = match factor.written {
                Written::Count => map.next_value::<Option<u32>>()?.map(f64::from),
                Written::Number | Written::UnlessOne => map.next_value()?,
            };
            harsher.given[place] = value.and_then(|value| factor.kept(value));
        }
        Ok(harsher)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::contact::ContactModel;

    use rsrs_testing::conditions::FLOCKBOT;

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
    fn the_factor_of_friction_is_one_unless_it_is_given_and_is_not_written_where_it_is() {
        let mut measured = drifting();
        (measured.body.contact, measured.body.contact_friction) = (ContactModel::Push, Some(0.4));
        let read = |text: &str| serde_json::from_str::<Harsher>(text).unwrap();
        let friction = |harsher: Harsher| {
            let simulated = harsher.factors(&measured).apply(&measured).unwrap();
            (100.0 * simulated.body.contact_friction.unwrap()).round() as u32
        };

        assert_eq!(
            ["{}", r#""none""#, r#"{"friction_factor": 1}"#].map(|it| friction(read(it))),
            [40; 3]
        );
        assert_eq!(friction(read(r#"{"friction_factor": 2}"#)), 80);
        assert_eq!(friction(read(r#"{"friction_factor": 9}"#)), 200, "no body has more");
        assert_eq!(read(r#"{"friction_factor": 1}"#), Harsher::default());
        assert_eq!(read(r#""none""#), HarsherFactors::NONE.into());
        let written = |text: &str| serde_json::to_string(&read(text)).unwrap();
        assert!(!written(r#""none""#).contains("friction_factor"));
        assert_eq!(written(r#"{"friction_factor": 2}"#), r#"{"friction_factor":2.0}"#);
        let less = HarsherFactors { friction_factor: 0.5, ..HarsherFactors::NONE };
        assert!(less.apply(&measured).is_err(), "they would slide better than they do");
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
