//! What a robot's sensor covers: `eq:output` and its disc-shaped neighbours.

use rsrs_core::conditions::{Region, SimulatedRobot};
use rsrs_core::robot::profile::Sees;

/// The sensing region in single precision, ready for the pair loop.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldOfView {
    /// A cone, widened by the body if bodies are seen.
    Cone(ConeView),
    /// A convex polygon that must contain the neighbour's centre.
    PolygonCentre(PolygonView),
    /// A convex polygon, its sides moved out by the neighbour's radius, in front only.
    PolygonBody(PolygonView),
}

/// A cone: `|lateral| <= forward * slope + offset_m`, in front, within reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeView {
    pub(crate) slope: f32,
    pub(crate) offset_m: f32,
    pub(crate) reach_squared_m2: f32,
}

/// A convex polygon as half-planes `normal . point <= limit`.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonView {
    pub(crate) sides: Vec<Side>,
}

/// One side of a polygon: what lies inside has `normal . point <= limit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Side {
    pub(crate) normal_x: f32,
    pub(crate) normal_y: f32,
    pub(crate) limit_m: f32,
}

/// How far a view reaches from the robot: no centre beyond is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Greatest distance, in metres.
    pub(crate) reach_m: f32,
    /// Half of the view's width at the robot and at its reach, in metres; `None` if it is not known
    /// to lie in front.
    pub(crate) edge: Option<(f32, f32)>,
}

/// A polygon with a corner sharper than this is not given an extent: rounding moves its tip.
const SHARPEST_SINE: f64 = 1e-2;

impl FieldOfView {
    /// How far the view reaches; `None` if there is no useful bound.
    pub(crate) fn extent(&self) -> Option<Extent> {
        match self {
            Self::Cone(cone) => {
                let reach_m = cone.reach_squared_m2.sqrt();
                let far_m = reach_m * cone.slope + cone.offset_m;
                Some(Extent { reach_m, edge: Some((cone.offset_m, far_m)) })
            }
            Self::PolygonCentre(polygon) | Self::PolygonBody(polygon) => {
                Some(Extent { reach_m: polygon.reach_m()?, edge: None })
            }
        }
    }

    /// Whether a neighbour is seen at `forward_m` and `lateral_m` in the robot's frame; `d2_m2` is its
    /// squared distance.
    #[inline]
    pub fn sees(&self, forward_m: f32, lateral_m: f32, d2_m2: f32) -> bool {
        match self {
            Self::Cone(cone) => cone.sees(forward_m, lateral_m, d2_m2),
            Self::PolygonCentre(polygon) => d2_m2 > 0.0 && polygon.contains(forward_m, lateral_m),
            Self::PolygonBody(polygon) => forward_m > 0.0 && polygon.contains(forward_m, lateral_m),
        }
    }

    /// The view of a simulated robot upon robots of its own kind.
    pub fn new(robot: &SimulatedRobot) -> Self {
        Self::upon(robot, robot.radius_m)
    }

    /// The view of a simulated robot upon robots with bodies of another radius, in metres.
    ///
    /// A body of radius `r` touches a half-plane when its centre lies within `r` of it. Moving each
    /// side out by `r` therefore covers every body that touches the region, and a little more
    /// beyond the corners; what lies behind the robot is left out.
    pub fn upon(robot: &SimulatedRobot, other_radius_m: f64) -> Self {
        let body_m = match robot.sees {
            Sees::Body => other_radius_m,
            Sees::Centre => 0.0,
        };
        match (&robot.region, robot.sees) {
            (Region::Cone { half_angle_rad, range_m }, _) => {
                let reach_m = range_m + body_m;
                Self::Cone(ConeView {
                    slope: libm::tan(*half_angle_rad) as f32,
                    offset_m: (body_m / libm::cos(*half_angle_rad)) as f32,
                    reach_squared_m2: (reach_m * reach_m) as f32,
                })
            }
            (Region::Polygon { corners_m }, Sees::Centre) => {
                Self::PolygonCentre(PolygonView::new(corners_m, body_m))
            }
            (Region::Polygon { corners_m }, Sees::Body) => {
                Self::PolygonBody(PolygonView::new(corners_m, body_m))
            }
        }
    }
}

impl ConeView {
    /// Whether a neighbour is seen at `forward_m` and `lateral_m` in the robot's frame; `d2_m2` is
    /// its squared distance.
    #[expect(clippy::needless_bitwise_bool, reason = "without branches, lanes stay together")]
    #[inline]
    pub fn sees(&self, forward_m: f32, lateral_m: f32, d2_m2: f32) -> bool {
        (forward_m > 0.0)
            & (d2_m2 <= self.reach_squared_m2)
            & (lateral_m.abs() <= forward_m * self.slope + self.offset_m)
    }
}

