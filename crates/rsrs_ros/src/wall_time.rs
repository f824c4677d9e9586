//! The time of the wall.

use std::time::{SystemTime, UNIX_EPOCH};

use rsrs_msgs::builtin_interfaces::Time;

/// The time of the wall, for stamps that people read; nothing is decided by it.
pub fn wall_time() -> Time {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Time::from_nanos(u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX))
}
