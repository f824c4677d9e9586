//! Why a bag gives no trajectory.

use rsrs_core::help::Help;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::cdr::CdrError;

use super::needed::Needed;
use crate::{BagError, Damage};

/// Why a bag gives no trajectory. Times are in seconds, on the clock of the pose stamps.
#[expect(missing_docs, reason = "fields are what the message names")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// The bag itself does not read.
    #[error("cannot read the bag")]
    Bag(#[from] BagError),
    /// The bag is not as it was written, or breaks off.
    #[error("{}", damaged(.0))]
    Damaged(Damage),
    /// No topic of the bag has poses.
    #[error("the bag has no poses: {} among its topics: {}", wanted(*.asked), list(.topics))]
    NoPoses { asked: Option<PoseSource>, topics: Vec<String> },
    /// The recorder has received nothing.
    #[error("the bag has no messages; topics in it: {n_topics}")]
    NoMessages { n_topics: usize },
    /// There are topics for poses, and nothing was recorded on them.
    #[error("the bag has no poses: there is no message on {}", list(.topics))]
    SilentPoses { topics: Vec<String> },
    /// A robot has poses and no commands.
    #[error("robot {robot} has poses and no commands: expected {expected} among the topics: {}", list(.topics))]
    NoCommands { robot: String, expected: String, topics: Vec<String> },
    /// One topic was recorded with two types.
    #[error("topic {topic} was recorded with the types {}", list(.types))]
    TwoTypes { topic: String, types: Vec<String> },
    /// A message does not decode as its type.
    #[error("a message on {topic} at {time_s:.3} s of log time does not decode")]
    Message { topic: String, time_s: f64, source: CdrError },
    /// A pose or command with NaN or infinity in it.
    #[error("{what} of robot {robot} at {time_s:.3} s is not a number")]
    NotFinite { what: &'static str, robot: String, time_s: f64 },
    /// An orientation that is no rotation.
    #[error("orientation of robot {robot} at {time_s:.3} s has length {length:.3}, expected 1")]
    NoOrientation { robot: String, time_s: f64, length: f64 },
    /// The poses of two robots are in different frames, or those of one at different times.
    #[error("poses of robot {robot} are in frame {found:?}, others in {expected:?}")]
    Frames { robot: String, found: String, expected: String },
    /// Robots of the run have no poses.
    #[error("robots of the run without poses: {}", list(.robots))]
    MissingRobots { robots: Vec<String> },
    /// Poses without names, and not as many as robots.
    #[error("{topic} has {n_poses} poses without names for {n_robots} robots")]
    Unnamed { topic: String, n_poses: usize, n_robots: usize },
    /// A tracker's message that gives no poses.
    #[error("a message on {topic} at {time_s:.3} s of log time cannot be used: {reason}")]
    OfTracker { topic: String, time_s: f64, reason: UnreadablePoses },
    /// The bag has nothing of the tracker that its record describes.
    #[error(
        "the bag has no poses of its tracker: expected {}, among its topics: {}",
        list(.expected), list(.topics)
    )]
    NoTracker { expected: Vec<String>, topics: Vec<String> },
    /// A message of a known name with other fields.
    #[error("the poses on {topic} have the fields {}, expected string name, geometry_msgs/Pose pose", list(.found))]
    Layout { topic: String, found: Vec<String> },
    /// The stamps of a robot's poses go back.
    #[error("the stamps of robot {robot} go back by {by_s:.3} s at {time_s:.3} s")]
    ClockBackwards { robot: String, time_s: f64, by_s: f64 },
    /// A robot was where it cannot have gone.
    #[error(
        "robot {robot} jumped by {distance_m:.2} m at {time_s:.3} s, expected at most {limit_m:.2} m, and no exchange of robots explains it"
    )]
    Jump { robot: String, time_s: f64, distance_m: f64, limit_m: f64 },
    /// Too many poses of a robot are missing.
    #[error(
        "{:.0} % of the poses of robot {robot} are missing{needed}, up to {longest_s:.2} s at a time, expected at most {:.0} %",
        .share * 100.0, .limit * 100.0
    )]
    TooManyMissing { robot: String, share: f64, limit: f64, longest_s: f64, needed: Needed },
    /// The lease was recorded and was never RUNNING.
    #[error("the run lease in the bag is never RUNNING")]
    NeverRunning,
    /// There is no lease and no command was anything but zero.
    #[error("no robot was ever commanded to move")]
    NeverCommanded,
    /// A robot has fewer than two poses in the running time.
    #[error("robot {robot} has {n_samples} poses while the swarm was running, expected at least 2")]
    TooFewPoses { robot: String, n_samples: usize },
    /// Two poses of one robot at the same time.
    #[error(
        "robot {robot} has poses {distance_s:.4} s apart at {time_s:.3} s, expected about {period_s:.4} s: two publishers on one topic?"
    )]
    TooClose { robot: String, time_s: f64, distance_s: f64, period_s: f64 },
    /// Poses of a robot are missing for too long where it is judged; times since the start of the
    /// trajectory.
    #[error(
        "robot {robot} has no pose from {from_s:.2} s to {to_s:.2} s{needed}, expected gaps of at most {limit_s} s there"
    )]
    Gap { robot: String, from_s: f64, to_s: f64, limit_s: f64, needed: Needed },
    /// A robot came late or left early.
    #[error(
        "robot {robot} has poses from {first_s:.3} s to {last_s:.3} s, the others from {expected_first_s:.3} s to {expected_last_s:.3} s"
    )]
    Span { robot: String, first_s: f64, last_s: f64, expected_first_s: f64, expected_last_s: f64 },
    /// A robot's poses end before the run does.
    #[error(
        "robot {robot} has no pose after {last_s:.1} s of {end_s:.1} s: a run is judged by its end"
    )]
    EndsEarly { robot: String, last_s: f64, end_s: f64 },
    /// Robots start where no two bodies have room.
    #[error(
        "robots {} start on one spot, ({x_m:.2} m, {y_m:.2} m): each has poses in a frame of its own?",
        list(.robots)
    )]
    OneSpot { robots: Vec<String>, x_m: f64, y_m: f64 },
    /// The stamps of a robot's poses come from a clock that was set, or is of another rate.
    #[error(
        "the stamps of robot {robot} move by {by_s:.3} s against those of the others during the run"
    )]
    Clocks { robot: String, by_s: f64 },
}

