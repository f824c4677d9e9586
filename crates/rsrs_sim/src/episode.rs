//! One run of a swarm under its controller, from the start to the end.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::Readings;

use crate::controllers::Controllers;
use crate::draw::Seed;
use crate::placement::PlacementError;
use crate::world::World;

/// Runs one episode of `floor(duration / Δt)` steps and records it.
///
/// Sample `ℓ` is the pose that was sensed in step `ℓ` and the command that answered it. A longer
/// run passes through the states of a shorter one.
pub fn run_episode(
    conditions: &Conditions,
    seed: Seed,
    duration_s: f64,
) -> Result<Trajectory, PlacementError> {
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    run_episode_into(conditions, seed, duration_s, &mut trajectory)?;
    Ok(trajectory)
}

/// As [`run_episode`], into a trajectory whose memory is used again. It stays as it was if the
/// robots do not fit where they are to start.
pub fn run_episode_into(
    conditions: &Conditions,
    seed: Seed,
    duration_s: f64,
    trajectory: &mut Trajectory,
) -> Result<(), PlacementError> {
    let mut world = World::new(conditions, seed)?;
    let mut controllers = Controllers::new(conditions, seed);
    trajectory.period_s = conditions.period_s;
    trajectory.n_robots = conditions.robots;
    trajectory.n_objects = conditions.world.n_objects();
    trajectory.poses.clear();
    trajectory.commands.clear();
    trajectory.objects_m.clear();
    let mut commands = Vec::with_capacity(conditions.robots);
    for _ in 0..conditions.steps(duration_s) {
        commands.clear();
        controllers.decide(world.sense_all(), &mut commands);
        trajectory.poses.extend(world.poses());
        trajectory.objects_m.extend(world.objects_m());
        trajectory.commands.extend_from_slice(&commands);
        world.advance(&commands);
    }
    Ok(())
}

/// A run with what its robots detected.
#[derive(Clone, Debug, PartialEq)]
pub struct Observed {
    /// Poses and commands.
    pub trajectory: Trajectory,
    /// Whether a robot detected something, of several sensors with the first, in the order of the poses; shape
    /// `[n_samples * n_robots]`.
    pub detections: Vec<bool>,
}

/// Runs one episode under any controller: it is given what all robots report, shape `[n_robots]`, and appends their
/// commands, as many.
///
/// Of `duration_s`, in seconds, `floor(duration / Δt)` steps are made, `world` being a new one of the conditions.
/// With [`Controllers::decide`] as the controller this is [`run_episode`]. An error of the controller ends the run.
pub fn run_controlled<E>(
    mut world: World,
    conditions: &Conditions,
    duration_s: f64,
    mut controller: impl FnMut(&[Readings], &mut Vec<Command>) -> Result<(), E>,
) -> Result<Observed, E> {
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    trajectory.n_objects = conditions.world.n_objects();
    let (mut detections, mut commands) = (Vec::new(), Vec::with_capacity(conditions.robots));
    for _ in 0..conditions.steps(duration_s) {
        let readings = world.sense_all();
        commands.clear();
        controller(readings, &mut commands)?;
        detections.extend(readings.iter().map(|readings| readings.detection()));
        trajectory.poses.extend(world.poses());
        trajectory.objects_m.extend(world.objects_m());
        trajectory.commands.extend_from_slice(&commands);
        world.advance(&commands);
    }
    Ok(Observed { trajectory, detections })
}

/// The digests of all states of one episode, each before its step is made: [`World::digest`] of the
/// states that the samples of [`run_episode`] show. Shape `[n_steps]`.
pub fn episode_digests(
    conditions: &Conditions,
    seed: Seed,
    duration_s: f64,
) -> Result<Vec<u64>, PlacementError> {
    let mut world = World::new(conditions, seed)?;
    let mut controllers = Controllers::new(conditions, seed);
    let mut commands = Vec::with_capacity(conditions.robots);
    let steps = 0..conditions.steps(duration_s);
    Ok(steps
        .map(|_| {
            let digest = world.digest();
            commands.clear();
            controllers.decide(world.sense_all(), &mut commands);
            world.advance(&commands);
            digest
        })
        .collect())
}
