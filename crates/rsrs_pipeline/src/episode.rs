//! A simulated run as a bag: the topics, times and texts of a run in lockstep, without the network.

pub mod recorder;
pub mod replicate;

use std::path::Path;

use rsrs_bags::{BagError, BagSummary, ChannelId};
use rsrs_core::conditions::Conditions;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::record::ExperimentRecord;
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{LeaseState, WorldDigest};
use rsrs_msgs::topics;
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;

use recorder::{Recorder, RobotStep};
use rsrs_core::help::Help;

/// Why there is no bag of a simulated run.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The bag cannot be written.
    #[error(transparent)]
    Bag(#[from] BagError),
}

impl Help for EpisodeError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Placement(error) => error.help(),
            Self::Bag(error) => error.help(),
        }
    }
}

/// Simulates the run that a record describes, with its seed and replicate, and writes it as a bag
/// into a folder that must not exist; the trajectory that is returned is the run as it was in
/// memory.
///
/// The bag has what a recorded run in lockstep has: of every robot detection, odometry and command,
/// of every object its pose, the clock, the world's digest, the lease from RUNNING to STOPPED, the
/// record and how the run ended. What only a network has is not there: statuses, parameters, logs.
pub fn write(
    folder: &Path,
    record: &ExperimentRecord,
) -> Result<(BagSummary, Trajectory), EpisodeError> {
    let conditions = &record.conditions;
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let mut world = World::new(conditions, seed)?;
    let mut controllers = Controllers::new(conditions, seed);
    let mut recorder = Lockstep::open(folder, record)?;
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    trajectory.n_objects = conditions.world.n_objects();
    let mut obeyed = vec![Command::STOP; conditions.robots];
    recorder.lease(0, LeaseState::Running)?;
    let steps = conditions.steps(record.duration_s);
    for step in 1..=steps {
        let digest = world.digest();
        let readings = world.sense_all().to_vec();
        let poses: Vec<Pose> = world.poses().collect();
        let objects_m: Vec<[f64; 2]> = world.objects_m().collect();
        let mut commands = Vec::with_capacity(conditions.robots);
        controllers.decide(&readings, &mut commands);
        let moment = Moment {
            poses: &poses,
            objects_m: &objects_m,
            readings: &readings,
            obeyed: &obeyed,
            digest,
        };
        recorder.step(step, &moment, &commands)?;
        world.advance(&commands);
        trajectory.poses.extend(poses);
        trajectory.objects_m.extend(objects_m);
        trajectory.commands.extend_from_slice(&commands);
        obeyed = commands;
    }
    recorder.lease(steps, LeaseState::Stopped)?;
    Ok((recorder.recorder.close()?, trajectory))
}

/// What the simulator shows of one step.
struct Moment<'a> {
    /// Where the robots are; shape `[n_robots]`.
    poses: &'a [Pose],
    /// Where objects are, in metres; shape `[n_objects][2]`.
    objects_m: &'a [[f64; 2]],
    /// What they see; shape `[n_robots]`.
    readings: &'a [Readings],
    /// The commands that brought them here; shape `[n_robots]`.
    obeyed: &'a [Command],
    /// The fingerprint of the world.
    digest: u64,
}

/// A bag of a run in lockstep that is being written.
struct Lockstep<'a> {
    recorder: Recorder<'a>,
    period_ns: u64,
    clock: ChannelId,
    digest: ChannelId,
}

impl<'a> Lockstep<'a> {
    fn open(folder: &Path, record: &'a ExperimentRecord) -> Result<Self, BagError> {
        let (recorder, [clock, digest]) =
            Recorder::open(folder, record, [topics::CLOCK, topics::WORLD_DIGEST])?;
        Ok(Self { recorder, period_ns: period_ns(&record.conditions), clock, digest })
    }

    /// Writes one step in the order in which the simulator publishes it: the clock first.
    fn step(&mut self, step: u64, moment: &Moment, commands: &[Command]) -> Result<(), BagError> {
        let time_ns = step * self.period_ns;
        let Self { recorder, .. } = self;
        recorder.put(self.clock, time_ns, &Clock { clock: Stamp::from_nanos(time_ns) })?;
        let thoughts: Vec<RobotStep> = (0..commands.len())
            .map(|robot| RobotStep {
                robot,
                time_ns,
                pose: moment.poses[robot],
                obeyed: moment.obeyed[robot],
                readings: moment.readings[robot],
                command: commands[robot],
            })
            .collect();
        for step in &thoughts {
            recorder.detection(step)?;
        }
        for step in &thoughts {
            recorder.odometry(step)?;
        }
        for (object, place_m) in moment.objects_m.iter().enumerate() {
            recorder.object(object, time_ns, *place_m)?;
        }
        recorder.put(self.digest, time_ns, &WorldDigest { step, digest: moment.digest })?;
        for step in &thoughts {
            recorder.command(step)?;
        }
        Ok(())
    }

    fn lease(&mut self, step: u64, state: LeaseState) -> Result<(), BagError> {
        self.recorder.lease(step * self.period_ns, state)
    }
}

/// The period as a whole number of nanoseconds, as the simulator stamps it.
fn period_ns(conditions: &Conditions) -> u64 {
    u64::try_from(std::time::Duration::from_secs_f64(conditions.period_s).as_nanos())
        .expect("conditions allow at most 60 s")
}
