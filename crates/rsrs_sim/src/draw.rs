//! Random draws that depend only on what they are for: never on order, thread or neighbours.
//!
//! Within a run, draws are *counter-based*: the key names robot and purpose, the counter is the
//! step. Before a run, each robot has its own short streams of a standard generator.

use rand::Rng;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rsrs_core::digest::mix;

use crate::turn::turn;

/// Which run this is: replicate `replicate` of the sweep or experiment with this seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Seed {
    /// Seed of the sweep or experiment, below 2^63.
    pub seed: u64,
    /// Number of the replicate, from 0.
    pub replicate: u64,
}

/// What a draw is for. Each purpose has draws of its own, so that switching one noise on or off
/// leaves all others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Whether a sensor reports a detection; each step.
    Detection = 1,
    /// Noise of the speed gain; each step.
    SpeedGainNoise = 2,
    /// Noise of the turn gain; each step.
    TurnGainNoise = 3,
    /// Noise of the heading; each step.
    HeadingNoise = 4,
    /// Gusts along the world's x axis; each step.
    GustX = 5,
    /// Gusts along the world's y axis; each step.
    GustY = 6,
    /// Where a robot starts; once.
    Placement = 7,
    /// A robot's speed gain; once.
    SpeedGain = 8,
    /// A robot's turn gain; once.
    TurnGain = 9,
    /// A robot's turning bias; once.
    TurnBias = 10,
    /// A step of a search for controllers.
    Exploration = 11,
}

/// Everything that a draw of one run has in common.
#[derive(Clone, Copy, Debug)]
pub struct RunKey {
    seed: Seed,
    digest: u64,
}

/// Who draws and why, as two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    pub(crate) low: u32,
    pub(crate) high: u32,
}

impl RunKey {
    /// The key of a run under conditions with this digest.
    pub fn new(seed: Seed, digest: u64) -> Self {
        Self { seed, digest }
    }

    /// Number of the replicate, from 0.
    pub fn replicate(&self) -> u64 {
        self.seed.replicate
    }

    /// The key of one robot's draws for one purpose.
    pub fn key(&self, robot: usize, purpose: Purpose) -> Key {
        let words = [self.digest, self.seed.replicate, robot as u64, purpose as u64];
        let key = words.iter().fold(mix(self.seed.seed ^ KEY_SALT), |key, word| {
            mix(key.wrapping_mul(KEY_FACTOR) ^ *word)
        });
        Key { low: key as u32, high: (key >> 32) as u32 }
    }

    /// One robot's stream for draws before the run.
    pub fn stream(&self, robot: usize, purpose: Purpose) -> Stream {
        let mut bytes = [0; 32];
        bytes[0..8].copy_from_slice(&self.seed.seed.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.digest.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.seed.replicate.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(bytes);
        generator.set_stream((robot as u64) << 8 | purpose as u64);
        Stream { generator }
    }
}

/// Keeps a key away from the fixed point of [`mix`] at zero.
const KEY_SALT: u64 = 0x9e37_79b9_7f4a_7c15;

/// Odd, so that folding in a word loses nothing of the words before it.
const KEY_FACTOR: u64 = 0xd134_2543_de82_ef95;

/// Number of different values of [`Key::uniform24`].
const LEVELS: f64 = 16_777_216.0;

/// The threshold below which [`Key::uniform24`] falls with this probability.
///
/// It is exact at both ends: a probability of 0 never happens and a probability of 1 always does.
pub fn threshold(probability: f64) -> u32 {
    (probability * LEVELS).round() as u32
}

impl Key {
    /// A whole number, uniform below 2^24.
    ///
    /// # Source
    ///
    /// The multipliers and shifts are those of `lowbias32` (C. Wellons, hash-prospector), with the
    /// second half of the key added midway.
    #[inline]
    pub fn uniform24(self, counter: u32) -> u32 {
        let word = self.low.wrapping_add(counter);
        let word = (word ^ (word >> 16)).wrapping_mul(0x21f0_aaad).wrapping_add(self.high);
        let word = (word ^ (word >> 15)).wrapping_mul(0xd35a_2d97);
        (word ^ (word >> 15)) >> 8
    }

    /// A number above 0 and at most 1.
    #[inline]
    fn unit(self, counter: u32) -> f32 {
        (self.uniform24(counter) + 1) as f32 * (1.0 / 16_777_216.0)
    }

    /// A standard normal number, at most 5.8 from 0.
    ///
    /// # Source
    ///
    /// Box and Muller, 1958; one of the two numbers is used.
    pub fn normal(self, counter: u32) -> f32 {
        let first = self.unit(counter.wrapping_mul(2));
        let second = self.unit(counter.wrapping_mul(2).wrapping_add(1));
        let (cosine, _) = turn(second * std::f32::consts::TAU);
        (-2.0 * natural_logarithm(first)).sqrt() * cosine
    }
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
    fn the_ends_of_probability_are_exact() {
        let key = run_key().key(0, Purpose::Detection);

        assert!((0..100_000).all(|step| key.uniform24(step) < threshold(1.0)));
        assert!((0..100_000).all(|step| key.uniform24(step) >= threshold(0.0)));
    }

    #[test]
    fn a_probability_happens_as_often_as_stated() {
        let limit = threshold(0.08);
        let n_keys: u32 = 100;
        let n_steps: u32 = 10_000;

        let hits = (0..n_keys as usize)
            .flat_map(|robot| {
                let key = run_key().key(robot, Purpose::Detection);
                (0..n_steps).map(move |step| key.uniform24(step) < limit)
            })
            .filter(|hit| *hit)
            .count();

        let share = hits as f64 / f64::from(n_keys * n_steps);
        let four_sigma = 4.0 * (0.08_f64 * 0.92 / f64::from(n_keys * n_steps)).sqrt();
        assert!((share - 0.08).abs() < four_sigma, "{share}");
    }

    #[test]
    fn the_normal_numbers_have_the_moments_of_the_normal_distribution() {
        let key = run_key().key(7, Purpose::GustX);
        let n = 200_000;

        let draws: Vec<f64> = (0..n).map(|step| f64::from(key.normal(step))).collect();

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
    fn every_part_of_the_key_matters() {
        let base = run_key().key(0, Purpose::Detection);
        let others = [
            RunKey::new(Seed { seed: 9, replicate: 2 }, 3).key(0, Purpose::Detection),
            RunKey::new(Seed { seed: 1, replicate: 9 }, 3).key(0, Purpose::Detection),
            RunKey::new(Seed { seed: 1, replicate: 2 }, 9).key(0, Purpose::Detection),
            run_key().key(9, Purpose::Detection),
            run_key().key(0, Purpose::GustX),
        ];

        for other in others {
            assert_ne!(other, base);
            assert!((0..64).any(|step| other.uniform24(step) != base.uniform24(step)));
        }
    }

    #[test]
    fn a_truncated_normal_never_leaves_three_standard_deviations() {
        let mut stream = run_key().stream(3, Purpose::SpeedGain);

        assert!((0..100_000).all(|_| stream.truncated_normal().abs() <= 3.0));
    }
}
