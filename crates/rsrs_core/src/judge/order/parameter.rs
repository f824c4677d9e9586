//! The order parameters by name: what each one is, what it needs, and where its value stands.

use std::fmt;

use serde::{Serialize, Serializer};

use super::OrderParameters;
use super::measure::{self, Measure};
use crate::judge::trajectory::Bodies;

/// One of the order parameters: a place in the one table of all.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Parameter(u8);

/// What must be known so that an order parameter has a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prerequisite {
    /// What robots were commanded.
    Commands,
    /// How far from a robot another one can be seen.
    Reach,
    /// The radius of the bodies.
    Radius,
    /// The arena, which walls enclose.
    Arena,
    /// Objects, and where they were.
    Objects,
    /// Goals.
    Goals,
    /// Classes of robots.
    Classes,
}

struct Row {
    key: &'static str,
    /// Empty for what is dimensionless.
    unit: &'static str,
    words: &'static str,
    /// No value is greater.
    most: f64,
    needs: &'static [Prerequisite],
    value: Value,
}

/// Where a value stands.
enum Value {
    /// In a field of its own, which every window has.
    Field { of: fn(&OrderParameters) -> Option<f64>, set: fn(&mut OrderParameters, f64) },
    /// Measured only where the rules of a behaviour ask for it.
    Asked(Measure),
}

/// A row of a field, or of an optional one.
macro_rules! field {
    ($name:ident) => {
        Value::Field { of: |it| Some(it.$name), set: |it, value| it.$name = value }
    };
    (optional $name:ident) => {
        Value::Field { of: |it| it.$name, set: |it, value| it.$name = Some(value) }
    };
}

const NO_LIMIT: f64 = f64::INFINITY;

/// A row of what is from 0 to 1.
const fn share(
    key: &'static str,
    words: &'static str,
    needs: &'static [Prerequisite],
    value: Value,
) -> Row {
    Row { key, unit: "", words, most: 1.0, needs, value }
}

/// A row of what has no greatest value.
const fn amount(
    (key, unit): (&'static str, &'static str),
    words: &'static str,
    needs: &'static [Prerequisite],
    value: Value,
) -> Row {
    Row { key, unit, words, most: NO_LIMIT, needs, value }
}

