//! Whether a file makes a behaviour: each refusal with its line.

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;

use super::file::{BehaviourFile, Words, rgb};
use super::phase::MOST_PHASES;
use crate::document::file_error::FileError;
use crate::document::{did_you_mean, is_name, nearest};
use crate::help::Help;
use crate::judge::columns;
use crate::judge::window::{LAST_S, Window};
use crate::quantity::Axis;

/// Where in a file something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At a key of the file.
    Key(&'static str),
    /// In a phase, from 0.
    Phase(usize),
    /// In a rule, from 0.
    Rule(usize),
}

/// What is wrong with a behaviour, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
pub struct Flaw {
    /// Where.
    pub place: Place,
    /// What.
    pub problem: Unusable,
}

/// Why a file makes no behaviour.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unusable {
    /// A name that no file can have.
    #[error("`{0}` is no name, expected small letters, digits and `_`, a letter first")]
    Name(String),
    /// A name of what is built in.
    #[error("`{found}` is the name of {of}, which is built in")]
    BuiltIn {
        /// What it is called.
        found: String,
        /// What has this name.
        of: String,
    },
    /// A phase with the name of another column of results.
    #[error("a phase cannot be called `{0}`: tables of results have a column of this name")]
    Column(String),
    /// Too few phases, or too many.
    #[error("there are {0} phases, expected 2 to {MOST_PHASES}")]
    Phases(usize),
    /// Two phases with one name.
    #[error("phase `{0}` is given twice, or another one has its title")]
    Twice(String),
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
    /// A wanted phase without a rule of its own.
    #[error("no rule gives `{0}`, the first phase, which is the wanted one")]
    WantedNeverGiven(String),
    /// A phase that no run can be in.
    #[error("no rule gives the phase `{0}`, and it is neither `otherwise` nor `not_lasting`")]
    NeverGiven(String),
    /// A rule after which nothing counts.
    #[error("the rule of `{0}` holds of every swarm, so that nothing after it counts")]
    AlwaysHolds(String),
    /// A rule that no swarm can meet.
    #[error("the rule of `{phase}` never holds: no {parameter} is less than 0")]
    NeverHolds {
        /// Its phase.
        phase: String,
        /// The order parameter.
        parameter: &'static str,
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
    #[error("`{0}` is no colour, expected one such as \"#0072b2\"")]
    Colour(String),
    /// A window that is too short, or too long.
    #[error(
        "`window` is the last {0} s, expected {least} to {most} s", least = LAST_S[0], most = LAST_S[1]
    )]
    Window(String),
    /// A word that is empty.
    #[error("`words` has an empty text")]
    NoWord,
}

/// Why a text is no behaviour.
pub type BehaviourFileError = FileError<Unusable>;

impl Help for Unusable {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::BuiltIn { .. } | Self::Column { .. } => "choose another name".to_owned(),
            Self::WantedNeverGiven(key) => format!(
                "add a rule with `phase: {key}`, or put the phase first that the behaviour is named for"
            ),
            Self::NeverGiven(key) => {
                format!("add a rule with `phase: {key}`, or leave the phase out")
            }
            Self::AlwaysHolds(phase) => {
                format!(
                    "leave the rule out, and write `otherwise: {phase}`; or give it another bound"
                )
            }
            Self::NeverReached { .. } => "put it before that one, or leave it out".to_owned(),
            Self::NeverHolds { .. } => "where none at all is meant, write `at_most: 0`".to_owned(),
            Self::Name { .. }
            | Self::Phases { .. }
            | Self::Twice { .. }
            | Self::NoPhase { .. }
            | Self::Colour { .. }
            | Self::Window { .. }
            | Self::NoWord => return None,
        })
    }
}

/// Where the parts of a behaviour are in its file.
#[derive(Deserialize)]
struct Lines {
    name: Spanned<IgnoredAny>,
    words: Spanned<IgnoredAny>,
    phases: Vec<Spanned<IgnoredAny>>,
    rules: Vec<Spanned<IgnoredAny>>,
    otherwise: Spanned<IgnoredAny>,
    not_lasting: Option<Spanned<IgnoredAny>>,
    window: Option<Spanned<IgnoredAny>>,
}

impl Flaw {
    /// The flaw of a file, with its line there.
    pub(super) fn in_file(self, file: &str, text: &str) -> BehaviourFileError {
        let Self { place, problem } = self;
        FileError::flaw((file, text), problem, |lines: &Lines| {
            let part = match place {
                Place::Phase(at) => lines.phases.get(at)?,
                Place::Rule(at) => lines.rules.get(at)?,
                Place::Key("words") => &lines.words,
                Place::Key("phases") => lines.phases.first()?,
                Place::Key("otherwise") => &lines.otherwise,
                Place::Key("not_lasting") => lines.not_lasting.as_ref()?,
                Place::Key("window") => lines.window.as_ref()?,
                Place::Key(_) => &lines.name,
            };
            Some(part.defined.line())
        })
    }
}

