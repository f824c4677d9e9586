//! The times of the protocol, each in one place.

use std::time::Duration;

/// Interval of leases and statuses: 20 Hz, so that several in a row may be lost within
/// [`LEASE_DURATION`].
pub const HEARTBEAT_PERIOD: Duration = Duration::from_millis(50);

/// How often a stop or its release is repeated until all have acknowledged it, and the zero that stops
/// a base.
pub const REPEAT_PERIOD: Duration = Duration::from_millis(100);

/// How often a node's machine is given the time while nothing arrives.
pub const TICK: Duration = Duration::from_millis(20);

/// How long a lease holds after *the robot sent* the status that it echoes.
pub const LEASE_DURATION: Duration = Duration::from_millis(500);

/// How long a robot that stands because its lease ran out may be let go on, by a lease that echoes a
/// status of it from after that; then it stands until a newer epoch arms it.
pub const RESUME_TIMEOUT: Duration = Duration::from_secs(1);

/// How long nothing may be received of a robot in a run before it is lost: one that was out of reach for as
/// long as it may be, and still goes on, has to be received again first.
pub const SILENCE_TIMEOUT: Duration = Duration::from_millis(1600);

/// How long a robot may stand in a run in all, each time because its lease ran out, before the runner
/// gives it up: one hundredth of the run, and at least 3 s.
pub fn most_paused(run: Duration) -> Duration {
    (run / 100).max(Duration::from_secs(3))
}

/// How long a controller's status counts.
pub const CONTROLLER_TIMEOUT: Duration = Duration::from_millis(500);

/// Time after which a gate trusts no message any more of a process that has died: [`CONTROLLER_TIMEOUT`],
/// and what messages take on their way.
pub const DEAD_PROCESS_TIMEOUT: Duration = Duration::from_millis(700);

/// Silence of a runner after which it will not come back to a robot that it has armed.
pub const RUNNER_GONE_TIMEOUT: Duration = Duration::from_secs(5);

/// How long an e-stop publisher may be silent before the lock engages by itself.
pub const E_STOP_TIMEOUT: Duration = Duration::from_millis(500);

/// How long a robot whose node has just started receives what the e-stop has locked on the others.
pub const LOCK_QUERY_DURATION: Duration = Duration::from_secs(2);

/// How long a world in lockstep waits for what it needs for a step before its run is void.
pub const LEAST_STEP_TIMEOUT: Duration = Duration::from_secs(30);

/// How long stepping may stay frozen in lockstep before the run is void.
pub const LOCKSTEP_GRACE: Duration = Duration::from_secs(5);

/// How messages travel, on which some times depend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transport {
    /// As they are.
    #[default]
    Plain,
    /// Signed and encrypted. Whenever somebody joins, its handshakes hold everything up, by up to
    /// 0.4 s where ten programs share a machine; and it takes seconds until all are authenticated.
    Secured,
}

impl Transport {
    /// Least age at which a velocity command is stale.
    pub const fn least_command_timeout(self) -> Duration {
        match self {
            Self::Plain => Duration::from_millis(300),
            Self::Secured => Duration::from_millis(500),
        }
    }

    /// How long the runner looks for what an experiment needs, from when it last found more of it:
    /// hundreds of robots take their time to start.
    pub const fn discovery_timeout(self) -> Duration {
        match self {
            Self::Plain => Duration::from_secs(10),
            Self::Secured => Duration::from_secs(20),
        }
    }

    /// How long a stop looks for robots that were not named.
    pub const fn robot_search_duration(self) -> Duration {
        match self {
            Self::Plain => Duration::from_secs(2),
            Self::Secured => Duration::from_secs(5),
        }
    }
}

/// Age at which a velocity command is stale: the larger of 300 ms (500 ms if secured) and 2.5 control
/// periods.
pub fn command_timeout(period_s: f64, transport: Transport) -> Duration {
    transport.least_command_timeout().max(Duration::from_secs_f64(2.5 * period_s))
}

/// How long a node may be silent before the runner takes it for gone.
pub const NODE_TIMEOUT: Duration = Duration::from_secs(1);

/// Silence of a robot's sensor after which a controller that holds its lease reports a fault, and age
/// of its last detection then.
pub const SENSOR_TIMEOUT: Duration = Duration::from_secs(1);

/// How long detections may stay away in a run before the runner gives their robot up.
pub const DETECTION_TIMEOUT: Duration = Duration::from_secs(3);

/// How long poses may stay away in a run before the runner gives their robot up: a tracker that loses
/// sight of a robot for a moment is no loss.
pub const POSE_TIMEOUT: Duration = Duration::from_secs(5);

/// Poses outside of the geofence, one after the other, after which a robot has left it: a tracker may
/// be wrong once.
pub const OUTSIDE_POSES: u32 = 3;

/// The same where poses come seldom, or no more.
pub const OUTSIDE_TIMEOUT: Duration = Duration::from_secs(1);

/// How long the runner waits, from the start of the movement, for the first detection or pose of a
/// robot.
pub const FIRST_SAMPLE_TIMEOUT: Duration = Duration::from_secs(5);

/// How often the runner looks for publishers that have started since it found all that it needs.
pub const GRAPH_PERIOD: Duration = Duration::from_millis(500);

/// How long the runner looks at most while its own machine does not keep up with what it receives, as
/// when dozens of processes start on it.
pub const CATCH_UP_TIMEOUT: Duration = Duration::from_secs(60);

/// How long setting, and then reading back, all parameters may take.
pub const CONFIGURE_TIMEOUT: Duration = Duration::from_secs(5);

/// When an unanswered or refused request for parameters is repeated.
pub const RETRY_PERIOD: Duration = Duration::from_secs(1);

/// How long the recorder may take to open, to catch up after the last step, and to write anything at all
/// while it closes.
pub const RECORDER_TIMEOUT: Duration = Duration::from_secs(10);

/// How long the robots may take to arm.
pub const ARM_TIMEOUT: Duration = Duration::from_secs(5);

/// How long the robots may take to report that they stand.
pub const STAND_TIMEOUT: Duration = Duration::from_secs(2);

/// How long the runner waits, when all robots are armed, for poses that come seldom.
pub const POSE_SEARCH_DURATION: Duration = Duration::from_secs(2);

/// How long a stop, or its release, waits for acknowledgements.
pub const ACKNOWLEDGE_TIMEOUT: Duration = Duration::from_secs(5);

/// From the moment when all robots of a fleet are armed until they move.
pub const COUNTDOWN: Duration = Duration::from_secs(3);

/// How long the runner tries to have all robots armed through a whole countdown, which starts again
/// whenever a robot's lease runs out in it.
pub const COUNTDOWN_TIMEOUT: Duration = Duration::from_secs(60);

/// How far a robot's wall clock may be from the runner's before it is noted that its stamps are aligned
/// by when they are received.
pub const MAX_CLOCK_SKEW: Duration = Duration::from_secs(1);

/// For how long such a clock is looked at, as one that is just being set can be aligned by nothing ...
pub const CLOCK_LOOK: Duration = Duration::from_secs(2);

/// ... and by how much it may change meanwhile: whoever reads the bag allows as much.
pub const MAX_CLOCK_CHANGE: Duration = Duration::from_millis(250);