/// In the order of tables: fields first. A new one is a row at the end, with its measure in `measure.rs`.
const TABLE: &[Row] = &[
    share(
        "lost",
        "share of robots without a neighbour within reach for more than half of the window",
        &[Prerequisite::Reach],
        field!(optional lost),
    ),
    share(
        "blocked",
        "share of time in which robots came less than 20 % as far as they were commanded to drive",
        &[Prerequisite::Commands],
        field!(blocked),
    ),
    share(
        "stuck",
        "share of robots that were blocked for more than 90 % of the window",
        &[Prerequisite::Commands],
        field!(stuck),
    ),
    share(
        "rotation",
        "how well headings circle the centroid: the normalised angular momentum",
        &[],
        field!(rotation),
    ),
    amount(
        ("orbit", ""),
        "how far robots went around the centroid, over how far they were commanded to drive",
        &[Prerequisite::Commands],
        field!(orbit),
    ),
    share(
        "fatness",
        "one less the square of the least over the greatest distance from the centroid",
        &[],
        field!(fatness),
    ),
    share(
        "tangentness",
        "mean |cos| of the angle between a robot's heading and its bearing from the centroid",
        &[],
        field!(tangentness),
    ),
    share("circliness", "one less the larger of fatness and tangentness", &[], field!(circliness)),
    amount(
        ("mean_radius_m", "m"),
        "mean distance of robots from their centroid",
        &[],
        field!(mean_radius_m),
    ),
    amount(
        ("contact_onsets_per_s", "1/s"),
        "how often a robot comes into contact",
        &[Prerequisite::Radius],
        field!(optional contact_onsets_per_s),
    ),
    share(
        "circliness_ceiling",
        "the greatest circliness of a mill that steers once per period",
        &[Prerequisite::Commands],
        field!(circliness_ceiling),
    ),
    share(
        "clustered",
        "share of robots in the largest cluster: no other robot fits between two of one cluster",
        &[Prerequisite::Radius],
        field!(optional clustered),
    ),
    share(
        "polarisation",
        "how well headings agree: the length of their mean; 1 where all head one way",
        &[],
        Value::Asked(measure::POLARISATION),
    ),
    amount(
        ("spread_m", "m"),
        "dispersion about the centroid: root of the mean squared distance from it",
        &[],
        Value::Asked(measure::SPREAD),
    ),
    amount(
        ("wall_distance_m", "m"),
        "mean distance of robots' centres from the nearest wall",
        &[Prerequisite::Arena],
        Value::Asked(measure::WALL_DISTANCE),
    ),
    share(
        "coverage",
        "share of the arena's cells in which a robot is, of as many cells as robots",
        &[Prerequisite::Arena],
        Value::Asked(measure::COVERAGE),
    ),
    share(
        "visited",
        "share of the arena's cells in which a robot was within the window, of cells as wide as a body",
        &[Prerequisite::Arena, Prerequisite::Radius],
        Value::Asked(measure::VISITED),
    ),
    share(
        "objects_clustered",
        "share of objects in the largest cluster of objects: no other object fits between two of one cluster",
        &[Prerequisite::Objects],
        Value::Asked(measure::OBJECTS_CLUSTERED),
    ),
    share(
        "objects_at_goal",
        "share of objects whose centres are in a goal",
        &[Prerequisite::Objects, Prerequisite::Goals],
        Value::Asked(measure::OBJECTS_AT_GOAL),
    ),
    share(
        "at_goal",
        "share of robots whose centres are in a goal",
        &[Prerequisite::Goals],
        Value::Asked(measure::AT_GOAL),
    ),
    amount(
        ("goal_distance_m", "m"),
        "mean distance of robots' centres from the nearest goal, 0 in it",
        &[Prerequisite::Goals],
        Value::Asked(measure::GOAL_DISTANCE),
    ),
    share(
        "segregated",
        "share of the robots of a class in its largest cluster, a mean over classes: two of one cluster are at \
most 5 cm apart",
        &[Prerequisite::Classes, Prerequisite::Radius],
        Value::Asked(measure::SEGREGATED),
    ),
    share(
        "least_segregated",
        "the same of the class of which it is least",
        &[Prerequisite::Classes, Prerequisite::Radius],
        Value::Asked(measure::LEAST_SEGREGATED),
    ),
    share(
        "consensus",
        "share of robots gathered at the goal that has most of them: no other robot fits between one and the goal, \
or one that is gathered there",
        &[Prerequisite::Goals, Prerequisite::Radius],
        Value::Asked(measure::CONSENSUS),
    ),
    share(
        "last_class_at_goal",
        "share of the robots of the last class in the world's file whose centres are in a goal",
        &[Prerequisite::Goals, Prerequisite::Classes],
        Value::Asked(measure::LAST_CLASS_AT_GOAL),
    ),
];

/// Those before it are fields.
const FIRST_ASKED: usize = TABLE.len() - measure::N_ASKED;

impl Parameter {
    /// Share of lost robots.
    pub const LOST: Self = Self::named("lost");
    /// Share of time blocked.
    pub const BLOCKED: Self = Self::named("blocked");
    /// Share of stuck robots.
    pub const STUCK: Self = Self::named("stuck");
    /// Normalised angular momentum.
    pub const ROTATION: Self = Self::named("rotation");
    /// Way around the centroid.
    pub const ORBIT: Self = Self::named("orbit");
    /// Roundness.
    pub const CIRCLINESS: Self = Self::named("circliness");
    /// Share of robots in the largest cluster.
    pub const CLUSTERED: Self = Self::named("clustered");
    /// Distance of robots from the nearest wall.
    pub const WALL_DISTANCE: Self = Self::named("wall_distance_m");

