//! The record of a run, which tests change where they need another one.

use std::collections::BTreeMap;

use rsrs_core::conditions::Conditions;
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::record::{Backend, ExperimentRecord, RecordProvenance};

/// A run of 300 s of a fleet in real time, of whose robots only the digest of the profile is known.
pub fn fleet_record(profile_digest: &str, conditions: Conditions) -> ExperimentRecord {
    ExperimentRecord {
        run_id: "run".to_owned(),
        robots: (1..=conditions.robots).map(|robot| format!("robot_{robot}")).collect(),
        provenance: RecordProvenance::new(profile_digest, &conditions),
        conditions,
        duration_s: 300.0,
        seed: 1,
        replicate: 0,
        robot_lost: RobotLost::Abort,
        backend: Backend::Fleet,
        controller_only: Vec::new(),
        gates: BTreeMap::new(),
        own_profiles: BTreeMap::new(),
        fixed: None,
        pose_source: None,
        tracker: None,
        time: Time::RealTime,
    }
}
