//! The robots of a world in the words of `simulation_interfaces`: which there are, and where.

use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{Accel, Twist, Vector3};
use rsrs_msgs::simulation_interfaces::{
    Bounds, EntityCategory, EntityFilters, EntityState, SetEntityStateRequest,
    SetEntityStateResponse,
};
use rsrs_msgs::std_msgs::Header;

use crate::frames::FRAME;
use crate::mixed::on_the_floor;
use crate::placed_world::PlacedWorld;
use crate::robots::pose_message;

/// Why entities cannot be found or moved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EntityError {
    /// A filter that is none.
    #[error("the filter `{filter}` is no regular expression: {reason}")]
    Filter {
        /// The filter.
        filter: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A way of picking that is not offered.
    #[error("robots are not picked by {by}")]
    Unsupported {
        /// Which way.
        by: &'static str,
    },
    /// No robot has this name.
    #[error("no robot is called `{name}`")]
    NotFound {
        /// The name.
        name: String,
    },
    /// The simulator only follows it.
    #[error("{name} is a real robot, which the simulator cannot move")]
    Real {
        /// The robot.
        name: String,
    },
    /// Our robots have no momentum: they do what they are commanded.
    #[error("a robot's velocity follows its commands and cannot be set")]
    Velocity,
    /// No robot can be there.
    #[error("the pose is {problem}")]
    Pose {
        /// Why not.
        problem: &'static str,
    },
}

/// How far from the floor a pose may be, in metres, and how far from upright, as a quaternion's part.
const FLAT: f64 = 1e-3;

/// Rows of the robots that pass all filters.
pub fn pick(
    placed_world: &PlacedWorld,
    filters: &EntityFilters,
) -> Result<Vec<usize>, EntityError> {
    let name = regex_lite::Regex::new(&filters.filter).map_err(|error| EntityError::Filter {
        filter: filters.filter.clone(),
        reason: error.to_string(),
    })?;
    if !filters.tags.tags.is_empty() {
        return Err(EntityError::Unsupported { by: "tags" });
    }
    let robot = EntityCategory { category: EntityCategory::ROBOT };
    if !filters.categories.is_empty() && !filters.categories.contains(&robot) {
        return Ok(Vec::new());
    }
    let volume = Volume::new(&filters.bounds)?;
    let conditions = &placed_world.conditions;
    let passes = |(row, pose): (usize, Pose)| {
        let is_inside = volume.overlaps(&pose, conditions.robot_at(row).radius_m);
        (is_inside && name.is_match(&placed_world.rows.names[row])).then_some(row)
    };
    Ok(placed_world.world.poses().enumerate().filter_map(passes).collect())
}

/// The row of a robot.
pub fn row(placed_world: &PlacedWorld, name: &str) -> Result<usize, EntityError> {
    let row = placed_world.rows.names.iter().position(|known| known == name);
    row.ok_or_else(|| EntityError::NotFound { name: name.to_owned() })
}

/// Where the robots of these rows are, in their order, and how they are commanded to move;
/// accelerations are not known.
pub fn states(placed_world: &PlacedWorld, rows: &[usize], stamp: Time) -> Vec<EntityState> {
    let poses: Vec<Pose> = placed_world.world.poses().collect();
    let state = |row: &usize| {
        let pose = poses[*row];
        let ours = placed_world.rows.ours.iter().position(|ours| ours == row);
        let twist = ours.map(|robot| {
            let command = placed_world.obeyed()[robot];
            let (sine, cosine) = libm::sincos(pose.heading_rad);
            let (x, y) = (command.speed_m_s * cosine, command.speed_m_s * sine);
            Twist {
                linear: Vector3 { x, y, z: 0.0 },
                angular: Vector3 { x: 0.0, y: 0.0, z: command.turn_rate_rad_s },
            }
        });
        EntityState {
            header: Header { stamp, frame_id: FRAME.to_owned() },
            pose: pose_message(pose),
            twist: twist.unwrap_or_default(),
            acceleration: Accel::default(),
        }
    };
    rows.iter().map(state).collect()
}

