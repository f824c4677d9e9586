//! What was mended on the way from a bag to a trajectory, and what else is to be known of it.

use std::fmt;

use rsrs_core::judge::window::MAX_GAP_S;
use rsrs_core::robot::pose_source::PoseSource;
use serde::Serialize;

/// Something in a bag that the trajectory does not show. Times are in seconds, on the
/// clock of the pose stamps.
#[expect(missing_docs, reason = "fields are what the message names")]
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Finding {
    /// Poses came at other times than the trajectory's, and were interpolated.
    Resampled { recorded_s: f64, period_s: f64 },
    /// Poses of a robot were missing here and there, and were interpolated.
    Missing { robot: String, share: f64, longest_s: f64 },
    /// There was no pose of a robot for so long, counted from the start of the trajectory; it is
    /// interpolated on a straight line.
    Gap { robot: String, from_s: f64, to_s: f64, is_judged: bool },
    /// Single poses far away from those before and behind were left out.
    Outliers { robot: String, n_poses: usize },
    /// The tracker took robots for one another; their poses were exchanged back.
    Swap { robots: Vec<String>, time_s: f64 },
    /// A robot had poses only later than the others; what was before is left out.
    LateStart { robot: String, by_s: f64 },
    /// A robot had no poses at the end; what was after it is left out.
    EarlyEnd { robot: String, by_s: f64 },
    /// Stamps came from several clocks; all were put on that of the recorder.
    Clocks { least_s: f64, most_s: f64 },
    /// Something has poses and is no robot of this run.
    Ignored { name: String },
    /// An object was not seen for too long, so that nothing is known of where objects were.
    LostObject { object: String, time_s: f64 },
    /// An object has poses in another frame than the robots, so that nothing is known of where objects were.
    ObjectFrame { object: String, found: String, expected: String },
    /// An object moved further than a robot could push it, so that nothing is known of where objects were.
    ObjectJump { object: String, by_m: f64, in_s: f64, time_s: f64 },
    /// Machines of the tracker saw a robot in two places, up to so far apart.
    Apart { robot: String, by_m: f64, topics: [String; 2] },
    /// Several sources have poses of all robots, and nothing in the bag states which one counts.
    Unstated { taken: PoseSource, others: Vec<PoseSource> },
}

impl Finding {
    /// Whether something was mended, so that the trajectory does not show it any more.
    pub fn is_mended(&self) -> bool {
        !matches!(self, Self::Unstated { .. }) && !self.is_of_objects()
    }

    /// Whether nothing is known of where objects were for it.
    pub fn is_of_objects(&self) -> bool {
        matches!(self, Self::LostObject { .. } | Self::ObjectFrame { .. } | Self::ObjectJump { .. })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Resampled { recorded_s, period_s } => {
                write!(formatter, "poses every {recorded_s:.3} s, resampled to {period_s:.3} s")
            }
            Self::Missing { robot, share, longest_s } => write!(
                formatter,
                "{robot}: {:.1} % of poses missing, at most {longest_s:.2} s at a time, interpolated",
                share * 100.0
            ),
            Self::Gap { robot, from_s, to_s, is_judged } => {
                let when = if *is_judged { "in" } else { "before" };
                write!(
                    formatter,
                    "{robot}: no pose from {from_s:.2} s to {to_s:.2} s, {when} the time that is \
                     judged: interpolated on a straight line"
                )
            }
            Self::Outliers { robot, n_poses } => {
                write!(formatter, "{robot}: {n_poses} poses far from all others, left out")
            }
            Self::Swap { robots, time_s } => {
                write!(formatter, "{} exchanged at {time_s:.2} s, set right", robots.join(" and "))
            }
            Self::LateStart { robot, by_s } => {
                write!(formatter, "{robot}: first pose {by_s:.2} s after the others")
            }
            Self::EarlyEnd { robot, by_s } => {
                write!(formatter, "{robot}: last pose {by_s:.2} s before the others")
            }
            Self::Clocks { least_s, most_s } => write!(
                formatter,
                "stamps of several clocks, {least_s:+.3} s to {most_s:+.3} s off the recorder's: \
                 aligned by log time"
            ),
            Self::Ignored { name } => write!(formatter, "{name}: no robot of this run, ignored"),
            Self::LostObject { object, time_s } => write!(
                formatter,
                "{object} was not seen for more than {MAX_GAP_S} s, {time_s:.1} s after the start: nothing is \
                 made of the poses of objects"
            ),
            Self::ObjectFrame { object, found, expected } => write!(
                formatter,
                "poses of {object} are in the frame `{found}`, and those of robots in `{expected}`: nothing is \
                 made of the poses of objects"
            ),
            Self::ObjectJump { object, by_m, in_s, time_s } => write!(
                formatter,
                "{object} moved by {by_m:.2} m in {in_s:.2} s, {time_s:.1} s after the start, and no robot pushes it \
                 so far: was it carried, taken for another one, or is it in another unit? nothing is made of the \
                 poses of objects"
            ),
            Self::Apart { robot, by_m, topics: [used, other] } => write!(
                formatter,
                "{robot}: up to {by_m:.2} m apart by {used}, which counts, and by {other}: calibrate the \
                 tracker's machines"
            ),
            Self::Unstated { taken, others } => {
                let others: Vec<String> = others.iter().map(ToString::to_string).collect();
                write!(
                    formatter,
                    "poses of {taken} are taken, and nothing states which ones count: there are those \
                     of {}, too (`--poses`)",
                    others.join(", ")
                )
            }
        }
    }
}
