//! How sure a verdict is: how far the order parameters are from where another phase begins.

use serde::Serialize;

use crate::judge::behaviour::condition::{Condition, Needs};
use crate::judge::behaviour::rule::Rules;
use crate::judge::order::OrderParameters;
use crate::judge::phase::{Phase, Verdict, n_good};

pub use crate::judge::order::Parameter;

/// How sure a verdict is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Every boundary of every rule, in the order in which the judge looks.
    pub margins: Vec<Margin>,
    /// The least change that gives another phase; `None` if no change of an order parameter does.
    pub nearest: Option<Nearest>,
    /// Whether the phase stays the same while every order parameter moves by less than
    /// [`SETTLED`], or by half a boundary that is itself smaller than that.
    pub is_settled: bool,
    /// Share of the blocks of 10 s in the window which by themselves show the same phase, from 0
    /// to 1.
    pub confidence: f64,
    /// Share of these blocks that satisfy the rule of the wanted phase by themselves, from 0 to 1; a
    /// stable mill breaks it in at most one of six.
    pub steady: f64,
}

/// One order parameter and one boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margin {
    /// The phase whose rule has this boundary.
    pub phase: Phase,
    /// The order parameter.
    pub parameter: Parameter,
    /// Where the boundary is, in the unit of the order parameter.
    pub boundary: f64,
    /// How far the order parameter is from it: positive, or zero, where this part of the rule
    /// holds, negative where it does not.
    pub distance: f64,
}

/// The least change that gives another phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// The phase it gives.
    pub becomes: Phase,
    /// How far the order parameter that moves most has to move, in its unit.
    pub distance: f64,
    /// The order parameters that have to move.
    pub parameters: Vec<Parameter>,
}

/// A verdict is settled if it withstands changes of every order parameter below this, in its unit.
pub const SETTLED: f64 = 0.05;

impl Certainty {
    /// Measures how sure a verdict of [`crate::judge::phase::label_with`] by these rules is.
    pub fn new(verdict: &Verdict, rules: &Rules) -> Self {
        let (n_good, n_blocks) = (n_good(&verdict.blocks, rules), verdict.blocks.len());
        // Where the whole window is not in the wanted phase, its blocks would change together with it.
        let is_whole = rules.is_wanted(&verdict.evidence);
        let blocks = if is_whole { (n_good, n_blocks) } else { (0, 0) };
        let state = State { evidence: verdict.evidence, blocks };
        let margins = margins(rules, &state, verdict.n_robots);
        let decided = |crossed: &[Margin]| state.after(crossed).phase(rules);
        let near: Vec<Margin> = margins
            .iter()
            .filter(|margin| margin.distance.abs() < settled(margin))
            .copied()
            .collect();
        let is_settled = !subsets(&near).any(|crossed| decided(&crossed) != verdict.phase);
        Self {
            nearest: nearest(&margins, verdict.phase, decided),
            is_settled,
            confidence: confidence(&verdict.blocks, verdict.phase, rules),
            margins,
            steady: n_good as f64 / n_blocks as f64,
        }
    }
}

/// What the rules look at.
#[derive(Clone, Copy)]
struct State {
    evidence: OrderParameters,
    /// Good blocks, of how many; none of a block, or where they are not asked.
    blocks: (usize, usize),
}

impl State {
    fn phase(&self, rules: &Rules) -> Phase {
        let (n_good, n_blocks) = self.blocks;
        rules.lasting(rules.phase(&self.evidence), n_good, n_blocks)
    }

    /// The same with some order parameters just on the other side of their boundaries.
    fn after(mut self, crossed: &[Margin]) -> Self {
        for margin in crossed {
            let is_upward = margin.parameter.of(&self.evidence) < margin.boundary;
            let beyond = if is_upward { margin.boundary } else { margin.boundary.next_down() };
            margin.parameter.set(&mut self.evidence, beyond);
        }
        self
    }
}

/// Every boundary, in the order of the rules.
fn margins(rules: &Rules, state: &State, n_robots: usize) -> Vec<Margin> {
    let conditions = rules
        .rules
        .iter()
        .flat_map(|rule| rule.conditions.iter().map(move |condition| (rule.phase, condition)));
    let margin = |(phase, condition): (Phase, &Condition)| {
        let Condition { parameter, needs, bound } = *condition;
        let boundary = match needs {
            // Where no robot may be lost, the boundary is the first robot.
            Needs::AtMost if bound == 0.0 => 1.0 / n_robots as f64,
            Needs::AtMost => bound.next_up(),
            Needs::AtLeast | Needs::Below => bound,
        };
        let found = parameter.of(&state.evidence);
        let distance = match needs {
            Needs::AtLeast => found - boundary,
            Needs::Below | Needs::AtMost => boundary - found,
        };
        Margin { phase, parameter, boundary, distance }
    };
    conditions.map(margin).collect()
}

/// How far from a boundary is far enough.
fn settled(margin: &Margin) -> f64 {
    SETTLED.min(margin.boundary / 2.0)
}

/// All sets of these margins that are not empty, the smaller ones first.
fn subsets(margins: &[Margin]) -> impl Iterator<Item = Vec<Margin>> {
    let mut masks: Vec<u32> = (1..1 << margins.len()).collect();
    masks.sort_by_key(|mask| mask.count_ones());
    masks.into_iter().map(|mask| {
        let is_in = |(index, _): &(usize, &Margin)| mask & (1 << index) != 0;
        margins.iter().enumerate().filter(is_in).map(|(_, margin)| *margin).collect()
    })
}

/// Widens the circle of boundaries that are crossed until the phase changes.
fn nearest(
    margins: &[Margin],
    phase: Phase,
    decided: impl Fn(&[Margin]) -> Phase,
) -> Option<Nearest> {
    let mut sorted = margins.to_vec();
    sorted.sort_by(|one, other| one.distance.abs().total_cmp(&other.distance.abs()));
    (0..sorted.len()).find_map(|last| {
        let (closer, farthest) = (&sorted[..last], sorted[last]);
        std::iter::once(Vec::new()).chain(subsets(closer)).find_map(|mut crossed| {
            crossed.push(farthest);
            let becomes = decided(&crossed);
            (becomes != phase).then(|| Nearest {
                becomes,
                distance: farthest.distance.abs(),
                parameters: crossed.iter().map(|margin| margin.parameter).collect(),
            })
        })
    })
}

/// The share of blocks that show the same phase.
fn confidence(blocks: &[OrderParameters], phase: Phase, rules: &Rules) -> f64 {
    let is_same = |evidence: &&OrderParameters| {
        State { evidence: **evidence, blocks: (0, 0) }.phase(rules) == phase
    };
    blocks.iter().filter(is_same).count() as f64 / blocks.len() as f64
}
