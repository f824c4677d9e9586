//! The shape of a sensing region: how far and how wide it is, and the same region turned or stretched.
//!
//! A polygon that was fitted to readings has no range and no angle written down. What a laboratory
//! can change about its sensor is still these: where it points, how far it reaches, how wide it opens.

use crate::robot::sensor::Cone;

/// Greatest distance of a corner from the robot, in metres. Corners are `[x, y]`, x forward and y
/// left, as in all of this module.
pub fn range_m(corners_m: &[[f64; 2]]) -> f64 {
    corners_m.iter().map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max)
}

/// Where a polygon points and how wide it opens, as seen from the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Bearing of the middle between both edges, in radians; left is positive.
    pub bearing_rad: f64,
    /// Half of the angle between both edges, in radians.
    pub half_angle_rad: f64,
}

impl Opening {
    /// The opening of a polygon: its edges are the corners farthest to the right and to the left. A
    /// corner at the robot itself has no bearing. `None` if the polygon is not in front of the
    /// robot, or around it.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_core::robot::shape::Opening;
    ///
    /// let opening = Opening::new(&[[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]]).unwrap();
    /// assert_eq!(format!("{:.3}", opening.bearing_rad), "0.393");
    /// assert_eq!(format!("{:.3}", opening.half_angle_rad), "0.393");
    /// ```
    pub fn new(corners_m: &[[f64; 2]]) -> Option<Self> {
        let least_m = AT_THE_ROBOT * range_m(corners_m);
        let seen = corners_m.iter().filter(|[x, y]| libm::hypot(*x, *y) > least_m);
        let mut edges: Option<(f64, f64)> = None;
        for [x, y] in seen {
            if *x <= 0.0 {
                return None;
            }
            let bearing_rad = libm::atan2(*y, *x);
            let (right, left) = edges.unwrap_or((bearing_rad, bearing_rad));
            edges = Some((right.min(bearing_rad), left.max(bearing_rad)));
        }
        let (right, left) = edges?;
        let half_angle_rad = (left - right) / 2.0;
        (half_angle_rad > 0.0)
            .then_some(Self { bearing_rad: f64::midpoint(left, right), half_angle_rad })
    }
}

/// A corner closer than this share of the range is at the robot; dimensionless.
const AT_THE_ROBOT: f64 = 1e-6;

/// The polygon, all of it larger or smaller.
pub fn scaled(corners_m: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
    corners_m.iter().map(|[x, y]| [by * x, by * y]).collect()
}

/// The polygon turned about the robot; left is positive.
pub fn turned(corners_m: &[[f64; 2]], by_rad: f64) -> Vec<[f64; 2]> {
    let (sine, cosine) = libm::sincos(by_rad);
    corners_m.iter().map(|[x, y]| [cosine * x - sine * y, sine * x + cosine * y]).collect()
}

/// The polygon stretched across its own axis until it opens so wide, to either side less than a right
/// angle, and with the range that it had: a convex polygon stays one, with as many corners. `None` as
/// [`Opening::new`].
pub fn stretched(corners_m: &[[f64; 2]], half_angle_rad: f64) -> Option<Vec<[f64; 2]>> {
    let opening = Opening::new(corners_m)?;
    let by = libm::tan(half_angle_rad) / libm::tan(opening.half_angle_rad);
    let ahead = turned(corners_m, -opening.bearing_rad);
    let wider: Vec<[f64; 2]> = ahead.iter().map(|[x, y]| [*x, by * y]).collect();
    let kept = scaled(&wider, range_m(corners_m) / range_m(&wider));
    Some(turned(&kept, opening.bearing_rad))
}

/// A cone that points elsewhere, as a polygon: its tip, and seven corners along its arc.
///
/// The arc of radius R becomes six chords that lie half inside and half outside of it: the reach is
/// off by at most 0.03 % for a half-angle of 0.2 rad, 0.2 % for 0.5 rad and 1.6 % for 1.5 rad.
pub fn turned_cone(cone: Cone, by_rad: f64) -> Vec<[f64; 2]> {
    let chord_rad = 2.0 * cone.half_angle_rad / f64::from(CHORDS);
    let radius_m = cone.range_m * 2.0 / (1.0 + libm::cos(chord_rad / 2.0));
    let arc = (0..=CHORDS).map(|corner| {
        let bearing_rad = by_rad - cone.half_angle_rad + chord_rad * f64::from(corner);
        let (sine, cosine) = libm::sincos(bearing_rad);
        [radius_m * cosine, radius_m * sine]
    });
    std::iter::once([0.0, 0.0]).chain(arc).collect()
}

/// With the tip, as many corners as a polygon may have.
const CHORDS: u32 = 6;

#[cfg(test)]
mod tests {
    use super::*;

    const LOPSIDED: [[f64; 2]; 4] = [[0.0, 0.0], [0.6, -0.1], [0.7, 0.1], [0.5, 0.3]];

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn a_stretched_polygon_opens_as_asked_and_keeps_range_and_axis() {
        let before = Opening::new(&LOPSIDED).unwrap();

        for half_angle_rad in [0.05, before.half_angle_rad, 1.2] {
            let corners_m = stretched(&LOPSIDED, half_angle_rad).unwrap();

            let after = Opening::new(&corners_m).unwrap();
            near(after.half_angle_rad, half_angle_rad);
            near(after.bearing_rad, before.bearing_rad);
            near(range_m(&corners_m), range_m(&LOPSIDED));
        }
    }

    #[test]
    fn a_turned_polygon_points_elsewhere_and_is_else_the_same() {
        let before = Opening::new(&LOPSIDED).unwrap();

        let after = Opening::new(&turned(&LOPSIDED, -before.bearing_rad)).unwrap();

        near(after.bearing_rad, 0.0);
        near(after.half_angle_rad, before.half_angle_rad);
    }

    #[test]
    fn what_is_around_the_robot_has_no_opening() {
        assert_eq!(Opening::new(&[[-0.1, -0.1], [0.5, 0.0], [-0.1, 0.1]]), None);
        assert_eq!(Opening::new(&[[0.0, 0.0]]), None);
    }

    #[test]
    fn a_turned_cone_has_its_opening_and_nearly_its_range() {
        for (half_angle_rad, off) in [(0.2, 0.0003), (0.5, 0.002), (1.5, 0.016)] {
            let cone = Cone { half_angle_rad, range_m: 0.75 };

            let ahead = turned_cone(cone, 0.0);
            let leaning = turned_cone(cone, 0.05);

            near(Opening::new(&ahead).unwrap().half_angle_rad, half_angle_rad);
            near(Opening::new(&leaning).unwrap().bearing_rad, 0.05);
            let chord_rad = half_angle_rad / 3.0;
            let (most_m, least_m) = (range_m(&ahead), range_m(&ahead) * libm::cos(chord_rad / 2.0));
            assert!(most_m < 0.75 * (1.0 + off) && least_m > 0.75 * (1.0 - off), "{most_m}");
        }
    }
}
