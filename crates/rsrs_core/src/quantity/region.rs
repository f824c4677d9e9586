//! The region of a sensor: how far it reaches, how wide it opens, and where it points.

use crate::robot::profile::RobotProfile;
use crate::robot::shape::{self, Opening};

/// Why a region cannot become another one: what robots are that have such.
type Refused = Result<(), &'static str>;

pub fn range_m(robot: &RobotProfile) -> Option<f64> {
    match (&robot.sensing.cone, &robot.sensing.polygon_m) {
        (Some(cone), _) => Some(cone.range_m),
        (None, corners_m) => Some(shape::range_m(corners_m.as_deref()?)),
    }
}

pub fn half_angle_rad(robot: &RobotProfile) -> Option<f64> {
    match (&robot.sensing.cone, &robot.sensing.polygon_m) {
        (Some(cone), _) => Some(cone.half_angle_rad),
        (None, corners_m) => Some(Opening::new(corners_m.as_deref()?)?.half_angle_rad),
    }
}

pub fn scale(robot: &RobotProfile) -> Option<f64> {
    robot.sensing.polygon_m.as_ref().map(|_| 1.0)
}

/// A polygon keeps its shape.
#[expect(clippy::unnecessary_wraps, reason = "a row of the table takes functions of one shape")]
pub fn set_range(robot: &mut RobotProfile, range_m: f64) -> Refused {
    if let Some(cone) = &mut robot.sensing.cone {
        cone.range_m = range_m;
    } else if let Some(corners_m) = &mut robot.sensing.polygon_m {
        *corners_m = shape::scaled(corners_m, range_m / shape::range_m(corners_m));
    }
    Ok(())
}

/// A polygon is stretched across its own axis.
pub fn set_half_angle(robot: &mut RobotProfile, half_angle_rad: f64) -> Refused {
    if let Some(cone) = &mut robot.sensing.cone {
        cone.half_angle_rad = half_angle_rad;
    } else if let Some(corners_m) = &mut robot.sensing.polygon_m {
        let stretched = shape::stretched(corners_m, half_angle_rad);
        *corners_m = stretched.ok_or("whose sensor is a polygon that is not all in front of it")?;
    }
    Ok(())
}

pub fn set_scale(robot: &mut RobotProfile, scale: f64) -> Refused {
    let corners_m = robot.sensing.polygon_m.as_mut().ok_or("whose sensor is a cone")?;
    *corners_m = shape::scaled(corners_m, scale);
    Ok(())
}

/// A cone that is turned becomes a polygon ([`shape::turned_cone`]).
#[expect(clippy::unnecessary_wraps, reason = "a row of the table takes functions of one shape")]
pub fn turn(robot: &mut RobotProfile, turn_rad: f64) -> Refused {
    let sensing = &mut robot.sensing;
    if turn_rad == 0.0 {
        return Ok(());
    }
    if let Some(cone) = sensing.cone.take() {
        sensing.polygon_m = Some(shape::turned_cone(cone, turn_rad));
    } else if let Some(corners_m) = &mut sensing.polygon_m {
        *corners_m = shape::turned(corners_m, turn_rad);
    }
    Ok(())
}
