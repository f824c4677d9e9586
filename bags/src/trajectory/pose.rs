//! Poses on the floor out of the messages that carry them.

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::tracker::TrackerFrame;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{NoOrientation, Point, Pose as Pose3, Quaternion, Vector3};
use rsrs_msgs::std_msgs::Header;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;

use super::TrajectoryError;
use crate::TopicInfo;

/// Frames that stand for the robot's body, by REP 105.
const BODY_FRAMES: [&str; 2] = ["/base_link", "/base_footprint"];

/// One robot's pose at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSample {
    /// The stamp in the message, in nanoseconds; 0 where there is none, until
    /// [`fill_missing_stamps`].
    pub stamp_ns: u64,
    /// When it was recorded, in nanoseconds.
    pub log_ns: u64,
    pub pose: Pose,
}

/// A pose as it is in a message.
#[derive(Clone, Debug, PartialEq)]
pub struct RawPose {
    /// Whose it is.
    pub robot: String,
    /// The frame that the message names, or the one at the upper end of the transforms.
    pub frame: String,
    /// As the message has it.
    pub stamp: Time,
    /// In that frame, in the tracker's units.
    pub position: Vector3,
    /// In that frame.
    pub orientation: Quaternion,
}

/// The robot whose poses a topic has, if it has some.
pub fn robot_of_topic(topic: &TopicInfo, source: PoseSource) -> Option<String> {
    let known = match source {
        PoseSource::Odom => topics::ODOM,
        PoseSource::Pose => topics::POSE,
        PoseSource::Tf | PoseSource::NamedPoses | PoseSource::PoseArray => return None,
    };
    (topic.type_name == known.type_name).then(|| robot_of(&topic.name, known)).flatten()
}

/// The robot whose topic of this kind has the name, if it is one.
pub fn robot_of(name: &str, known: topics::Topic) -> Option<String> {
    known.robot_of(name).map(str::to_owned)
}

/// The pose of a robot in a message.
pub fn of_message(robot: String, header: &Header, pose: Pose3) -> RawPose {
    let Point { x, y, z } = pose.position;
    RawPose {
        robot,
        frame: header.frame_id.clone(),
        stamp: header.stamp,
        position: Vector3 { x, y, z },
        orientation: pose.orientation,
    }
}

/// The robot whose body a frame is.
pub fn robot_of_frame(frame: &str) -> Option<String> {
    BODY_FRAMES.iter().find_map(|body| frame.strip_suffix(body)).map(str::to_owned)
}

/// The frames that are the body of a robot, unless it is known to be another one.
pub fn frames_of_robot(robot: &str) -> [String; 2] {
    BODY_FRAMES.map(|body| format!("{robot}{body}"))
}

/// The poses of robots' bodies among some transforms; `robot_of` a frame is the robot whose body it
/// is.
pub fn of_transforms(
    message: TFMessage,
    robot_of: &dyn Fn(&str) -> Option<String>,
) -> Vec<RawPose> {
    let bodies = message.transforms.into_iter().filter_map(|transform| {
        let robot = robot_of(transform.child_frame_id.trim_start_matches('/'))?;
        Some(RawPose {
            robot,
            frame: transform.header.frame_id,
            stamp: transform.header.stamp,
            position: transform.transform.translation,
            orientation: transform.transform.rotation,
        })
    });
    bodies.collect()
}

impl RawPose {
    /// The same with its vectors along the floor's axes.
    pub(super) fn upright(mut self, frame: &TrackerFrame) -> Self {
        let Vector3 { x, y, z } = self.position;
        let [x, y, z] = frame.upright([x, y, z]);
        self.position = Vector3 { x, y, z };
        let Quaternion { x, y, z, w } = self.orientation;
        let [x, y, z] = frame.upright([x, y, z]);
        self.orientation = Quaternion { x, y, z, w };
        self
    }

    /// Whether a tracker sees it: what it lost is NaN.
    pub(super) fn is_seen(&self) -> bool {
        let Quaternion { x, y, z, w } = self.orientation;
        [self.position.x, self.position.y, x, y, z, w].iter().all(|number| number.is_finite())
    }

    /// The pose alone, as a message has it.
    pub fn pose(&self) -> Pose3 {
        let Vector3 { x, y, z } = self.position;
        Pose3 { position: Point { x, y, z }, orientation: self.orientation }
    }

