//! Many experiments, one after the other, each in a folder that contains all of it.

pub mod file;
mod folder;
mod manifest;
mod summary;

use rsrs_core::robot::other_profile::ProfilesDiffer;
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::ExperimentRecord;

pub use file::Experiment;
pub use folder::{BAG, CampaignFolder, Finished, attempts_in};
pub use manifest::Manifest;
pub use summary::{Replaced, Row, Summary};

/// An experiment of a campaign with what it is, whenever it is run.
pub struct Item {
    /// As the campaign file has it.
    pub experiment: Experiment,
    /// All that it takes to run it, with the robots that the fleet file has now.
    pub record: ExperimentRecord,
    /// That the sweep of its cell is of robots with another profile, on which somebody insists.
    pub other_profile: Option<ProfilesDiffer>,
    /// What is done about robots that do not stand where they should start.
    pub place_check: PlaceCheck,
}

/// Whether two records are of the same experiment.
///
/// The names of robots are no part of it: one that breaks is replaced by another of the same profile. Nor
/// is the program, or what a later version of it records besides.
pub fn is_same(one: &ExperimentRecord, other: &ExperimentRecord) -> bool {
    let setup = |record: &ExperimentRecord| {
        let ExperimentRecord { seed, replicate, robot_lost, backend, time, .. } = record;
        (*seed, *replicate, *robot_lost, *backend, *time)
    };
    setup(one) == setup(other)
        && one.robots.len() == other.robots.len()
        && one.conditions == other.conditions
        && one.duration_s.to_bits() == other.duration_s.to_bits()
        && one.provenance.profile_digest == other.provenance.profile_digest
        && one.fixed == other.fixed
}
