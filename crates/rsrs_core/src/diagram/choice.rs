//! Which cell to run: the one from which the robots may drift furthest and still mill.

mod candidates;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagram::settling::Settling;
use crate::judge::behaviour::Behaviour;
use crate::judge::counts::PhaseCounts;
use crate::judge::order::OrderParameters;
use crate::judge::order::Parameter;
use crate::judge::phase::Phase;
use crate::quantity::{Axis, Cell};
use crate::statistics::interval::{Interval, TAIL};
use crate::statistics::share::Share;

pub use candidates::{Candidate, Worlds, most_frequent, rank};

/// How far a value may drift, in the unit of its axis, and still be that of a swept cell in the
/// region, the other axes unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Downward.
    pub low: f64,
    /// Upward.
    pub high: f64,
}

/// On which sides of a cell the region goes on as far as was swept: nothing is known beyond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// Downward.
    pub low: bool,
    /// Upward.
    pub high: bool,
}

impl Edge {
    /// Whether there is one.
    pub fn is_any(self) -> bool {
        self.low || self.high
    }
}

/// The chosen cell, confirmed on fresh seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The cell.
    pub cell: Cell,
    /// How many robots it has; `None` in a file that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<usize>,
    /// Digest of the sweep that it was chosen from ([`SweepFile::digest`]); `None` in a file that does
    /// not contain it.
    ///
    /// [`SweepFile::digest`]: crate::diagram::sweep_file::SweepFile::digest
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep_digest: Option<String>,
    /// Share of confirming replicates that milled.
    pub b_s: f64,
    /// Lower bound of its 95 % interval; where other candidates were confirmed before and did not hold, a
    /// lower one, so that the bounds of all of them hold together ([`tail`]).
    pub b_s_low: f64,
    /// Upper bound.
    pub b_s_high: f64,
    /// Number of confirming replicates.
    pub n_replicates: u64,
    /// How far each swept axis may drift.
    pub margin: BTreeMap<Axis, Margin>,
    /// Axes on which a margin ends where the sweep does, and not at a value that is not viable; empty
    /// in a file that does not contain it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub edge: BTreeMap<Axis, Edge>,
    /// How the confirming replicates ended; `None` in a file without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phases: Option<PhaseCounts>,
    /// The same cell with the robots as measured; `None` if they were not made worse, or in a file
    /// that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_measured: Option<AsMeasured>,
    /// Whether its runs were given enough time; `None` if they are too short to decide, or in a
    /// file that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settling: Option<Settling>,
    /// When half of the mills among its first runs had begun, in seconds; `None` if none did, or in a
    /// file that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged_s: Option<f64>,
    /// What a denser start would give; `None` if the robots do not start in a disc, or fit into no
    /// smaller one, and in a file that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denser_start: Option<DenserStart>,
    /// What other numbers of robots would give, ascending; empty in a file that does not contain it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_numbers: Vec<OtherNumber>,
    /// `b_s` for other circliness at which semi-stable mills end and stable ones begin; empty in a
    /// file that does not contain it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_circliness: Vec<AtCircliness>,
    /// How many candidates were confirmed until this one held, itself included; `None` in a file
    /// that does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates_tried: Option<u64>,
}

/// A cell with another number of robots, in fresh runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherNumber {
    /// Number of robots.
    pub robots: usize,
    /// Share of replicates that milled, in the world in which they are rarer.
    pub b_s: f64,
    /// Lower bound of its 95 % interval.
    pub b_s_low: f64,
    /// Upper bound.
    pub b_s_high: f64,
    /// Number of replicates in each world.
    pub n_replicates: u64,
}

/// A cell whose robots start in a smaller disc, in fresh runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DenserStart {
    /// Radius of the disc, in metres.
    pub placement_radius_m: f64,
    /// Radius of the cell's disc, in metres.
    pub now_m: f64,
    /// Share of replicates that milled, in the world in which they are rarer.
    pub b_s: f64,
    /// Lower bound of its 95 % interval.
    pub b_s_low: f64,
    /// Number of replicates in each world.
    pub n_replicates: u64,
}

/// What `B_s` would be if a mill were called stable from another circliness on.
///
/// Stable and semi-stable mills are a continuum (§IV step 3), and where to cut it is a convention.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AtCircliness {
    /// Least circliness of a stable mill; 0.5 is what every phase rests on.
    pub stable_circliness: f64,
    /// Share of replicates that milled.
    pub b_s: f64,
}

