//! The behaviours that this program knows by now: those that are built in, and those that it has read.
//!
//! What was read stays until the end, so that phases are small values with names of their own.

use std::sync::{LazyLock, PoisonError, RwLock};

use super::Behaviour;
use super::check::Flaw;
use super::file::{BehaviourFile, PhaseEntry, RuleEntry};
use super::phase::Phase;
use super::rule::{Rule, Rules};

/// A behaviour with what follows from its file.
pub struct Known {
    pub file: BehaviourFile,
    pub phases: Vec<Phase>,
    pub titles: Vec<String>,
    pub rules: Rules,
}

/// As JSON, which is YAML, too: a browser's simulator does without a reader of YAML.
///
/// Aggregation is that of M. Gauci, J. Chen, W. Li, T. J. Dodd and R. Groß, "Self-organized aggregation
/// without computation", IJRR 33(8), 2014. Stable and semi-stable milling are a continuum in circliness, and where
/// it is cut is a convention.
const BUILT_IN: [&str; 3] = [
    include_str!("../../../behaviours/milling.json"),
    include_str!("../../../behaviours/aggregation.json"),
    include_str!("../../../behaviours/dispersal.json"),
];

static KNOWN: LazyLock<RwLock<Vec<&'static Known>>> = LazyLock::new(|| {
    let known = Behaviour::BUILT_IN.into_iter().zip(BUILT_IN).map(|(handle, text)| {
        leaked(handle, serde_json::from_str(text).expect("what is built in is well formed"))
    });
    RwLock::new(known.collect())
});

fn leaked(handle: Behaviour, file: BehaviourFile) -> &'static Known {
    let phases = (0..file.phases.len()).map(|place| Phase::new(handle, place)).collect();
    let titles = file.phases.iter().map(PhaseEntry::title).collect();
    let rules = file.rules(handle);
    Box::leak(Box::new(Known { file, phases, titles, rules }))
}

impl BehaviourFile {
    /// Its rules, with phases of this handle.
    fn rules(&self, behaviour: Behaviour) -> Rules {
        let place = |key: &str| {
            let place = self.phases.iter().position(|phase| phase.key == key);
            Phase::new(behaviour, place.expect("the file was checked"))
        };
        let rule = |rule: &RuleEntry| {
            let conditions = rule.when.conditions().to_vec();
            Rule { phase: place(&rule.phase), conditions }
        };
        Rules {
            rules: self.rules.iter().map(rule).collect(),
            otherwise: place(&self.otherwise),
            wanted: Phase::new(behaviour, 0),
            not_lasting: place(self.not_lasting.as_ref().unwrap_or(&self.otherwise)),
            window: self.window,
            also: Vec::new(),
        }
    }
}

pub fn get(behaviour: Behaviour) -> &'static Known {
    KNOWN.read().unwrap_or_else(PoisonError::into_inner)[usize::from(behaviour.0)]
}

/// In the order in which they were read.
pub fn all() -> impl DoubleEndedIterator<Item = Behaviour> {
    let n = KNOWN.read().unwrap_or_else(PoisonError::into_inner).len();
    (0..n).map(handle)
}

pub fn add(file: BehaviourFile) -> Result<Behaviour, Flaw> {
    file.check()?;
    let mut known = KNOWN.write().unwrap_or_else(PoisonError::into_inner);
    if let Some(same) = known.iter().position(|known| known.file == file) {
        return Ok(handle(same));
    }
    for built_in in &known[..BUILT_IN.len()] {
        file.check_names_beside(&built_in.file)?;
    }
    let new = handle(known.len());
    known.push(leaked(new, file));
    Ok(new)
}

fn handle(at: usize) -> Behaviour {
    Behaviour(u16::try_from(at).expect("no program reads 65,536 different behaviours"))
}
