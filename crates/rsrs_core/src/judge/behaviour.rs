//! The behaviours that swarms are judged for: a name, phases, and the rules between them.
//!
//! A behaviour is a file ([`file::BehaviourFile`]), and nothing else depends on which one it is: a sweep
//! names it, the judge applies its rules, shares are those of its wanted phase. Three are built in.

pub mod bounds;
pub mod check;
pub mod condition;
pub mod file;
mod known;
pub mod named;
pub mod phase;
pub mod rule;

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use crate::document::{self, did_you_mean, nearest};
use crate::judge::order::Parameter;
use crate::judge::window::Window;

use check::{BehaviourFileError, Flaw};
use file::BehaviourFile;
use phase::Phase;
use rule::Rules;

/// What a swarm is judged for: the handle of a behaviour that is built in, or whose file was read.
///
/// In files it is the name of one that is built in, or all of it, so that no other file is needed to judge
/// again.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Behaviour(u16);

impl Behaviour {
    /// One rotating circle: the paper's.
    pub const MILLING: Self = Self(0);
    /// All robots in one cluster.
    pub const AGGREGATION: Self = Self(1);
    /// No robot within reach of another.
    pub const DISPERSAL: Self = Self(2);
    /// Those that need no file.
    pub const BUILT_IN: [Self; 3] = [Self::MILLING, Self::AGGREGATION, Self::DISPERSAL];

    /// The behaviour of a file; the same one for equal files. Names of what is built in are taken.
    pub fn new(file: BehaviourFile) -> Result<Self, Flaw> {
        known::add(file)
    }

    /// All that are known by now, in the order in which they were read.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> {
        known::all()
    }

    /// Reads a behaviour's file, called `file` in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, BehaviourFileError> {
        let read = document::parse_with(file, text, &BehaviourFile::REQUIRED)?;
        Self::new(read).map_err(|flaw| flaw.in_file(file, text))
    }

    /// The built-in behaviour with this name, or the one that was read last.
    pub fn from_key(key: &str) -> Option<Self> {
        known::all().rev().find(|behaviour| behaviour.key() == key)
    }

    /// The name in files and on the command line: `milling`.
    pub fn key(self) -> &'static str {
        &self.file().name
    }

    /// What it is, as a file.
    pub fn file(self) -> &'static BehaviourFile {
        &known::get(self).file
    }

    /// Whether it is the one that files do not name.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// Its phases, in the order of columns and legends; the wanted one first.
    pub fn phases(self) -> &'static [Phase] {
        &known::get(self).phases
    }

    /// The names of its phases in pictures and texts, in their order.
    fn titles(self) -> &'static [String] {
        &known::get(self).titles
    }

    /// The phase that it is named for: `B` is its share.
    pub fn wanted(self) -> Phase {
        self.phases()[0]
    }

    /// What its share is a share of: `share of stable milling`.
    pub fn noun(self) -> &'static str {
        &self.file().words.noun
    }

    /// A swarm that is judged for it: `a milling swarm`.
    pub fn swarm(self) -> &'static str {
        &self.file().words.swarm
    }

    /// What a swarm does in the wanted phase: `it mills in 98 % of its runs`.
    pub fn verb(self) -> Verb {
        let [plain, does, did] = &self.file().words.verb;
        Verb { plain, does, did }
    }

    /// Which time of a run is judged.
    pub fn window(self) -> Window {
        self.file().window
    }

    /// The rules between its phases.
    pub fn rules(self) -> Rules {
        known::get(self).rules.clone()
    }
}

impl Parameter {
    /// Those that the tables of a behaviour have: what every window has, and what its rules ask for besides.
    pub fn of_behaviour(behaviour: Behaviour) -> Vec<Self> {
        let rules = behaviour.rules();
        Self::all().filter(|it| !it.is_asked() || rules.ask_for(*it)).collect()
    }
}

