//! Robots as they might be: profiles drawn around the intervals of a fit.

use serde::Serialize;
use serde_json::Value;

use crate::digest::Digest;
use crate::help::Help;
use crate::robot::harsher::tidy;
use crate::robot::profile::{ProfileError, Provenance, RobotProfile};

/// A number of a profile that is drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Varied {
    /// Dotted path of its key, such as `sensing.true_positive`.
    pub key: String,
    /// As measured; in the unit of its key, as are the others.
    pub measured: f64,
    /// The least that is drawn.
    pub from: f64,
    /// The greatest.
    pub to: f64,
}

/// Profiles that a robot might have, as far as its trials show: *pseudo-realities*.
///
/// Each number with an interval in the provenance is drawn evenly from that interval, widened around the number by
/// a factor; gains at the commands of one table are drawn together. All other numbers stay as they are.
///
/// # Source
///
/// A. Ligot and M. Birattari, *On using simulation to predict the performance of robot swarms*, Scientific Data 9:788
/// (2022): swarms are evaluated in models other than the one they were designed in.
#[derive(Clone, Debug)]
pub struct PseudoRealities<'a> {
    profile: &'a RobotProfile,
    varied: Vec<Varied>,
}

/// Why no profiles can be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PseudoRealityError {
    /// No number of the profile has an interval.
    #[error("the profile {0} has no intervals, so nothing says what else its robots might be")]
    NoIntervals(String),
    /// No robot is like that.
    #[error("with intervals {widening} times as wide, {problem}")]
    TooWide {
        /// The factor.
        widening: f64,
        /// What is wrong with the robot at an end of its intervals.
        problem: ProfileError,
    },
}

impl Help for PseudoRealityError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::NoIntervals { .. } => {
                "`rsrs measure fit` writes profiles that have them, from trials of robots"
            }
            Self::TooWide { .. } => "a smaller `--widening` asks for less",
        };
        Some(help.to_owned())
    }
}

impl Provenance {
    /// The 95 % interval of the number at a dotted path, as its source states it:
    /// `95 % interval 0.8829 to 0.9045`. Of parts that are added as variances, as they are in spreads of gains,
    /// the ends are added likewise.
    pub fn interval(&self, key: &str) -> Option<[f64; 2]> {
        let source = self.numbers.get(key)?;
        let parts = source.split("95 % interval ").skip(1).map(|part| {
            let (low, rest) = part.split_once(" to ")?;
            let is_of_number = |sign: char| sign.is_ascii_digit() || sign == '.';
            let high = rest.split(|sign| !is_of_number(sign)).next()?.trim_end_matches('.');
            Some([low.parse().ok()?, high.parse().ok()?])
        });
        let parts: Vec<[f64; 2]> = parts.collect::<Option<_>>()?;
        match parts[..] {
            [] => None,
            [one] => Some(one),
            _ => Some([0, 1].map(|end| {
                libm::sqrt(parts.iter().map(|part| part[end] * part[end]).sum::<f64>())
            })),
        }
    }
}

impl<'a> PseudoRealities<'a> {
    /// Profiles around that of a measured robot, `widening` times as wide as the intervals of the
    /// fit.
    pub fn around(profile: &'a RobotProfile, widening: f64) -> Result<Self, PseudoRealityError> {
        let document = plain(profile);
        let varied: Vec<Varied> = profile
            .provenance
            .numbers
            .keys()
            .filter_map(|key| {
                let [low, high] = profile.provenance.interval(key)?;
                let measured = document.pointer(&pointer(key))?.as_f64()?;
                let most = if key.ends_with("_positive") { 1.0 } else { f64::INFINITY };
                let end = |end: f64| (measured + widening * (end - measured)).clamp(0.0, most);
                Some(Varied { key: key.clone(), measured, from: end(low), to: end(high) })
            })
            .collect();
        if varied.is_empty() {
            return Err(PseudoRealityError::NoIntervals(profile.name.clone()));
        }
        let all = Self { profile, varied };
        for share in [0.0, 1.0] {
            let at_end = all.at(|_| share);
            at_end.check().map_err(|problem| PseudoRealityError::TooWide { widening, problem })?;
        }
        Ok(all)
    }

    /// What is drawn.
    pub fn varied(&self) -> &[Varied] {
        &self.varied
    }

    /// One of the profiles: the same for the same seed and number.
    pub fn draw(&self, seed: u64, number: u64) -> RobotProfile {
        self.at(|table| {
            let mut digest = Digest::new("pseudo-reality");
            digest.word(seed);
            digest.word(number);
            digest.text(table);
            (digest.value() >> 11) as f64 / (1_u64 << 53) as f64
        })
    }

