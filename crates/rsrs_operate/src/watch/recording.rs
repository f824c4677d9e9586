//! A recorded fleet, to be watched again.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use rsrs_bags::trajectory::{Needed, RecordedTrajectory};
use rsrs_bags::{Bag, BagError};
use rsrs_core::judge::trajectory::Bodies;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_files::quoted;
use rsrs_fleet::e_stop::Source;
use rsrs_fleet::observation::{Event, Playback, RecordedSwarm};
use rsrs_fleet::record::ExperimentRecord;
use rsrs_pipeline::attempt::NOT_JUDGED;
use rsrs_pipeline::error::{in_one_line, with_help};
use rsrs_pipeline::recorded_run::{self, BrokenRecording, PosesOfRun};

use super::watched_topic::WatchedTopic;

/// No bag holds who published a message.
const NOBODY: Source = Source([0; 16]);

/// A bag that can be watched.
pub struct RecordedFleet {
    /// From its beginning.
    pub playback: Playback,
    /// What a person should see about it, such as why the judge cannot read it.
    pub notes: Vec<String>,
}

/// Reads a bag to watch it: whole, or as far as it goes.
///
/// Where the judge can read the run, order parameters are those of its trajectory, so that they end
/// with those of `rsrs label`, and poses of topics that are not watched live are shown as well. A
/// bag that has nothing of a robot is refused.
pub fn read(path: &Path) -> anyhow::Result<RecordedFleet> {
    let bag = recorded_run::open_damaged(path)?;
    let record = recorded_run::record_in(&bag)?;
    let mut notes: Vec<String> =
        BrokenRecording::in_bag(&bag).iter().map(ToString::to_string).collect();
    let poses = PosesOfRun::new(&bag, record.as_ref(), None)
        .map_err(|error| notes.push(format!("{NOT_JUDGED}{}", in_one_line(&error))))
        .ok();
    let recorded = poses.and_then(|poses| {
        let behaviour = record.as_ref().map(|it| it.conditions.behaviour).unwrap_or_default();
        let read = poses.read(&bag, record.as_ref(), Needed::Judged(behaviour.window()));
        read.map_err(|error| notes.push(format!("{NOT_JUDGED}{error}"))).ok()
    });

    let mut messages = watched_messages(&bag)?;
    // Robots are shown where they are judged, or else where they would be.
    let judged = recorded.as_ref().map(|recorded| recorded.poses);
    // What a tracker has published is not yet where robots are on the floor.
    let is_raw = record.as_ref().is_some_and(|record| record.tracker.is_some());
    if let Some(shown) = judged.or(poses.and_then(|poses| poses.source)) {
        messages.retain(|(_, event)| match event {
            Event::Pose { source, .. } => *source == shown && !is_raw,
            _ => true,
        });
    }
    let first_ns = messages.iter().map(|(at_ns, _)| *at_ns).min();
    let Some(first_ns) = first_ns.or(recorded.as_ref().map(|recorded| recorded.window.start_ns))
    else {
        return Err(with_help(
            format!("{}: nothing of a robot is in it", path.display()),
            format!("`rsrs bag info {}` lists its topics", quoted(path)),
        ));
    };
    if let Some(recorded) = &recorded {
        let posed = posed_robots(&messages);
        messages.extend(judged_poses(recorded, &posed));
    }
    let since_start = |at_ns: u64| Duration::from_nanos(at_ns.saturating_sub(first_ns));
    let last_ns = messages.iter().map(|(at_ns, _)| *at_ns).max().unwrap_or(first_ns);
    let mut events: Vec<_> =
        messages.into_iter().map(|(at_ns, event)| (since_start(at_ns), event)).collect();
    if let Some(record) = &record {
        events.insert(0, (Duration::ZERO, Event::Experiment(Box::new(record.clone()))));
    }
    if let Some((record, ending)) = record.as_ref().zip(recorded_run::ending_in(&bag)?) {
        events
            .push((since_start(last_ns), Event::Ending { run_id: record.run_id.clone(), ending }));
    }
    let swarm = recorded.map(|recorded| swarm(recorded, record.as_ref(), &since_start));
    Ok(RecordedFleet { playback: Playback::new(events, swarm, since_start(last_ns)), notes })
}

/// What is watched, with its log times in nanoseconds, up to where the recording breaks off.
fn watched_messages(bag: &Bag) -> anyhow::Result<Vec<(u64, Event)>> {
    let topics = bag.topics();
    let is_watched = |name: &str, type_name: &str| WatchedTopic::new(name, type_name).is_some();
    let names: BTreeSet<String> = topics
        .into_iter()
        .filter(|topic| topic.encoding == "cdr" && is_watched(&topic.name, &topic.type_name))
        .map(|topic| topic.name)
        .collect();
    let mut events = Vec::new();
    for message in bag.messages_on(names) {
        let message = match message {
            Err(BagError::Incomplete { .. }) => continue,
            message => message?,
        };
        let Some(watched) = WatchedTopic::new(&message.topic, &message.type_name) else { continue };
        match watched.understand(NOBODY, &message.bytes) {
            Ok(event) => events.push((message.log_time_ns, event)),
            Err(reason) => log::warn!("left out a message on {}: {reason}", message.topic),
        }
    }
    Ok(events)
}

/// Robots of which poses are among the messages.
fn posed_robots(messages: &[(u64, Event)]) -> BTreeSet<String> {
    let posed = messages.iter().filter_map(|(_, event)| match event {
        Event::Pose { robot, .. } => Some(robot.clone()),
        _ => None,
    });
    posed.collect()
}

/// Poses that the judge reads, of robots of which no others are there: of trackers of whole swarms
/// and of transforms.
fn judged_poses(recorded: &RecordedTrajectory, posed: &BTreeSet<String>) -> Vec<(u64, Event)> {
    let trajectory = &recorded.trajectory;
    let start_ns = start_ns(recorded);
    let mut events = Vec::new();
    for sample in 0..trajectory.n_samples() {
        let after = Duration::from_secs_f64(sample as f64 * trajectory.period_s);
        let at_ns = start_ns.saturating_add(u64::try_from(after.as_nanos()).unwrap_or(u64::MAX));
        for (robot, pose) in recorded.robots.iter().zip(trajectory.poses_at(sample)) {
            if !posed.contains(robot) {
                let (robot, source) = (robot.clone(), PoseSource::Pose);
                events.push((at_ns, Event::Pose { robot, source, pose: *pose }));
            }
        }
    }
    events
}

/// The log time of the first sample: poses have the stamps of other clocks at times.
fn start_ns(recorded: &RecordedTrajectory) -> u64 {
    recorded.start_ns.clamp(recorded.window.start_ns, recorded.window.end_ns)
}

fn swarm(
    recorded: RecordedTrajectory,
    record: Option<&ExperimentRecord>,
    since_start: &dyn Fn(u64) -> Duration,
) -> RecordedSwarm {
    RecordedSwarm {
        start: since_start(start_ns(&recorded)),
        bodies: record.map_or(Bodies::UNKNOWN, |record| record.conditions.bodies()),
        behaviour: record.map(|record| record.conditions.behaviour).unwrap_or_default(),
        trajectory: recorded.trajectory,
    }
}
