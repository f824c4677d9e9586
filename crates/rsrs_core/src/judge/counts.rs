//! How often runs ended in each phase.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::judge::behaviour::Behaviour;
use crate::judge::phase::Phase;
use crate::statistics::share::Share;

/// How many replicates of one cell ended in each phase; in files `{"stable_milling": 16, …}`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<Phase, u64>", into = "BTreeMap<Phase, u64>")]
pub struct PhaseCounts {
    counts: [u64; Phase::ALL.len()],
}

impl PhaseCounts {
    /// The behaviour whose phases are counted; milling where nothing was counted.
    pub fn behaviour(&self) -> Behaviour {
        let counted = Phase::ALL.into_iter().find(|phase| self.get(*phase) > 0);
        counted.map_or(Behaviour::default(), Phase::behaviour)
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
    pub fn of(phases: impl IntoIterator<Item = Phase>) -> Self {
        let mut counts = Self::default();
        for phase in phases {
            counts.add(phase);
        }
        counts
    }

    /// Counts one more replicate.
    pub fn add(&mut self, phase: Phase) {
        self.counts[index(phase)] += 1;
    }

    /// Counts `n` more replicates of a phase.
    pub fn add_many(&mut self, phase: Phase, n: u64) {
        self.counts[index(phase)] += n;
    }

    /// Replicates that ended in this phase.
    pub fn get(&self, phase: Phase) -> u64 {
        self.counts[index(phase)]
    }

    /// All replicates.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The most frequent phase; of equally frequent ones the first in [`Phase::ALL`].
    ///
    /// # Returns
    ///
    /// `None` if nothing was counted.
    pub fn majority(&self) -> Option<Phase> {
        let most = *self.counts.iter().max()?;
        if most == 0 {
            return None;
        }
        Phase::ALL.into_iter().find(|phase| self.get(*phase) == most)
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

fn index(phase: Phase) -> usize {
    match phase {
        Phase::StableMilling => 0,
        Phase::SemiStableMilling => 1,
        Phase::Unformed => 2,
        Phase::Dispersion => 3,
        Phase::CollidingUnstable => 4,
        Phase::Aggregated => 5,
        Phase::PartlyAggregated => 6,
        Phase::NotAggregated => 7,
        Phase::SpreadOut => 8,
        Phase::PartlySpreadOut => 9,
        Phase::NotSpreadOut => 10,
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
    fn counts_follow_the_order_of_the_phases() {
        for phase in Phase::ALL {
            assert_eq!(Phase::ALL[index(phase)], phase);
        }
    }

    #[test]
    fn the_majority_of_equals_is_the_first() {
        let counts = PhaseCounts::of([Phase::Dispersion, Phase::SemiStableMilling]);

        assert_eq!(counts.majority(), Some(Phase::SemiStableMilling));
    }
}
