//! The frames of poses that each robot has by itself: without one frame for all of them, their places
//! do not belong together.

use super::TrajectoryError;
use super::collect::RecordedRobot;
use super::finding::Finding;
use super::objects::RecordedObject;
use super::transforms::plain;
use super::window::RunningWindow;

/// The frames that a robot's poses were in, each from the log time on, in nanoseconds, at which it was
/// first named.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameChanges(Vec<(u64, String)>);

impl FrameChanges {
    /// Takes the frame of one more pose.
    pub fn take(&mut self, log_ns: u64, frame: &str) {
        let frame = plain(frame);
        if self.0.last().is_none_or(|(_, last)| last != frame) {
            self.0.push((log_ns, frame.to_owned()));
        }
    }

    /// The frames of the poses within a time.
    fn within(&self, window: &RunningWindow) -> impl Iterator<Item = &str> {
        let first = self.0.partition_point(|(log_ns, _)| *log_ns <= window.start_ns);
        let frames = self.0[first.saturating_sub(1)..].iter();
        frames.take_while(|(log_ns, _)| *log_ns <= window.end_ns).map(|(_, frame)| frame.as_str())
    }
}

/// Refuses robots whose poses are in different frames while the swarm is running.
pub fn check(robots: &[RecordedRobot], window: &RunningWindow) -> Result<(), TrajectoryError> {
    let frames = || {
        let of_robot = |robot: &'_ RecordedRobot| {
            let frames: Vec<String> = robot.frames.within(window).map(str::to_owned).collect();
            frames.into_iter().map(|frame| (robot.name.clone(), frame)).collect::<Vec<_>>()
        };
        robots.iter().flat_map(of_robot)
    };
    let Some((_, expected)) = frames().next() else { return Ok(()) };
    match frames().find(|(_, frame)| *frame != expected) {
        None => Ok(()),
        Some((robot, found)) => Err(TrajectoryError::Frames { robot, found, expected }),
    }
}

/// The first frame of robots' poses while the swarm is running.
pub fn of_robots<'a>(robots: &'a [RecordedRobot], window: &RunningWindow) -> Option<&'a str> {
    robots.iter().find_map(|robot| robot.frames.within(window).next())
}

/// The first object that has a pose in another frame than the robots while the swarm is running.
pub fn other_frame(
    objects: &[RecordedObject],
    expected: &str,
    window: &RunningWindow,
) -> Option<Finding> {
    let other = |object: &RecordedObject| {
        let found = object.frames.within(window).find(|frame| *frame != expected)?.to_owned();
        let (object, expected) = (object.name.clone(), expected.to_owned());
        Some(Finding::ObjectFrame { object, found, expected })
    };
    objects.iter().find_map(other)
}
