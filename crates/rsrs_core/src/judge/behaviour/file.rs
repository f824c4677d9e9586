//! A behaviour as a file that people write.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::Behaviour;
use super::window::{LAST_S, Window};
use crate::document::{self, DocumentError, did_you_mean, is_name, nearest};
use crate::help::Help;
use crate::judge::phase::{MOST_PHASES, Phase};
use crate::judge::rule::{Condition, NONE, Needs, Parameter, Rule, Rules};

/// What swarms are judged for: phases, and the rules that tell them apart.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BehaviourFile {
    /// The name in files: letters, digits and `_`.
    pub name: String,
    /// What sentences call it.
    pub words: Words,
    /// Two to five phases, the wanted one first; columns and legends have this order.
    pub phases: Vec<PhaseEntry>,
    /// The first rule that holds gives the phase.
    pub rules: Vec<RuleEntry>,
    /// Key of the phase if none holds.
    pub otherwise: String,
    /// Key of the phase of a run that shows the wanted one on the whole, but in more than one of six of its
    /// blocks of 10 s not (default: `otherwise`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_lasting: Option<String>,
    /// Which time of a run is judged: `{last_s: 60}` (default), with another number of seconds from 10 on;
    /// `whole_run`; or `ever`, where a run counts that was in the wanted phase in any 60 s of it.
    #[serde(default, skip_serializing_if = "Window::is_usual")]
    pub window: Window,
}

/// What sentences call a behaviour.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// What its share is a share of: `stable milling`.
    pub noun: String,
    /// A swarm that is judged for it, with its article: `a milling swarm`.
    pub swarm: String,
    /// What robots do, what it does, and what they did: `[mill, mills, milled]`.
    pub verb: [String; 3],
}

/// A phase.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhaseEntry {
    /// The name in files and columns: letters, digits and `_`.
    pub key: String,
    /// The name in pictures and texts (default: the key with spaces).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Its colour, as `"#0072b2"` (default: one for its place, which the colour-blind distinguish).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<String>,
}

/// A phase, and what must hold for it.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RuleEntry {
    /// Key of the phase.
    pub phase: String,
    /// Bounds on [order parameters](#order-parameters), all of which must hold: `{lost: {at_most: 0.1}, rotation: {at_least: 0.5}}`, or `below`.
    pub when: Bounds,
}

/// Bounds on order parameters, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds(Vec<Condition>);

/// A bound as a file has it, in the unit of its order parameter.
#[derive(Clone, Copy, Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Bound {
    /// At the bound or above.
    AtLeast(f64),
    /// Below it.
    Below(f64),
    /// At the bound or below.
    AtMost(f64),
}

/// Why a file makes no behaviour.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unusable {
    /// A name that no file can have.
    #[error("`{found}` is no name, expected letters, digits and `_`, beginning with a letter")]
    Name {
        /// What it is called.
        found: String,
    },
    /// A name of what is built in.
    #[error("`{found}` is built in, as a part of {of}: what is not that needs another name")]
    BuiltIn {
        /// What it is called.
        found: String,
        /// Which behaviour has it.
        of: String,
    },
    /// Too few phases, or too many.
    #[error("there are {found} phases, expected 2 to {MOST_PHASES}")]
    Phases {
        /// How many there are.
        found: usize,
    },
    /// Two phases with one name.
    #[error("phase `{key}` is given twice, or another one has its title")]
    Twice {
        /// The phase.
        key: String,
    },
    /// A rule for what is no phase.
    #[error("`{found}` is none of the phases {}{}", expected.join(", "), did_you_mean(nearest.as_deref()))]
    NoPhase {
        /// What the rule gives.
        found: String,
        /// The keys of all phases.
        expected: Vec<String>,
        /// The one that is closest in spelling.
        nearest: Option<String>,
    },
    /// A phase that no run can be in.
    #[error("no rule gives the phase `{key}`, and it is not `otherwise`")]
    NeverGiven {
        /// The phase.
        key: String,
    },
    /// A rule without bounds, after which no other one counts.
    #[error(
        "the rule of `{phase}` has no bounds, so that it always holds: that is what `otherwise` is for"
    )]
    AlwaysHolds {
        /// Its phase.
        phase: String,
    },
    /// A rule that asks for more than one before it, so that it never decides.
    #[error(
        "rule {number}, of `{phase}`, never decides: whenever it holds, rule {before} before it holds, too"
    )]
    NeverReached {
        /// Which rule, from 1.
        number: usize,
        /// Its phase.
        phase: String,
        /// Which rule before it.
        before: usize,
    },
    /// A colour in another notation.
    #[error("`{found}` is no colour, expected one such as \"#0072b2\"")]
    Colour {
        /// What is given.
        found: String,
    },
    /// A window that is too short, or too long.
    #[error("`window` is the last {found} s, expected {} to {} s", LAST_S[0], LAST_S[1])]
    Window {
        /// How many seconds it has, as text.
        found: String,
    },
    /// A word that is empty.
    #[error("`words` has an empty text")]
    NoWord,
}

