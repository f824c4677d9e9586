//! How a run ends.

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// All of it was run and recorded.
    Completed,
    /// It was run, but is no evidence, for a cause that was established before its result.
    Void {
        /// The cause.
        reason: String,
    },
    /// It was stopped before its end.
    Aborted {
        /// Why.
        reason: String,
    },
    /// It could not be started, or not be recorded.
    Failed {
        /// Every problem.
        problems: Vec<Failure>,
    },
}

/// One of the things that a run must have its parameters from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// The controller of a robot.
    Robot(String),
    /// The simulator.
    Simulator,
}

impl std::fmt::Display for Target {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Robot(name) => formatter.write_str(name),
            Self::Simulator => formatter.write_str("simulator"),
        }
    }
}

/// What must keep coming from every robot while it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SampleKind {
    /// What its sensor detects.
    Detection,
    /// Where it is.
    Pose,
}

impl std::fmt::Display for SampleKind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Detection => "detection",
            Self::Pose => "pose",
        })
    }
}

/// One reason for which a run could not be started or recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// Something is missing or wrong before anything is set.
    #[error(transparent)]
    Preflight(#[from] crate::preflight::Problem),
    /// Parameters could not be set.
    #[error("{target}: parameters not set: {reason}")]
    NotSet {
        /// Whose.
        target: Target,
        /// Why.
        reason: String,
    },
    /// Parameters could not be read back, or are not those that were set.
    #[error("{target}: parameters not confirmed: {reason}")]
    NotConfirmed {
        /// Whose.
        target: Target,
        /// Why.
        reason: String,
    },
    /// A robot or controller did not arm.
    #[error("{robot}: did not arm: {found}")]
    NotArmed {
        /// The robot.
        robot: String,
        /// The state that it reports instead.
        found: String,
    },
    /// No pose of a robot was ever received, and a run without them cannot be judged.
    #[error(
        "{robot}: no pose received before the start (`ros2 topic hz` on its topic shows whether \
         any is published)"
    )]
    NoPose {
        /// The robot.
        robot: String,
    },
    /// Nothing of a kind came from a robot since the start, so that nothing of it can have moved it.
    #[error(
        "{robot}: no {kind} received since the start (`ros2 topic hz` on its topic shows whether \
         anything is published)"
    )]
    NoSample {
        /// The robot.
        robot: String,
        /// What did not come.
        kind: SampleKind,
    },
    /// The recorder did not do its work.
    #[error("recorder: {reason}")]
    Recorder {
        /// What went wrong.
        reason: String,
    },
}
