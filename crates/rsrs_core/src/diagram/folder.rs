//! The folder of a sweep: how what is in it is called, and what was swept into it.

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::sweep_file::SweepFile;
use crate::document::{self, DocumentError};
use crate::help::Help;
use crate::robot::profile::RobotProfile;

/// What was swept, with all that was left out.
pub const SWEEP: &str = "sweep.yaml";
/// How often each cell ended in each phase.
pub const CELLS: &str = "cells.csv";
/// Every replicate.
pub const REPLICATES: &str = "replicates.parquet";
/// The cell that was chosen.
pub const CHOICE: &str = "choice.json";
/// The folder of finished blocks, while a sweep is at work.
pub const UNFINISHED: &str = "unfinished";

/// What was swept, as [`SWEEP`] in the folder has it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweptSource {
    /// The sweep, with all that other files had.
    pub sweep: SweepFile,
    /// The measured robot.
    pub profile: RobotProfile,
    /// Which program made it; no part of what was swept.
    #[serde(default)]
    provenance: IgnoredAny,
}

impl SweptSource {
    /// Reads the text of [`SWEEP`], called `file` in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, DocumentError> {
        document::parse(file, text)
    }

    /// A sweep and its profile as YAML; whoever writes the file appends their `provenance`.
    pub fn to_yaml(sweep: &SweepFile, profile: &RobotProfile) -> String {
        #[derive(Serialize)]
        struct Written<'a> {
            sweep: &'a SweepFile,
            profile: &'a RobotProfile,
        }
        document::to_yaml(&Written { sweep, profile })
    }
}

/// A sweep that is at work, or was broken off.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the sweep in {folder} is unfinished")]
pub struct UnfinishedSweep {
    /// Its folder.
    pub folder: String,
    /// What to type to finish it: [`finish`].
    pub finish: String,
}

impl Help for UnfinishedSweep {
    fn help(&self) -> Option<String> {
        let finish = &self.finish;
        Some(format!("finish it with `{finish}`, or put shards together with `rsrs merge`"))
    }
}

/// The command that finishes a sweep, by its file and its folder, both quoted for a shell.
pub fn finish(sweep: &str, folder: &str) -> String {
    format!("rsrs sweep {sweep} -o {folder}")
}
