//! What poses and commands of a run show that cannot be, and starts that are not those of its record.

use rsrs_bags::trajectory::{Finding, RecordedTrajectory};
use rsrs_core::judge::plausibility::{self, Implausibility, Known, STOOD_S, Unseen};
use rsrs_core::judge::trajectory::Bodies;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::placement::{Tolerance, WantedStart, deviations_beyond, deviations_of_objects};
use rsrs_fleet::record::{Backend, ExperimentRecord, LostRobot};
use rsrs_sim::draw::Seed;
use rsrs_sim::failures;
use serde::Serialize;

/// What some robots show that cannot be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImplausibleMotion {
    /// What it is, with its numbers.
    #[serde(flatten)]
    pub cause: Implausibility,
    /// Names of the robots.
    pub robots: Vec<String>,
    /// In words.
    pub text: String,
}

/// Holds the poses of a run against its commands. Of robots that were lost, and did not take part
/// to the end, nothing is asked.
pub fn find(
    recorded: &RecordedTrajectory,
    bodies: &Bodies,
    record: Option<&ExperimentRecord>,
    lost: &[LostRobot],
) -> Vec<ImplausibleMotion> {
    let RecordedTrajectory { trajectory, robots, .. } = recorded;
    let stand = record.map(standing).unwrap_or_default();
    let is_lost = |row: &usize| {
        lost.iter().any(|lost| lost.robot == robots[*row]) || stand.contains(&&robots[*row])
    };
    let left_out: Vec<usize> = (0..robots.len()).filter(is_lost).collect();
    let walls_m = record.and_then(|record| record.conditions.arena.walls_m());
    let unseen = |finding: &Finding| match finding {
        Finding::Gap { robot, from_s, to_s, .. } => {
            let row = robots.iter().position(|name| name == robot)?;
            Some(Unseen { row, from_s: *from_s, to_s: *to_s })
        }
        _ => None,
    };
    let unseen: Vec<Unseen> = recorded.findings.iter().filter_map(unseen).collect();
    let known = Known { bodies: bodies.clone(), walls_m, left_out: &left_out, unseen: &unseen };
    let found = plausibility::implausible(trajectory, &known, STOOD_S);
    let named = |found: plausibility::Implausible| ImplausibleMotion {
        cause: found.cause,
        text: found.in_words(robots),
        robots: found.robots.iter().map(|row| robots[*row].clone()).collect(),
    };
    found.into_iter().map(named).collect()
}

/// Robots that the record has stand still from a time on.
fn standing(record: &ExperimentRecord) -> Vec<&String> {
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let standing = failures::standing(&record.conditions, seed).into_iter();
    standing.filter_map(|robot| record.robots.get(robot)).collect()
}

/// Robots and objects whose first poses are not where the record places them, in words.
///
/// A simulator has placed its robots itself. Where the first poses of a robot are missing, all of them had
/// moved before they are known, and nothing is asked.
pub fn misplaced(recorded: &RecordedTrajectory, record: &ExperimentRecord) -> Vec<String> {
    let is_late = |finding: &Finding| matches!(finding, Finding::LateStart { .. });
    if record.backend == Backend::Simulator || recorded.findings.iter().any(is_late) {
        return Vec::new();
    }
    let wanted = WantedStart::new(&record.conditions, record.replicate);
    let first = recorded.trajectory.poses_at(0);
    let placed = |(name, pose): (&String, &Pose)| {
        let number = record.robots.iter().position(|robot| robot == name)?;
        Some((number, name.clone(), *pose))
    };
    let placed: Vec<_> = recorded.robots.iter().zip(first).filter_map(placed).collect();
    let robots = deviations_beyond(Tolerance::RECORDED, &wanted, &placed);
    let world = &record.conditions.world;
    // Where one is missing, nobody knows which of them the others are.
    let objects_m = if recorded.trajectory.n_objects == world.n_objects() {
        recorded.trajectory.objects_at(0)
    } else {
        &[]
    };
    let objects = deviations_of_objects(Tolerance::RECORDED, world, objects_m);
    robots.iter().chain(&objects).map(ToString::to_string).collect()
}
