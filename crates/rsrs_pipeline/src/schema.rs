//! The reference of all files that people write: JSON Schema for editors, Markdown for people.
//!
//! Both follow from the types that read the files, so they are never out of date.

mod reference;

use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::behaviour::file::BehaviourFile;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::world::WorldFile;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::fleet_file::FleetFile;
use serde_json::Value;

use crate::campaign::file::CampaignFile;

pub use reference::reference;

/// A kind of file that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// What a kind of robot can do.
    Profile,
    /// What decides on its commands.
    Controller,
    /// What is in the arena besides robots.
    World,
    /// Which robots there are.
    Fleet,
    /// What is simulated.
    Sweep,
    /// What is run.
    Experiment,
    /// Many experiments.
    Campaign,
    /// What swarms are judged for.
    Behaviour,
}

impl FileKind {
    /// All kinds, in the order in which one writes them.
    pub const ALL: [Self; 8] = [
        Self::Profile,
        Self::Controller,
        Self::World,
        Self::Fleet,
        Self::Sweep,
        Self::Experiment,
        Self::Campaign,
        Self::Behaviour,
    ];

    /// The name on the command line: `profile`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Profile => "profile",
            Self::Controller => "controller",
            Self::World => "world",
            Self::Fleet => "fleet",
            Self::Sweep => "sweep",
            Self::Experiment => "experiment",
            Self::Campaign => "campaign",
            Self::Behaviour => "behaviour",
        }
    }

    /// The kind with this name.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.key() == key)
    }

    /// What may stand in such a file, as JSON Schema (draft 2020-12), which holds for YAML as well.
    pub fn schema(self) -> Value {
        match self {
            Self::Profile => schemars::schema_for!(RobotProfile),
            Self::Controller => schemars::schema_for!(ControllerTable),
            Self::World => schemars::schema_for!(WorldFile),
            Self::Fleet => schemars::schema_for!(FleetFile),
            Self::Sweep => schemars::schema_for!(SweepFile),
            Self::Experiment => schemars::schema_for!(ExperimentFile),
            Self::Campaign => schemars::schema_for!(CampaignFile),
            Self::Behaviour => schemars::schema_for!(BehaviourFile),
        }
        .into()
    }
}
