//! The work of a sweep in blocks: what is finished, kept and found again as a whole.
//!
//! Blocks follow from what is swept alone: not from the machine, its vector unit, the number of
//! threads, or how often the work was interrupted.

use std::ops::Range;

use rsrs_core::conditions::Conditions;

use crate::batch::{MOST_LANES, runs_in_lanes};

/// Consecutive replicates of one cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellReplicates {
    /// Index of the cell among the conditions.
    pub cell: usize,
    /// Numbers of the replicates.
    pub replicates: Range<u64>,
}

impl CellReplicates {
    /// How many replicates it has.
    pub fn n_rows(&self) -> u64 {
        self.replicates.end - self.replicates.start
    }
}

/// Replicates of one or more cells that are finished together: at least 1 and at most
/// [`MOST_ROWS`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// In the order of the work; none is empty.
    pub pieces: Vec<CellReplicates>,
}

impl Block {
    /// How many replicates it has.
    pub fn n_rows(&self) -> u64 {
        self.pieces.iter().map(CellReplicates::n_rows).sum()
    }

    /// Cell and number of every replicate, in order.
    pub fn rows(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.pieces
            .iter()
            .flat_map(|piece| piece.replicates.clone().map(|replicate| (piece.cell, replicate)))
    }
}

/// Replicates of a block at most: it is held in memory.
pub const MOST_ROWS: u64 = 2048;

/// Steps of single robots in vectors in a block at most, unless one vector has more: about a second's work, so
/// that little is lost with a block.
const MOST_AGENT_STEPS: u64 = 200_000_000;

/// So many steps of a robot in a vector take as long as one of a body in the reference world, about.
const REFERENCE_STEPS: u64 = 100;

/// Into so many blocks work is cut at least, as far as it can be, so that machines may share a small sweep.
const LEAST_BLOCKS: u64 = 16;

/// Cuts work into blocks, in its order; empty pieces are left out.
///
/// Cells are cut where a vector of any machine is full; those that are run one world at a time, anywhere.
pub fn blocks<'a>(
    conditions: &'a [Conditions],
    duration_s: f64,
    work: impl IntoIterator<Item = CellReplicates> + 'a,
) -> impl Iterator<Item = Block> + 'a {
    let work: Vec<CellReplicates> = work.into_iter().collect();
    let of_piece = |piece: &CellReplicates| {
        piece.n_rows().saturating_mul(Size::new(&conditions[piece.cell], duration_s).agent_steps)
    };
    let all = work.iter().map(of_piece).fold(0, u64::saturating_add);
    let agent_steps = MOST_AGENT_STEPS.min(all.div_ceil(LEAST_BLOCKS));
    let mut work = work.into_iter();
    let mut rest: Option<CellReplicates> = None;
    std::iter::from_fn(move || {
        let mut room = Room { rows: MOST_ROWS, agent_steps };
        let mut block = Block::default();
        while let Some(mut piece) = rest.take().or_else(|| work.next()) {
            let size = Size::new(&conditions[piece.cell], duration_s);
            let n_fitting = match room.fitting(size) {
                0 if block.pieces.is_empty() => size.at_once,
                n_fitting => n_fitting,
            };
            let n_rest = piece.n_rows().saturating_sub(n_fitting);
            // What is less than a vector is no block of its own.
            let is_all = n_fitting > 0 && n_rest < size.at_once && piece.n_rows() <= room.rows;
            let n_taken = if is_all { piece.n_rows() } else { n_fitting.min(piece.n_rows()) };
            if n_taken > 0 {
                let end = piece.replicates.start + n_taken;
                block.pieces.push(CellReplicates {
                    cell: piece.cell,
                    replicates: piece.replicates.start..end,
                });
                piece.replicates.start = end;
                room.take(n_taken, size);
            }
            if piece.n_rows() > 0 {
                rest = Some(piece);
                break;
            }
        }
        (!block.pieces.is_empty()).then_some(block)
    })
}

/// What a replicate of a cell takes.
#[derive(Clone, Copy)]
struct Size {
    /// Replicates that stay together.
    at_once: u64,
    /// As of robots in vectors.
    agent_steps: u64,
}

impl Size {
    fn new(conditions: &Conditions, duration_s: f64) -> Self {
        let (at_once, per_step) = if runs_in_lanes(conditions, duration_s) {
            (MOST_LANES as u64, conditions.robots as u64)
        } else {
            let n_bodies = conditions.robots + conditions.world.n_objects();
            (1, REFERENCE_STEPS * n_bodies as u64)
        };
        let agent_steps = conditions.steps(duration_s).saturating_mul(per_step);
        Self { at_once, agent_steps: agent_steps.max(1) }
    }
}

/// What still fits into a block.
struct Room {
    rows: u64,
    agent_steps: u64,
}

impl Room {
    /// How many replicates fit, in full vectors.
    fn fitting(&self, size: Size) -> u64 {
        let n = self.rows.min(self.agent_steps / size.agent_steps);
        n - n % size.at_once
    }

    fn take(&mut self, n: u64, size: Size) {
        self.rows = self.rows.saturating_sub(n);
        self.agent_steps = self.agent_steps.saturating_sub(n.saturating_mul(size.agent_steps));
    }
}