/// Where a robot shall be; `None` if its pose is not meant.
pub fn wanted(
    placed_world: &PlacedWorld,
    request: &SetEntityStateRequest,
) -> Result<Option<(usize, Pose)>, EntityError> {
    let row = row(placed_world, &request.entity)?;
    if placed_world.rows.tracked.contains(&row) {
        return Err(EntityError::Real { name: request.entity.clone() });
    }
    let state = &request.state;
    let has_velocity = request.set_twist && state.twist != Twist::default();
    if has_velocity || request.set_acceleration && state.acceleration != Accel::default() {
        return Err(EntityError::Velocity);
    }
    if !request.set_pose {
        return Ok(None);
    }
    let refused = |problem| Err(EntityError::Pose { problem });
    if !["", FRAME, "world"].contains(&state.header.frame_id.as_str()) {
        return refused("in a frame other than `map`");
    }
    let (position, turn) = (state.pose.position, state.pose.orientation);
    // Written so that what is not a number is refused.
    let is_flat = [position.z, turn.x, turn.y].into_iter().all(|part| part.abs() <= FLAT);
    let Some(pose) = on_the_floor(&state.pose).filter(|_| is_flat) else {
        return refused("none on the floor");
    };
    let conditions = &placed_world.conditions;
    let radius_m = conditions.robot_at(row).radius_m;
    if !conditions.is_within_walls([pose.x_m, pose.y_m], radius_m) {
        return refused("outside the arena");
    }
    Ok(Some((row, pose)))
}

impl EntityError {
    /// The code of `simulation_interfaces` for it.
    pub fn code(&self) -> u8 {
        use rsrs_msgs::simulation_interfaces::Result as Code;
        match self {
            Self::Unsupported { .. } => Code::FEATURE_UNSUPPORTED,
            Self::NotFound { .. } => Code::NOT_FOUND,
            Self::Filter { .. } | Self::Real { .. } | Self::Velocity => Code::OPERATION_FAILED,
            Self::Pose { .. } => SetEntityStateResponse::INVALID_POSE,
        }
    }
}

/// Where entities are asked for; corners and centre in metres.
enum Volume {
    Everywhere,
    Box { least: [f64; 3], most: [f64; 3] },
    Sphere { centre: [f64; 3], radius_m: f64 },
}

impl Volume {
    fn new(bounds: &Bounds) -> Result<Self, EntityError> {
        let point = |point: &Vector3| [point.x, point.y, point.z];
        match (bounds.r#type, bounds.points.as_slice()) {
            (Bounds::EMPTY, _) => Ok(Self::Everywhere),
            (Bounds::BOX, [first, second]) => {
                let (first, second) = (point(first), point(second));
                let corner = |pick: fn(f64, f64) -> f64| {
                    std::array::from_fn(|axis| pick(first[axis], second[axis]))
                };
                Ok(Self::Box { least: corner(f64::min), most: corner(f64::max) })
            }
            (Bounds::SPHERE, [centre, radius]) => {
                Ok(Self::Sphere { centre: point(centre), radius_m: radius.x })
            }
            (Bounds::BOX | Bounds::SPHERE, _) => {
                Err(EntityError::Unsupported { by: "bounds without two points" })
            }
            _ => Err(EntityError::Unsupported { by: "bounds of this type" }),
        }
    }

    /// Whether a ball of this radius around a robot's centre touches the volume.
    fn overlaps(&self, pose: &Pose, body_m: f64) -> bool {
        let at = [pose.x_m, pose.y_m, 0.0];
        let within = |nearest: [f64; 3], reach_m: f64| {
            let squares =
                (0..3).map(|axis| (at[axis] - nearest[axis]) * (at[axis] - nearest[axis]));
            squares.sum::<f64>() <= reach_m * reach_m
        };
        match self {
            Self::Everywhere => true,
            Self::Box { least, most } => {
                let nearest = std::array::from_fn(|axis| at[axis].max(least[axis]).min(most[axis]));
                within(nearest, body_m)
            }
            Self::Sphere { centre, radius_m } => within(*centre, radius_m + body_m),
        }
    }
}

#[cfg(test)]
mod tests;
