//! The behaviours that swarms are judged for: a name, phases, and the rules between them.
//!
//! A behaviour is what its table states, and nothing else depends on which one it is: a sweep file
//! names it, the judge applies its rules, shares are those of its wanted phase.

use std::fmt;

use serde::Serialize;
use serde::de::{self, Deserialize, Deserializer};

use crate::document::nearest;
use crate::judge::phase::Phase;
use crate::judge::rule::{Condition, NONE, Parameter, Rule, Rules};

/// What a swarm is judged for.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Behaviour {
    /// One rotating circle: the paper's.
    #[default]
    Milling,
    /// All robots in one cluster.
    Aggregation,
    /// No robot within reach of another.
    Dispersal,
}

impl Behaviour {
    /// All behaviours.
    pub const ALL: [Self; 3] = [Self::Milling, Self::Aggregation, Self::Dispersal];

    /// The name in files and on the command line: `milling`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Milling => "milling",
            Self::Aggregation => "aggregation",
            Self::Dispersal => "dispersal",
        }
    }

    /// The behaviour with this name in files.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|behaviour| behaviour.key() == key)
    }

    /// Whether it is the one that files do not name.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// Its phases, in the order of columns and legends; the wanted one first.
    pub fn phases(self) -> &'static [Phase] {
        match self {
            Self::Milling => &[
                Phase::StableMilling,
                Phase::SemiStableMilling,
                Phase::Unformed,
                Phase::Dispersion,
                Phase::CollidingUnstable,
            ],
            Self::Aggregation => {
                &[Phase::Aggregated, Phase::PartlyAggregated, Phase::NotAggregated]
            }
            Self::Dispersal => &[Phase::SpreadOut, Phase::PartlySpreadOut, Phase::NotSpreadOut],
        }
    }

    /// The phase that it is named for: `B` is its share.
    pub fn wanted(self) -> Phase {
        self.phases()[0]
    }

    /// What its share is a share of: `share of stable milling`.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Milling => "stable milling",
            Self::Aggregation => "aggregation",
            Self::Dispersal => "dispersal",
        }
    }

    /// A swarm that is judged for it: `a milling swarm`.
    pub fn swarm(self) -> &'static str {
        match self {
            Self::Milling => "a milling swarm",
            Self::Aggregation => "an aggregating swarm",
            Self::Dispersal => "a dispersing swarm",
        }
    }

    /// What a swarm does in the wanted phase: `it mills in 98 % of its runs`.
    pub fn verb(self) -> Verb {
        match self {
            Self::Milling => Verb { plain: "mill", does: "mills", did: "milled" },
            Self::Aggregation => Verb { plain: "aggregate", does: "aggregates", did: "aggregated" },
            Self::Dispersal => Verb { plain: "spread out", does: "spreads out", did: "spread out" },
        }
    }

    /// The rules between its phases.
    ///
    /// Stable and semi-stable milling are a continuum in circliness. So its bound can be moved
    /// ([`Rules::with_wanted_bound`]), and results show how `B_s` moves with it.
    pub fn rules(self) -> Rules {
        match self {
            Self::Milling => milling(),
            Self::Aggregation => aggregation(),
            Self::Dispersal => dispersal(),
        }
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

impl<'de> Deserialize<'de> for Behaviour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        Self::from_key(&key).ok_or_else(|| {
            let keys = Self::ALL.map(Self::key);
            let nearest = nearest(&key, keys);
            let meant = nearest.map_or_else(String::new, |key| format!("; did you mean `{key}`?"));
            let keys = keys.join(", ");
            de::Error::custom(format!("unknown behaviour `{key}`, expected one of {keys}{meant}"))
        })
    }
}

impl fmt::Display for Behaviour {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

/// A share of robots from which on a group is nearly all of them.
const NEARLY_ALL: f64 = 0.9;

fn rule<const N: usize>(phase: Phase, conditions: [Condition; N]) -> Rule {
    Rule { phase, conditions: conditions.into() }
}

fn milling() -> Rules {
    let (least, below) = (Condition::at_least, Condition::below);
    Rules {
        rules: vec![
            rule(Phase::Dispersion, [least(Parameter::Lost, 0.25)]),
            rule(Phase::CollidingUnstable, [least(Parameter::Stuck, 0.2)]),
            rule(Phase::CollidingUnstable, [least(Parameter::Blocked, 0.25)]),
            rule(
                Phase::StableMilling,
                [
                    least(Parameter::Rotation, 0.9),
                    least(Parameter::Orbit, 0.8),
                    least(Parameter::Circliness, 0.5),
                    below(Parameter::Blocked, 0.02),
                    below(Parameter::Lost, NONE),
                ],
            ),
            rule(
                Phase::SemiStableMilling,
                [least(Parameter::Rotation, 0.6), least(Parameter::Orbit, 0.5)],
            ),
        ],
        otherwise: Phase::Unformed,
        wanted: Phase::StableMilling,
        not_lasting: Phase::SemiStableMilling,
    }
}

/// Clusters as in M. Gauci, J. Chen, W. Li, T. J. Dodd and R. Groß, "Self-organized aggregation
/// without computation", IJRR 33(8), 2014.
fn aggregation() -> Rules {
    let least = Condition::at_least;
    Rules {
        rules: vec![
            rule(Phase::Aggregated, [least(Parameter::Clustered, NEARLY_ALL)]),
            rule(Phase::PartlyAggregated, [least(Parameter::Clustered, 0.5)]),
        ],
        otherwise: Phase::NotAggregated,
        wanted: Phase::Aggregated,
        not_lasting: Phase::PartlyAggregated,
    }
}

fn dispersal() -> Rules {
    let least = Condition::at_least;
    Rules {
        rules: vec![
            rule(Phase::SpreadOut, [least(Parameter::Lost, NEARLY_ALL)]),
            rule(Phase::PartlySpreadOut, [least(Parameter::Lost, 0.5)]),
        ],
        otherwise: Phase::NotSpreadOut,
        wanted: Phase::SpreadOut,
        not_lasting: Phase::PartlySpreadOut,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_belongs_to_one_behaviour_and_a_rule_gives_it() {
        let listed: Vec<Phase> =
            Behaviour::ALL.iter().flat_map(|behaviour| behaviour.phases()).copied().collect();
        assert_eq!(listed, Phase::ALL);

        for behaviour in Behaviour::ALL {
            let rules = behaviour.rules();
            assert_eq!(rules.wanted, behaviour.wanted());
            assert_eq!(Behaviour::from_key(behaviour.key()), Some(behaviour));
            for phase in behaviour.phases() {
                assert_eq!(phase.behaviour(), behaviour);
                let is_given = rules.of(*phase).count() > 0 || *phase == rules.otherwise;
                assert!(is_given, "{phase}");
            }
        }
    }
}
