//! A behaviour as a file that people write.

use serde::{Deserialize, Serialize};

use super::bounds::ParameterBounds;
use crate::judge::window::Window;

/// What swarms are judged for: phases, and the rules that tell them apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RuleEntry {
    /// Key of the phase.
    pub phase: String,
    /// Bounds on [order parameters](#order-parameters), all of which must hold: `{lost: {at_most: 0.1}, rotation: {at_least: 0.5}}`, or `below`; `{at_least: 0.2, below: 0.5}` is between.
    pub when: ParameterBounds,
}

impl BehaviourFile {
    /// The keys that every file has.
    pub(super) const REQUIRED: [&str; 5] = ["name", "words", "phases", "rules", "otherwise"];
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

pub(super) fn rgb(colour: &str) -> Option<[u8; 3]> {
    let digits = colour.strip_prefix('#').filter(|it| it.len() == 6 && it.is_ascii())?;
    let channel = |at: usize| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).ok();
    Some([channel(0)?, channel(1)?, channel(2)?])
}