impl PolygonView {
    fn new(corners_m: &[[f64; 2]], body_m: f64) -> Self {
        let side = |corner: usize| {
            let (from, to) = (corners_m[corner], corners_m[(corner + 1) % corners_m.len()]);
            let (along_x, along_y) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(along_x, along_y);
            // The region lies left of each side (counterclockwise), so outside is to the right.
            let (normal_x, normal_y) = (along_y / length, -along_x / length);
            Side {
                normal_x: normal_x as f32,
                normal_y: normal_y as f32,
                limit_m: (normal_x * from[0] + normal_y * from[1] + body_m) as f32,
            }
        };
        Self { sides: (0..corners_m.len()).map(side).collect() }
    }

    /// The greatest distance of a corner from the robot, in metres, and a little more; `None` if a
    /// corner is too sharp for one.
    fn reach_m(&self) -> Option<f32> {
        let mut reach_m = 0.0_f64;
        for (index, side) in self.sides.iter().enumerate() {
            let next = &self.sides[(index + 1) % self.sides.len()];
            let [x, y, limit] = [side.normal_x, side.normal_y, side.limit_m].map(f64::from);
            let [next_x, next_y, next_limit] =
                [next.normal_x, next.normal_y, next.limit_m].map(f64::from);
            let sine = x * next_y - y * next_x;
            if sine < SHARPEST_SINE {
                return None;
            }
            let corner_x = (limit * next_y - next_limit * y) / sine;
            let corner_y = (next_limit * x - limit * next_x) / sine;
            reach_m = reach_m.max(libm::hypot(corner_x, corner_y));
        }
        Some((reach_m * 1.001) as f32)
    }

    /// Whether a point lies on the inner side of all sides.
    #[expect(clippy::needless_bitwise_bool, reason = "without branches, lanes stay together")]
    #[inline]
    pub fn contains(&self, forward_m: f32, lateral_m: f32) -> bool {
        self.sides.iter().fold(true, |inside, side| {
            inside & (forward_m * side.normal_x + lateral_m * side.normal_y <= side.limit_m)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsrs_testing::conditions::flockbot_conditions;

    fn robot(region: Region, sees: Sees) -> SimulatedRobot {
        SimulatedRobot { region, sees, ..flockbot_conditions().robot }
    }

    fn sees(view: &FieldOfView, forward_m: f32, lateral_m: f32) -> bool {
        let d2_m2 = forward_m * forward_m + lateral_m * lateral_m;
        match view {
            FieldOfView::Cone(cone) => cone.sees(forward_m, lateral_m, d2_m2),
            FieldOfView::PolygonCentre(polygon) => polygon.contains(forward_m, lateral_m),
            FieldOfView::PolygonBody(polygon) => {
                forward_m > 0.0 && polygon.contains(forward_m, lateral_m)
            }
        }
    }

    const CONE: Region = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };

    #[test]
    fn a_cone_sees_a_centre_within_its_edges_and_range() {
        let view = FieldOfView::new(&robot(CONE, Sees::Centre));

        assert!(sees(&view, 0.74, 0.0) && !sees(&view, 0.76, 0.0));
        assert!(sees(&view, 0.5, 0.101) && !sees(&view, 0.5, 0.102));
        assert!(sees(&view, 0.5, -0.101) && !sees(&view, 0.5, -0.102));
        assert!(!sees(&view, -0.5, 0.0));
    }

    #[test]
    fn a_cone_sees_a_body_that_touches_it() {
        let view = FieldOfView::new(&robot(CONE, Sees::Body));

        // The edge at 0.5 m: 0.5 tan 0.2 + 0.075 / cos 0.2 = 0.1779 m.
        assert!(sees(&view, 0.5, 0.177) && !sees(&view, 0.5, 0.179));
        assert!(sees(&view, 0.82, 0.0) && !sees(&view, 0.83, 0.0));
        assert!(!sees(&view, -0.01, 0.0));
    }

    #[test]
    fn a_polygon_sees_what_is_inside_it() {
        let corners_m = vec![[0.1, -0.1], [0.6, -0.2], [0.6, 0.2], [0.1, 0.1]];
        let centre = FieldOfView::new(&robot(
            Region::Polygon { corners_m: corners_m.clone() },
            Sees::Centre,
        ));
        let body = FieldOfView::new(&robot(Region::Polygon { corners_m }, Sees::Body));

        assert!(sees(&centre, 0.3, 0.0) && !sees(&centre, 0.61, 0.0) && !sees(&centre, 0.09, 0.0));
        assert!(sees(&body, 0.67, 0.0) && !sees(&body, 0.68, 0.0));
        assert!(sees(&body, 0.03, 0.0) && !sees(&body, 0.02, 0.0));
    }

    #[test]
    fn a_polygon_around_the_robot_sees_bodies_in_front_only() {
        let corners_m = vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let centre = FieldOfView::new(&robot(
            Region::Polygon { corners_m: corners_m.clone() },
            Sees::Centre,
        ));
        let body = FieldOfView::new(&robot(Region::Polygon { corners_m }, Sees::Body));

        assert!(sees(&centre, -0.3, 0.0));
        assert!(!sees(&body, -0.3, 0.0));
    }
}