    /// All of them, in the order of tables.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..).take(TABLE.len()).map(Self)
    }

    /// Those that are measured only where the rules of a behaviour ask for them, as [`Asked`](super::Asked) has them.
    pub(super) fn all_asked() -> impl Iterator<Item = Self> {
        Self::all().skip(FIRST_ASKED)
    }

    /// The one with this name.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::all().find(|parameter| parameter.key() == key)
    }

    #[expect(clippy::cast_possible_truncation, reason = "the table has few rows")]
    const fn named(key: &str) -> Self {
        let mut place = 0;
        while !are_equal(TABLE[place].key, key) {
            place += 1;
        }
        Self(place as u8)
    }

    fn row(self) -> &'static Row {
        &TABLE[usize::from(self.0)]
    }

    /// The name in files, tables and reports; its end names the unit.
    pub fn key(self) -> &'static str {
        self.row().key
    }

    /// The unit: `m`, `1/s`, or nothing for what is dimensionless.
    pub fn unit(self) -> &'static str {
        self.row().unit
    }

    /// A value of it as sentences have it: `0.50`, `0.50 m`.
    pub fn with_unit(self, value: f64) -> String {
        let space = if self.unit().is_empty() { "" } else { " " };
        format!("{value:.2}{space}{}", self.unit())
    }

    /// What it is, in words.
    pub fn words(self) -> &'static str {
        self.row().words
    }

    /// No value is greater; infinite where there is no limit. None is below 0.
    pub fn most(self) -> f64 {
        self.row().most
    }

    /// Whether it has a value only where this is known.
    pub fn needs(self, what: Prerequisite) -> bool {
        self.row().needs.contains(&what)
    }

    /// Whether it is about what robots were commanded, and not about poses alone.
    pub fn needs_commands(self) -> bool {
        self.needs(Prerequisite::Commands)
    }

    /// What it needs of the robots and their arena that is not known; reach and commands are another matter,
    /// because they do not always decide.
    pub fn lacks(self, bodies: &Bodies) -> Option<Prerequisite> {
        let is_unknown = |needs: &Prerequisite| match needs {
            Prerequisite::Radius => bodies.radius_m.is_none(),
            Prerequisite::Arena => bodies.arena_m.is_none(),
            Prerequisite::Objects => bodies.world.n_objects() == 0,
            Prerequisite::Goals => bodies.world.goals.is_empty(),
            Prerequisite::Classes => bodies.classes.is_empty(),
            Prerequisite::Commands | Prerequisite::Reach => false,
        };
        self.row().needs.iter().copied().find(is_unknown)
    }

    /// Its value; `None` if it is not known, or was not asked for.
    pub fn value(self, evidence: &OrderParameters) -> Option<f64> {
        match self.row().value {
            Value::Field { of, .. } => of(evidence),
            Value::Asked(_) => evidence.asked.0[usize::from(self.0) - FIRST_ASKED],
        }
    }

    /// Its value; of one that is not known 0, and of one that was not asked for nothing that any bound holds of.
    pub fn of(self, evidence: &OrderParameters) -> f64 {
        let unknown = if self.is_asked() { f64::NAN } else { 0.0 };
        self.value(evidence).unwrap_or(unknown)
    }

    /// Sets its value.
    pub fn set(self, evidence: &mut OrderParameters, value: f64) {
        match self.row().value {
            Value::Field { set, .. } => set(evidence, value),
            Value::Asked(_) => evidence.asked.0[usize::from(self.0) - FIRST_ASKED] = Some(value),
        }
    }

    /// How it is measured, if that is done only where it is asked for.
    pub(super) fn asked(self) -> Option<&'static Measure> {
        match &self.row().value {
            Value::Field { .. } => None,
            Value::Asked(measure) => Some(measure),
        }
    }

    /// Whether it is measured only where the rules of a behaviour ask for it.
    pub fn is_asked(self) -> bool {
        self.asked().is_some()
    }

    /// Whether it grows with the window, so that a block of it shows less than the whole.
    pub fn adds_up(self) -> bool {
        self.asked().is_some_and(|measure| measure.adds_up)
    }
}

const fn are_equal(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut at = 0;
    while at < one.len() && at < other.len() && one[at] == other[at] {
        at += 1;
    }
    at == one.len() && at == other.len()
}

impl fmt::Display for Parameter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

impl fmt::Debug for Parameter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}
