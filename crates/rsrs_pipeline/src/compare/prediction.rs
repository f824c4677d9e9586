//! How often simulated robots mill in a cell: what real runs are held against.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::{AsMeasured, Choice};
use rsrs_core::diagram::folder::CHOICE;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::statistics::share::Share;
use rsrs_files::quoted;

use crate::error::with_help;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;

/// The part of the error that the chosen cell has beside others.
pub const CHOSEN: f64 = 0.5;

/// Simulated runs of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Simulated {
    /// How they ended.
    pub phases: PhaseCounts,
    /// Whether they are fresh ones, which did not choose the cell.
    pub is_confirmed: bool,
}

/// What a reader of what rests on a prediction must not overlook.
#[derive(Clone, Debug)]
pub enum Note {
    /// No cell was chosen in this folder of a sweep, and confirmed on fresh seeds.
    NothingChosen(PathBuf),
    /// In the chosen cell robots that are made worse do as is wanted more often.
    WorseIsBetter {
        /// The choice.
        choice: Box<Choice>,
        /// What robots as measured do there.
        measured: AsMeasured,
    },
}

/// The cells of a sweep.
pub struct Prediction<'a> {
    folder: &'a Path,
    result: &'a SweepResult,
    /// The chosen cell, by its index in the diagram.
    pub chosen: Option<(usize, Choice)>,
}

impl<'a> Prediction<'a> {
    /// That of a sweep, with the choice beside it.
    pub fn new(folder: &'a Path, result: &'a SweepResult) -> anyhow::Result<Self> {
        let chosen = match folder::read_choice(folder)? {
            None => None,
            Some(choice) => {
                let SweepResult { source, .. } = result;
                let digest = choice.sweep_digest.as_deref();
                source.sweep.check_choice(&source.profile, digest).map_err(|error| {
                    let message = format!("choice.json in {} {error}", folder.display());
                    with_help(message, choose_again(folder))
                })?;
                let index = result.diagram.locate(&choice.cell).map_err(|error| {
                    let message =
                        format!("choice.json in {} is of another sweep: {error}", folder.display());
                    with_help(message, choose_again(folder))
                })?;
                Some((index, choice))
            }
        };
        Ok(Self { folder, result, chosen })
    }

    /// What is to be noted about the chosen cell, if anything.
    pub fn note(&self) -> Option<Note> {
        let Some((_, choice)) = &self.chosen else {
            return Some(Note::NothingChosen(self.folder.to_path_buf()));
        };
        let measured = choice.as_measured.filter(|_| choice.worse_is_better())?;
        Some(Note::WorseIsBetter { choice: Box::new(choice.clone()), measured })
    }

    /// A cell's part of the error, which is fixed by the sweep and its choice, before any run: one half is that
    /// of the chosen cell, and the other cells have equal parts of the rest, whether they are run or not.
    pub fn part(&self, index: usize) -> f64 {
        let n_cells = self.result.diagram.cells.len() as f64;
        match &self.chosen {
            _ if n_cells < 2.0 => 1.0,
            Some((chosen, _)) if *chosen == index => CHOSEN,
            Some(_) => (1.0 - CHOSEN) / (n_cells - 1.0),
            None => 1.0 / n_cells,
        }
    }

    /// How often robots as measured mill in a cell: fresh runs of the chosen one, of others those of the
    /// sweep; `None` in a sweep of one world that is not theirs.
    pub fn as_measured(&self, index: usize) -> Option<Share> {
        let confirmed = self.chosen.as_ref().filter(|(chosen, _)| *chosen == index);
        if let Some(measured) = confirmed.and_then(|(_, choice)| choice.as_measured) {
            return Some(measured.milling());
        }
        match self.result.worlds().ok()?.as_measured {
            Some(measured) => Some(Share::milling(&measured.cells.get(index)?.counts)),
            // The simulated robots are as measured.
            None => Some(Share::milling(&self.of_cell(index).ok()?.phases)),
        }
    }

    /// Replicates of the sweep; of the chosen cell its fresh ones, because those of the sweep have
    /// chosen it and flatter it.
    pub fn of_cell(&self, index: usize) -> anyhow::Result<Simulated> {
        match &self.chosen {
            Some((chosen, choice)) if *chosen == index => match choice.phases {
                Some(phases) => Ok(Simulated { phases, is_confirmed: true }),
                None => Err(with_help(
                    format!(
                        "choice.json in {} does not state how its fresh runs ended",
                        self.folder.display()
                    ),
                    choose_again(self.folder),
                )),
            },
            _ => Ok(Simulated {
                phases: self.result.diagram.cells[index].counts,
                is_confirmed: false,
            }),
        }
    }
}

/// The error of who needs a cell, and neither was one named nor chosen.
pub fn nothing_chosen(folder: &Path) -> anyhow::Error {
    let message = format!("{} has no {CHOICE}, and no cell is named", folder.display());
    let help = format!("name one with `--cell AXIS=VALUE,…`, or {}", choose_again(folder));
    with_help(message, help)
}

/// What to type where the choice is of no use.
fn choose_again(folder: &Path) -> String {
    format!("choose again: `{}`", choose_line(folder))
}

/// The command that chooses a cell and keeps it where it is looked for.
pub fn choose_line(folder: &Path) -> String {
    format!("rsrs choose {} -o {}", quoted(folder), quoted(folder.join(CHOICE)))
}
