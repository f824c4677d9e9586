//! Why a range ends where it does: by geometry where that explains it, else by how runs end.

use rsrs_core::diagram::theory::Condition;
use rsrs_core::judge::counts::PhaseCounts;

use super::tried_value::TriedValue;
use crate::swarm::Swarm;

/// Why a range ends where it does.
#[derive(Clone, Debug)]
pub enum Why {
    /// There is a range, and these are its ends; `None` where it goes as far as was tried.
    Ends {
        /// Below it.
        below: Option<Box<Edge>>,
        /// Above it.
        above: Option<Box<Edge>>,
    },
    /// There is none: robots mill too rarely even at the recommendation.
    Nowhere {
        /// How runs end there; `None` if it cannot be simulated.
        at: Option<PhaseCounts>,
        /// The value with which they mill most often, if that is more often, and the share of it.
        most: Option<(f64, f64)>,
    },
}

/// What goes wrong beyond the end of a range.
#[derive(Clone, Debug)]
pub struct Edge {
    /// The first value beyond it.
    pub value: f64,
    /// How runs with it end.
    pub phases: PhaseCounts,
    /// The condition for an ideal ring that ceases to hold where mills become rare, the value there, and the
    /// robots with it; `None` also if up to there robots mill on rings of another kind.
    pub theory: Option<(f64, Swarm, Condition)>,
}

/// Where fewer runs mill than this share of those at the recommendation, it is plain what goes wrong.
const RARE: f64 = 0.5;

impl Edge {
    /// The end of a range, of what was tried from the recommendation outward, itself first: the
    /// first `n_inside` belong to the range, and not all do.
    pub fn new(outward: &[&TriedValue], n_inside: usize) -> Self {
        let first = outward[n_inside];
        let is_rare = |index: &usize| milling(outward[*index]) < RARE * milling(outward[0]);
        let rare = (n_inside..outward.len()).find(is_rare);
        let theory = rare.and_then(|rare| {
            let (swarm, condition) = broken(&outward[..rare], outward[rare])?;
            Some((outward[rare].value, swarm, condition))
        });
        Self { value: first.value, phases: first.phases, theory }
    }
}

/// The condition for an ideal ring that ceases to hold between values with which robots mill and one beyond
/// them.
fn broken(mills: &[&TriedValue], beyond: &TriedValue) -> Option<(Swarm, Condition)> {
    let is_ideal = |swept: &&TriedValue| {
        let swarm = Swarm::new(&swept.harsher);
        swarm.zip(swept.ring_m).is_some_and(|(swarm, ring_m)| swarm.is_ring(ring_m))
    };
    let meets = |swept: &TriedValue, condition| {
        Swarm::new(&swept.harsher).and_then(|swarm| swarm.meets(condition)) == Some(true)
    };
    let breaks = |condition: &Condition| {
        mills.iter().all(|swept| meets(swept, *condition)) && !meets(beyond, *condition)
    };
    let swarm = Swarm::new(&beyond.harsher)?;
    let broken = Condition::ALL.into_iter().find(breaks)?;
    mills.iter().all(is_ideal).then_some((swarm, broken))
}

fn milling(swept: &TriedValue) -> f64 {
    swept.phases.wanted_share()
}

impl Why {
    /// That robots mill too rarely even at the recommendation, and where more often.
    pub fn nowhere(swept: &[TriedValue], at: Option<&TriedValue>) -> Self {
        let Some(at) = at else { return Self::Nowhere { at: None, most: None } };
        let most = swept.iter().rev().max_by(|one, other| milling(one).total_cmp(&milling(other)));
        let most = most.filter(|most| milling(most) > milling(at));
        Self::Nowhere { at: Some(at.phases), most: most.map(|most| (most.value, milling(most))) }
    }
}
