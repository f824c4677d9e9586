//! Whether robots can start where a table puts them.

use super::Conditions;
use crate::quantity::Bounds;
use crate::robot::unicycle::Pose;
use crate::world::ROUNDING;

/// Why robots cannot start where a table puts them; robots and replicates are numbered as people do,
/// robots from 1 and replicates from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StartsError {
    /// There is no set of poses.
    #[error("no start poses, expected a set of them")]
    None,
    /// A set has places for more or fewer robots than there are.
    #[error(
        "replicate {replicate} has {found} start poses, expected {expected}, one for each robot"
    )]
    Robots {
        /// Number of the set, from 0.
        replicate: usize,
        /// Poses in it.
        found: usize,
        /// Robots.
        expected: usize,
    },
    /// A coordinate or heading is not a finite number of a sensible size.
    #[error(
        "replicate {replicate}: robot {robot} starts at ({x_m}, {y_m}) m, heading {heading_rad} rad"
    )]
    Number {
        /// Number of the set, from 0.
        replicate: usize,
        /// Number of the robot, from 1.
        robot: usize,
        /// In metres.
        x_m: f64,
        /// In metres.
        y_m: f64,
        /// In radians.
        heading_rad: f64,
    },
    /// Two bodies overlap.
    #[error(
        "replicate {replicate}: robots {} and {} start {found_m:.3} m apart, expected {least_m:.3} m \
         or more: their bodies overlap",
        robots[0], robots[1]
    )]
    Overlap {
        /// Number of the set, from 0.
        replicate: usize,
        /// Numbers of the two, from 1.
        robots: [usize; 2],
        /// Distance of their centres, in metres.
        found_m: f64,
        /// Twice the radius, in metres.
        least_m: f64,
    },
    /// A body is not within the walls.
    #[error(
        "replicate {replicate}: robot {robot} starts at ({x_m}, {y_m}) m, which is not within the walls \
         of {arena}"
    )]
    Outside {
        /// Number of the set, from 0.
        replicate: usize,
        /// Number of the robot, from 1.
        robot: usize,
        /// In metres.
        x_m: f64,
        /// In metres.
        y_m: f64,
        /// The arena, in words.
        arena: String,
    },
}

/// Checks every set of start poses.
pub(super) fn check(starts: &[Vec<Pose>], conditions: &Conditions) -> Result<(), StartsError> {
    if starts.is_empty() {
        return Err(StartsError::None);
    }
    starts.iter().enumerate().try_for_each(|(replicate, poses)| {
        let (found, expected) = (poses.len(), conditions.robots);
        if found != expected {
            return Err(StartsError::Robots { replicate, found, expected });
        }
        for (index, pose) in poses.iter().enumerate() {
            check_pose(replicate, index + 1, *pose, conditions)?;
        }
        check_apart(replicate, poses, conditions)
    })
}

fn check_pose(
    replicate: usize,
    robot: usize,
    pose: Pose,
    conditions: &Conditions,
) -> Result<(), StartsError> {
    let Pose { x_m, y_m, heading_rad } = pose;
    if ![x_m, y_m, heading_rad].iter().all(|number| Bounds::COORDINATE.contains(*number)) {
        return Err(StartsError::Number { replicate, robot, x_m, y_m, heading_rad });
    }
    if conditions.is_within_walls([x_m, y_m], conditions.robot_at(robot - 1).radius_m) {
        return Ok(());
    }
    let side_m = conditions.arena.side_m;
    let arena = match (&conditions.world.arena, conditions.world.obstacles.len()) {
        (None, 0) => format!("an arena of {side_m} m"),
        (None, _) => format!("an arena of {side_m} m with obstacles"),
        (Some(arena), 0) => format!("the arena, {}", arena.in_words()),
        (Some(arena), _) => format!("the arena, {} with obstacles", arena.in_words()),
    };
    Err(StartsError::Outside { replicate, robot, x_m, y_m, arena })
}

/// Holds each robot against those of nearly its x only, so that large swarms are checked soon.
fn check_apart(
    replicate: usize,
    poses: &[Pose],
    conditions: &Conditions,
) -> Result<(), StartsError> {
    let widest_m = 2.0 * conditions.largest_radius_m();
    let mut order: Vec<usize> = (0..poses.len()).collect();
    order.sort_by(|one, other| poses[*one].x_m.total_cmp(&poses[*other].x_m));
    for (position, one) in order.iter().enumerate() {
        for other in &order[position + 1..] {
            let (from, to) = (poses[*one], poses[*other]);
            if to.x_m - from.x_m >= widest_m {
                break;
            }
            let found_m = libm::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
            let radius_m = |robot: usize| conditions.robot_at(robot).radius_m;
            let least_m = radius_m(*one) + radius_m(*other);
            if found_m < least_m * (1.0 - ROUNDING) {
                let robots = [one.min(other) + 1, one.max(other) + 1];
                return Err(StartsError::Overlap { replicate, robots, found_m, least_m });
            }
        }
    }
    Ok(())
}