/// Why a text is no behaviour.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BehaviourFileError {
    /// The text is not such a file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// It makes no behaviour.
    #[error("{file}: {source}")]
    Unusable {
        /// The file.
        file: String,
        /// Why.
        source: Unusable,
    },
}

impl Help for BehaviourFileError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::Unusable { .. } => None,
        }
    }
}

const REQUIRED: [&str; 5] = ["name", "words", "phases", "rules", "otherwise"];

impl BehaviourFile {
    /// Reads a behaviour, called `file` in errors.
    ///
    /// # Errors
    ///
    /// [`BehaviourFileError`], the first problem found.
    pub fn parse(file: &str, text: &str) -> Result<Self, BehaviourFileError> {
        let parsed: Self = document::parse_with(file, text, &REQUIRED)?;
        parsed
            .check()
            .map_err(|source| BehaviourFileError::Unusable { file: file.to_owned(), source })?;
        Ok(parsed)
    }

    /// Refuses what makes no behaviour.
    ///
    /// # Errors
    ///
    /// [`Unusable`], the first problem found.
    pub fn check(&self) -> Result<(), Unusable> {
        let keys: Vec<&str> = self.phases.iter().map(|phase| phase.key.as_str()).collect();
        for name in keys.iter().copied().chain([self.name.as_str()]) {
            if !is_name(name) {
                return Err(Unusable::Name { found: name.to_owned() });
            }
        }
        if !(2..=MOST_PHASES).contains(&keys.len()) {
            return Err(Unusable::Phases { found: keys.len() });
        }
        for (at, phase) in self.phases.iter().enumerate() {
            let before = &self.phases[..at];
            if before.iter().any(|other| other.key == phase.key || other.title() == phase.title()) {
                return Err(Unusable::Twice { key: phase.key.clone() });
            }
            if let Some(colour) = &phase.colour {
                rgb(colour).ok_or_else(|| Unusable::Colour { found: colour.clone() })?;
            }
        }
        let Words { noun, swarm, verb } = &self.words;
        if [noun, swarm].into_iter().chain(verb).any(|word| word.trim().is_empty()) {
            return Err(Unusable::NoWord);
        }
        if let Window::LastS(last_s) = self.window
            && !(LAST_S[0]..=LAST_S[1]).contains(&last_s)
        {
            return Err(Unusable::Window { found: last_s.to_string() });
        }
        let given = self.rules.iter().map(|rule| &rule.phase);
        for key in given.chain([&self.otherwise]).chain(&self.not_lasting) {
            if !keys.contains(&key.as_str()) {
                return Err(Unusable::NoPhase {
                    found: key.clone(),
                    nearest: nearest(key, keys.iter().copied()).map(str::to_owned),
                    expected: keys.iter().map(|key| (*key).to_owned()).collect(),
                });
            }
        }
        for (at, rule) in self.rules.iter().enumerate() {
            if rule.when.0.is_empty() {
                return Err(Unusable::AlwaysHolds { phase: rule.phase.clone() });
            }
            if let Some(before) =
                self.rules[..at].iter().position(|it| it.when.follow_from(&rule.when))
            {
                return Err(Unusable::NeverReached {
                    number: at + 1,
                    phase: rule.phase.clone(),
                    before: before + 1,
                });
            }
        }
        let is_given = |key: &str| self.rules.iter().any(|rule| rule.phase == key);
        let ends = [Some(self.otherwise.as_str()), self.not_lasting.as_deref()];
        match keys
            .iter()
            .enumerate()
            .find(|(place, key)| !is_given(key) && (*place == 0 || !ends.contains(&Some(**key))))
        {
            Some((_, key)) => Err(Unusable::NeverGiven { key: (*key).to_owned() }),
            None => Ok(()),
        }
    }

    /// Refuses names that a behaviour has that is built in: files of results have the names alone.
    pub(super) fn check_names_beside(&self, built_in: &Self) -> Result<(), Unusable> {
        let names = |file: &Self| -> Vec<String> {
            let keys = file.phases.iter().map(|phase| phase.key.clone());
            keys.chain([file.name.clone()]).collect()
        };
        let theirs = names(built_in);
        match names(self).into_iter().find(|name| theirs.contains(name)) {
            Some(found) => Err(Unusable::BuiltIn { found, of: built_in.name.clone() }),
            None => Ok(()),
        }
    }

