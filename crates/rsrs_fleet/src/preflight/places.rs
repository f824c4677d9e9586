//! Whether poses can be those of robots on one floor.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::tf2_msgs::MAX_CHAIN;

use super::{Apart, Problem, Seen};

/// Frame and pose by robot.
type Poses<'a> = BTreeMap<&'a String, &'a (String, Pose)>;

/// Poses that cannot be used, two robots on one spot, and frames that nothing ties together: the last
/// two are what odometry looks like that starts at 0, 0 on each robot.
pub(super) fn problems(apart: &Apart, seen: &Seen) -> Vec<Problem> {
    let poses: Poses<'_> =
        seen.poses.iter().filter(|(robot, _)| apart.robots.contains(*robot)).collect();
    let radius_m = apart.radius_m;
    let mut problems = unusable_poses(apart, &seen.unusable_poses);
    problems.extend(different_frames(&poses, seen));
    let mut on_one_spot = BTreeSet::new();
    for (robot, (frame, pose)) in &poses {
        for (other, (other_frame, place)) in poses.range::<&String, _>(*robot..).skip(1) {
            let apart_m = libm::hypot(pose.x_m - place.x_m, pose.y_m - place.y_m);
            // Bodies that touch are two radii apart; a tracker is nowhere near as wrong as one.
            if frame == other_frame && apart_m < radius_m {
                on_one_spot.extend([(*robot).clone(), (*other).clone()]);
            }
        }
    }
    if !on_one_spot.is_empty() {
        problems.push(Problem::OneSpot { robots: on_one_spot.into_iter().collect(), radius_m });
    }
    problems
}

/// Robots of `apart` whose last pose cannot be used, with the reasons of each; others need no poses.
pub(crate) fn unusable_poses(apart: &Apart, reasons: &BTreeMap<String, String>) -> Vec<Problem> {
    let needed = reasons.iter().filter(|(robot, _)| apart.robots.contains(*robot));
    let problem = |(robot, reason): (&String, &String)| Problem::PoseUnusable {
        robot: robot.clone(),
        reason: reason.clone(),
    };
    needed.map(problem).collect()
}

/// Frames that do not lead up to one.
fn different_frames(poses: &Poses<'_>, seen: &Seen) -> Option<Problem> {
    let frames: BTreeMap<&str, &String> =
        poses.iter().map(|(robot, (frame, _))| (plain(frame), *robot)).collect();
    let roots: BTreeSet<&str> = frames.keys().map(|frame| root(frame, seen)).collect();
    (roots.len() > 1).then(|| Problem::Frames {
        frames: frames
            .into_iter()
            .map(|(frame, robot)| (robot.clone(), frame.to_owned()))
            .collect(),
    })
}

/// The frame at the upper end of the chain.
fn root<'a>(frame: &'a str, seen: &'a Seen) -> &'a str {
    let mut frame = frame;
    for _ in 0..MAX_CHAIN {
        match seen.parents.get(frame) {
            Some(parent) => frame = plain(parent),
            None => break,
        }
    }
    frame
}

/// As tf2 compares them.
fn plain(frame: &str) -> &str {
    frame.trim_start_matches('/')
}
