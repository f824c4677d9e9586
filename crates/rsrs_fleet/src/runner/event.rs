//! The orders to a runner, its events and its actions.

use std::collections::BTreeSet;
use std::time::Duration;

use rsrs_core::judge::window::Window;
use rsrs_core::robot::controller::{Command, Controller, Reaction};
use rsrs_core::robot::unicycle::Pose;

use super::{MotionCheck, Outcome, SampleKind, Target};
use crate::e_stop::Message;
use crate::experiment::RobotLost;
use crate::message::{Lease, Status};
use crate::parameters::GateSettings;
use crate::placement::{PlaceCheck, WantedStart};
use crate::preflight::{Expected, Graph};

/// What a runner is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct RunnerOptions {
    /// Names the run; no two runs share it.
    pub run_id: String,
    /// What must be there; its robots are the robots of the run.
    pub expected: Expected,
    /// What every controller is set to.
    pub controller: Controller,
    /// Whether controllers decide by their sensors; in a trial they do not.
    pub reaction: Reaction,
    /// Digest of the world that the simulator must have placed
    /// ([`crate::simulator::placement_digest`]); unused without a simulator.
    pub simulator_digest: u64,
    /// When the run is complete.
    pub length: RunLength,
    /// What to do when a robot is lost.
    pub robot_lost: RobotLost,
    /// Which time of the run is judged.
    pub judged: Window,
    /// How long all robots stand armed before they move, while the operator sees a countdown; zero
    /// where no person stands beside them.
    pub countdown: Duration,
    /// Where the robots should stand at the start; `None` if that need not be checked.
    pub start: Option<WantedStart>,
    /// What to do where they do not: with `Require` no robot moves, else it is noted. Whether it is looked
    /// at is up to `start`.
    pub place_check: PlaceCheck,
    /// What must keep coming from every robot while it moves; nothing in lockstep, where the
    /// simulator steps only when all is there.
    pub samples: BTreeSet<SampleKind>,
    /// What poses are held against, while robots move; `None` where the simulator moves all of them.
    pub motion: Option<MotionCheck>,
}

impl RunnerOptions {
    /// Digest that every controller must have.
    pub(super) fn controller_digest(&self) -> u64 {
        self.controller.digest_with(self.reaction)
    }
}

/// When a run is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunLength {
    /// When the simulator has made these steps and the recorder has taken them all.
    Lockstep {
        /// Steps.
        steps: u64,
    },
    /// When this much wall-clock time has passed.
    RealTime {
        /// The time.
        duration: Duration,
    },
}

