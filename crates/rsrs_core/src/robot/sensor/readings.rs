//! What all sensors of a robot report at one time.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::DETECTION;

/// Most readings of a robot: all of their cases are looked through.
pub const MOST_READINGS: usize = 8;

/// What the sensors of one robot report, in the order of [`ReadingNames`]; the first reading is `detection`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Readings(u8);

impl Readings {
    /// Whether a reading is true.
    pub fn has(self, reading: usize) -> bool {
        self.0 >> reading & 1 == 1
    }

    /// Whether `detection` is.
    pub fn detection(self) -> bool {
        self.has(0)
    }

    /// Sets a reading.
    ///
    /// # Panics
    ///
    /// If there cannot be so many.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    pub fn set(&mut self, reading: usize, is_true: bool) {
        assert!(reading < MOST_READINGS, "a robot has at most {MOST_READINGS} readings");
        self.0 = self.0 & !(1 << reading) | u8::from(is_true) << reading;
    }

    /// Its place among all cases.
    pub fn case(self) -> usize {
        usize::from(self.0)
    }

    /// The case at a place.
    ///
    /// # Panics
    ///
    /// If there is none.
    pub fn of_case(case: usize) -> Self {
        Self(u8::try_from(case).expect("a case of at most eight readings"))
    }
}

/// A robot that has no reading but `detection`.
impl From<bool> for Readings {
    fn from(detection: bool) -> Self {
        Self(u8::from(detection))
    }
}

/// Robots that report more than somebody takes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("these robots report {found}, and {where_} `{DETECTION}` alone")]
pub struct FurtherReadings {
    /// What they report.
    found: String,
    /// Who takes less.
    where_: &'static str,
}

/// The readings of a robot by name: those of each sensor together, of which one at most is true. Empty where
/// `detection` is all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ReadingNames(Vec<Vec<String>>);

impl ReadingNames {
    /// The names of sensors, `detection` first.
    pub fn new(sensors: impl IntoIterator<Item = Vec<String>>) -> Self {
        let sensors: Vec<Vec<String>> = sensors.into_iter().collect();
        if sensors.iter().flatten().eq([DETECTION]) { Self::default() } else { Self(sensors) }
    }

    /// Whether `detection` is all.
    pub fn is_detection(&self) -> bool {
        self.0.is_empty()
    }

    /// All names, in the order of [`Readings`].
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        let only = self.0.is_empty().then_some(DETECTION);
        only.into_iter().chain(self.0.iter().flatten().map(String::as_str))
    }

    /// All but `detection`.
    pub fn further(&self) -> impl Iterator<Item = &str> {
        self.iter().skip(1)
    }

    /// How many there are.
    pub fn n_readings(&self) -> usize {
        self.iter().count()
    }

    /// Which reading has a name.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.iter().position(|known| known == name)
    }

    /// The readings of each sensor, by place.
    fn sensors(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let mut first = 0;
        self.0.iter().map(move |names| {
            let readings = first..first + names.len();
            first = readings.end;
            readings
        })
    }

    /// A case in which each sensor reports one thing at most, the first of those that it reports here: messages of
    /// different times may contradict each other.
    pub fn possible(&self, found: Readings) -> Readings {
        let mut possible = found;
        for readings in self.sensors() {
            for behind in readings.filter(|reading| found.has(*reading)).skip(1) {
                possible.set(behind, false);
            }
        }
        possible
    }

    /// Every case that can be, the one in which nothing is detected last.
    pub fn cases(&self) -> impl Iterator<Item = Readings> {
        let all = (0..1_usize << self.n_readings()).rev().map(Readings::of_case);
        all.filter(|case| self.possible(*case) == *case)
    }

    /// A case in words, as rows state it: `detection: true, wall: false`.
    pub fn described(&self, case: Readings) -> String {
        let readings = self.iter().enumerate();
        let words = readings.map(|(place, name)| format!("{name}: {}", case.has(place)));
        words.collect::<Vec<_>>().join(", ")
    }

    /// Refuses readings besides `detection` where there is no place for them: `where_` says where,
    /// as in "a function in place of their controller takes".
    pub fn refuse_further(&self, where_: &'static str) -> Result<(), FurtherReadings> {
        if self.is_detection() {
            return Ok(());
        }
        Err(FurtherReadings { found: self.to_string(), where_ })
    }

    /// Whether each name is there once, they are not too many, and the first one is `detection`.
    pub fn check(&self) -> Result<(), String> {
        let names: Vec<&str> = self.iter().collect();
        let twice = (1..names.len()).find(|place| names[..*place].contains(&names[*place]));
        match twice {
            Some(place) => Err(format!("`{}` is the name of two readings", names[place])),
            None if names.len() > MOST_READINGS => {
                Err(format!("there are {} readings, expected at most {MOST_READINGS}", names.len()))
            }
            None if names[0] != DETECTION => {
                Err(format!("the first reading is `{}`, expected `{DETECTION}`", names[0]))
            }
            None => Ok(()),
        }
    }
}

/// `detection, wall`
impl fmt::Display for ReadingNames {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.iter().collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(sensors: &[&[&str]]) -> ReadingNames {
        let sensor = |names: &&[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        ReadingNames::new(sensors.iter().map(sensor))
    }

    #[test]
    fn of_the_readings_of_one_sensor_one_at_most_is_true() {
        let ternary = names(&[&["detection", "wall"], &["bump"]]);

        let cases: Vec<String> = ternary.cases().map(|case| ternary.described(case)).collect();

        assert_eq!(cases.len(), 6);
        assert_eq!(cases[5], "detection: false, wall: false, bump: false");
        assert!(!cases.iter().any(|case| case.starts_with("detection: true, wall: true")));
        let both = ternary.possible(Readings::of_case(0b111));
        assert_eq!(ternary.described(both), "detection: true, wall: false, bump: true");
        assert_eq!(names(&[&["detection"], &["wall"]]).cases().count(), 4);
    }

    #[test]
    fn one_reading_is_that_of_every_robot() {
        let one = names(&[&["detection"]]);

        assert!(one.is_detection());
        assert_eq!(one, ReadingNames::default());
        assert_eq!(one.iter().collect::<Vec<_>>(), ["detection"]);
        let cases: Vec<Readings> = one.cases().collect();
        assert_eq!(cases, [Readings::from(true), Readings::from(false)]);
    }
}
