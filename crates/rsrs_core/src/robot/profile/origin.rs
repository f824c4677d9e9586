//! Whether a profile rests on trials of robots or on those of a simulator.

use serde::{Deserialize, Serialize};

/// How far trials are those of a simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrialOrigin {
    /// All of them.
    Simulated,
    /// Some of them.
    PartlySimulated,
}

impl TrialOrigin {
    /// Whose trials they are, for a sentence: `trials of …`.
    pub fn whose(self) -> &'static str {
        match self {
            Self::Simulated => "the simulator",
            Self::PartlySimulated => "the simulator and of robots",
        }
    }
}
