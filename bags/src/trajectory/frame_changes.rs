//! Which frame poses were in, and when another one.

use super::transforms::plain;

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

    /// The frames of the poses between two log times, in nanoseconds, both included.
    pub fn between(&self, start_ns: u64, end_ns: u64) -> impl Iterator<Item = &str> {
        let first = self.0.partition_point(|(log_ns, _)| *log_ns <= start_ns);
        let frames = self.0[first.saturating_sub(1)..].iter();
        frames.take_while(move |(log_ns, _)| *log_ns <= end_ns).map(|(_, frame)| frame.as_str())
    }
}
