//! Where the poses of a recorded run come from, and by what that is known.

use rsrs_bags::Bag;
use rsrs_bags::trajectory::{
    Needed, RecordedTracker, RecordedTrajectory, TrajectoryError, TrajectoryOptions,
    read_trajectory,
};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::fleet_file::{FleetFile, FleetRobot};
use rsrs_fleet::record::{Backend, ExperimentRecord, pose_source};
use serde::Serialize;

use crate::error::with_help;

/// By what the source of a run's poses is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PosesBy {
    /// Who asks has named it.
    Request,
    /// The record of the run.
    Record,
    /// The fleet file that is in the bag, as the record states none.
    FleetFile,
    /// Nothing in the bag states it: it is the first source that has poses of all robots.
    Guess,
}

/// Where the poses of a run come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PosesOfRun {
    /// The source; `None` if it is for the reader of trajectories to choose.
    pub source: Option<PoseSource>,
    /// By what that is known.
    pub by: PosesBy,
}

impl PosesOfRun {
    /// The source that was asked for, else that of the record, else that which the fleet file in
    /// the bag has for the robots of the record (an error if they have different ones), else
    /// whatever the bag has.
    pub fn new(
        bag: &Bag,
        record: Option<&ExperimentRecord>,
        asked: Option<PoseSource>,
    ) -> anyhow::Result<Self> {
        let known = |source, by| Self { source: Some(source), by };
        let guess = Self { source: None, by: PosesBy::Guess };
        if let Some(source) = asked {
            return Ok(known(source, PosesBy::Request));
        }
        let Some(record) = record else { return Ok(guess) };
        if let Some(source) = record.pose_source {
            return Ok(known(source, PosesBy::Record));
        }
        if record.backend == Backend::Simulator {
            return Ok(known(PoseSource::Odom, PosesBy::Record));
        }
        let Some(robots) = robots_in_fleet_file(bag, record) else { return Ok(guess) };
        match pose_source(record.backend, &robots) {
            Ok(source) => Ok(known(source, PosesBy::FleetFile)),
            Err(error) => {
                let name = bag.path().display();
                Err(with_help(
                    format!(
                        "{name}: its record states no source of poses, and by its {} {error}",
                        FleetFile::NAME
                    ),
                    "name the one that has poses of all robots in one frame: `--poses`",
                ))
            }
        }
    }

    /// Reads the trajectory of the run.
    ///
    /// A run may have been admitted because its frames are tied together on `/tf`, though poses of each
    /// robot are in a frame of its own: then these transforms are its poses.
    pub fn read(
        self,
        bag: &Bag,
        record: Option<&ExperimentRecord>,
        needed: Needed,
    ) -> Result<RecordedTrajectory, TrajectoryError> {
        let read = |poses| {
            let run_id = record.map(|record| record.run_id.clone());
            let tracker = record.and_then(|record| tracker_of(record, poses));
            read_trajectory(bag, &TrajectoryOptions { poses, run_id, needed, tracker })
        };
        let error = match read(self.source) {
            Err(error @ TrajectoryError::Frames { .. }) => error,
            done => return done,
        };
        let is_stated = matches!(self.by, PosesBy::Record | PosesBy::FleetFile);
        let is_of_each = self.source.is_some_and(PoseSource::is_of_each_robot);
        if is_stated && is_of_each {
            return read(Some(PoseSource::Tf)).map_err(|_not_tied| error);
        }
        Err(error)
    }
}

/// The tracker that the record describes, if these are its poses.
fn tracker_of(record: &ExperimentRecord, poses: Option<PoseSource>) -> Option<RecordedTracker> {
    let tracker = record.tracker.clone().filter(|_| poses == record.pose_source)?;
    Some(RecordedTracker {
        tracker,
        robots: record.robots.clone(),
        radius_m: record.conditions.smallest_radius_m(),
    })
}

/// The robots of a record, as the fleet file in the bag has them; `None` if it is not there, does not
/// read, or lacks one of them.
fn robots_in_fleet_file(bag: &Bag, record: &ExperimentRecord) -> Option<Vec<FleetRobot>> {
    let attachment = bag.attachment(FleetFile::NAME)?;
    let text = std::str::from_utf8(&attachment.data).ok()?;
    let unreadable = |error| {
        log::warn!("{}: its {} does not read: {error}", bag.path().display(), FleetFile::NAME);
    };
    let fleet = FleetFile::parse(FleetFile::NAME, text).map_err(unreadable).ok()?;
    let of_fleet = |name: &String| fleet.robots.iter().find(|robot| robot.name == *name).cloned();
    record.robots.iter().map(of_fleet).collect()
}
