//! The most robust setting of a grid.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::axis::Cell;
use rsrs_core::diagram::choice::{Worlds, rank};
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::statistics::interval_kind::IntervalKind;
use rsrs_core::statistics::share::Share;

use crate::best_setting::search::{Changes, Confirmed, Search};

/// Runs of every cell of the grid, in each world.
const REPLICATES: u64 = 16;

/// Recommends a setting: the one from which each quantity may drift farthest, confirmed on fresh seeds.
///
/// # Returns
///
/// Of settings that are not viable the best; `None` if there is none in which the robots can be
/// simulated.
///
/// # Errors
///
/// If runs are called off or fail.
pub fn recommend(search: &Search<'_>) -> anyhow::Result<Option<Confirmed>> {
    let Some((simulated, as_measured)) = diagrams(search)? else {
        return Ok(None);
    };
    let worlds = Worlds { simulated: &simulated, as_measured: as_measured.as_ref() };
    let ranked = rank(worlds, IntervalKind::ClopperPearson, search.wanted);
    let mut cells: Vec<&Cell> = ranked.iter().map(|candidate| &candidate.cell).collect();
    if cells.is_empty() {
        let least = |index: &usize| {
            let worlds = [Some(&simulated), as_measured.as_ref()];
            let milling =
                |diagram: &PhaseDiagram| Share::milling(&diagram.cells[*index].counts).value();
            worlds.into_iter().flatten().map(milling).fold(1.0, f64::min)
        };
        let best = (0..simulated.cells.len())
            .rev()
            .max_by(|one, other| least(one).total_cmp(&least(other)));
        cells.extend(best.map(|index| &simulated.cells[index].cell));
    }
    let none = Changes::new();
    let mut best: Option<Confirmed> = None;
    for (attempt, cell) in (0..).zip(cells) {
        let confirmed = search.confirmed(&none, cell, attempt)?;
        let is_enough = confirmed.b_s_low >= search.wanted;
        if best.as_ref().is_none_or(|best| confirmed.b_s_low > best.b_s_low) {
            best = Some(confirmed);
        }
        if is_enough {
            break;
        }
    }
    Ok(best)
}

/// The grid in both worlds, the cells left out in which robots cannot be simulated; `None` if those are
/// all.
fn diagrams(search: &Search<'_>) -> anyhow::Result<Option<(PhaseDiagram, Option<PhaseDiagram>)>> {
    let none = Changes::new();
    let mut cells = Vec::new();
    let mut worlds: [Vec<Conditions>; 2] = [Vec::new(), Vec::new()];
    for cell in &search.grid.cells {
        if let Some([harsher, measured]) = search.in_both_worlds(&none, cell) {
            cells.push(cell);
            worlds[0].push(harsher);
            worlds[1].push(measured);
        }
    }
    let Some(first) = cells.first() else { return Ok(None) };
    let axes = first.axes();
    let diagram = |counts: &[PhaseCounts]| PhaseDiagram {
        axes: axes.clone(),
        cells: (cells.iter().zip(counts))
            .map(|(cell, counts)| DiagramCell { cell: (*cell).clone(), counts: *counts })
            .collect(),
    };
    let n_worlds = if worlds[0] == worlds[1] { 1 } else { 2 };
    let conditions = worlds[..n_worlds].concat();
    let runs = (search.grid.seed, REPLICATES);
    let counts = search.counts(&conditions, runs, "looking for the milling region")?;
    let mut diagrams = counts.chunks(cells.len()).map(diagram);
    let simulated = diagrams.next().expect("there is a cell");
    Ok(Some((simulated, diagrams.next())))
}