/// Why a message gives no poses.
#[derive(Debug, thiserror::Error)]
pub enum UnreadablePoses {
    /// It is damaged, or of another type.
    #[error("it does not decode")]
    Damaged(#[from] CdrError),
    /// Nothing tells any more which pose is whose.
    #[error(
        "it has {found} poses, expected {expected}: without names, only their number and order tell \
         whose they are"
    )]
    Length {
        /// Poses in it.
        found: usize,
        /// Names in the fleet file, or poses in the first message.
        expected: usize,
    },
    /// Two bodies of one name.
    #[error("it has `{name}` twice")]
    Twice {
        /// The name.
        name: String,
    },
}

impl Help for TrajectoryError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Bag(error) => return error.help(),
            Self::NoMessages { .. } => {
                "record it again: the recorder must run in the network of the robots, while they do"
            }
            Self::NoPoses { .. } | Self::SilentPoses { .. } | Self::NoCommands { .. } => {
                "the judge needs poses and commands: record /<robot>/odom, or a tracker's \
                 /<robot>/pose, and /<robot>/cmd_vel; or judge the run by eye: `rsrs label BAG --as \
                 PHASE --by WHO`"
            }
            Self::Frames { .. } => {
                "poses must be in one frame: take those of a tracker with `--poses pose`, or, if frames \
                 are tied together on /tf and /tf_static, the transforms with `--poses tf`"
            }
            Self::MissingRobots { .. } => {
                "record the poses of every robot, or take another source with `--poses`"
            }
            Self::TooClose { .. } => {
                "give every robot a name of its own, and one source of poses, and record the run again"
            }
            Self::Damaged(_) => {
                "save what can be saved with `rsrs bag recover BAG`, and read the bag that it writes"
            }
            Self::EndsEarly { .. } => {
                "judge the run by eye: `rsrs label BAG --as PHASE --by WHO`, or run it again"
            }
            Self::OneSpot { .. } => {
                "poses must be in one frame, with z up: record those of a tracker, or the transforms from \
                 one `map` to each robot's odometry on /tf and /tf_static, and take them with `--poses`"
            }
            Self::ClockBackwards { .. } | Self::Clocks { .. } => {
                "a clock was set during the run: keep clocks with chrony, and record the run again; or \
                 judge it by eye: `rsrs label BAG --as PHASE --by WHO`"
            }
            Self::TwoTypes { .. }
            | Self::Message { .. }
            | Self::Layout { .. }
            | Self::OfTracker { reason: UnreadablePoses::Damaged(_), .. } => {
                "what was recorded is not of its type: look which program published it"
            }
            Self::NoTracker { .. }
            | Self::NotFinite { .. }
            | Self::NoOrientation { .. }
            | Self::Jump { .. }
            | Self::TooManyMissing { .. }
            | Self::Gap { .. }
            | Self::Span { .. } => {
                "take another source of poses with `--poses`, or judge the run by eye instead: `rsrs \
                 label BAG --as PHASE --by WHO`"
            }
            Self::NeverRunning | Self::NeverCommanded | Self::TooFewPoses { .. } => {
                "there is no run in this bag to be judged"
            }
            Self::OfTracker { .. } | Self::Unnamed { .. } => {
                "let the tracker name its robots, or take another source with `--poses`"
            }
        };
        Some(help.to_owned())
    }
}

/// What was looked for.
fn wanted(asked: Option<PoseSource>) -> &'static str {
    match asked {
        None => "expected /<robot>/odom, /<robot>/pose, /poses or /tf",
        Some(PoseSource::Odom) => "expected nav_msgs/msg/Odometry on /<robot>/odom",
        Some(PoseSource::Pose) => "expected geometry_msgs/msg/PoseStamped on /<robot>/pose",
        Some(PoseSource::NamedPoses) => {
            "expected a topic of motion_capture_tracking_interfaces/msg/NamedPoseArray"
        }
        Some(PoseSource::PoseArray) => "expected a topic of geometry_msgs/msg/PoseArray",
        Some(PoseSource::Tf) => "expected transforms to <robot>/base_link on /tf",
    }
}

/// Names one after the other, or that there are none.
fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Where a bag is not as it was written.
fn damaged(damage: &Damage) -> String {
    let Damage { path, n_messages, last_log_time_ns, at_byte, is_end, reason } = damage;
    let what = if *is_end { "breaks off" } else { "is damaged" };
    let last = last_log_time_ns.map_or_else(String::new, |time_ns| {
        format!(", the last one at {:.1} s of log time", time_ns as f64 / 1e9)
    });
    let path = path.display();
    format!(
        "{path} {what} at byte {at_byte} ({reason}); {n_messages} messages came before it{last}"
    )
}
