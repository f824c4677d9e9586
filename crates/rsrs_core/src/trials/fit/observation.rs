//! A trial as a number: delivered over commanded.

/// One trial, as a gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Position of the robot's name.
    pub robot: usize,
    /// Line of the table.
    pub line: u64,
    /// The command; its sign is the sense of a turn.
    pub command: f64,
    /// Delivered over commanded; dimensionless.
    pub gain: f64,
}
