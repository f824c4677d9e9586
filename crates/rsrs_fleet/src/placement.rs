//! Whether the robots stand on the floor as the experiment wants them to start.

use rsrs_core::conditions::{Conditions, Placement, Sides};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::tracker::TrackerFrame;
use rsrs_core::world::{Object, WorldFile};
use serde::Serialize;

/// Whether start poses are held against the wanted placement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaceCheck {
    /// They are, and what deviates is noted.
    #[default]
    On,
    /// They are, and no robot moves while one deviates.
    Require,
    /// They are not, as where there are no poses.
    Off,
}

impl PlaceCheck {
    /// What the command line calls it.
    pub fn key(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Require => "require",
            Self::Off => "off",
        }
    }
}

/// How the robots are to start.
#[derive(Clone, Debug, PartialEq)]
pub struct WantedStart {
    /// Where.
    pub area: StartArea,
    /// Least distance between two centres, in metres.
    pub clearance_m: f64,
}

/// Where the robots are to start.
#[derive(Clone, Debug, PartialEq)]
pub enum StartArea {
    /// In a disc around the origin, facing away from it.
    Disc {
        /// Radius of the disc of their centres, in metres.
        radius_m: f64,
    },
    /// In a box around the origin, facing away from it.
    Box(Sides),
    /// In a box around the origin, heading anywhere.
    BoxFacingAnyWay(Sides),
    /// Each at a pose of its own, in the order of the robots.
    Poses(Vec<Pose>),
}

impl WantedStart {
    /// How the robots of these conditions are to start; of several tables of poses, the replicate
    /// selects one.
    pub fn new(conditions: &Conditions, replicate: u64) -> Self {
        let area = match &conditions.placement {
            Placement::BoxFacingOut(sides) => StartArea::Box(*sides),
            Placement::BoxFacingAnyWay(sides) => StartArea::BoxFacingAnyWay(*sides),
            Placement::Given { starts } => {
                // A number that is no index is far beyond the last set, which none of ours is.
                let set = replicate % starts.len().max(1) as u64;
                let set = usize::try_from(set).unwrap_or_default();
                StartArea::Poses(starts.get(set).cloned().unwrap_or_default())
            }
            disc => StartArea::Disc { radius_m: disc.radius_m() },
        };
        // A table may put robots as near as they can stand.
        let clearance_m = if matches!(area, StartArea::Poses(_)) {
            2.0 * conditions.smallest_radius_m()
        } else {
            CLEARANCE_RADII * conditions.largest_radius_m()
        };
        Self { area, clearance_m }
    }
}

/// Least distance between two centres at the start, in robot radii; as the simulator places them.
pub const CLEARANCE_RADII: f64 = 2.2;

/// How far from where it is wanted a robot may stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Outside of its area, away from its place or too close to another, in metres.
    pub place_m: f64,
    /// Of its heading, in degrees.
    pub heading_deg: f64,
}

impl Tolerance {
    /// That of robots that stand and were set down with care.
    pub const STANDING: Self = Self { place_m: 0.02, heading_deg: 15.0 };

    /// That of the first poses of a run: until they were recorded robots drove for a moment (a period at
    /// 0.3 m/s is 4 cm), and a tracker may be 1 cm and 0.1 rad wrong in a single pose.
    pub const RECORDED: Self = Self { place_m: 0.08, heading_deg: 35.0 };
}

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
    /// A robot is out of the box.
    #[error(
        "{robot}: at ({x_m:.2}, {y_m:.2}) m, expected within a box of {width_m:.3} m by {height_m:.3} m"
    )]
    OutsideBox {
        /// The robot.
        robot: String,
        /// Where it is, in metres.
        x_m: f64,
        /// Where it is, in metres.
        y_m: f64,
        /// Width of the box, in metres.
        width_m: f64,
        /// Height of the box, in metres.
        height_m: f64,
    },
    /// A robot, or an object, is not at its place.
    #[error(
        "{robot}: at ({x_m:.2}, {y_m:.2}) m, expected ({expected_x_m:.2}, {expected_y_m:.2}) m, \
         {found_m:.2} m away"
    )]
    Misplaced {
        /// Its name.
        robot: String,
        /// Where it is, in metres.
        x_m: f64,
        /// Where it is, in metres.
        y_m: f64,
        /// Its place, in metres.
        expected_x_m: f64,
        /// Its place, in metres.
        expected_y_m: f64,
        /// How far from its place, in metres.
        found_m: f64,
    },
    /// A robot does not head where it should.
    #[error("{robot}: heading {found_deg:.0}°, expected {expected_deg:.0}°")]
    HeadingOfPose {
        /// The robot.
        robot: String,
        /// Its heading, in degrees.
        found_deg: f64,
        /// The wanted one, in degrees.
        expected_deg: f64,
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

/// Where the robots of a run are seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeenPlaces {
    /// Where their poses come from.
    pub pose_source: PoseSource,
    /// On which topics.
    pub topics: Vec<String>,
    /// Where the tracker's frame is on the floor; not there where poses are on the floor as they come.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracker_frame: Option<TrackerFrame>,
    /// In the order of the fleet file.
    pub robots: Vec<SeenRobot>,
    /// What is not as the experiment wants it to start.
    pub deviations: Vec<String>,
    /// What would keep a run from starting, as far as poses are concerned.
    pub problems: Vec<String>,
    /// What the operator should know besides.
    pub notes: Vec<String>,
    /// What the tracker sees besides the robots of the run, by name.
    pub others: Vec<String>,
    /// Whether every robot is seen, and stands where it should start.
    pub is_as_wanted: bool,
    /// For how long it has been looked, in seconds.
    pub looked_for_s: f64,
}