impl AtCircliness {
    /// Judges simulated replicates, whose reach is known, again with lower, equal and higher
    /// thresholds; mills that did not last stay what they are. Empty for a behaviour whose wanted
    /// phase has no bound on circliness.
    pub fn new(judged: &[(Phase, OrderParameters)]) -> Vec<Self> {
        let Some((phase, _)) = judged.first() else { return Vec::new() };
        let rules = phase.behaviour().rules();
        let Some(bound) = rules.wanted_bound(Parameter::CIRCLINESS) else { return Vec::new() };
        let wanted = rules.wanted;
        let lasts = |(phase, evidence): &&(Phase, OrderParameters)| {
            *phase == wanted || rules.phase(evidence) != wanted
        };
        let at = |stable_circliness: f64| {
            let moved = rules.clone().with_wanted_bound(Parameter::CIRCLINESS, stable_circliness);
            let is_mill =
                |(_, evidence): &&(Phase, OrderParameters)| moved.phase(evidence) == wanted;
            let n_mills = judged.iter().filter(lasts).filter(is_mill).count();
            Self { stable_circliness, b_s: n_mills as f64 / judged.len() as f64 }
        };
        [0.4, bound, 0.6].map(at).into()
    }
}

/// What robots as measured do where robots made worse were chosen.
///
/// That a robot is nowhere less capable does not mean that a swarm of them mills more often
/// (`eq:finalgap` is a claim, and not a theorem): some imperfections help.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AsMeasured {
    /// Share of replicates that milled.
    pub share: f64,
    /// Lower bound of its 95 % interval.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Number of replicates.
    pub n_replicates: u64,
}

impl AsMeasured {
    /// Replicates that milled, of all.
    pub fn milling(&self) -> Share {
        let hits = (self.share * self.n_replicates as f64).round() as u64;
        Share { hits, n: self.n_replicates }
    }

    /// What follows from how replicates ended; `number` is the candidate's, as for [`tail`].
    pub fn new(phases: &PhaseCounts, number: u64) -> Self {
        let milling = Share::milling(phases);
        let interval = Interval::with_tails(milling.hits, milling.n, tail(number));
        Self {
            share: milling.value(),
            low: interval.low,
            high: interval.high,
            n_replicates: milling.n,
        }
    }
}

/// A confirmed cell is viable when the lower bound of its `B_s` is at least this in both worlds,
/// unless asked otherwise; and what the smoothed share of a cell in the milling region is at least.
pub const VIABLE_B_S_LOW: f64 = 0.8;

/// The probability that the bound of a candidate errs: 2.5 % of the first that is confirmed, with the
/// number 1, and as much of all others together, so that the lower bounds of all hold together at 95 %,
/// however many there are.
pub fn tail(number: u64) -> f64 {
    if number <= 1 { TAIL } else { TAIL / (number as f64 * (number as f64 - 1.0)) }
}

impl Choice {
    /// The choice of a candidate of [`rank`] after its confirmation by fresh replicates: those of
    /// the sweep do not count. `number` is the candidate's, as for [`tail`].
    pub fn new(candidate: &Candidate, phases: PhaseCounts, number: u64) -> Self {
        let confirmed = Share::milling(&phases);
        let interval = Interval::with_tails(confirmed.hits, confirmed.n, tail(number));
        Self {
            cell: candidate.cell.clone(),
            robots: None,
            sweep_digest: None,
            b_s: confirmed.value(),
            b_s_low: interval.low,
            b_s_high: interval.high,
            n_replicates: confirmed.n,
            margin: candidate.margin.clone(),
            edge: candidate.edge.clone(),
            phases: Some(phases),
            as_measured: None,
            settling: None,
            converged_s: None,
            denser_start: None,
            other_numbers: Vec::new(),
            by_circliness: Vec::new(),
            candidates_tried: Some(number),
        }
    }

    /// The behaviour that the cell was chosen for; milling in a file that does not state how runs
    /// ended.
    pub fn behaviour(&self) -> Behaviour {
        self.phases.map_or(Behaviour::default(), |phases| phases.behaviour())
    }

    /// The share of mills in the world in which they are rarer, and its lower bound.
    pub fn least(&self) -> (f64, f64) {
        let made_worse = (self.b_s, self.b_s_low);
        let measured = self.as_measured.map(|measured| (measured.share, measured.low));
        measured.filter(|measured| measured.1 < made_worse.1).unwrap_or(made_worse)
    }

    /// Whether robots as measured surely mill less often than these, which are worse: no point of
    /// one interval is in the other. Then fewer mills on the floor are to be expected.
    pub fn worse_is_better(&self) -> bool {
        self.as_measured.is_some_and(|measured| measured.high < self.b_s_low)
    }

    /// Whether robots are capable enough in this cell, made worse and as measured: the lower bound
    /// of both confirmed shares is at least `least_low` ([`VIABLE_B_S_LOW`] by default).
    pub fn is_viable(&self, least_low: f64) -> bool {
        self.least().1 >= least_low
    }
}