    /// The pose on the floor.
    pub fn sample(self, log_ns: u64) -> Result<PoseSample, TrajectoryError> {
        let stamp_ns = self.stamp.to_nanos().unwrap_or(0);
        let time_s = if stamp_ns == 0 { log_ns } else { stamp_ns } as f64 / 1e9;
        let Quaternion { x, y, z, w } = self.orientation;
        let (x_m, y_m) = (self.position.x, self.position.y);
        if ![x_m, y_m, x, y, z, w].iter().all(|number| number.is_finite()) {
            return Err(TrajectoryError::NotFinite { what: "pose", robot: self.robot, time_s });
        }
        let heading_rad = self.orientation.heading_rad().map_err(|NoOrientation { length }| {
            TrajectoryError::NoOrientation { robot: self.robot, time_s, length }
        })?;
        Ok(PoseSample { stamp_ns, log_ns, pose: Pose { x_m, y_m, heading_rad } })
    }
}

/// Gives poses their log time if none of them has a stamp.
///
/// A single stamp of zero is a time: that at which a simulation starts.
pub fn fill_missing_stamps(poses: &mut [PoseSample]) {
    if poses.iter().all(|pose| pose.stamp_ns == 0) {
        for pose in poses {
            pose.stamp_ns = pose.log_ns;
        }
    }
}

#[cfg(test)]
mod tests {
    use rsrs_msgs::geometry_msgs::{PoseStamped, Transform, TransformStamped};

    use super::*;

    fn tracked(orientation: Quaternion) -> RawPose {
        let mut message = PoseStamped::default();
        message.pose.orientation = orientation;
        of_message("robot_1".to_owned(), &message.header, message.pose)
    }

    #[test]
    fn the_heading_is_the_turn_about_the_vertical_axis() {
        for heading_rad in [-3.0, -0.5, 0.0, 1.0, 3.1] {
            let (z, w) = (libm::sin(heading_rad / 2.0), libm::cos(heading_rad / 2.0));

            let sample = tracked(Quaternion { x: 0.0, y: 0.0, z, w }).sample(7).unwrap();

            assert!((sample.pose.heading_rad - heading_rad).abs() < 1e-12, "{heading_rad} rad");
        }
    }

    #[test]
    fn poses_without_stamps_get_their_log_times_and_a_simulation_starts_at_zero() {
        let sample = |stamp_ns, log_ns| PoseSample {
            stamp_ns,
            ..tracked(Quaternion::default()).sample(log_ns).unwrap()
        };
        let mut unstamped = [sample(0, 7), sample(0, 8)];
        let mut simulated = [sample(0, 7), sample(1, 8)];

        fill_missing_stamps(&mut unstamped);
        fill_missing_stamps(&mut simulated);

        assert_eq!(unstamped.map(|pose| pose.stamp_ns), [7, 8]);
        assert_eq!(simulated.map(|pose| pose.stamp_ns), [0, 1]);
    }

    #[test]
    fn an_orientation_that_was_never_set_is_refused() {
        let error = tracked(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 }).sample(7).unwrap_err();

        assert!(matches!(error, TrajectoryError::NoOrientation { .. }), "{error}");
    }

    #[test]
    fn only_bodies_of_robots_are_taken_from_the_transforms() {
        let edge = |child: &str| TransformStamped {
            header: Header { frame_id: "map".into(), ..Header::default() },
            child_frame_id: child.into(),
            transform: Transform::default(),
        };
        let transforms = ["robot_1/base_link", "/robot_2/base_footprint", "robot_1/camera"];

        let message = TFMessage { transforms: transforms.map(edge).to_vec() };
        let poses = of_transforms(message, &robot_of_frame);

        let robots: Vec<&str> = poses.iter().map(|pose| pose.robot.as_str()).collect();
        assert_eq!(robots, ["robot_1", "robot_2"]);
    }

    #[test]
    fn a_robot_is_the_whole_namespace_before_the_topic() {
        let robot = |name| robot_of(name, topics::ODOM);

        assert_eq!(robot("/robot_1/odom").as_deref(), Some("robot_1"));
        assert_eq!(robot("/lab/robot_1/odom").as_deref(), Some("lab/robot_1"));
        assert_eq!(robot("/odom"), None);
        assert_eq!(robot("/robot_1/modem_odom"), None);
    }
}
