//! How often a sensor detected a neighbour: at one place, and over several.

use serde::Serialize;

use crate::statistics::interval::Interval;

/// How often a sensor detected a neighbour at one place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorPoint {
    /// Distance of the centres, in metres.
    pub distance_m: f64,
    /// Bearing of the neighbour's centre, in radians; left is positive.
    pub bearing_rad: f64,
    /// What was counted there.
    pub rate: Rate,
}

/// A share of readings, with the interval of Clopper and Pearson.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Readings.
    pub samples: u64,
    /// Readings that were detections.
    pub detections: u64,
    /// Their share.
    pub value: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl Rate {
    /// A share with its interval.
    ///
    /// # Panics
    ///
    /// If there are more detections than samples, or no samples.
    pub fn new(detections: u64, samples: u64) -> Self {
        assert!(samples > 0, "a share of nothing");
        let Interval { low, high } = Interval::clopper_pearson(detections, samples);
        Self { samples, detections, value: detections as f64 / samples as f64, low, high }
    }

    /// The share of all readings together; `None` without readings.
    pub(super) fn sum(rates: impl Iterator<Item = (u64, u64)>) -> Option<Self> {
        let (detections, samples) =
            rates.fold((0, 0), |sum, rate| (sum.0 + rate.0, sum.1 + rate.1));
        (samples > 0).then(|| Self::new(detections, samples))
    }
}

impl SensorPoint {
    /// The neighbour's place in the robot's frame, in metres.
    pub fn place_m(&self) -> [f64; 2] {
        place_m(self.distance_m, self.bearing_rad)
    }
}

pub(super) fn place_m(distance_m: f64, bearing_rad: f64) -> [f64; 2] {
    let (sine, cosine) = libm::sincos(bearing_rad);
    [distance_m * cosine, distance_m * sine]
}
