//! Time: wall-clock time, and time since boot, by which permissions and commands grow old.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rsrs_msgs::builtin_interfaces::Time;
use rustix::time::{ClockId, clock_gettime};

/// Wall-clock time, for stamps that people read; nothing is decided by it.
pub fn wall_time() -> Time {
    Time::from_nanos(u64::try_from(since_1970().as_nanos()).unwrap_or(u64::MAX))
}

/// The same as one span of time, for what holds from one date to another.
pub fn since_1970() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// Time since the computer was started, with that in which it slept: a robot that wakes up after hours has
/// no permission left, which the clock of `Instant` would still count by.
///
/// # Panics
///
/// Never: this clock begins at 0.
pub fn since_boot() -> Duration {
    let now = clock_gettime(ClockId::Boottime);
    let seconds = u64::try_from(now.tv_sec).expect("this clock begins at 0");
    Duration::from_secs(seconds) + Duration::from_nanos(now.tv_nsec.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn time_since_boot_goes_as_fast_as_the_other_clock_while_nothing_sleeps() {
        let (start, other_start) = (since_boot(), Instant::now());
        std::thread::sleep(Duration::from_millis(20));
        let other = other_start.elapsed();

        let passed = since_boot().saturating_sub(start);

        assert!(other >= Duration::from_millis(20) && passed >= Duration::from_millis(20));
        assert!(passed >= other, "it is read before and after the other: {passed:?}, {other:?}");
    }
}