/// A verb in the forms that sentences need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verb {
    /// `robots mill`
    pub plain: &'static str,
    /// `it mills`
    pub does: &'static str,
    /// `9 runs milled`
    pub did: &'static str,
}

/// Why a name is that of no behaviour, with what was meant.
pub fn unknown(key: &str) -> String {
    let keys: Vec<&str> = known::all().map(Behaviour::key).collect();
    let meant = did_you_mean(nearest(key, keys.iter().copied()));
    format!("unknown behaviour `{key}`, expected one of {}{meant}", keys.join(", "))
}

impl Serialize for Behaviour {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if Self::BUILT_IN.contains(self) {
            return serializer.serialize_str(self.key());
        }
        self.file().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Behaviour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrFile;
        impl<'de> Visitor<'de> for NameOrFile {
            type Value = Behaviour;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the name of a behaviour, or all of one")
            }
            fn visit_str<E: de::Error>(self, key: &str) -> Result<Behaviour, E> {
                Behaviour::from_key(key).ok_or_else(|| E::custom(unknown(key)))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Behaviour, A::Error> {
                let file = BehaviourFile::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Behaviour::new(file).map_err(de::Error::custom)
            }
        }
        deserializer.deserialize_any(NameOrFile)
    }
}

impl schemars::JsonSchema for Behaviour {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Behaviour".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let file = generator.subschema_for::<BehaviourFile>();
        schemars::json_schema!({
            "description": "What a swarm is judged for: the name of what is built in, or all of a behaviour.",
            "anyOf": [{"type": "string", "enum": Self::BUILT_IN.map(Self::key)}, file],
        })
    }
}

impl fmt::Display for Behaviour {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

impl fmt::Debug for Behaviour {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_that_is_built_in_belongs_to_one_behaviour_and_a_rule_gives_it() {
        for behaviour in Behaviour::BUILT_IN {
            let rules = behaviour.rules();
            assert_eq!(behaviour.file().check(), Ok(()));
            assert_eq!(rules.wanted, behaviour.wanted());
            assert_eq!(Behaviour::from_key(behaviour.key()), Some(behaviour));
            for phase in behaviour.phases() {
                assert_eq!(phase.behaviour(), behaviour);
                assert_eq!(Phase::from_key(phase.key()), Some(*phase));
                let is_given = rules.of(*phase).count() > 0 || *phase == rules.otherwise;
                assert!(is_given, "{phase}");
            }
        }
        assert_eq!(Phase::COLLIDING_UNSTABLE.key(), "colliding_unstable");
        assert_eq!(Phase::NOT_AGGREGATED.key(), "not_aggregated");
        assert_eq!(Phase::NOT_SPREAD_OUT.key(), "not_spread_out");
    }

    #[test]
    fn a_behaviour_of_a_file_is_in_other_files_as_a_whole_and_one_that_is_built_in_by_name() {
        let flock = Behaviour::parse("flock.yaml", FLOCK).unwrap();

        assert_eq!(Behaviour::parse("flock.yaml", FLOCK), Ok(flock), "it is read twice");
        assert_eq!(serde_json::to_string(&Behaviour::AGGREGATION).unwrap(), r#""aggregation""#);
        let written = serde_json::to_string(&flock).unwrap();
        assert_eq!(serde_json::from_str::<Behaviour>(&written).unwrap(), flock);
        let other = written.replace("0.75", "0.5");
        let other: Behaviour = serde_json::from_str(&other).unwrap();
        assert_ne!(other, flock, "with another bound it is another one");
        assert_eq!(flock.wanted().key(), "flocking");
        assert_eq!(flock.verb().did, "flocked");
    }

    const FLOCK: &str = "
name: flock
words: {noun: flocking, swarm: a flocking swarm, verb: [flock, flocks, flocked]}
phases: [{key: flocking}, {key: no_flock}]
rules: [{phase: flocking, when: {clustered: {at_least: 0.75}}}]
otherwise: no_flock
";
}
