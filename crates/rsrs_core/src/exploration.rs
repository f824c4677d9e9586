//! A search for controllers: what it follows from, as its folder has it.

use serde::{Deserialize, Serialize};

use crate::conditions::Walls;
use crate::conditions::controller_table::ControllerTable;
use crate::conditions::start_file::StartPlacement;
use crate::document::{self, DocumentError};
use crate::judge::behaviour::Behaviour;
use crate::world::WorldFile;

/// Everything but the robot that a search follows from: two searches with these are one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplorationSettings {
    /// The behaviour that is searched for; not there for all that differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub behaviour: Option<Behaviour>,
    /// The table whose numbers are searched; not there for two commands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerTable>,
    /// What is in the arena besides the robots; not there where nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub world: Option<WorldFile>,
    /// Number of robots.
    pub robots: usize,
    /// Side of the arena, in metres.
    pub arena_m: f64,
    /// What happens at its border.
    pub walls: Walls,
    /// Where robots start, by the table in the folder; not there for anywhere in a disc.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<StartPlacement>,
    /// Radius of the disc in which robots start, in metres.
    pub placement_radius_m: f64,
    /// Whether robots may drive backward.
    pub backward: bool,
    /// Runs of each controller.
    pub replicates: u64,
    /// Simulated time of each run, in seconds.
    pub duration_s: f64,
    /// Seed of the search and of its runs.
    pub seed: u64,
}

impl ExplorationSettings {
    /// Reads what [`to_yaml`](Self::to_yaml) wrote, called `file` in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, DocumentError> {
        document::parse(file, text)
    }

    /// Them as a YAML document.
    pub fn to_yaml(&self) -> String {
        document::to_yaml(self)
    }
}
