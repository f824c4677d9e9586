//! Where a result comes from: enough to make it again.

use rsrs_core::program;
use rsrs_core::robot::profile::RobotProfile;
use serde::{Deserialize, Serialize};

/// Version of the shapes of files that this program writes.
pub const SCHEMA_VERSION: u32 = 1;

/// Where a result comes from. The seed stands in the sweep itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResultProvenance {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// Digest of the measured profile.
    pub profile_digest: String,
    /// Version of the file shapes.
    pub schema_version: u32,
}

impl ResultProvenance {
    /// The provenance of what this program makes from a profile.
    pub fn new(profile: &RobotProfile) -> Self {
        Self {
            version: program::VERSION.to_owned(),
            commit: program::commit().to_owned(),
            profile_digest: profile.digest(),
            schema_version: SCHEMA_VERSION,
        }
    }
}
