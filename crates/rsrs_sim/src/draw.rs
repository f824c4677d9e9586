//! Random draws that depend only on what they are for: never on order, thread or neighbours.
//!
//! Within a run, draws are *counter-based*: the key names robot and purpose, the counter is the
//! step. Before a run, each robot has its own short streams of a standard generator.

use rand::Rng;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use crate::turn::turn;

pub use rsrs_core::draw::{Key, Purpose, RunKey, Seed, threshold};

/// A number above 0 and at most 1.
#[inline]
fn unit(key: Key, counter: u32) -> f32 {
    (key.uniform24(counter) + 1) as f32 * (1.0 / 16_777_216.0)
}

/// A standard normal number, at most 5.8 from 0.
///
/// # Source
///
/// Box and Muller, 1958; one of the two numbers is used.
pub fn normal(key: Key, counter: u32) -> f32 {
    let first = unit(key, counter.wrapping_mul(2));
    let second = unit(key, counter.wrapping_mul(2).wrapping_add(1));
    let (cosine, _) = turn(second * std::f32::consts::TAU);
    (-2.0 * natural_logarithm(first)).sqrt() * cosine
}

/// The natural logarithm of a positive normal number, by its exponent and the series of the
/// inverse hyperbolic tangent: the same bits on every machine.
fn natural_logarithm(number: f32) -> f32 {
    let bits = number.to_bits();
    let exponent = (bits >> 23).cast_signed() - 127;
    let mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    let above = mantissa > std::f32::consts::SQRT_2;
    let mantissa = if above { mantissa * 0.5 } else { mantissa };
    let exponent = if above { exponent + 1 } else { exponent };
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let square = ratio * ratio;
    let series = 1.0
        + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0 + square * (1.0 / 9.0))));
    exponent as f32 * std::f32::consts::LN_2 + 2.0 * ratio * series
}

/// Draws before a run, in double precision.
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// One robot's draws for one purpose.
    pub fn new(run: RunKey, robot: usize, purpose: Purpose) -> Self {
        let mut bytes = [0; 32];
        bytes[0..8].copy_from_slice(&run.seed.seed.to_le_bytes());
        bytes[8..16].copy_from_slice(&run.digest.to_le_bytes());
        bytes[16..24].copy_from_slice(&run.seed.replicate.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(bytes);
        generator.set_stream((robot as u64) << 8 | purpose as u64);
        Self { generator }
    }

    /// A number from 0 to below 1.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A standard normal number, redrawn until it is at most 3 from 0.
    pub fn truncated_normal(&mut self) -> f64 {
        loop {
            let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
            let normal = radius * libm::cos(std::f64::consts::TAU * self.uniform());
            if normal.abs() <= 3.0 {
                return normal;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run_key() -> RunKey {
        RunKey::new(Seed { seed: 1, replicate: 2 }, 3)
    }

    #[test]
    fn the_normal_numbers_have_the_moments_of_the_normal_distribution() {
        let key = run_key().key(7, Purpose::GustX);
        let n = 200_000;

        let draws: Vec<f64> = (0..n).map(|step| f64::from(normal(key, step))).collect();

        let moment = |power| draws.iter().map(|draw| draw.powi(power)).sum::<f64>() / f64::from(n);
        // Four standard errors of each moment: sqrt(1/n), sqrt(2/n), sqrt(15/n), sqrt(96/n).
        assert!(moment(1).abs() < 0.009, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.013, "{}", moment(2));
        assert!(moment(3).abs() < 0.035, "{}", moment(3));
        assert!((moment(4) - 3.0).abs() < 0.088, "{}", moment(4));
    }

    #[test]
    fn the_logarithm_agrees_with_libm() {
        for sample in (1..16_777_216_u32).step_by(997) {
            let number = sample as f32 / 16_777_216.0;
            let exact = libm::log(f64::from(number));

            let error = (f64::from(natural_logarithm(number)) - exact).abs();

            assert!(error <= 3e-7 * exact.abs().max(1.0), "{number}: {error}");
        }
    }

    #[test]
    fn a_truncated_normal_never_leaves_three_standard_deviations() {
        let mut stream = Stream::new(run_key(), 3, Purpose::SpeedGain);

        assert!((0..100_000).all(|_| stream.truncated_normal().abs() <= 3.0));
    }
}
