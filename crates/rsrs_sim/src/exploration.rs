//! What a swarm of robots can do at all: binary controllers beyond the given one, searched for.
//!
//! A binary controller is four numbers ([`space`]): speed and turning rate where something is
//! detected, and where nothing is. They are searched for one behaviour by an evolution strategy
//! ([`evolution_strategy`]), and for all that differ by an archive with a place for each niche
//! ([`archive`]). Both propose controllers and are given what became of them, so that whoever runs the
//! simulations may do so on any number of threads, write down what came out, and go on later.
//!
//! # Source
//!
//! §III step 3, "Exploration within simulation"; the general binary controller as in M. Gauci et al.,
//! IJRR 33(8), 2014, and novelty over descriptors of the swarm as in D. S. Brown et al., DARS 2018.

pub mod archive;
pub mod evolution_strategy;
pub mod niche;
pub mod space;

/// Uniform and normal numbers of a search; each step has its own, so that it depends on no other.
pub(crate) struct Draws(crate::draw::Stream);

impl Draws {
    /// The numbers of one step of a search.
    pub fn new(seed: u64, step: u64) -> Self {
        use crate::draw::{Purpose, RunKey, Seed, Stream};
        let run = RunKey::new(Seed { seed, replicate: step }, EXPLORATION);
        Self(Stream::new(run, 0, Purpose::Exploration))
    }

    /// A number from 0 to below 1.
    pub fn uniform(&mut self) -> f64 {
        self.0.uniform()
    }

    /// A standard normal number, at most 3 from 0.
    pub fn normal(&mut self) -> f64 {
        self.0.truncated_normal()
    }

    /// A whole number below `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
}

/// "explore" in ASCII.
const EXPLORATION: u64 = 0x6578_706c_6f72_6500;
