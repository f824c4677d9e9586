//! The clock by which permissions and commands grow old.

use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

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
    fn it_goes_as_fast_as_the_other_clock_while_nothing_sleeps() {
        let (start, other_start) = (since_boot(), Instant::now());
        std::thread::sleep(Duration::from_millis(20));
        let other = other_start.elapsed();

        let passed = since_boot().saturating_sub(start);

        assert!(other >= Duration::from_millis(20) && passed >= Duration::from_millis(20));
        assert!(passed >= other, "it is read before and after the other: {passed:?}, {other:?}");
    }
}
