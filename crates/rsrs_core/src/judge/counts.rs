//! How often runs ended in each phase.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::judge::behaviour::Behaviour;
use crate::judge::phase::{MOST_PHASES, Phase};
use crate::statistics::share::Share;

/// How many replicates of one cell ended in each phase of a behaviour; in files
/// `{"stable_milling": 16, …}`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<Phase, u64>", into = "BTreeMap<Phase, u64>")]
pub struct PhaseCounts {
    behaviour: Behaviour,
    counts: [u64; MOST_PHASES],
}

impl PhaseCounts {
    /// The behaviour whose phases are counted; milling where nothing was counted.
    pub fn behaviour(&self) -> Behaviour {
        self.behaviour
    }

    /// Replicates that ended in the wanted phase of their behaviour: stable milling.
    pub fn wanted(&self) -> u64 {
        self.get(self.behaviour().wanted())
    }

    /// Share of the replicates in the wanted phase; 0 if nothing was counted.
    pub fn wanted_share(&self) -> f64 {
        self.share(self.behaviour().wanted())
    }

    /// Counts phases.
    pub fn new(phases: impl IntoIterator<Item = Phase>) -> Self {
        let mut counts = Self::default();
        for phase in phases {
            counts.add(phase);
        }
        counts
    }

    /// Counts one more replicate.
    pub fn add(&mut self, phase: Phase) {
        self.add_many(phase, 1);
    }

    /// Counts `n` more replicates of a phase.
    ///
    /// # Panics
    ///
    /// If phases of another behaviour were counted.
    pub fn add_many(&mut self, phase: Phase, n: u64) {
        if n == 0 {
            return;
        }
        if self.total() == 0 {
            self.behaviour = phase.behaviour();
        }
        assert_eq!(phase.behaviour(), self.behaviour, "phases of two behaviours have no shares");
        self.counts[phase.place()] += n;
    }

    /// Replicates that ended in this phase.
    pub fn get(&self, phase: Phase) -> u64 {
        if phase.behaviour() == self.behaviour { self.counts[phase.place()] } else { 0 }
    }

    /// All replicates.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The most frequent phase; of equally frequent ones the first of its behaviour. `None` if
    /// nothing was counted.
    pub fn majority(&self) -> Option<Phase> {
        let most = *self.counts.iter().max()?;
        if most == 0 {
            return None;
        }
        self.behaviour.phases().iter().copied().find(|phase| self.get(*phase) == most)
    }

    /// Share of the replicates in this phase; 0 if nothing was counted.
    pub fn share(&self, phase: Phase) -> f64 {
        if self.total() == 0 { 0.0 } else { self.get(phase) as f64 / self.total() as f64 }
    }
}

impl From<BTreeMap<Phase, u64>> for PhaseCounts {
    fn from(phases: BTreeMap<Phase, u64>) -> Self {
        let mut counts = Self::default();
        for (phase, n) in phases {
            counts.add_many(phase, n);
        }
        counts
    }
}

impl From<PhaseCounts> for BTreeMap<Phase, u64> {
    fn from(counts: PhaseCounts) -> Self {
        let phases = counts.behaviour().phases();
        phases.iter().map(|phase| (*phase, counts.get(*phase))).collect()
    }
}

impl Share {
    /// The share of the wanted phase among counted phases.
    pub fn milling(counts: &PhaseCounts) -> Self {
        Self { hits: counts.wanted(), n: counts.total() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_majority_of_equals_is_the_first() {
        let counts = PhaseCounts::new([Phase::DISPERSION, Phase::SEMI_STABLE_MILLING]);

        assert_eq!(counts.majority(), Some(Phase::SEMI_STABLE_MILLING));
    }
}
