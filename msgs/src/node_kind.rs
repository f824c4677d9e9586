//! The kinds of nodes that publish and subscribe the topics of a fleet.

use std::fmt;

/// A kind of node, of ours or of another package.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// The node of a robot, with the gate in front of its wheels.
    Robot,
    /// What decides what a robot does.
    Controller,
    /// What moves a robot's wheels, of another package.
    BaseDriver,
    /// What reads a robot's sensor, of another package.
    SensorDriver,
    /// The simulator.
    Simulator,
    /// Who runs and records experiments.
    Runner,
    /// Who stops all robots: `rsrs stop`, an e-stop box.
    Stop,
    /// Who publishes poses.
    Tracker,
    /// Who only watches: `RViz`, Foxglove, `ros2 topic echo`.
    Viewer,
}

impl NodeKind {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Robot,
        Self::Controller,
        Self::BaseDriver,
        Self::SensorDriver,
        Self::Simulator,
        Self::Runner,
        Self::Stop,
        Self::Tracker,
        Self::Viewer,
    ];
}

impl fmt::Display for NodeKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Robot => "robot",
            Self::Controller => "controller",
            Self::BaseDriver => "base driver",
            Self::SensorDriver => "sensor driver",
            Self::Simulator => "simulator",
            Self::Runner => "runner",
            Self::Stop => "e-stop",
            Self::Tracker => "tracker",
            Self::Viewer => "viewer",
        })
    }
}