/// Where a robot is seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeenRobot {
    /// Its name.
    pub robot: String,
    /// What the tracker calls it, where that is not its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Where it is on the floor; `None` as long as it is not seen.
    pub pose: Option<Pose>,
    /// The frame that its poses name.
    pub frame: Option<String>,
    /// How long ago that was, in seconds.
    pub age_s: Option<f64>,
    /// Poses in a second.
    pub rate_hz: Option<f64>,
    /// Why its last pose cannot be used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unusable: Option<String>,
}

/// Everything that is not as wanted, robot by robot: each with its number from 0, its name, and its
/// pose in one frame, whose origin is the centre of the area.
pub fn deviations(wanted: &WantedStart, robots: &[(usize, String, Pose)]) -> Vec<Deviation> {
    deviations_beyond(Tolerance::STANDING, wanted, robots)
}

/// As [`deviations`], beyond another tolerance.
pub fn deviations_beyond(
    tolerance: Tolerance,
    wanted: &WantedStart,
    robots: &[(usize, String, Pose)],
) -> Vec<Deviation> {
    let mut deviations = Vec::new();
    for (index, (number, robot, pose)) in robots.iter().enumerate() {
        match &wanted.area {
            StartArea::Disc { radius_m } => {
                deviations.extend(out_of_disc(tolerance, *radius_m, robot, *pose));
                deviations.extend(not_facing_out(tolerance, robot, *pose));
            }
            StartArea::Box(sides) => {
                deviations.extend(out_of_box(tolerance, *sides, robot, *pose));
                deviations.extend(not_facing_out(tolerance, robot, *pose));
            }
            StartArea::BoxFacingAnyWay(sides) => {
                deviations.extend(out_of_box(tolerance, *sides, robot, *pose));
            }
            StartArea::Poses(poses) => {
                let expected = poses.get(*number);
                deviations.extend(
                    expected
                        .into_iter()
                        .flat_map(|expected| misplaced(tolerance, *expected, robot, *pose)),
                );
            }
        }
        for (_, other, place) in &robots[..index] {
            let found_m = libm::hypot(pose.x_m - place.x_m, pose.y_m - place.y_m);
            if found_m < wanted.clearance_m - tolerance.place_m {
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

fn out_of_disc(tolerance: Tolerance, radius_m: f64, robot: &str, pose: Pose) -> Option<Deviation> {
    let found_m = libm::hypot(pose.x_m, pose.y_m);
    (found_m > radius_m + tolerance.place_m).then(|| Deviation::Outside {
        robot: robot.to_owned(),
        found_m,
        expected_m: radius_m,
    })
}

fn out_of_box(
    tolerance: Tolerance,
    Sides { width_m, height_m }: Sides,
    robot: &str,
    pose: Pose,
) -> Option<Deviation> {
    let Pose { x_m, y_m, .. } = pose;
    let is_out = x_m.abs() > width_m / 2.0 + tolerance.place_m
        || y_m.abs() > height_m / 2.0 + tolerance.place_m;
    let robot = || robot.to_owned();
    is_out.then(|| Deviation::OutsideBox { robot: robot(), x_m, y_m, width_m, height_m })
}

fn not_facing_out(tolerance: Tolerance, robot: &str, pose: Pose) -> Option<Deviation> {
    let expected_rad = libm::atan2(pose.y_m, pose.x_m);
    let is_off = libm::hypot(pose.x_m, pose.y_m) > CENTRE_M.max(2.0 * tolerance.place_m)
        && off_deg(pose.heading_rad, expected_rad) > tolerance.heading_deg;
    is_off.then(|| Deviation::Heading {
        robot: robot.to_owned(),
        found_deg: pose.heading_rad.to_degrees(),
        expected_deg: expected_rad.to_degrees(),
    })
}

fn misplaced(tolerance: Tolerance, expected: Pose, robot: &str, pose: Pose) -> Vec<Deviation> {
    let place = away(tolerance, [expected.x_m, expected.y_m], robot, [pose.x_m, pose.y_m]);
    let is_off = off_deg(pose.heading_rad, expected.heading_rad) > tolerance.heading_deg;
    let heading = is_off.then(|| Deviation::HeadingOfPose {
        robot: robot.to_owned(),
        found_deg: pose.heading_rad.to_degrees(),
        expected_deg: expected.heading_rad.to_degrees(),
    });
    place.into_iter().chain(heading).collect()
}

fn away(
    tolerance: Tolerance,
    [expected_x_m, expected_y_m]: [f64; 2],
    name: &str,
    [x_m, y_m]: [f64; 2],
) -> Option<Deviation> {
    let found_m = libm::hypot(x_m - expected_x_m, y_m - expected_y_m);
    (found_m > tolerance.place_m).then(|| Deviation::Misplaced {
        robot: name.to_owned(),
        x_m,
        y_m,
        expected_x_m,
        expected_y_m,
        found_m,
    })
}

/// Objects that are not where their world has them; those that it places at random may be
/// anywhere.
///
/// Their places, in metres, have the shape `[n_objects][2]`, or are empty if nobody knows them.
pub fn deviations_of_objects(
    tolerance: Tolerance,
    world: &WorldFile,
    places_m: &[[f64; 2]],
) -> Vec<Deviation> {
    let objects = world.each_object().zip(places_m).enumerate();
    let deviation = |(number, (object, place_m)): (usize, (Object, &[f64; 2]))| {
        away(tolerance, object.place_m?, &WorldFile::object_name(number), *place_m)
    };
    objects.filter_map(deviation).collect()
}

/// Angle between two headings, in degrees, 0 to 180.
fn off_deg(one_rad: f64, other_rad: f64) -> f64 {
    libm::acos(libm::cos(one_rad - other_rad).clamp(-1.0, 1.0)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: WantedStart =
        WantedStart { area: StartArea::Disc { radius_m: 0.825 }, clearance_m: 0.165 };

    fn at(name: &str, x_m: f64, y_m: f64, heading_deg: f64) -> (usize, String, Pose) {
        let number: usize = name.rsplit('_').next().unwrap().parse().unwrap();
        (number - 1, name.to_owned(), Pose { x_m, y_m, heading_rad: heading_deg.to_radians() })
    }

    #[test]
    fn robots_that_are_not_in_the_box_or_at_their_places_are_reported() {
        let clearance_m = 0.165;
        let wanted_box = WantedStart {
            area: StartArea::Box(Sides { width_m: 2.0, height_m: 1.0 }),
            clearance_m,
        };
        let pose = |x_m, y_m, heading_rad| Pose { x_m, y_m, heading_rad };
        let poses = vec![pose(0.5, 0.0, 0.0), pose(-0.5, 0.0, 0.0), pose(0.0, 0.5, 1.0)];
        let wanted_poses = WantedStart { area: StartArea::Poses(poses), clearance_m };
        let robots = [at("robot_1", 0.5, 0.0, 0.0), at("robot_3", 0.0, 0.9, 90.0)];

        let world =
            "objects: [{places_m: [[1, 0], [0, 1]], radius_m: 0.1}, {count: 1, radius_m: 0.1}]";
        let world = WorldFile::parse("world.yaml", world, &[4.0], &[]).unwrap();
        let of_objects = |places_m: &[[f64; 2]]| -> Vec<String> {
            let found = deviations_of_objects(Tolerance::STANDING, &world, places_m);
            found.iter().map(ToString::to_string).collect()
        };
        let expected = "object_2: at (0.00, 0.60) m, expected (0.00, 1.00) m, 0.40 m away";
        assert_eq!(of_objects(&[[1.01, 0.0], [0.0, 0.6], [1.5, 1.5]]), [expected]);
        assert_eq!(of_objects(&[]), [""; 0]);

        let texts = |wanted: &WantedStart| -> Vec<String> {
            deviations(wanted, &robots).iter().map(ToString::to_string).collect()
        };

        assert_eq!(
            texts(&wanted_box),
            ["robot_3: at (0.00, 0.90) m, expected within a box of 2.000 m by 1.000 m"]
        );
        let any_way = StartArea::BoxFacingAnyWay(Sides { width_m: 2.0, height_m: 2.0 });
        let robots_any_way = [at("robot_1", 0.5, 0.0, 123.0), at("robot_2", 0.0, 0.9, 45.0)];
        let wanted_any_way = WantedStart { area: any_way, clearance_m };
        assert_eq!(deviations(&wanted_any_way, &robots_any_way), []);
        assert_eq!(
            texts(&wanted_poses),
            [
                "robot_3: at (0.00, 0.90) m, expected (0.00, 0.50) m, 0.40 m away",
                "robot_3: heading 90°, expected 57°"
            ]
        );
    }

    #[test]
    fn robots_that_stand_as_wanted_are_not_mentioned() {
        let robots = [
            at("robot_1", 0.5, 0.0, 0.0),
            at("robot_2", 0.0, 0.8, 90.0),
            at("robot_3", -0.8, -0.01, 180.0),
            at("robot_4", 0.01, 0.0, 77.0),
        ];

        assert_eq!(deviations(&WANTED, &robots), []);
    }

    #[test]
    fn every_deviation_is_reported_with_what_was_expected() {
        let robots = [
            at("robot_1", 1.0, 0.0, 0.0),
            at("robot_2", 0.0, 0.5, -90.0),
            at("robot_3", 0.0, 0.6, 80.0),
        ];

        let texts: Vec<_> = deviations(&WANTED, &robots).iter().map(ToString::to_string).collect();

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
