//! From what a sensor measures to the binary detection of the paper.

use std::time::Duration;

/// One reading of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// It is binary already.
    Seen(bool),
    /// Distance to the nearest thing, in metres. As in REP 117, plus infinity is nothing in range,
    /// minus infinity is something too close to measure, and NaN is a failed measurement.
    Range(f64),
}

/// How readings become detections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectorSettings {
    /// What is at most so far away is seen, in metres.
    pub threshold_m: f64,
    /// So many readings in a row must agree before the detection changes; at least 1.
    pub debounce: u32,
    /// So long after its last valid reading, the sensor has failed.
    pub timeout: Duration,
}

/// A sensor that has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SensorFailure {
    /// There was no reading yet.
    #[error("no reading of the sensor yet")]
    NoReading,
    /// It has fallen silent.
    #[error("no valid reading of the sensor for more than {} ms", timeout.as_millis())]
    Silent {
        /// How long it may be silent.
        timeout: Duration,
    },
}

/// Makes detections of readings.
#[derive(Clone, Debug, Default)]
pub struct Detector {
    detected: bool,
    /// Readings in a row that differ from it.
    against: u32,
    received: Option<Duration>,
}

impl Detector {
    /// Takes a reading.
    pub fn on_reading(&mut self, reading: Reading, settings: &DetectorSettings, now: Duration) {
        let seen = match reading {
            Reading::Seen(seen) => seen,
            // A failed measurement is no reading, and a sensor that only fails is silent.
            Reading::Range(range_m) if range_m.is_nan() => return,
            Reading::Range(range_m) => range_m <= settings.threshold_m,
        };
        if self.is_silent(settings, now) {
            // What was counted before a silence is not in a row with what comes after it.
            self.against = 0;
        }
        self.received = Some(now);
        if seen == self.detected {
            self.against = 0;
            return;
        }
        self.against += 1;
        if self.against >= settings.debounce {
            self.detected = seen;
            self.against = 0;
        }
    }

    /// Whether the robot sees something now; an error if there was no reading yet, or none for longer
    /// than the timeout.
    pub fn detected(
        &self,
        settings: &DetectorSettings,
        now: Duration,
    ) -> Result<bool, SensorFailure> {
        let timeout = settings.timeout;
        match self.received {
            None => Err(SensorFailure::NoReading),
            Some(_) if self.is_silent(settings, now) => Err(SensorFailure::Silent { timeout }),
            Some(_) => Ok(self.detected),
        }
    }

    fn is_silent(&self, settings: &DetectorSettings, now: Duration) -> bool {
        self.received.is_some_and(|received| now.saturating_sub(received) > settings.timeout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: DetectorSettings =
        DetectorSettings { threshold_m: 0.75, debounce: 3, timeout: Duration::from_millis(500) };

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    fn after(readings: &[f64]) -> bool {
        let mut detector = Detector::default();
        for range_m in readings {
            detector.on_reading(Reading::Range(*range_m), &SETTINGS, ms(0));
        }
        detector.detected(&SETTINGS, ms(0)).unwrap()
    }

    #[test]
    fn a_detection_changes_when_enough_readings_in_a_row_agree() {
        assert!(!after(&[0.5, 0.5]));
        assert!(after(&[0.5, 0.5, 0.75]));
        assert!(!after(&[0.5, 0.5, 0.76, 0.5, 0.5]));
        assert!(!after(&[0.5, 0.5, 0.5, 1.0, 1.0, f64::INFINITY]));
        assert!(after(&[f64::NEG_INFINITY; 3]), "too close to measure is seen");
    }

    #[test]
    fn a_sensor_that_only_fails_is_silent() {
        let mut detector = Detector::default();
        assert_eq!(detector.detected(&SETTINGS, ms(0)), Err(SensorFailure::NoReading));
        detector.on_reading(Reading::Seen(true), &SETTINGS, ms(0));

        detector.on_reading(Reading::Range(f64::NAN), &SETTINGS, ms(400));

        assert_eq!(detector.detected(&SETTINGS, ms(500)), Ok(false));
        assert_eq!(
            detector.detected(&SETTINGS, ms(501)),
            Err(SensorFailure::Silent { timeout: ms(500) })
        );
    }

    #[test]
    fn readings_before_a_silence_do_not_count_after_it() {
        let mut detector = Detector::default();
        for _ in 0..2 {
            detector.on_reading(Reading::Seen(true), &SETTINGS, ms(0));
        }

        detector.on_reading(Reading::Seen(true), &SETTINGS, ms(1000));

        assert_eq!(detector.detected(&SETTINGS, ms(1000)), Ok(false));
    }
}