/// What happens to a runner.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The discovery database as it is now.
    Seen(Graph),
    /// The status of a robot.
    RobotStatus {
        /// The robot.
        robot: String,
        /// The status.
        status: Status,
    },
    /// The status of a controller.
    ControllerStatus {
        /// Its robot.
        robot: String,
        /// The status.
        status: Status,
    },
    /// A robot's status was stamped with this much more than our wall clock when it came.
    ClockAhead {
        /// The robot.
        robot: String,
        /// Its lead, in seconds; negative behind ours, as a slow network makes it.
        seconds: f64,
    },
    /// A message waited this long on this machine, from when it was sent here until it was looked at
    /// here.
    Behind {
        /// The wait, in seconds.
        seconds: f64,
    },
    /// A robot's diagnostics reported on a part.
    Diagnosed {
        /// The robot.
        robot: String,
        /// The part, as the diagnostics name it.
        part: String,
        /// The diagnosis, if it is an error.
        error: Option<String>,
    },
    /// A robot's pose was stamped with this much more than our wall clock when it came.
    PoseAhead {
        /// The robot.
        robot: String,
        /// The lead of the clock of its publisher, in seconds.
        seconds: f64,
    },
    /// A robot's pose was received.
    Pose {
        /// The robot.
        robot: String,
        /// The frame in which it stands there.
        frame: String,
        /// Where it stands.
        pose: Pose,
    },
    /// A robot's pose was received that cannot be used.
    PoseUnusable {
        /// The robot.
        robot: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A sample that must keep coming was received.
    Sampled {
        /// The robot that it is of.
        robot: String,
        /// What it is.
        kind: SampleKind,
    },
    /// A velocity command was sent to a robot.
    Commanded {
        /// The robot.
        robot: String,
        /// The command.
        command: Command,
    },
    /// A request to set parameters was answered.
    ParametersSet {
        /// Who answered.
        target: Target,
        /// Why not, if not.
        result: Result<(), String>,
    },
    /// A request to read parameters was answered.
    ReadBack {
        /// Who answered.
        target: Target,
        /// Digest of the parameters, or why there is none.
        result: Result<u64, String>,
    },
    /// The settings of a robot's gate were read.
    GateRead {
        /// The robot.
        robot: String,
        /// What they are; `None` if no gate of ours answers.
        found: Option<GateSettings>,
    },
    /// The recorder receives every topic.
    RecorderReady,
    /// The recorder has taken every topic up to this step.
    Recorded {
        /// The step.
        step: u64,
    },
    /// The recorder cannot go on.
    RecorderFailed {
        /// Why.
        reason: String,
    },
    /// The bag is being closed.
    RecorderCloses {
        /// What was done so far, in steps of any size: as long as it grows, something is written.
        done: u64,
        /// Bytes that are still to be written.
        left_bytes: u64,
    },
    /// The bag is closed.
    RecorderClosed,
    /// A simulator reported: whether it has made all steps, or the run does not count. Any simulator
    /// may be in the network.
    SimulatorStatus(Status),
    /// A lease was received, of any runner.
    LeaseReceived(Lease),
    /// A message on one of the e-stop's topics.
    EStop(Message),
    /// A frame is fixed to, or moves in, another one.
    Transform {
        /// The frame.
        child: String,
        /// The one that it is in.
        parent: String,
    },
    /// Someone wants the run to end now.
    Interrupt {
        /// Why.
        reason: String,
    },
    /// Time passed.
    Tick,
}

impl Event {
    /// Whether it only adds to the state of the robots.
    pub(super) fn is_a_word(&self) -> bool {
        match self {
            Self::RobotStatus { .. }
            | Self::ControllerStatus { .. }
            | Self::ClockAhead { .. }
            | Self::Behind { .. }
            | Self::Diagnosed { .. }
            | Self::Pose { .. }
            | Self::PoseUnusable { .. }
            | Self::PoseAhead { .. }
            | Self::Transform { .. }
            | Self::Commanded { .. }
            | Self::Sampled { .. } => true,
            Self::Seen(_)
            | Self::ParametersSet { .. }
            | Self::ReadBack { .. }
            | Self::GateRead { .. }
            | Self::RecorderReady
            | Self::Recorded { .. }
            | Self::RecorderFailed { .. }
            | Self::RecorderCloses { .. }
            | Self::RecorderClosed
            | Self::SimulatorStatus(_)
            | Self::LeaseReceived(_)
            | Self::EStop(_)
            | Self::Interrupt { .. }
            | Self::Tick => false,
        }
    }
}

/// What a runner does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Publish a lease.
    PublishLease(Lease),
    /// Set all parameters of a target at once: a robot's to [`RunnerOptions::controller`].
    Configure(Target),
    /// Read the parameters of a target and digest them.
    ReadBack(Target),
    /// Read what the gate of a robot is set to.
    ReadGate(String),
    /// Open the bag and subscribe to every topic.
    OpenRecorder,
    /// Drain and close the bag.
    CloseRecorder,
    /// Show the operator a note.
    Note(String),
    /// The run is over; nothing more comes.
    Finish {
        /// How it ended.
        outcome: Outcome,
        /// Robots that did not report that they stand; someone should go and look.
        not_standing: Vec<String>,
    },
}
