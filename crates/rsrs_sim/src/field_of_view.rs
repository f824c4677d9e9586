//! What a robot's sensor covers: `eq:output` and its disc-shaped neighbours.
//!
//! With `sees: centre` a neighbour is seen if its centre lies in the region. With `sees: body` it is
//! seen if its body, a disc of radius `r`, touches the region: if the distance of its centre from the
//! region is at most `r`, wherever that centre is. The region is closed. A robot does not see itself, nor a
//! neighbour whose centre is exactly its own.
//!
//! **Cone**, of half-angle `a < π/2` and range `R`. By symmetry only `|lateral|` counts. Beside the
//! sector and along its edge, the centre is `s = |lateral| cos a - forward sin a` away from the edge's
//! line, and `e = sqrt(d² - s²)` along it; it is within `r` of the edge or of its far end, where the
//! arc begins, if `s <= r` and `e <= R + sqrt(r² - s²)`. Squared, and with the sector itself, where
//! `s <= 0` and `d <= R + r`:
//!
//! ```text
//! max(s, 0)² + (max(d² - (R² + r²), 0) / 2R)² <= r²
//! ```
//!
//! Divided by `cos² a`, the first term is that of `|lateral| - forward tan a`. With `r = 0` it is the
//! cone for centres. It holds where the centre's foot on the line is not behind the robot,
//! `forward + |lateral| tan a >= 0`; elsewhere the tip is nearest, and the disc touches if `d <= r`.
//!
//! **Polygon**, convex. Its sides are moved out by `r`. That covers too much only at corners: beyond the
//! chord from where the disc around a corner meets one side to where it meets the next, the centre must
//! lie within `r` of the corner.

use rsrs_core::conditions::SimulatedRobot;
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;

/// The sensing region in single precision, ready for the pair loop.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldOfView {
    /// A cone, with the width that bodies add to it.
    Cone(ConeView),
    /// A convex polygon, with the room that bodies add to it.
    Polygon(PolygonView),
}

/// A cone, in the numbers of the module's text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeView {
    /// `tan a`
    pub(crate) slope: f32,
    /// `1 / (2R cos a)`
    pub(crate) per_m: f32,
    /// `(R² + r²) / (2R cos a)`
    pub(crate) end_m: f32,
    /// `(r / cos a)²`
    pub(crate) width_squared_m2: f32,
    /// `r²`
    pub(crate) body_squared_m2: f32,
    /// `R + r`
    pub(crate) reach_m: f32,
}

/// A convex polygon whose sides are moved out, and whose corners are round.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonView {
    pub(crate) sides: Vec<HalfPlane>,
    /// None where centres are seen.
    pub(crate) corners: Vec<Corner>,
    /// `r²`
    pub(crate) body_squared_m2: f32,
}

/// A half-plane `normal . point <= limit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HalfPlane {
    pub(crate) normal_x: f32,
    pub(crate) normal_y: f32,
    pub(crate) limit_m: f32,
}

/// A corner with the chord beyond which it is nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// What lies within the chord.
    pub(crate) chord: HalfPlane,
    pub(crate) x_m: f32,
    pub(crate) y_m: f32,
}

/// How far a view reaches from the robot: no centre beyond is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Greatest distance, in metres.
    pub(crate) reach_m: f32,
    /// Half of the view's width at the robot and at its reach, in metres; `None` if it is not known
    /// to lie in front. What is seen behind the robot is no wider than at the robot, and no
    /// farther behind than a body's radius.
    pub(crate) edge: Option<(f32, f32)>,
}

/// A polygon with a corner sharper than this is not given an extent: rounding moves its tip.
const SHARPEST_SINE: f64 = 1e-2;

/// What rounding may do to a bound, relative to it.
const MARGIN: f32 = 1e-4;

impl FieldOfView {
    /// How far the view reaches; `None` if there is no useful bound.
    pub(crate) fn extent(&self) -> Option<Extent> {
        match self {
            Self::Cone(cone) => {
                let (reach_m, near_m) = (cone.reach_m, cone.width_squared_m2.sqrt());
                Some(Extent { reach_m, edge: Some((near_m, reach_m * cone.slope + near_m)) })
            }
            Self::Polygon(polygon) => Some(Extent { reach_m: polygon.reach_m()?, edge: None }),
        }
    }

    /// The view of a simulated robot upon robots of its own kind.
    pub fn new(robot: &SimulatedRobot) -> Self {
        Self::upon(robot, robot.radius_m)
    }

    /// The view of a simulated robot upon robots with bodies of another radius, in metres.
    pub fn upon(robot: &SimulatedRobot, other_radius_m: f64) -> Self {
        Self::from_region(&robot.region, seen_radius_m(robot.sees, other_radius_m))
    }

