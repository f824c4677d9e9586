//! The frames of poses that each robot has by itself: without one frame for all of them, their places
//! do not belong together.

use super::TrajectoryError;
use super::collect::RecordedRobot;
use super::finding::Finding;
use super::frame_changes::FrameChanges;
use super::objects::RecordedObject;
use super::window::RunningWindow;

/// The frames of poses while the swarm is running.
fn within<'a>(frames: &'a FrameChanges, window: &RunningWindow) -> impl Iterator<Item = &'a str> {
    frames.between(window.start_ns, window.end_ns)
}

/// Refuses robots whose poses are in different frames while the swarm is running.
pub fn check(robots: &[RecordedRobot], window: &RunningWindow) -> Result<(), TrajectoryError> {
    let frames = || {
        let of_robot = |robot: &'_ RecordedRobot| {
            let frames: Vec<String> = within(&robot.frames, window).map(str::to_owned).collect();
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
    robots.iter().find_map(|robot| within(&robot.frames, window).next())
}

/// The first object that has a pose in another frame than the robots while the swarm is running.
pub fn other_frame(
    objects: &[RecordedObject],
    expected: &str,
    window: &RunningWindow,
) -> Option<Finding> {
    let other = |object: &RecordedObject| {
        let found = within(&object.frames, window).find(|frame| *frame != expected)?.to_owned();
        let (object, expected) = (object.name.clone(), expected.to_owned());
        Some(Finding::ObjectFrame { object, found, expected })
    };
    objects.iter().find_map(other)
}
