//! What a search follows from, as it is written down.

use rsrs_core::conditions::Walls;
use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::conditions::start_file::StartPlacement;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::world::WorldFile;
use serde::{Deserialize, Serialize};

use super::ExploreOptions;
use super::file_names::STARTS;
use super::trial::TestBed;

/// Everything but the robot that a search follows from: two searches with these are one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
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

impl Settings {
    /// Those of a search. How many controllers are tried is none of them: a longer search begins with a
    /// shorter one.
    pub fn new(options: &ExploreOptions, test_bed: &TestBed) -> Self {
        use rsrs_sim::exploration::space::Directions;
        Self {
            behaviour: options.wanted,
            controller: options.controller.cloned(),
            world: options.world.cloned(),
            robots: options.robots,
            arena_m: test_bed.arena_m,
            walls: options.walls,
            placement: options.starts.map(|_| in_folder(STARTS.to_owned())),
            placement_radius_m: test_bed.placement_m,
            backward: options.directions == Directions::Both,
            replicates: options.replicates,
            duration_s: options.duration_s,
            seed: options.seed,
        }
    }
}

/// Start poses by a table that has headings.
pub fn in_folder(path: String) -> StartPlacement {
    StartPlacement::File { path, headings: None }
}
