//! Where to simulate more: a sweep that spends its replicates where the phase is uncertain.
//!
//! Most cells of a diagram are plain after a few replicates; what is worth knowing lies at the
//! boundary of the milling region. An adaptive sweep begins with some replicates of every cell and
//! goes on in rounds with the cells that are still open. What it does next follows from the counts so
//! far and from nothing else, so it is repeated from its seed, and resumed.
//!
//! The counts decide when to stop, so intervals of a fixed number of runs would flatter. All
//! decisions and all intervals of an adaptive sweep rest on confidence sequences ([`sequence`]),
//! which hold at any time.
//!
//! What it saves, at an equal error of the boundary's place, where `B_s` falls through one half along
//! each row: on the Flockbot's diagram of 20 × 20 cells, 95 replicates a cell on average place it as
//! well as a full grid of about 320, 3.4 times as many (0.28 cells root mean square; `cargo run
//! --release -p rsrs_benches --example adaptive_saving`). On a made-up diagram whose phases are pure
//! away from the boundary, 43 replicates a cell do as well as 296, 6.8 times as many
//! (`an_adaptive_sweep_finds_the_boundary_with_a_fifth_of_the_replicates`).

use serde::{Deserialize, Serialize};

use super::{Point, moved, points};
use crate::judge::counts::PhaseCounts;
use crate::quantity::Cell;
use crate::statistics::sequence;
use crate::statistics::share::Share;

/// When an adaptive sweep has seen enough of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Adaptive {
    /// The interval of a cell's `B_s` is narrow enough when it is at most this wide; between 0 and 1.
    pub width: f64,
    /// Replicates that a cell gets at most.
    pub most_replicates: u64,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self { width: 0.2, most_replicates: 1000 }
    }
}

/// What is known of a cell so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// The interval of its `B_s` is narrow enough.
    Narrow,
    /// Its most frequent phase is certain, and so is whether it mills in half of its runs; and no
    /// neighbour is on the other side of that.
    Settled,
    /// Neither, and it has had all the replicates that it may have.
    Exhausted,
    /// Neither yet.
    Open,
}

/// Decides what an adaptive sweep does next.
#[derive(Clone, Debug)]
pub struct Schedule {
    adaptive: Adaptive,
    /// Replicates that every cell begins with.
    first: u64,
    /// For each cell, the cells beside it on the grid.
    neighbours: Vec<Vec<usize>>,
}

/// Replicates are simulated this many at a time, where cells begin with as many.
const AT_ONCE: u64 = 16;

impl Schedule {
    /// The schedule of a sweep of cells with the same axes, each of which begins with `first`
    /// replicates, at least 1.
    pub fn new(adaptive: Adaptive, first: u64, cells: &[Cell]) -> Self {
        Self { adaptive, first, neighbours: neighbours(cells) }
    }

    /// How many more replicates each cell gets in the next round, from the counts of all so far;
    /// both of shape `[n_cells]`. At the end of the sweep all are zero.
    ///
    /// An open cell gets a quarter of what it has had, so that it ends with at most a quarter more
    /// than it needed.
    pub fn next_round(&self, counts: &[PhaseCounts]) -> Vec<u64> {
        let more = |cell: usize| {
            let n = counts[cell].total();
            if n == 0 {
                return self.first;
            }
            match self.knowledge(counts, cell) {
                Knowledge::Open => {
                    let at_once = AT_ONCE.min(self.first);
                    let more = n.div_ceil(4).div_ceil(at_once) * at_once;
                    more.min(self.adaptive.most_replicates - n)
                }
                Knowledge::Narrow | Knowledge::Settled | Knowledge::Exhausted => 0,
            }
        };
        (0..counts.len()).map(more).collect()
    }

    /// What is known of the cell with this index, from the counts of all, of shape `[n_cells]`.
    pub fn knowledge(&self, counts: &[PhaseCounts], cell: usize) -> Knowledge {
        let share = Share::milling(&counts[cell]);
        if sequence::interval(share.hits, share.n, sequence::ERROR).width() <= self.adaptive.width {
            return Knowledge::Narrow;
        }
        let is_other_side = |other: &usize| mills(&counts[*other]) != mills(&counts[cell]);
        let is_at_boundary = self.neighbours[cell].iter().any(is_other_side);
        if !is_at_boundary && is_settled(&counts[cell]) {
            return Knowledge::Settled;
        }
        if share.n >= self.adaptive.most_replicates {
            return Knowledge::Exhausted;
        }
        Knowledge::Open
    }
}

/// Whether half of the runs so far ended in the wanted phase.
fn mills(counts: &PhaseCounts) -> bool {
    2 * counts.wanted() >= counts.total()
}

/// Whether it is certain which phase is the most frequent one, and whether a cell mills in half of
/// its runs: each at 95 %, at any time.
///
/// One phase is more frequent than another if it is so among the runs that ended in either; against
/// each of its four rivals, a quarter of the error is allowed.
pub fn is_settled(counts: &PhaseCounts) -> bool {
    let Some(leader) = counts.majority() else {
        return false;
    };
    let phases = counts.behaviour().phases();
    let rivals = phases.iter().copied().filter(|phase| *phase != leader);
    let error = sequence::ERROR / (phases.len() - 1) as f64;
    let hits = counts.get(leader);
    let mut beaten =
        rivals.map(|rival| sequence::interval(hits, hits + counts.get(rival), error).low > HALF);
    if !beaten.all(|is_beaten| is_beaten) {
        return false;
    }
    let share = Share::milling(counts);
    let milling = sequence::interval(share.hits, share.n, sequence::ERROR);
    milling.low >= HALF || milling.high <= HALF
}

const HALF: f64 = 0.5;

/// For each cell, the cells that are next to it on one axis and equal on all others.
fn neighbours(cells: &[Cell]) -> Vec<Vec<usize>> {
    let axes = cells.first().map(Cell::axes).unwrap_or_default();
    let points = points(&axes, cells.iter());
    let index: std::collections::BTreeMap<&[usize], usize> =
        points.iter().enumerate().map(|(cell, point)| (point.as_slice(), cell)).collect();
    let beside_it = |point: &Point| {
        let beside = (0..point.len()).flat_map(|axis| {
            let down = point[axis].checked_sub(1);
            [down, Some(point[axis] + 1)].into_iter().flatten().map(move |to| (axis, to))
        });
        let find = |(axis, to)| index.get(moved(point, axis, to).as_slice()).copied();
        beside.filter_map(find).collect()
    };
    points.iter().map(beside_it).collect()
}
