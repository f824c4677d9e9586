//! How the tracker of a fleet publishes, as a fleet file states it.

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::{Axes, Carries, InvalidTracker, Names, Tracker, TrackerFrame};

/// How a tracker publishes where robots are, as a person writes it: what a robot has overrides what its
/// type has, key by key, which overrides what `all` has.
#[derive(Clone, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenTracker {
    /// Topics with poses, one for each machine; of several that see a robot, the one with the freshest
    /// pose counts. With `pose: odom` and `pose: pose` they are below each robot's name, or have
    /// `{body}` in them, which stands for what the tracker calls it: `/vrpn_mocap/{body}/pose` (default:
    /// `odom`, `pose` or `/poses`).
    topics: Option<Vec<String>>,
    /// With `pose: pose_array`: what the poses in a message are of, in their order; not all of them have
    /// to be robots.
    names: Option<Vec<String>>,
    /// With `pose: tf`: the frame up to which transforms are followed (default: the uppermost).
    parent: Option<String>,
    /// Where the tracker's origin is on the floor, x and y in metres (default: at its origin).
    offset_m: Option<[f64; 2]>,
    /// By how much the tracker's frame is turned on the floor, counterclockwise, in radians (default: 0).
    rotation_rad: Option<f64>,
    /// Metres in one of the tracker's units: 0.001 for millimetres (default: 1).
    scale: Option<f64>,
    /// Which of the tracker's axes are the floor's x, y and up: `[x, -z, y]` for a tracker with y up
    /// (default: `[x, y, z]`).
    axes: Option<Axes>,
}

/// The tracker that the layers of a robot describe, the first of which counts most.
pub(super) fn resolved(layers: [&Option<WrittenTracker>; 3]) -> Tracker {
    let layers = layers.map(Option::as_ref);
    let frame = TrackerFrame::default();
    Tracker {
        topics: first(layers, |it| it.topics.clone()).unwrap_or_default(),
        names: first(layers, |it| it.names.clone()).unwrap_or_default(),
        bodies: std::collections::BTreeMap::new(),
        parent: first(layers, |it| it.parent.clone()),
        frame: TrackerFrame {
            offset_m: first(layers, |it| it.offset_m).unwrap_or(frame.offset_m),
            rotation_rad: first(layers, |it| it.rotation_rad).unwrap_or(frame.rotation_rad),
            scale: first(layers, |it| it.scale).unwrap_or(frame.scale),
            axes: first(layers, |it| it.axes).unwrap_or(frame.axes),
        },
    }
}

fn first<T>(
    layers: [Option<&WrittenTracker>; 3],
    key: impl Fn(&WrittenTracker) -> Option<T>,
) -> Option<T> {
    layers.into_iter().flatten().find_map(key)
}

/// Looks whether a tracker fits where poses come from.
pub(super) fn check(tracker: &Tracker, source: PoseSource) -> Result<(), InvalidTracker> {
    let (carries, names) = match source {
        PoseSource::Odom | PoseSource::Pose => (Carries::OneRobot, Names::InTheMessage),
        PoseSource::NamedPoses => (Carries::AllBodies, Names::InTheMessage),
        PoseSource::PoseArray => (Carries::AllBodies, Names::InTheFile),
        PoseSource::Tf => (Carries::Transforms, Names::InTheMessage),
    };
    tracker.check(carries, names)
}
