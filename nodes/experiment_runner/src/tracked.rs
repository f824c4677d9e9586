//! Where robots are, as the tracker of a run publishes it.

use std::collections::BTreeSet;

use rsrs_bags::trajectory::{PoseReader, TrackedTopic, UnreadablePoses};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::tracker::{HandOver, Taken, Tracker, TrackerFrame};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_ros::session::ReceivedRaw;

use crate::plan::Plan;

/// A machine of the tracker: the place of its topic, and who publishes there.
type Machine = (usize, [u8; 16]);

/// The poses of a run's robots, as they come.
pub struct Tracked {
    reader: PoseReader,
    frame: TrackerFrame,
    /// Which machine counts for each robot.
    machines: HandOver<Machine>,
    /// Robots whose machines were already found to disagree.
    apart: BTreeSet<String>,
}

/// A pose that was received.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenPose {
    /// Whose it is.
    pub robot: String,
    /// The frame that its message names.
    pub frame: String,
    /// How far its stamp is ahead of our clock, in seconds; `None` if it has none.
    pub ahead_s: Option<f64>,
    /// Where the robot is on the floor, or why the pose cannot be used.
    pub pose: Result<Pose, String>,
    /// Whether it counts: another machine of the tracker may be in use for this robot.
    pub counts: bool,
}

/// What a message of the tracker shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The poses in it, of robots of the run.
    pub poses: Vec<SeenPose>,
    /// What the operator should know.
    pub notes: Vec<String>,
}

impl Tracked {
    /// Nothing was received yet by the reader of the run; `radius_m` is that of the robots' bodies.
    pub fn new(reader: PoseReader, frame: TrackerFrame, radius_m: f64) -> Self {
        Self { reader, frame, machines: HandOver::new(radius_m), apart: BTreeSet::new() }
    }

    /// The tracker of a run.
    pub fn of_run(plan: &Plan) -> Self {
        let frame = plan.record.tracker.as_ref().map_or_else(TrackerFrame::default, |it| it.frame);
        Self::new(reader(plan), frame, plan.record.conditions.smallest_radius_m())
    }

    /// The topics with poses.
    pub fn topics(&self) -> &[TrackedTopic] {
        self.reader.topics()
    }

    /// The place of a topic among them.
    pub fn index_of(&self, name: &str, type_name: &str) -> Option<usize> {
        self.reader.index_of(name, type_name)
    }

    /// What the tracker sees besides the robots, by name.
    pub fn others(&self) -> impl Iterator<Item = &str> {
        self.reader.others()
    }

    /// Understands a message on a topic, which is given by its place.
    ///
    /// # Errors
    ///
    /// What is wrong with the message, where it tells nothing about any robot.
    pub fn take(&mut self, topic: usize, received: &ReceivedRaw) -> anyhow::Result<Sighting> {
        let raw = match self.reader.take(topic, &received.message) {
            Ok(raw) => raw,
            Err(UnreadablePoses::Damaged(error)) => return Err(error.into()),
            Err(reason) => return Ok(self.useless(topic, &reason)),
        };
        let mut sighting = Sighting::default();
        for raw in raw {
            let pose = wire::pose(&raw.pose()).map(|pose| self.frame.on_floor(pose));
            let counts = match &pose {
                Ok(pose) => {
                    let machine = (self.topics()[topic].machine, received.writer);
                    let taken =
                        self.machines.take(&raw.robot, machine, received.received_time_ns, *pose);
                    sighting.notes.extend(self.disagreement(&raw.robot, machine, taken));
                    taken == Taken::Used
                }
                Err(_) => true,
            };
            sighting.poses.push(SeenPose {
                ahead_s: seconds_ahead(raw.stamp, received.received_time_ns),
                robot: raw.robot,
                frame: raw.frame,
                pose: pose.map_err(|error| error.to_string()),
                counts,
            });
        }
        Ok(sighting)
    }

