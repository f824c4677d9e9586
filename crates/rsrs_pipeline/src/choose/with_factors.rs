//! A choice, with what else is known of its cell.

use std::path::Path;

use rsrs_core::quantity::Cell;

use super::extension::{Extension, extensions};
use super::pseudo_realities::{Draws, InPseudoRealities, can_be_drawn, pseudo_realities};
use super::{Chosen, SearchOptions, choose_in, write};
use crate::sweep::ablation::{Ablation, REPLICATES, ablate};
use crate::sweep::folder;

/// What came of choosing, and what else is known of the cell.
#[derive(Clone, Debug)]
pub struct ChosenWithFactors {
    /// What came of choosing.
    pub chosen: Chosen,
    /// How the sweep would have to go on where a viable cell lies at its edge.
    pub extensions: Vec<Extension>,
    /// What every factor that makes robots worse does in the cell; `None` if none changes a robot.
    pub factors: Option<Ablation>,
    /// What comes of all cells in pseudo-realities, where they were asked for.
    pub pseudo_realities: Option<InPseudoRealities>,
}

impl ChosenWithFactors {
    /// The chosen cell; where none is viable, the best of those that were confirmed.
    pub fn cell(&self) -> &Cell {
        match &self.chosen {
            Chosen::Viable(choice) => &choice.cell,
            Chosen::NoViableCell(none) => &none.best.cell,
        }
    }
}

/// Chooses the best setting of the sweep in a folder as [`choose`](super::choose) does, and finds what each factor does in its
/// cell and, if `draws` are given, how all cells do in pseudo-realities. A viable choice is written into `output`
/// as soon as it is made.
pub fn choose_with_factors(
    folder: &Path,
    options: SearchOptions<'_>,
    draws: Option<Draws>,
    output: Option<&Path>,
) -> anyhow::Result<ChosenWithFactors> {
    let result = folder::read(folder)?;
    if let Some(draws) = draws {
        // Before minutes of runs, not after them.
        can_be_drawn(&result, draws.widening)?;
    }
    let chosen = choose_in(result.clone(), options)?;
    let mut found =
        ChosenWithFactors { chosen, extensions: Vec::new(), factors: None, pseudo_realities: None };
    if let Chosen::Viable(choice) = &found.chosen {
        if let Some(path) = output {
            write(path, choice)?;
        }
        found.extensions = extensions(&result, choice);
    }
    let replicates = REPLICATES.min(options.confirm);
    found.factors = ablate(&result.source, found.cell(), replicates, options.execution)?;
    let result = result.of_robots(options.robots)?;
    let of_draws = |draws| pseudo_realities(&result, draws, options.execution);
    found.pseudo_realities = draws.map(of_draws).transpose()?;
    Ok(found)
}
