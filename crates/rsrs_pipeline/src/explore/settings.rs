//! What a search follows from, by its options.

use rsrs_core::conditions::start_file::StartPlacement;
use rsrs_core::exploration::ExplorationSettings;
use rsrs_sim::exploration::space::Directions;

use super::ExploreOptions;
use super::file_names::STARTS;
use super::trial::TestBed;

/// What a search with these options follows from. How many controllers are tried is no part of it: a longer
/// search begins with a shorter one.
pub fn settings(options: &ExploreOptions, test_bed: &TestBed) -> ExplorationSettings {
    ExplorationSettings {
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

/// Start poses by a table that has headings.
pub fn in_folder(path: String) -> StartPlacement {
    StartPlacement::File { path, headings: None }
}
