//! How a run ends.

use crate::message::{E_STOP_REASON, OTHER_RUNNER, RobotState};
use crate::timing::NODE_TIMEOUT;

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

/// Why a run is stopped before its end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AbortCause {
    /// The e-stop is engaged.
    #[error("{E_STOP_REASON}")]
    EStop,
    /// Another runner publishes leases.
    #[error("{OTHER_RUNNER}, run {run_id}")]
    OtherRunner {
        /// Its run.
        run_id: String,
    },
    /// A robot obeys an epoch that this runner has not made.
    #[error("a robot obeys epoch {found}, expected at most {expected}: another runner has it")]
    HigherEpoch {
        /// The robot's epoch.
        found: u64,
        /// The run's.
        expected: u64,
    },
    /// A robot waits for the start of another run in the same epoch.
    #[error("a robot is armed for run {run_id}: another runner has it")]
    ArmedForAnother {
        /// That run.
        run_id: String,
    },
    /// Robots were lost, and the experiment wants the run to end then.
    #[error("lost {}", by_reason.join("; "))]
    LostRobots {
        /// What is wrong, each time with the robots of which it is.
        by_reason: Vec<String>,
    },
    /// No robot is left.
    #[error("lost every robot")]
    LostAll,
    /// A node began to publish what only one may.
    #[error("a second publisher of {topic}: node {node}")]
    SecondPublisher {
        /// The topic.
        topic: String,
        /// The node.
        node: String,
    },
    /// A program whose node is not known began to publish what only one may.
    #[error("a second publisher of {topic}, of a node that does not state its name")]
    UnnamedPublisher {
        /// The topic.
        topic: String,
    },
    /// Someone wanted it to end, or nothing can be sent any more.
    #[error("{reason}")]
    Interrupted {
        /// Why.
        reason: String,
    },
}

/// Why a robot is lost in a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LossCause {
    /// Nothing is received of it.
    #[error("silent for more than {} s", NODE_TIMEOUT.as_secs())]
    Silent,
    /// It reports something else than that it moves in this run.
    #[error("{state} in epoch {epoch}: {reason}")]
    NotMoving {
        /// What it reports.
        state: RobotState,
        /// The epoch that it obeys.
        epoch: u64,
        /// Its reason.
        reason: String,
    },
    /// Its samples come no more.
    #[error("no {kind} received for more than {silence_s} s")]
    NoSample {
        /// What does not come.
        kind: SampleKind,
        /// For how long, in seconds.
        silence_s: u64,
    },
    /// It left the floor of the fleet file.
    #[error("left the geofence, at ({x_m:.2}, {y_m:.2}) m")]
    LeftGeofence {
        /// Where it is, in metres.
        x_m: f64,
        /// Where it is, in metres.
        y_m: f64,
    },
    /// Its link works and fails by turns.
    #[error("stood for {stood_s:.1} s in all, as no lease reached it")]
    StoodTooLong {
        /// How long, in seconds.
        stood_s: f64,
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
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SampleKind {
    /// What its sensor detects; of several sensors the first.
    Detection,
    /// What a further sensor reports, by its name.
    FurtherDetection(String),
    /// Where it is.
    Pose,
}

impl std::fmt::Display for SampleKind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Detection => formatter.write_str("detection"),
            Self::FurtherDetection(name) => write!(formatter, "detection/{name}"),
            Self::Pose => formatter.write_str("pose"),
        }
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
