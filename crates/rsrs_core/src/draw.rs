//! Draws of a run that are *counter-based*: the key names run, robot and purpose, and the counter the step, so
//! that none depends on order, thread or neighbours. The simulator and a controller on a robot draw the same.

use crate::digest::mix;

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
    /// Which transition a controller's state machine makes; each step.
    Transition = 12,
    /// Where an object is at the start; once.
    Object = 13,
    /// Who fails of so many robots; once.
    Failure = 14,
    /// How far off a tracker was when it saw where an object is.
    TrackerError = 15,
}

/// Everything that a draw of one run has in common.
#[derive(Clone, Copy, Debug)]
pub struct RunKey {
    /// The run.
    pub seed: Seed,
    /// What it is a run of: digest of its conditions, or of a part of them.
    pub digest: u64,
}

/// Who draws and why, as two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Added to the counter.
    pub low: u32,
    /// Added midway.
    pub high: u32,
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
        self.key_of(robot, purpose as u64)
    }

    /// The key of the detections of one of a robot's sensors, by its place among all: of the first that of its
    /// [`Purpose::Detection`].
    pub fn sensor_key(&self, robot: usize, sensor: usize) -> Key {
        self.key_of(robot, Purpose::Detection as u64 | (sensor as u64) << 8)
    }

    fn key_of(&self, robot: usize, purpose: u64) -> Key {
        let words = [self.digest, self.seed.replicate, robot as u64, purpose];
        let key = words.iter().fold(mix(self.seed.seed ^ KEY_SALT), |key, word| {
            mix(key.wrapping_mul(KEY_FACTOR) ^ *word)
        });
        Key::from_bits(key)
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
    /// Both words as one number, low word last: as a parameter of a node has it.
    pub fn bits(self) -> u64 {
        u64::from(self.high) << 32 | u64::from(self.low)
    }

    /// The key of these [`Self::bits`].
    pub fn from_bits(bits: u64) -> Self {
        Self { low: bits as u32, high: (bits >> 32) as u32 }
    }

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
    fn every_part_of_the_key_matters() {
        let base = run_key().key(0, Purpose::Detection);
        let others = [
            RunKey::new(Seed { seed: 9, replicate: 2 }, 3).key(0, Purpose::Detection),
            RunKey::new(Seed { seed: 1, replicate: 9 }, 3).key(0, Purpose::Detection),
            RunKey::new(Seed { seed: 1, replicate: 2 }, 9).key(0, Purpose::Detection),
            run_key().key(9, Purpose::Detection),
            run_key().key(0, Purpose::GustX),
            run_key().sensor_key(0, 1),
            run_key().sensor_key(0, 2),
        ];

        for other in others {
            assert_ne!(other, base);
            assert!((0..64).any(|step| other.uniform24(step) != base.uniform24(step)));
        }
        assert_eq!(run_key().sensor_key(0, 0), base, "the first sensor is that of one");
    }
}