    /// The profile whose numbers are so far between their ends, from 0 to 1, by the table that they are in.
    fn at(&self, share: impl Fn(&str) -> f64) -> RobotProfile {
        let mut document = plain(self.profile);
        for Varied { key, from, to, .. } in &self.varied {
            let is_index = |part: &&str| part.parse::<usize>().is_ok();
            let table: Vec<&str> = key.split('.').take_while(|part| !is_index(part)).collect();
            let value = from + share(&table.join(".")) * (to - from);
            if let Some(place) = document.pointer_mut(&pointer(key)) {
                *place = Value::from(tidy(value));
            }
        }
        serde_json::from_value(document).expect("only numbers have changed")
    }
}

/// A profile as its file has it.
fn plain(profile: &RobotProfile) -> Value {
    serde_json::to_value(profile).expect("a profile is plain data")
}

/// A dotted path as a pointer into JSON.
fn pointer(key: &str) -> String {
    format!("/{}", key.replace('.', "/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smars() -> RobotProfile {
        let text = include_str!("../../../../launch_configs/profiles/smars.yaml");
        RobotProfile::parse("smars.yaml", text).unwrap()
    }

    #[test]
    fn intervals_are_those_that_the_sources_state() {
        let provenance = smars().provenance;

        assert_eq!(provenance.interval("sensing.true_positive"), Some([0.8829, 0.9045]));
        assert_eq!(provenance.interval("computation.period_s"), Some([0.09801, 0.1068]));
        assert_eq!(provenance.interval("body.radius_m"), None);
        assert_eq!(provenance.interval("no.such.key"), None);
        let [low, high] = provenance.interval("actuation.speed.robot_sd").unwrap();
        assert!((low - libm::hypot(0.03028, 0.01627)).abs() < 1e-12);
        assert!((high - libm::hypot(0.1467, 0.02333)).abs() < 1e-12);
    }

    #[test]
    fn every_number_with_an_interval_is_drawn_evenly_within_it_and_nothing_else_is() {
        let measured = smars();
        let around = PseudoRealities::around(&measured, 2.0).unwrap();
        assert_eq!(around.varied().len(), 12);
        let drawn: Vec<RobotProfile> = (0..400).map(|number| around.draw(7, number)).collect();

        for Varied { key, measured, from, to } in around.varied() {
            let values = drawn
                .iter()
                .map(|robot| plain(robot).pointer(&pointer(key)).unwrap().as_f64().unwrap());
            let mean = values.clone().sum::<f64>() / 400.0;
            assert!(from <= measured && measured <= to, "{key}");
            assert!(
                values.clone().all(|value| (from - 1e-9..=to + 1e-9).contains(&value)),
                "{key}"
            );
            // A mean of 400 even draws is within four of its standard errors.
            assert!(
                (mean - (from + to) / 2.0).abs() < 4.0 * (to - from) / 12.0_f64.sqrt() / 20.0,
                "{key}"
            );
        }
        for robot in &drawn {
            assert!(robot.check().is_ok());
            assert_eq!(
                (&robot.body, &robot.sensing.polygon_m),
                (&measured.body, &measured.sensing.polygon_m)
            );
        }
    }

    #[test]
    fn gains_of_one_table_are_drawn_together_and_each_number_again_alike() {
        let measured = smars();
        let around = PseudoRealities::around(&measured, 1.0).unwrap();
        let share = |robot: &RobotProfile, key: &str| {
            let varied = around.varied().iter().find(|it| it.key == key).unwrap();
            let value = plain(robot).pointer(&pointer(key)).unwrap().as_f64().unwrap();
            (value - varied.from) / (varied.to - varied.from)
        };
        let robot = around.draw(1, 3);

        let [one, two] =
            [0, 2].map(|row| share(&robot, &format!("actuation.speed.gain_by_command.{row}.mean")));
        let other = share(&robot, "actuation.turn.gain_by_command.0.mean");

        assert!((one - two).abs() < 1e-6 && (one - other).abs() > 1e-6);
        assert_eq!(around.draw(1, 3), robot);
        assert_ne!(around.draw(1, 4), robot);
        assert_ne!(around.draw(2, 3), robot);
    }

    #[test]
    fn robots_without_intervals_and_robots_that_cannot_be_are_refused() {
        let mut bare = smars();
        bare.provenance.numbers.clear();
        let refused = PseudoRealities::around(&bare, 2.0).unwrap_err();
        assert_eq!(refused, PseudoRealityError::NoIntervals("smars".to_owned()));
        let measured = smars();
        let refused = PseudoRealities::around(&measured, 1e6).unwrap_err();
        assert!(matches!(refused, PseudoRealityError::TooWide { .. }), "{refused}");
    }
}
