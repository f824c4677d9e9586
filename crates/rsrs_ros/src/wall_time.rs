//! Wall-clock time.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rsrs_msgs::builtin_interfaces::Time;

/// Wall-clock time, for stamps that people read; nothing is decided by it.
pub fn wall_time() -> Time {
    Time::from_nanos(u64::try_from(since_1970().as_nanos()).unwrap_or(u64::MAX))
}

/// The same as one span of time, for what holds from one date to another.
pub fn since_1970() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}
