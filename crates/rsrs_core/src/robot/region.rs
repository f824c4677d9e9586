//! Where a sensor detects a neighbour.

use serde::{Deserialize, Serialize};

use crate::robot::sensor::{Sees, Sensing};
use crate::robot::shape;

/// Where a neighbour is detected, in the robot's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// A cone in front.
    Cone {
        /// Half of the opening angle, in radians.
        half_angle_rad: f64,
        /// Reach, in metres.
        range_m: f64,
    },
    /// A convex polygon, counterclockwise, in metres.
    Polygon {
        /// Corners `[x, y]`, x forward, y left.
        corners_m: Vec<[f64; 2]>,
    },
}

impl Region {
    /// The region of a checked profile's sensor.
    ///
    /// # Panics
    ///
    /// If the profile has neither a cone nor a polygon: then it was not checked.
    pub fn new(sensing: &Sensing) -> Self {
        match (&sensing.cone, &sensing.polygon_m) {
            (Some(cone), _) => {
                Self::Cone { half_angle_rad: cone.half_angle_rad, range_m: cone.range_m }
            }
            (None, Some(corners)) => Self::Polygon { corners_m: corners.clone() },
            (None, None) => unreachable!("a checked profile has a region"),
        }
    }

    /// The greatest distance at which a centre can lie in the region, in metres.
    pub fn range_m(&self) -> f64 {
        match self {
            Self::Cone { range_m, .. } => *range_m,
            Self::Polygon { corners_m } => shape::range_m(corners_m),
        }
    }

    /// The reach of a sensor: how far from a robot's centre the centre of another can be seen, in
    /// metres.
    ///
    /// Where centres are seen this is [`Region::range_m`]. Where bodies are seen it is a radius of the
    /// neighbour more: a disc whose edge touches the region has its centre up to a radius outside.
    ///
    /// # Example
    ///
    /// A Flockbot sees 0.75 m far, and a robot whose centre is 7.5 cm beyond.
    ///
    /// ```
    /// use rsrs_core::robot::region::Region;
    /// use rsrs_core::robot::sensor::Sees;
    ///
    /// let cone = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };
    /// assert_eq!(format!("{:.3}", cone.reach_m(Sees::Body, 0.075)), "0.825");
    /// assert_eq!(cone.reach_m(Sees::Centre, 0.075), 0.75);
    /// ```
    pub fn reach_m(&self, sees: Sees, radius_m: f64) -> f64 {
        self.range_m() + if sees == Sees::Body { radius_m } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners_m: &[[f64; 2]]) -> Region {
        Region::Polygon { corners_m: corners_m.to_vec() }
    }

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn a_box_reaches_to_its_farthest_corner_and_a_bodys_radius_beyond() {
        let region = polygon(&[[0.1, -0.2], [0.6, -0.2], [0.6, 0.2], [0.1, 0.2]]);

        assert_near(region.reach_m(Sees::Body, 0.075), libm::hypot(0.6, 0.2) + 0.075);
        assert_near(region.reach_m(Sees::Centre, 0.075), libm::hypot(0.6, 0.2));
    }

    #[test]
    fn a_region_reaches_behind_the_robot_too() {
        let region = polygon(&[[-3.0, -0.5], [0.4, -0.5], [0.4, 0.5], [-3.0, 0.5]]);

        assert_near(region.reach_m(Sees::Body, 0.1), libm::hypot(3.0, 0.5) + 0.1);
    }
}
