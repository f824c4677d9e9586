//! The reasons not to start a run, in words.

use super::Ailment;
use crate::timing::{CLOCK_SKEW, LEASE};

/// One reason not to start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// No status of a robot.
    #[error("{robot}: no status heard")]
    RobotMissing {
        /// The robot.
        robot: String,
    },
    /// Nobody holds the lease of a robot without a gate.
    #[error(
        "{robot}: nobody holds its lease, expected its controller to (start it with \
         `-p lease:=controller`)"
    )]
    LeaseNotHeld {
        /// The robot.
        robot: String,
    },
    /// No status of a controller.
    #[error("{robot}: no status of its controller heard")]
    ControllerMissing {
        /// The robot.
        robot: String,
    },
    /// No simulator.
    #[error("no simulator discovered")]
    SimulatorMissing,
    /// A topic has another type than expected; the middleware would never match it.
    #[error("{topic}: type is {found}, expected {expected}")]
    WrongType {
        /// The topic.
        topic: String,
        /// The type found.
        found: String,
        /// The type expected.
        expected: String,
    },
    /// A node of a robot waits for another type; it hears nothing.
    #[error("{topic}: {node} waits for {found}, and {expected} is sent")]
    WrongSubscriber {
        /// The topic.
        topic: String,
        /// The node.
        node: String,
        /// The type that it expects.
        found: String,
        /// The type of the topic.
        expected: String,
    },
    /// A topic that was asked for cannot be recorded.
    #[error("{topic}: {reason}")]
    Unrecordable {
        /// The topic.
        topic: String,
        /// Why not.
        reason: String,
    },
    /// A topic that must have one publisher has none.
    #[error("{topic}: nobody publishes it")]
    NoPublisher {
        /// The topic.
        topic: String,
    },
    /// A topic of one robot has several publishers.
    #[error("{topic}: {found} publishers, expected 1 (two robots of one name?)")]
    SeveralPublishers {
        /// The topic.
        topic: String,
        /// Publishers found, of the right type.
        found: usize,
    },
    /// Another runner is at work.
    #[error("another runner is active, run {run_id}")]
    OtherRunner {
        /// Its run.
        run_id: String,
    },
    /// A robot's hardware has failed.
    #[error("{robot}: {reason}")]
    Faulted {
        /// The robot.
        robot: String,
        /// What it says.
        reason: String,
    },
    /// Its battery is low.
    #[error("{robot}: battery at {found_v:.2} V, expected at least {expected_v:.2} V")]
    BatteryLow {
        /// The robot.
        robot: String,
        /// Its voltage, in volts.
        found_v: f64,
        /// The limit in the fleet file, in volts.
        expected_v: f64,
    },
    /// Its battery should be checked, and it does not say how full it is.
    #[error("{robot}: battery unknown, expected at least {expected_v:.2} V")]
    BatteryUnknown {
        /// The robot.
        robot: String,
        /// The limit in the fleet file, in volts.
        expected_v: f64,
    },
    /// Its wall clock is not ours; recorded times would not fit together.
    #[error(
        "{robot}: clock {:.1} s {} ours, expected within {} s",
        ahead_s.abs(),
        if *ahead_s > 0.0 { "ahead of" } else { "behind" },
        CLOCK_SKEW.as_secs()
    )]
    Clock {
        /// The robot.
        robot: String,
        /// How far its clock is ahead, in seconds.
        ahead_s: f64,
    },
    /// The runner's machine does not keep up with what is said; that it hears no robot in time is
    /// not the robots' fault.
    #[error(
        "this machine is too slow: what it hears waits {behind_s:.1} s until it is looked at, \
         expected at most {} s",
        LEASE.as_secs_f64()
    )]
    TooSlow {
        /// The longest wait of the last second, in seconds.
        behind_s: f64,
    },
    /// Its diagnostics report an error.
    #[error("{}: diagnostics: {}: {}", .0.robot, .0.part, .0.message)]
    Ailing(Ailment),
    /// The e-stop holds robots, though nobody may say so any more.
    #[error("the e-stop holds {} (`rsrs stop --release` lets them go)", robots.join(", "))]
    Locked {
        /// The robots.
        robots: Vec<String>,
    },
    /// The e-stop is engaged.
    #[error("the e-stop is engaged")]
    EStop,
}