    /// Poses of all robots that such a message should have, none of which can be used.
    fn useless(&self, topic: usize, reason: &UnreadablePoses) -> Sighting {
        let name = &self.topics()[topic].name;
        let pose = |robot: &String| SeenPose {
            robot: robot.clone(),
            frame: String::new(),
            ahead_s: None,
            pose: Err(format!("a message on {name}: {reason}")),
            counts: true,
        };
        let robots: BTreeSet<&String> = self.reader.robots().collect();
        Sighting { poses: robots.into_iter().map(pose).collect(), notes: Vec::new() }
    }

    /// The note on machines that see a robot in two places, once for each robot.
    fn disagreement(
        &mut self,
        robot: &str,
        machine: Machine,
        taken: Taken<Machine>,
    ) -> Option<String> {
        let Taken::Apart { by_m, other } = taken else { return None };
        if !self.apart.insert(robot.to_owned()) {
            return None;
        }
        let topic = |machine: Machine| {
            let topics = self.topics().iter().filter(|topic| topic.machine == machine.0);
            let mut of_robot =
                topics.filter(|topic| topic.robot.as_deref().is_none_or(|of| of == robot));
            of_robot.next().map_or_else(String::new, |topic| topic.name.clone())
        };
        let (used, spare) = (topic(other), topic(machine));
        let spare = if used == spare {
            "by another publisher there".to_owned()
        } else {
            format!("by {spare}")
        };
        Some(format!(
            "{robot} is seen {by_m:.2} m apart by {used}, which counts, and {spare}: calibrate the \
             tracker's machines"
        ))
    }
}

/// What reads the poses of a run.
pub fn reader(plan: &Plan) -> PoseReader {
    let plain = Tracker::default();
    let tracker = plan.record.tracker.as_ref().unwrap_or(&plain);
    PoseReader::new(plan.tracked_by(), tracker, &plan.record.robots)
}

