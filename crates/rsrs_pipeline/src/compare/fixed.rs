//! Campaigns whose number of runs was fixed before the first of them.

use std::collections::BTreeMap;

use anyhow::bail;
use rsrs_core::comparison::fixed::{FixedCell, FixedDesign, FixedRun, FixedTest};
use rsrs_core::comparison::{MARGIN, Verdict};
use rsrs_core::statistics::share::Share;
use serde::Serialize;

use super::Runs;
use super::run_matching::Admitted;
use crate::error::with_help;

/// Where a campaign stands whose number of runs was fixed.
#[derive(Clone, Debug, Serialize)]
pub struct FixedCampaign {
    /// Runs that were fixed.
    pub runs: u64,
    /// Those of them that are made.
    pub made: u64,
    /// Those among these that were left out for a cause after their start: each is held against either
    /// verdict.
    pub left_out: u64,
    /// Those that ended as wanted.
    pub milled: u64,
    /// What decides; not there before all are made.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub test: Option<FixedTest>,
    /// What follows; `undecided` before all are made.
    pub verdict: Verdict,
}

/// What was fixed before the first of some runs; `None` if nothing was.
///
/// # Errors
///
/// If the runs are not of one design, or one of them was made twice.
pub fn design(admitted: &[Admitted]) -> anyhow::Result<Option<FixedDesign>> {
    let Some(first) = admitted.first() else { return Ok(None) };
    let design = |run: &Admitted| run.record.fixed.map(FixedRun::design);
    if let Some(other) = admitted.iter().find(|run| design(run) != design(first)) {
        let words = |run: &Admitted| match design(run) {
            None => "has no number of runs that was fixed".to_owned(),
            Some(FixedDesign { runs, margin }) => {
                format!("is of {runs} runs with the margin {margin}, which were fixed")
            }
        };
        return Err(with_help(
            format!(
                "{} {}, and {} {}",
                first.bag.display(),
                words(first),
                other.bag.display(),
                words(other)
            ),
            "compare the runs of each campaign apart",
        ));
    }
    let mut made: BTreeMap<u64, &Admitted> = BTreeMap::new();
    for run in admitted.iter().filter(|run| run.cause().is_none()) {
        let Some(FixedRun { number, runs, .. }) = run.record.fixed else { continue };
        if let Some(other) = made.insert(number, run) {
            bail!(
                "{} and {} are both run {number} of the {runs} that were fixed",
                other.bag.display(),
                run.bag.display()
            );
        }
    }
    Ok(design(first))
}

/// The margin of a comparison, which is refused if it is not the one that was fixed.
pub fn margin(asked: Option<f64>, design: Option<FixedDesign>) -> anyhow::Result<f64> {
    match (asked, design) {
        (Some(asked), Some(FixedDesign { margin, .. })) if asked.to_bits() != margin.to_bits() => {
            Err(with_help(
                format!("--margin is {asked}, and {margin} was fixed before the first run"),
                "leave `--margin` out",
            ))
        }
        (_, Some(FixedDesign { margin, .. })) => Ok(margin),
        (asked, None) => Ok(asked.unwrap_or(MARGIN)),
    }
}

/// What became of one of the runs that were fixed.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// The index of its cell in the diagram.
    cell: usize,
    /// Whether an attempt at it was left out for a cause after its start; the one that was made in its
    /// place does not count then.
    is_left_out: bool,
    milled: bool,
}

impl FixedCampaign {
    /// Where a campaign stands; `simulated` has the runs of a cell, by its index in the diagram.
    pub fn new(
        design: FixedDesign,
        runs: &Runs,
        simulated: impl Fn(usize) -> anyhow::Result<Share>,
    ) -> anyhow::Result<Self> {
        let mut slots: BTreeMap<u64, Slot> = BTreeMap::new();
        for (_, run, labelled) in &runs.counted {
            let Some(FixedRun { number, .. }) = run.record.fixed else { continue };
            let slot = slots.entry(number).or_default();
            slot.cell = run.cell;
            slot.milled = labelled.phase == labelled.phase.behaviour().wanted();
        }
        for run in runs.left_out.iter().filter(|run| run.not_counted.after_start) {
            let Some(number) = run.number else { continue };
            let slot = slots.entry(number).or_default();
            (slot.cell, slot.is_left_out) = (run.cell, true);
        }
        let made = slots.len() as u64;
        let count =
            |is_it: fn(&Slot) -> bool| slots.values().filter(|slot| is_it(slot)).count() as u64;
        let left_out = count(|slot| slot.is_left_out);
        let milled = count(|slot| !slot.is_left_out && slot.milled);
        let mut campaign = Self {
            runs: design.runs,
            made,
            left_out,
            milled,
            test: None,
            verdict: Verdict::Undecided,
        };
        if made < design.runs {
            return Ok(campaign);
        }
        let mut cells: BTreeMap<usize, FixedCell> = BTreeMap::new();
        for slot in slots.values() {
            let simulated = simulated(slot.cell)?;
            cells.entry(slot.cell).or_insert(FixedCell { runs: 0, simulated }).runs += 1;
        }
        let claims = |cell: usize| cells[&cell].claims(design.margin);
        let claimed = slots.values().filter(|slot| claims(slot.cell));
        let mills = claimed.filter(|slot| !slot.is_left_out && slot.milled).count() as u64;
        let test = FixedTest::new(&cells.values().copied().collect::<Vec<_>>(), design.margin);
        campaign.verdict = test.verdict(mills, milled + left_out);
        campaign.test = Some(test);
        Ok(campaign)
    }
}