impl BehaviourFile {
    /// Refuses what makes no behaviour.
    pub fn check(&self) -> Result<(), Flaw> {
        self.check_names()?;
        self.check_phases()?;
        self.check_rules()?;
        let Words { noun, swarm, verb } = &self.words;
        if [noun, swarm].into_iter().chain(verb).any(|word| word.trim().is_empty()) {
            return Err(Flaw { place: Place::Key("words"), problem: Unusable::NoWord });
        }
        match self.window {
            Window::LastS(last_s) if !(LAST_S[0]..=LAST_S[1]).contains(&last_s) => Err(Flaw {
                place: Place::Key("window"),
                problem: Unusable::Window(last_s.to_string()),
            }),
            _ => Ok(()),
        }
    }

    /// Its name and those of its phases, with their places.
    fn names(&self) -> impl Iterator<Item = (Place, &String)> {
        let phases = self.phases.iter().enumerate();
        let phases = phases.map(|(at, phase)| (Place::Phase(at), &phase.key));
        [(Place::Key("name"), &self.name)].into_iter().chain(phases)
    }

    fn check_names(&self) -> Result<(), Flaw> {
        for (place, name) in self.names() {
            let found = name.clone();
            if !is_name(name) {
                return Err(Flaw { place, problem: Unusable::Name(found) });
            }
            let is_column = columns::is_column(name) || name.parse::<Axis>().is_ok();
            if is_column && matches!(place, Place::Phase(_)) {
                return Err(Flaw { place, problem: Unusable::Column(found) });
            }
        }
        Ok(())
    }

    fn check_phases(&self) -> Result<(), Flaw> {
        let n = self.phases.len();
        if !(2..=MOST_PHASES).contains(&n) {
            let problem = Unusable::Phases(n);
            return Err(Flaw { place: Place::Key("phases"), problem });
        }
        for (at, phase) in self.phases.iter().enumerate() {
            let flaw = |problem| Flaw { place: Place::Phase(at), problem };
            let before = &self.phases[..at];
            if before.iter().any(|other| other.key == phase.key || other.title() == phase.title()) {
                return Err(flaw(Unusable::Twice(phase.key.clone())));
            }
            if let Some(colour) = &phase.colour {
                rgb(colour).ok_or_else(|| flaw(Unusable::Colour(colour.clone())))?;
            }
        }
        Ok(())
    }

    fn check_rules(&self) -> Result<(), Flaw> {
        let keys: Vec<&str> = self.phases.iter().map(|phase| phase.key.as_str()).collect();
        let given = self.rules.iter().enumerate().map(|(at, rule)| (Place::Rule(at), &rule.phase));
        let ends = [(Place::Key("otherwise"), &self.otherwise)].into_iter();
        let ends = ends.chain(self.not_lasting.iter().map(|key| (Place::Key("not_lasting"), key)));
        if let Some((place, key)) = given.chain(ends).find(|(_, key)| !keys.contains(&key.as_str()))
        {
            let problem = Unusable::NoPhase {
                found: key.clone(),
                nearest: nearest(key, keys.iter().copied()).map(str::to_owned),
                expected: keys.iter().map(|key| (*key).to_owned()).collect(),
            };
            return Err(Flaw { place, problem });
        }
        for at in 0..self.rules.len() {
            let flaw = |problem| Flaw { place: Place::Rule(at), problem };
            self.check_rule(at).map_err(flaw)?;
        }
        let is_given = |key: &str| self.rules.iter().any(|rule| rule.phase == key);
        let ends = [Some(self.otherwise.as_str()), self.not_lasting.as_deref()];
        for (at, key) in keys.iter().enumerate().filter(|(_, key)| !is_given(key)) {
            let flaw = |problem| Flaw { place: Place::Phase(at), problem };
            let key = (*key).to_owned();
            if at == 0 {
                return Err(flaw(Unusable::WantedNeverGiven(key)));
            }
            if !ends.contains(&Some(&key)) {
                return Err(flaw(Unusable::NeverGiven(key)));
            }
        }
        Ok(())
    }

    fn check_rule(&self, at: usize) -> Result<(), Unusable> {
        let rule = &self.rules[at];
        let phase = rule.phase.clone();
        let conditions = rule.when.conditions();
        if let Some(never) = conditions.iter().find(|it| it.foregone() == Some(false)) {
            return Err(Unusable::NeverHolds { phase, parameter: never.parameter.key() });
        }
        if conditions.iter().all(|it| it.foregone() == Some(true)) {
            return Err(Unusable::AlwaysHolds(phase));
        }
        let mut before = self.rules[..at].iter();
        match before.position(|other| other.when.follow_from(&rule.when)) {
            Some(before) => {
                Err(Unusable::NeverReached { number: at + 1, phase, before: before + 1 })
            }
            None => Ok(()),
        }
    }

    /// Refuses names that a behaviour has that is built in: files of results have the names alone.
    pub(super) fn check_names_beside(&self, built_in: &Self) -> Result<(), Flaw> {
        for (place, name) in self.names() {
            let Some((theirs, _)) = built_in.names().find(|(_, other)| *other == name) else {
                continue;
            };
            let of = match theirs {
                Place::Phase(_) => format!("a phase of {}", built_in.name),
                Place::Key(_) | Place::Rule(_) => "a behaviour".to_owned(),
            };
            return Err(Flaw { place, problem: Unusable::BuiltIn { found: name.clone(), of } });
        }
        Ok(())
    }
}
