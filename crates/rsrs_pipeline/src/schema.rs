//! The kinds of files that people write, as JSON Schema.
//!
//! It follows from the types that read the files, so it is never out of date.

use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::judge::behaviour::file::BehaviourFile;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::world::WorldFile;
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::fleet_file::FleetFile;
use schemars::{Schema, schema_for};
use serde_json::Value;

use crate::campaign::file::CampaignFile;

/// A kind of file that people write.
#[derive(Clone, Copy, Debug)]
pub struct FileKind {
    /// The name on the command line: `profile`.
    pub key: &'static str,
    schema: fn() -> Schema,
}

impl FileKind {
    /// All kinds, in the order in which one writes them.
    pub const ALL: [Self; 8] = [
        Self { key: "profile", schema: || schema_for!(RobotProfile) },
        Self { key: "controller", schema: || schema_for!(ControllerTable) },
        Self { key: "world", schema: || schema_for!(WorldFile) },
        Self { key: "fleet", schema: || schema_for!(FleetFile) },
        Self { key: "sweep", schema: || schema_for!(SweepFile) },
        Self { key: "experiment", schema: || schema_for!(ExperimentFile) },
        Self { key: "campaign", schema: || schema_for!(CampaignFile) },
        Self { key: "behaviour", schema: || schema_for!(BehaviourFile) },
    ];

    /// The kind with this name.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.key == key)
    }

    /// What may stand in such a file, as JSON Schema (draft 2020-12), which holds for YAML as well.
    pub fn schema(self) -> Value {
        (self.schema)().into()
    }
}