    /// Its rules, with phases of this handle.
    pub(super) fn rules(&self, behaviour: Behaviour) -> Rules {
        let place = |key: &str| {
            let place = self.phases.iter().position(|phase| phase.key == key);
            Phase::new(behaviour, place.expect("the file was checked"))
        };
        let rule =
            |rule: &RuleEntry| Rule { phase: place(&rule.phase), conditions: rule.when.0.clone() };
        Rules {
            rules: self.rules.iter().map(rule).collect(),
            otherwise: place(&self.otherwise),
            wanted: Phase::new(behaviour, 0),
            not_lasting: place(self.not_lasting.as_ref().unwrap_or(&self.otherwise)),
            window: self.window,
        }
    }
}

impl PhaseEntry {
    /// The name in pictures and texts.
    pub fn title(&self) -> String {
        self.title.clone().unwrap_or_else(|| self.key.replace('_', " "))
    }

    /// Its colour, red, green and blue, if it has one of its own.
    pub fn rgb(&self) -> Option<[u8; 3]> {
        self.colour.as_deref().and_then(rgb)
    }
}

fn rgb(colour: &str) -> Option<[u8; 3]> {
    let digits = colour.strip_prefix('#').filter(|it| it.len() == 6 && it.is_ascii())?;
    let channel = |at: usize| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).ok();
    Some([channel(0)?, channel(1)?, channel(2)?])
}

impl Bounds {
    /// Whether these hold wherever others do.
    fn follow_from(&self, others: &Self) -> bool {
        self.0.iter().all(|it| {
            others.0.iter().any(|other| {
                it.parameter == other.parameter
                    && it.needs == other.needs
                    && match it.needs {
                        Needs::AtLeast => other.bound >= it.bound,
                        Needs::Below => other.bound <= it.bound,
                    }
            })
        })
    }
}

impl Bound {
    fn of(condition: &Condition) -> Self {
        match condition.needs {
            Needs::AtLeast => Self::AtLeast(condition.bound),
            Needs::Below if condition.bound <= NONE => Self::AtMost(0.0),
            Needs::Below => Self::Below(condition.bound),
        }
    }

    fn condition(self, parameter: Parameter) -> Condition {
        match self {
            Self::AtLeast(bound) => Condition::at_least(parameter, bound),
            Self::Below(bound) => Condition::below(parameter, bound),
            Self::AtMost(0.0) => Condition::below(parameter, NONE),
            Self::AtMost(bound) => Condition::below(parameter, bound.next_up()),
        }
    }

    fn bound(self) -> f64 {
        let (Self::AtLeast(bound) | Self::Below(bound) | Self::AtMost(bound)) = self;
        bound
    }
}

impl Serialize for Bounds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for condition in &self.0 {
            map.serialize_entry(condition.parameter.key(), &Bound::of(condition))?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Bounds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ByParameter;
        impl<'de> Visitor<'de> for ByParameter {
            type Value = Bounds;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a map from order parameters to bounds")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Bounds, A::Error> {
                let mut conditions: Vec<Condition> = Vec::new();
                while let Some((key, bound)) = map.next_entry::<String, Bound>()? {
                    let parameter = Parameter::from_key(&key).ok_or_else(|| {
                        let keys: Vec<&str> = Parameter::all().map(Parameter::key).collect();
                        let meant = did_you_mean(nearest(&key, keys.iter().copied()));
                        let keys = keys.join(", ");
                        de::Error::custom(format!(
                            "unknown order parameter `{key}`, expected one of {keys}{meant}"
                        ))
                    })?;
                    let (found, most) = (bound.bound(), parameter.most());
                    if !found.is_finite() || !(0.0..=most).contains(&found) {
                        let to =
                            if most.is_finite() { format!("to {most}") } else { "on".to_owned() };
                        return Err(de::Error::custom(format!(
                            "the bound of {key} is {found}, expected a number from 0 {to}"
                        )));
                    }
                    conditions.push(bound.condition(parameter));
                }
                Ok(Bounds(conditions))
            }
        }
        deserializer.deserialize_map(ByParameter)
    }
}

impl schemars::JsonSchema for Bounds {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Bounds".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": "object",
            "propertyNames": {"enum": Parameter::all().map(Parameter::key).collect::<Vec<_>>()},
            "additionalProperties": generator.subschema_for::<Bound>(),
        })
    }
}