/// How far a stamp is ahead of a time on our clock, in seconds; `None` for one that was not set.
pub fn seconds_ahead(stamp: Time, ours_ns: u64) -> Option<f64> {
    let stamp_ns = stamp.to_nanos().filter(|nanos| *nanos > 0)?;
    Some((i128::from(stamp_ns) - i128::from(ours_ns)) as f64 / 1e9)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use rsrs_core::robot::pose_source::PoseSource;
    use rsrs_msgs::cdr;
    use rsrs_msgs::geometry_msgs::{Point, Pose as Pose3, PoseArray, Quaternion};
    use rsrs_msgs::motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};

    use super::*;

    const RADIUS_M: f64 = 0.1;

    fn robots() -> Vec<String> {
        ["robot_1", "robot_2"].map(str::to_owned).to_vec()
    }

    fn tracked(source: PoseSource, tracker: &Tracker) -> Tracked {
        Tracked::new(PoseReader::new(source, tracker, &robots()), tracker.frame, RADIUS_M)
    }

    fn received(message: Vec<u8>, at_ms: u64) -> ReceivedRaw {
        ReceivedRaw {
            message,
            source_time_ns: None,
            received_time_ns: at_ms * 1_000_000,
            sequence: 1,
            writer: [7; 16],
        }
    }

    /// As a tracker in millimetres with y up sees it.
    fn y_up(x_mm: f64, height_mm: f64, z_mm: f64, turn_rad: f64) -> Pose3 {
        let (sine, cosine) = libm::sincos(turn_rad / 2.0);
        Pose3 {
            position: Point { x: x_mm, y: height_mm, z: z_mm },
            orientation: Quaternion { x: 0.0, y: sine, z: 0.0, w: cosine },
        }
    }

    fn y_up_millimetres() -> TrackerFrame {
        let axes = ["x", "-z", "y"].map(str::to_owned);
        TrackerFrame {
            axes: axes.try_into().unwrap(),
            scale: 0.001,
            offset_m: [1.0, 0.0],
            ..TrackerFrame::default()
        }
    }

    #[test]
    fn bodies_of_a_tracker_with_y_up_in_millimetres_are_robots_on_the_floor() {
        let bodies = BTreeMap::from([("robot_2".to_owned(), "RigidBody 2".to_owned())]);
        let tracker = Tracker { bodies, frame: y_up_millimetres(), ..Tracker::default() };
        let mut tracked = tracked(PoseSource::NamedPoses, &tracker);
        let named = |name: &str, pose| NamedPose { name: name.to_owned(), pose };
        let poses = vec![
            named("wand", y_up(9.0, 9.0, 9.0, 0.0)),
            named("RigidBody 2", y_up(500.0, 60.0, -2000.0, 1.0)),
            named("robot_1", y_up(f64::NAN, f64::NAN, f64::NAN, 0.0)),
        ];
        let bytes = cdr::encode(&NamedPoseArray { poses, ..NamedPoseArray::default() });

        let Sighting { poses, notes } = tracked.take(0, &received(bytes, 0)).unwrap();

        let [only] = &poses[..] else { panic!("{poses:?}") };
        let pose = only.pose.clone().unwrap();
        assert_eq!((only.robot.as_str(), only.counts), ("robot_2", true));
        assert!((pose.x_m - 1.5).abs() < 1e-12 && (pose.y_m - 2.0).abs() < 1e-12, "{pose:?}");
        assert!((pose.heading_rad - 1.0).abs() < 1e-12, "{pose:?}");
        assert_eq!(tracked.others().collect::<Vec<_>>(), ["wand"]);
        assert_eq!(notes, [""; 0]);
    }

    #[test]
    fn an_array_of_another_length_is_refused_for_all_robots_with_the_reason() {
        let names = ["robot_2", "box", "robot_1"].map(str::to_owned).to_vec();
        let mut tracked = tracked(PoseSource::PoseArray, &Tracker { names, ..Tracker::default() });
        let array = |n_poses: usize| {
            let poses = (0..n_poses).map(|n| {
                let mut pose = Pose3::default();
                pose.position.x = n as f64;
                pose
            });
            cdr::encode(&PoseArray { poses: poses.collect(), ..PoseArray::default() })
        };

        let whole = tracked.take(0, &received(array(3), 0)).unwrap();
        let short = tracked.take(0, &received(array(2), 10)).unwrap();

        let place = |seen: &SeenPose| (seen.robot.clone(), seen.pose.clone().unwrap().x_m);
        let places: Vec<_> = whole.poses.iter().map(place).collect();
        assert_eq!(places, [("robot_2".to_owned(), 0.0), ("robot_1".to_owned(), 2.0)]);
        let refused: Vec<_> = short.poses.iter().map(|seen| seen.robot.as_str()).collect();
        assert_eq!(refused, ["robot_1", "robot_2"]);
        assert_eq!(
            short.poses[0].pose.clone().unwrap_err(),
            "a message on /poses: it has 2 poses, expected 3: without names, only their number and \
             order tell whose they are"
        );
    }

    #[test]
    fn of_two_machines_one_counts_and_that_they_disagree_is_reported_once() {
        let topics = vec!["/a/{body}".to_owned(), "/b/{body}".to_owned()];
        let mut tracked = tracked(PoseSource::Pose, &Tracker { topics, ..Tracker::default() });
        let names: Vec<String> = tracked.topics().iter().map(|topic| topic.name.clone()).collect();
        assert_eq!(names, ["/a/robot_1", "/b/robot_1", "/a/robot_2", "/b/robot_2"]);
        let at = |x: f64| {
            let mut message = rsrs_msgs::geometry_msgs::PoseStamped::default();
            message.pose.position.x = x;
            cdr::encode(&message)
        };

        let mut notes = Vec::new();
        for step in 0..20 {
            let by_a = tracked.take(0, &received(at(1.0), step * 20)).unwrap();
            let by_b = tracked.take(1, &received(at(1.5), step * 20 + 5)).unwrap();
            assert_eq!((by_a.poses[0].counts, by_b.poses[0].counts), (true, false), "{step}");
            notes.extend(by_b.notes);
        }
        let after_silence = tracked.take(1, &received(at(1.5), 2_000)).unwrap();

        assert_eq!(
            notes,
            [
                "robot_1 is seen 0.50 m apart by /a/robot_1, which counts, and by /b/robot_1: calibrate \
              the tracker's machines"
            ]
        );
        assert!(after_silence.poses[0].counts);
    }
}
