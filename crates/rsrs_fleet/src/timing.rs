//! The times of the protocol, each in one place.

use std::time::Duration;

/// Interval of leases and statuses: 10 Hz.
pub const BEAT: Duration = Duration::from_millis(100);

/// How long a lease holds after *the robot sent* the status that it echoes.
pub const LEASE: Duration = Duration::from_millis(500);

/// How long a controller's status counts.
pub const CONTROLLER: Duration = Duration::from_millis(500);

/// How long an e-stop publisher may be silent before the lock engages by itself.
pub const E_STOP_SILENCE: Duration = Duration::from_millis(500);

/// How long stepping may stay frozen in lockstep before the run is void.
pub const LOCKSTEP_GRACE: Duration = Duration::from_secs(5);

/// Least age at which a velocity command is stale.
pub const COMMAND_AT_LEAST: Duration = Duration::from_millis(300);

/// Age at which a velocity command is stale: the larger of 300 ms and 2.5 control periods.
pub fn command_timeout(period_s: f64) -> Duration {
    COMMAND_AT_LEAST.max(Duration::from_secs_f64(2.5 * period_s))
}
