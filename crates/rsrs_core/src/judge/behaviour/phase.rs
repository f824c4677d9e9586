//! The phases into which a swarm can settle.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer};
use serde::{Serialize, Serializer};

use super::Behaviour;
use super::file::PhaseEntry;
use crate::document::{did_you_mean, nearest};

/// What a swarm settled into: a phase of one of the behaviours that swarms are judged for.
///
/// Those of milling are the four phases of the paper, and `unformed` for what is none of them:
/// reported as such, never forced into the four.
///
/// # Source
///
/// §IV step 3, the list before `fig:phase_plot2`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Phase {
    behaviour: Behaviour,
    /// Among the phases of the behaviour, from 0.
    place: u8,
}

/// A behaviour has at most so many phases: as many as there are colours and symbols that everybody
/// distinguishes.
pub const MOST_PHASES: usize = 5;

impl Phase {
    /// One rotating circle, free of contact.
    pub const STABLE_MILLING: Self = Self { behaviour: Behaviour::MILLING, place: 0 };
    /// Rotating around a centre, but not a clean circle.
    pub const SEMI_STABLE_MILLING: Self = Self { behaviour: Behaviour::MILLING, place: 1 };
    /// None of the other four; mostly two or more separate groups.
    pub const UNFORMED: Self = Self { behaviour: Behaviour::MILLING, place: 2 };
    /// Robots have lost each other.
    pub const DISPERSION: Self = Self { behaviour: Behaviour::MILLING, place: 3 };
    /// Robots block each other and stand.
    pub const COLLIDING_UNSTABLE: Self = Self { behaviour: Behaviour::MILLING, place: 4 };
    /// Nearly all robots are in one cluster.
    pub const AGGREGATED: Self = Self { behaviour: Behaviour::AGGREGATION, place: 0 };
    /// At least half of the robots are in one cluster.
    pub const PARTLY_AGGREGATED: Self = Self { behaviour: Behaviour::AGGREGATION, place: 1 };
    /// No cluster holds half of the robots.
    pub const NOT_AGGREGATED: Self = Self { behaviour: Behaviour::AGGREGATION, place: 2 };
    /// Nearly no robot has another within reach.
    pub const SPREAD_OUT: Self = Self { behaviour: Behaviour::DISPERSAL, place: 0 };
    /// At least half of the robots have none within reach.
    pub const PARTLY_SPREAD_OUT: Self = Self { behaviour: Behaviour::DISPERSAL, place: 1 };
    /// Most robots have others within reach.
    pub const NOT_SPREAD_OUT: Self = Self { behaviour: Behaviour::DISPERSAL, place: 2 };

    /// All phases of the behaviours that are built in.
    pub const BUILT_IN: [Self; 11] = [
        Self::STABLE_MILLING,
        Self::SEMI_STABLE_MILLING,
        Self::UNFORMED,
        Self::DISPERSION,
        Self::COLLIDING_UNSTABLE,
        Self::AGGREGATED,
        Self::PARTLY_AGGREGATED,
        Self::NOT_AGGREGATED,
        Self::SPREAD_OUT,
        Self::PARTLY_SPREAD_OUT,
        Self::NOT_SPREAD_OUT,
    ];

    #[expect(clippy::cast_possible_truncation, reason = "there are at most MOST_PHASES")]
    pub(super) fn new(behaviour: Behaviour, place: usize) -> Self {
        Self { behaviour, place: place as u8 }
    }

    /// The behaviour that it is a phase of.
    pub fn behaviour(self) -> Behaviour {
        self.behaviour
    }

    /// Its place among the phases of its behaviour, from 0: that of colours, symbols and columns.
    pub fn place(self) -> usize {
        usize::from(self.place)
    }

    /// What its behaviour's file states of it.
    pub fn entry(self) -> &'static PhaseEntry {
        &self.behaviour.file().phases[self.place()]
    }

    /// The name in files: `stable_milling`.
    pub fn key(self) -> &'static str {
        &self.entry().key
    }

    /// The name in pictures and reports: `stable milling`.
    pub fn title(self) -> &'static str {
        self.behaviour.titles()[self.place()].as_str()
    }

    /// All phases that are known by now: of the behaviours that are built in, and of those that were read.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> {
        Behaviour::all().flat_map(|behaviour| behaviour.phases().iter().copied())
    }

    /// The phase with this name in files, of the behaviours that are built in or were read; of several that
    /// of the behaviour that was read last.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::all().rev().find(|phase| phase.key() == key)
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.title())
    }
}

/// `StableMilling`.
impl fmt::Debug for Phase {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.key().split('_').try_for_each(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            write!(formatter, "{}{rest}", first.to_ascii_uppercase())
        })
    }
}

impl Serialize for Phase {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl<'de> Deserialize<'de> for Phase {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        Self::from_key(&key).ok_or_else(|| de::Error::custom(unknown(&key)))
    }
}

/// Why a name is that of no phase, with what was meant.
pub fn unknown(key: &str) -> String {
    let meant = did_you_mean(nearest(key, Phase::all().map(Phase::key)));
    format!("unknown phase `{key}`{meant}")
}
