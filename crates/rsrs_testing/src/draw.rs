//! Draws for made-up trials.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// A seeded stream of numbers, the same on every machine.
pub struct Draw {
    generator: ChaCha8Rng,
}

impl Draw {
    /// A stream of its own for every seed.
    pub fn new(seed: u64) -> Self {
        Self { generator: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// A number from 0 to below 1.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A normal number.
    pub fn normal(&mut self, mean: f64, sd: f64) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        mean + sd * radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}
