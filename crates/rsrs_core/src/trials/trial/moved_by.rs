//! What moved the robots of trials: their own wheels, or a simulator in their place.

use std::iter::Sum;
use std::ops::Add;

use serde::{Deserialize, Serialize};

use crate::robot::profile::TrialOrigin;

/// What moved the robot of one trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrialBackend {
    /// The simulator.
    #[serde(rename = "sim")]
    Simulator,
    /// The robot itself.
    #[serde(rename = "fleet")]
    Fleet,
}

impl TrialBackend {
    /// Both, as tables and the command line spell them.
    pub const ALL: [Self; 2] = [Self::Simulator, Self::Fleet];

    /// Its name in tables and on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Simulator => "sim",
            Self::Fleet => "fleet",
        }
    }

    /// The one with a name.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|backend| backend.key() == key)
    }
}

/// How many trials were moved by what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MovedBy {
    /// By the simulator.
    pub simulator: usize,
    /// By the robots themselves.
    pub fleet: usize,
    /// Not stated, as in tables that were filled in by hand: taken for robots.
    pub unknown: usize,
}

impl MovedBy {
    /// So many trials, all moved by the same.
    pub fn all(backend: Option<TrialBackend>, n_trials: usize) -> Self {
        let mut moved_by = Self::default();
        match backend {
            Some(TrialBackend::Simulator) => moved_by.simulator = n_trials,
            Some(TrialBackend::Fleet) => moved_by.fleet = n_trials,
            None => moved_by.unknown = n_trials,
        }
        moved_by
    }

    /// How far they are a simulator's; `None` if none is.
    pub fn origin(self) -> Option<TrialOrigin> {
        match (self.simulator, self.fleet + self.unknown) {
            (0, _) => None,
            (_, 0) => Some(TrialOrigin::Simulated),
            _ => Some(TrialOrigin::PartlySimulated),
        }
    }
}

impl Add for MovedBy {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            simulator: self.simulator + other.simulator,
            fleet: self.fleet + other.fleet,
            unknown: self.unknown + other.unknown,
        }
    }
}

impl Sum for MovedBy {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}
