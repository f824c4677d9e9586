//! Package `builtin_interfaces`: time.

use serde::{Deserialize, Serialize};

use crate::message::ros_messages;

const NANOS_PER_SECOND: u64 = 1_000_000_000;

/// A point in time since the epoch of its clock: 1970 for the system's, the start for `/clock`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds, rounded down.
    pub sec: i32,
    /// Nanoseconds on top of the seconds; below 10⁹.
    pub nanosec: u32,
}

impl Time {
    /// Splits nanoseconds since the epoch of the clock into seconds and nanoseconds.
    ///
    /// # Panics
    ///
    /// If the time does not fit ROS's 32-bit seconds: after January 2038 on the system's clock.
    pub fn from_nanos(time_ns: u64) -> Self {
        let sec = i32::try_from(time_ns / NANOS_PER_SECOND)
            .expect("ROS 2 times have 32-bit seconds, which last until 2038");
        let nanosec =
            u32::try_from(time_ns % NANOS_PER_SECOND).expect("a remainder of 10^9 fits 32 bits");
        Self { sec, nanosec }
    }

    /// Nanoseconds since the epoch of the clock; `None` for a time before it.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_msgs::builtin_interfaces::Time;
    ///
    /// assert_eq!(Time { sec: 2, nanosec: 5 }.to_nanos(), Some(2_000_000_005));
    /// assert_eq!(Time { sec: -1, nanosec: 5 }.to_nanos(), None);
    /// ```
    pub fn to_nanos(self) -> Option<u64> {
        let sec = u64::try_from(self.sec).ok()?;
        Some(sec * NANOS_PER_SECOND + u64::from(self.nanosec))
    }
}

/// A span of time, possibly negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds, rounded down.
    pub sec: i32,
    /// Nanoseconds on top of the seconds; below 10⁹.
    pub nanosec: u32,
}

ros_messages! {
    Time => "builtin_interfaces/msg/Time",
    Duration => "builtin_interfaces/msg/Duration",
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nanoseconds_survive_the_split_into_seconds() {
        for time_ns in [0, 1, 999_999_999, NANOS_PER_SECOND, 1_700_000_000_123_456_789] {
            let time = Time::from_nanos(time_ns);

            assert!(u64::from(time.nanosec) < NANOS_PER_SECOND);
            assert_eq!(time.to_nanos(), Some(time_ns));
        }
    }
}
