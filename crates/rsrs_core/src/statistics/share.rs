//! How many of so many runs ended in the wanted phase: milled.

use std::ops::Add;

use serde::{Deserialize, Serialize};

use crate::statistics::interval::Interval;

/// Runs that ended in the wanted phase of their behaviour, stable milling, of all runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Share {
    /// Runs that did.
    pub hits: u64,
    /// All runs.
    pub n: u64,
}

impl Share {
    /// The share of `n` runs that was written as a number from 0 to 1.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a part of a count is a count"
    )]
    pub fn from_value(value: f64, n: u64) -> Self {
        Self { hits: (value * n as f64).round() as u64, n }
    }

    /// The share itself; 0 without runs.
    pub fn value(self) -> f64 {
        if self.n == 0 { 0.0 } else { self.hits as f64 / self.n as f64 }
    }

    /// Its 95 % confidence interval.
    pub fn interval(self) -> Interval {
        Interval::clopper_pearson(self.hits, self.n)
    }
}

impl Add for Share {
    type Output = Self;

    /// The share of both together.
    fn add(self, further: Self) -> Self {
        Self { hits: self.hits + further.hits, n: self.n + further.n }
    }
}
