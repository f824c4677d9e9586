//! Whether the robots stand on the floor as the experiment wants them to start.

use rsrs_core::unicycle::Pose;

/// How the robots are to start: in a disc around the origin, facing away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartDisc {
    /// Radius of the disc of their centres, in metres.
    pub radius_m: f64,
    /// Least distance between two centres, in metres.
    pub clearance_m: f64,
}

/// Least distance between two centres at the start, in robot radii; as the simulator places them.
pub const CLEARANCE_RADII: f64 = 2.2;

/// A robot that far outside the disc, or closer to another, was set down with care, in metres.
const TOLERANCE_M: f64 = 0.02;
/// A heading that far off was set with care, in degrees.
const TOLERANCE_DEG: f64 = 15.0;
/// Nearer to the centre than this, in metres, every heading faces away from it.
const CENTRE_M: f64 = 0.05;

/// What is not as wanted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Deviation {
    /// A robot is out of the disc.
    #[error("{robot}: {found_m:.2} m from the centre, expected at most {expected_m:.3} m")]
    Outside {
        /// The robot.
        robot: String,
        /// Its distance, in metres.
        found_m: f64,
        /// Radius of the disc, in metres.
        expected_m: f64,
    },
    /// Two robots nearly touch.
    #[error(
        "{} and {}: centres {found_m:.2} m apart, expected at least {expected_m:.3} m",
        robots[0], robots[1]
    )]
    TooClose {
        /// The two.
        robots: [String; 2],
        /// Distance between their centres, in metres.
        found_m: f64,
        /// Least distance, in metres.
        expected_m: f64,
    },
    /// A robot does not face away from the centre.
    #[error("{robot}: heading {found_deg:.0}°, expected {expected_deg:.0}°, away from the centre")]
    Heading {
        /// The robot.
        robot: String,
        /// Its heading, in degrees.
        found_deg: f64,
        /// Its bearing from the centre, in degrees.
        expected_deg: f64,
    },
}

/// Everything that is not as wanted, robot by robot.
///
/// # Arguments
///
/// * `robots` — names and poses in one frame, whose origin is the centre of the disc.
pub fn deviations(wanted: StartDisc, robots: &[(String, Pose)]) -> Vec<Deviation> {
    let mut deviations = Vec::new();
    for (index, (robot, pose)) in robots.iter().enumerate() {
        let found_m = libm::hypot(pose.x_m, pose.y_m);
        if found_m > wanted.radius_m + TOLERANCE_M {
            let (robot, expected_m) = (robot.clone(), wanted.radius_m);
            deviations.push(Deviation::Outside { robot, found_m, expected_m });
        }
        let expected_rad = libm::atan2(pose.y_m, pose.x_m);
        if found_m > CENTRE_M && off_deg(pose.heading_rad, expected_rad) > TOLERANCE_DEG {
            deviations.push(Deviation::Heading {
                robot: robot.clone(),
                found_deg: pose.heading_rad.to_degrees(),
                expected_deg: expected_rad.to_degrees(),
            });
        }
        for (other, place) in &robots[..index] {
            let found_m = libm::hypot(pose.x_m - place.x_m, pose.y_m - place.y_m);
            if found_m < wanted.clearance_m - TOLERANCE_M {
                deviations.push(Deviation::TooClose {
                    robots: [other.clone(), robot.clone()],
                    found_m,
                    expected_m: wanted.clearance_m,
                });
            }
        }
    }
    deviations
}

/// Angle between two headings, in degrees, 0 to 180.
fn off_deg(one_rad: f64, other_rad: f64) -> f64 {
    libm::acos(libm::cos(one_rad - other_rad).clamp(-1.0, 1.0)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: StartDisc = StartDisc { radius_m: 0.825, clearance_m: 0.165 };

    fn at(name: &str, (x_m, y_m): (f64, f64), heading_deg: f64) -> (String, Pose) {
        (name.to_owned(), Pose { x_m, y_m, heading_rad: heading_deg.to_radians() })
    }

    #[test]
    fn robots_that_stand_as_wanted_are_not_mentioned() {
        let robots = [
            at("robot_1", (0.5, 0.0), 0.0),
            at("robot_2", (0.0, 0.8), 90.0),
            at("robot_3", (-0.8, -0.01), 180.0),
            at("robot_4", (0.01, 0.0), 77.0),
        ];

        assert_eq!(deviations(WANTED, &robots), []);
    }

    #[test]
    fn every_deviation_is_told_with_what_was_expected() {
        let robots = [
            at("robot_1", (1.0, 0.0), 0.0),
            at("robot_2", (0.0, 0.5), -90.0),
            at("robot_3", (0.0, 0.6), 80.0),
        ];

        let texts: Vec<_> = deviations(WANTED, &robots).iter().map(ToString::to_string).collect();

        assert_eq!(
            texts,
            [
                "robot_1: 1.00 m from the centre, expected at most 0.825 m",
                "robot_2: heading -90°, expected 90°, away from the centre",
                "robot_2 and robot_3: centres 0.10 m apart, expected at least 0.165 m",
            ]
        );
    }
}
