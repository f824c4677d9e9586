//! The part of the floor that robots must not leave.

use rsrs_core::robot::unicycle::Pose;

use crate::placement::{StartArea, WantedStart};

/// A rectangle of the floor, in the frame of the robots' poses.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Geofence {
    /// Least and greatest x of a robot's centre, in metres.
    pub x_m: [f64; 2],
    /// Least and greatest y of a robot's centre, in metres.
    pub y_m: [f64; 2],
}

/// No floor is larger, in metres.
const MOST_M: f64 = 1000.0;

/// Bounds that are none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "geofence: `{key}` is {found}, expected two numbers, the smaller one first, of at most {MOST_M} m: \
     more is likely in millimetres"
)]
pub struct InvalidGeofence {
    /// The key.
    pub key: &'static str,
    /// What it has.
    pub found: String,
}

/// A start that is not within a geofence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "robots start at x = {:.2} to {:.2} m and y = {:.2} to {:.2} m, expected within the geofence, \
     x = {:.2} to {:.2} m and y = {:.2} to {:.2} m",
    start.x_m[0], start.x_m[1], start.y_m[0], start.y_m[1],
    fence.x_m[0], fence.x_m[1], fence.y_m[0], fence.y_m[1]
)]
pub struct StartsOutside {
    /// Where robots start.
    pub start: Geofence,
    /// What they must not leave.
    pub fence: Geofence,
}

impl Geofence {
    /// Refuses bounds between which nothing is.
    pub fn check(&self) -> Result<(), InvalidGeofence> {
        for (key, bounds) in [("x_m", self.x_m), ("y_m", self.y_m)] {
            let [least, greatest] = bounds;
            let is_range = -MOST_M <= least && least < greatest && greatest <= MOST_M;
            if !is_range {
                return Err(InvalidGeofence { key, found: format!("{bounds:?}") });
            }
        }
        Ok(())
    }

    /// Whether a robot that stands there is inside.
    pub fn contains(&self, pose: Pose) -> bool {
        let within = |[least, greatest]: [f64; 2], at: f64| (least..=greatest).contains(&at);
        within(self.x_m, pose.x_m) && within(self.y_m, pose.y_m)
    }

    /// Refuses a start that reaches out of it: robots would be outside before they have moved.
    pub fn check_start(&self, wanted: &WantedStart) -> Result<(), StartsOutside> {
        let start = match &wanted.area {
            StartArea::Disc { radius_m } => Self::around(*radius_m, *radius_m),
            StartArea::Box(sides) | StartArea::BoxFacingAnyWay(sides) => {
                Self::around(sides.width_m / 2.0, sides.height_m / 2.0)
            }
            StartArea::Poses(poses) => {
                let Some(all) = Self::of_poses(poses) else { return Ok(()) };
                all
            }
        };
        let within =
            |inner: [f64; 2], outer: [f64; 2]| inner[0] >= outer[0] && inner[1] <= outer[1];
        if within(start.x_m, self.x_m) && within(start.y_m, self.y_m) {
            return Ok(());
        }
        Err(StartsOutside { start, fence: *self })
    }

    fn around(x_m: f64, y_m: f64) -> Self {
        Self { x_m: [-x_m, x_m], y_m: [-y_m, y_m] }
    }

    /// The smallest that contains all poses; `None` without any.
    fn of_poses(poses: &[Pose]) -> Option<Self> {
        let first = poses.first()?;
        let point = Self { x_m: [first.x_m; 2], y_m: [first.y_m; 2] };
        let wider = |[least, greatest]: [f64; 2], at: f64| [least.min(at), greatest.max(at)];
        Some(poses.iter().fold(point, |all, pose| Self {
            x_m: wider(all.x_m, pose.x_m),
            y_m: wider(all.y_m, pose.y_m),
        }))
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Sides;

    use super::*;

    const FENCE: Geofence = Geofence { x_m: [-1.0, 2.0], y_m: [-1.0, 1.0] };

    fn at(x_m: f64, y_m: f64) -> Pose {
        Pose { x_m, y_m, heading_rad: 0.0 }
    }

    #[test]
    fn a_robot_on_the_line_is_inside_and_one_beyond_it_or_nowhere_is_not() {
        for (inside, expected) in
            [(at(2.0, -1.0), true), (at(2.01, 0.0), false), (at(0.0, f64::NAN), false)]
        {
            assert_eq!(FENCE.contains(inside), expected, "{inside:?}");
        }
    }

    #[test]
    fn bounds_that_hold_nothing_are_refused() {
        for bounds in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            let error = Geofence { y_m: bounds, ..FENCE }.check().unwrap_err().to_string();

            assert!(error.starts_with("geofence: `y_m` is ["), "{error}");
        }
        assert_eq!(FENCE.check(), Ok(()));
    }

    #[test]
    fn a_start_outside_of_it_is_refused_with_both_places() {
        let start = |area| FENCE.check_start(&WantedStart { area, clearance_m: 0.1 });

        assert_eq!(start(StartArea::Disc { radius_m: 0.9 }), Ok(()));
        assert_eq!(start(StartArea::Poses(vec![at(1.9, 0.0), at(0.0, 1.0)])), Ok(()));
        assert!(start(StartArea::Box(Sides { width_m: 1.0, height_m: 2.2 })).is_err());
        let error = start(StartArea::Poses(vec![at(0.0, 0.0), at(2.5, 0.5)])).unwrap_err();
        assert_eq!(
            error.to_string(),
            "robots start at x = 0.00 to 2.50 m and y = 0.00 to 0.50 m, expected within the \
             geofence, x = -1.00 to 2.00 m and y = -1.00 to 1.00 m"
        );
    }
}