    /// The view of a region upon robots of which so much around the centre is seen, in metres.
    pub fn from_region(region: &Region, body_m: f64) -> Self {
        match region {
            Region::Cone { half_angle_rad, range_m } => {
                Self::Cone(ConeView::new(*half_angle_rad, *range_m, body_m))
            }
            Region::Polygon { corners_m } => Self::Polygon(PolygonView::new(corners_m, body_m)),
        }
    }

    /// Whether a neighbour is seen at `forward_m` and `lateral_m` in the robot's frame; `d2_m2` is
    /// its squared distance.
    #[inline]
    pub fn sees(&self, forward_m: f32, lateral_m: f32, d2_m2: f32) -> bool {
        match self {
            Self::Cone(cone) => cone.sees(forward_m, lateral_m, d2_m2),
            Self::Polygon(polygon) => polygon.sees(forward_m, lateral_m, d2_m2),
        }
    }
}

/// How much around its centre is seen of a robot with a body of this radius, in metres.
pub fn seen_radius_m(sees: Sees, radius_m: f64) -> f64 {
    match sees {
        Sees::Body => radius_m,
        Sees::Centre => 0.0,
    }
}

/// The number, or 0 if it is negative.
#[inline]
fn positive(number: f32) -> f32 {
    if number > 0.0 { number } else { 0.0 }
}

impl ConeView {
    fn new(half_angle_rad: f64, range_m: f64, body_m: f64) -> Self {
        let (sine, cosine) = libm::sincos(half_angle_rad);
        let (width_m, per_m) = (body_m / cosine, 1.0 / (2.0 * range_m * cosine));
        Self {
            slope: (sine / cosine) as f32,
            per_m: per_m as f32,
            end_m: ((range_m * range_m + body_m * body_m) * per_m) as f32,
            width_squared_m2: (width_m * width_m) as f32,
            body_squared_m2: (body_m * body_m) as f32,
            reach_m: (range_m + body_m) as f32,
        }
    }

    /// As [`FieldOfView::sees`].
    #[expect(clippy::needless_bitwise_bool, reason = "without branches, lanes stay together")]
    #[inline]
    pub fn sees(&self, forward_m: f32, lateral_m: f32, d2_m2: f32) -> bool {
        let lateral_m = lateral_m.abs();
        let is_along = forward_m + lateral_m * self.slope >= 0.0;
        let over_m = positive(d2_m2 * self.per_m - self.end_m);
        let beside_m = positive(lateral_m - forward_m * self.slope);
        let touches = beside_m * beside_m <= self.width_squared_m2 - over_m * over_m;
        let is_near = d2_m2 <= self.body_squared_m2;
        ((forward_m > 0.0) & touches) | ((d2_m2 > 0.0) & (is_near | (is_along & touches)))
    }

    /// No neighbour is seen that is not in front and as far away as this, in square metres.
    pub(crate) fn behind_squared_m2(&self) -> f32 {
        self.width_squared_m2 * (1.0 + MARGIN)
    }
}

impl PolygonView {
    fn new(corners_m: &[[f64; 2]], body_m: f64) -> Self {
        let n = corners_m.len();
        let normal = |side: usize| {
            let (from, to) = (corners_m[side % n], corners_m[(side + 1) % n]);
            let (along_x, along_y) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(along_x, along_y);
            // The region lies left of each side (counterclockwise), so outside is to the right.
            [along_y / length, -along_x / length]
        };
        // Through a point that lies `body_m` outside of a corner, in the direction of `meets`.
        let half_plane = |[x, y]: [f64; 2], corner: [f64; 2], meets: [f64; 2]| HalfPlane {
            normal_x: x as f32,
            normal_y: y as f32,
            limit_m: (x * (corner[0] + body_m * meets[0]) + y * (corner[1] + body_m * meets[1]))
                as f32,
        };
        let corner = |corner: usize| {
            let (before, after) = (normal(corner + n - 1), normal(corner));
            let outward = if before[0] * after[0] + before[1] * after[1] > 0.0 {
                [before[0] + after[0], before[1] + after[1]]
            } else {
                // The same direction, for a sharp corner, whose normals are opposite.
                [after[1] - before[1], before[0] - after[0]]
            };
            let length = libm::hypot(outward[0], outward[1]);
            let outward = outward.map(|coordinate| coordinate / length);
            let at = corners_m[corner];
            Corner { chord: half_plane(outward, at, before), x_m: at[0] as f32, y_m: at[1] as f32 }
        };
        Self {
            sides: (0..n)
                .map(|side| half_plane(normal(side), corners_m[side], normal(side)))
                .collect(),
            corners: (0..if body_m > 0.0 { n } else { 0 }).map(corner).collect(),
            body_squared_m2: (body_m * body_m) as f32,
        }
    }

    /// The greatest distance at which a centre is seen, in metres, and a little more; `None` if a
    /// corner is too sharp for one.
    fn reach_m(&self) -> Option<f32> {
        let mut reach_m = 0.0_f64;
        for corner in &self.corners {
            let corner_m = libm::hypot(f64::from(corner.x_m), f64::from(corner.y_m));
            reach_m = reach_m.max(corner_m + f64::from(self.body_squared_m2).sqrt());
        }
        let tips = if self.corners.is_empty() { self.sides.len() } else { 0 };
        for (index, side) in self.sides.iter().enumerate().take(tips) {
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

    /// As [`FieldOfView::sees`].
    #[inline]
    pub fn sees(&self, forward_m: f32, lateral_m: f32, d2_m2: f32) -> bool {
        let is_inside = |half_plane: &HalfPlane| {
            forward_m * half_plane.normal_x + lateral_m * half_plane.normal_y <= half_plane.limit_m
        };
        let touches = |corner: &Corner| {
            let (dx_m, dy_m) = (forward_m - corner.x_m, lateral_m - corner.y_m);
            dx_m * dx_m + dy_m * dy_m <= self.body_squared_m2
        };
        let sides = self.sides.iter().fold(d2_m2 > 0.0, |seen, side| seen & is_inside(side));
        self.corners
            .iter()
            .fold(sides, |seen, corner| seen & (is_inside(&corner.chord) | touches(corner)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Purpose, RunKey, Seed, Stream};
    use rsrs_testing::conditions::flockbot_conditions;

    const BODY_M: f64 = 0.075;

    fn view(region: &Region, sees: Sees, radius_m: f64) -> FieldOfView {
        let robot = flockbot_conditions().robot;
        let region = region.clone();
        FieldOfView::new(&SimulatedRobot { region, sees, radius_m, ..robot })
    }

    fn sees(view: &FieldOfView, forward_m: f64, lateral_m: f64) -> bool {
        let (forward_m, lateral_m) = (forward_m as f32, lateral_m as f32);
        view.sees(forward_m, lateral_m, forward_m * forward_m + lateral_m * lateral_m)
    }

    /// Distance of a point from a segment.
    fn from_segment_m([x, y]: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
        let (along_x, along_y) = (to[0] - from[0], to[1] - from[1]);
        let length_m2 = along_x * along_x + along_y * along_y;
        let share = ((x - from[0]) * along_x + (y - from[1]) * along_y) / length_m2;
        let share = share.clamp(0.0, 1.0);
        libm::hypot(x - from[0] - share * along_x, y - from[1] - share * along_y)
    }

    /// Distance of a point from a region, in double precision and by its definition: 0 inside, else
    /// that from the nearest part of the border.
    fn from_region_m(region: &Region, point: [f64; 2]) -> f64 {
        match region {
            Region::Cone { half_angle_rad, range_m } => {
                let bearing_rad = libm::atan2(point[1], point[0]);
                if bearing_rad.abs() <= *half_angle_rad {
                    return (libm::hypot(point[0], point[1]) - range_m).max(0.0);
                }
                let end = |side: f64| {
                    let (sine, cosine) = libm::sincos(side * half_angle_rad);
                    [range_m * cosine, range_m * sine]
                };
                let edge = |side| from_segment_m(point, [[0.0, 0.0], end(side)]);
                edge(-1.0).min(edge(1.0))
            }
            Region::Polygon { corners_m } => {
                let n = corners_m.len();
                let sides = (0..n).map(|side| [corners_m[side], corners_m[(side + 1) % n]]);
                let is_left = |[from, to]: [[f64; 2]; 2]| {
                    (to[0] - from[0]) * (point[1] - from[1])
                        - (to[1] - from[1]) * (point[0] - from[0])
                        >= 0.0
                };
                if sides.clone().all(is_left) {
                    return 0.0;
                }
                sides.map(|side| from_segment_m(point, side)).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Numbers from -1 to 1.
    fn draws(replicate: u64) -> impl FnMut() -> f64 {
        let mut stream =
            Stream::new(RunKey::new(Seed { seed: 1, replicate }, 0), 0, Purpose::Placement);
        move || 2.0 * stream.uniform() - 1.0
    }

    /// Cones from a beam to nearly a half-plane, some of them shorter than a body.
    fn random_cone(draw: &mut impl FnMut() -> f64) -> Region {
        let half_angle_rad = 0.75 + 0.749 * draw();
        Region::Cone { half_angle_rad, range_m: libm::exp(2.5 * draw() - 1.0) }
    }

    /// Convex polygons in front, around or behind: corners on an ellipse, in order.
    fn random_polygon(draw: &mut impl FnMut() -> f64) -> Region {
        let n = 3 + (2.999 * (draw() + 1.0)) as usize;
        let mut bearings: Vec<f64> = (0..n).map(|_| std::f64::consts::PI * draw()).collect();
        bearings.sort_by(f64::total_cmp);
        let (long_m, wide_m) = (libm::exp(2.0 * draw() - 1.0), libm::exp(2.0 * draw() - 1.0));
        let (x, y, lean) = (draw(), 0.5 * draw(), draw());
        let corner = |bearing: &f64| {
            let (sine, cosine) = libm::sincos(*bearing);
            [x + long_m * cosine + lean * wide_m * sine, y + wide_m * sine]
        };
        Region::Polygon { corners_m: bearings.iter().map(corner).collect() }
    }

    /// How many random points a view is wrong about, and how many it is asked about that are seen: all
    /// but those that rounding may take for either.
    fn wrong(
        region: &Region,
        what: Sees,
        radius_m: f64,
        draw: &mut impl FnMut() -> f64,
    ) -> (Vec<[f64; 2]>, usize) {
        let view = view(region, what, radius_m);
        let allowed_m = if what == Sees::Body { radius_m } else { 0.0 };
        let width_m = 1.2 * region.range_m() + 2.0 * radius_m;
        let (mut wrong, mut n_seen) = (Vec::new(), 0);
        for point in 0..400 {
            // Half of them near the robot's own body.
            let most_m = if point % 2 == 0 { width_m } else { 3.0 * radius_m };
            let at = [most_m * draw(), most_m * draw()].map(|x| f64::from(x as f32));
            let distance_m = from_region_m(region, at);
            let from_border_m =
                if allowed_m > 0.0 { (distance_m - allowed_m).abs() } else { border_m(region, at) };
            if from_border_m < 1e-5 * width_m {
                continue;
            }
            n_seen += usize::from(distance_m <= allowed_m);
            if sees(&view, at[0], at[1]) != (distance_m <= allowed_m) {
                wrong.push(at);
            }
        }
        (wrong, n_seen)
    }

    /// Distance of a point from the border of a region, on either side of it.
    fn border_m(region: &Region, at: [f64; 2]) -> f64 {
        let border = rsrs_core::capability::border_m(region);
        let n = border.len();
        (0..n)
            .map(|side| from_segment_m(at, [border[side], border[(side + 1) % n]]))
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_body_is_seen_if_and_only_if_its_disc_touches_the_region() {
        let mut draw = draws(0);
        let (mut n_seen, mut n_points) = (0, 0);
        for round in 0..2000 {
            let region =
                if round % 2 == 0 { random_cone(&mut draw) } else { random_polygon(&mut draw) };
            let radius_m = 0.1 * libm::exp(2.0 * draw());

            let (wrong, seen) = wrong(&region, Sees::Body, radius_m, &mut draw);

            assert_eq!(wrong, Vec::<[f64; 2]>::new(), "{region:?}, radius {radius_m} m");
            (n_seen, n_points) = (n_seen + seen, n_points + 400);
        }
        assert!(n_seen > n_points / 5 && n_seen < n_points * 4 / 5, "{n_seen} of {n_points}");
    }

    #[test]
    fn a_centre_is_seen_if_and_only_if_it_lies_in_the_region() {
        let mut draw = draws(1);
        for round in 0..1000 {
            let region =
                if round % 2 == 0 { random_cone(&mut draw) } else { random_polygon(&mut draw) };

            let (wrong, _) = wrong(&region, Sees::Centre, BODY_M, &mut draw);

            assert_eq!(wrong, Vec::<[f64; 2]>::new(), "{region:?}");
        }
    }

    #[test]
    fn a_line_of_sight_sees_the_bodies_that_it_meets() {
        let region = Region::Cone { half_angle_rad: 0.0, range_m: 2.0 };
        let robot = SimulatedRobot { region, ..flockbot_conditions().robot };
        let line = FieldOfView::new(&robot);
        let sees = |forward_m: f32, lateral_m: f32| {
            line.sees(forward_m, lateral_m, forward_m * forward_m + lateral_m * lateral_m)
        };

        for (forward_m, lateral_m) in [(0.2, 0.0), (1.0, 0.0749), (1.99, -0.0749), (2.07, 0.0)] {
            assert!(sees(forward_m, lateral_m), "{forward_m} {lateral_m}");
        }
        for (forward_m, lateral_m) in [(1.0, 0.0751), (1.0, -0.0751), (2.08, 0.0), (-0.2, 0.0)] {
            assert!(!sees(forward_m, lateral_m), "{forward_m} {lateral_m}");
        }
    }
}
