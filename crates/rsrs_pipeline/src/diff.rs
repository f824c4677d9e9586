//! Two sweeps, cell by cell: where robots end as wanted more often in one of them than in the other.

use std::fmt;
use std::path::{Path, PathBuf};

use rsrs_core::diagram::DiagramCell;
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::share::Share;
use serde::Serialize;

use crate::error::with_help;
use crate::picture::{CellNumbers, DiagramOptions, ShareDifference, Worlds, of_sweep};
use crate::sweep::folder;
use crate::sweep::result::{SweepResult, World};
use crate::wording::{counted, quantity};

/// Two sweeps in one world.
#[derive(Clone, Debug, Serialize)]
pub struct SweepDifference {
    /// Folder of the first one.
    pub from: PathBuf,
    /// Folder of the second one.
    pub to: PathBuf,
    /// The world: `harsher` or `as_measured`.
    pub world: &'static str,
    /// Cells that both have.
    pub n_cells: usize,
    /// Those whose 95 % intervals do not overlap.
    pub n_moved: usize,
    /// Cells that only the first one has.
    pub n_only_from: usize,
    /// Cells that only the second one has.
    pub n_only_to: usize,
    /// The cells that both have, in the order of the second one.
    pub cells: Vec<CellDifference>,
    #[serde(skip)]
    noun: &'static str,
}

/// One cell in two sweeps.
#[derive(Clone, Debug, Serialize)]
pub struct CellDifference {
    /// The cell.
    pub cell: Cell,
    /// Share of the wanted phase in the first one.
    pub b_s_from: f64,
    /// Share of the wanted phase in the second one.
    pub b_s_to: f64,
    /// The second less the first.
    pub difference: f64,
    /// Whether the 95 % intervals do not overlap.
    pub moved: bool,
    #[serde(skip)]
    shares: ShareDifference,
}

/// Compares two sweeps.
///
/// # Errors
///
/// If a folder is not a sweep's, they are about different behaviours or axes, or no cell is in both.
pub fn diff(
    from: &Path,
    to: &Path,
    world: World,
) -> anyhow::Result<(SweepDifference, SweepResult)> {
    let (one, mut other) = (folder::read(from)?, folder::read(to)?);
    let (first, second) = (one.of_world(world)?, other.of_world(world)?);
    if one.source.sweep.behaviour != other.source.sweep.behaviour {
        return Err(with_help(
            format!(
                "{} is about {}, and {} about {}",
                from.display(),
                one.source.sweep.behaviour,
                to.display(),
                other.source.sweep.behaviour
            ),
            "compare sweeps of one behaviour",
        ));
    }
    let kinds = [one.source.sweep.interval_kind(), other.source.sweep.interval_kind()];
    let pair = |entry: &DiagramCell| {
        let before = first.find(&entry.cell)?;
        let shares = ShareDifference {
            from: Share::milling(&before.counts),
            to: Share::milling(&entry.counts),
            kinds,
        };
        Some(CellDifference {
            cell: entry.cell.clone(),
            b_s_from: shares.from.value(),
            b_s_to: shares.to.value(),
            difference: shares.difference(),
            moved: shares.has_moved(),
            shares,
        })
    };
    let cells: Vec<CellDifference> = second.cells.iter().filter_map(pair).collect();
    if cells.is_empty() {
        return Err(with_help(
            format!("no cell of {} was swept in {}, too", to.display(), from.display()),
            "compare sweeps over the same axes, with values in common",
        ));
    }
    let difference = SweepDifference {
        from: from.to_path_buf(),
        to: to.to_path_buf(),
        world: world.key(),
        n_cells: cells.len(),
        n_moved: cells.iter().filter(|cell| cell.moved).count(),
        n_only_from: first.cells.len() - cells.len(),
        n_only_to: second.cells.len() - cells.len(),
        noun: other.source.sweep.behaviour.noun(),
        cells,
    };
    let is_common = |entry: &DiagramCell| difference.cells.iter().any(|it| it.cell == entry.cell);
    for diagram in std::iter::once(&mut other.diagram).chain(&mut other.as_measured) {
        diagram.cells.retain(is_common);
    }
    Ok((difference, other))
}

impl SweepDifference {
    /// The map of the differences, as SVG.
    ///
    /// # Arguments
    ///
    /// * `common` — the second sweep, with the cells that both have.
    /// * `options` — how it is drawn.
    ///
    /// # Errors
    ///
    /// If it cannot be drawn.
    pub fn svg(
        &self,
        common: &SweepResult,
        world: World,
        options: DiagramOptions,
    ) -> anyhow::Result<String> {
        let shares: Vec<ShareDifference> = self.cells.iter().map(|cell| cell.shares).collect();
        let name =
            format!("share of {}: {} less {}", self.noun, name_of(&self.to), name_of(&self.from));
        let options = DiagramOptions {
            title: Some(format!("From {} to {}", name_of(&self.from), name_of(&self.to))),
            values: Some(CellNumbers::differences(name, &shares)),
            worlds: Worlds::One(world),
            ..options
        };
        of_sweep(common, &options)
    }
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

impl fmt::Display for SweepDifference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{}: the share of {} moved beyond its 95 % interval in {}",
            counted(self.n_cells as u64, "cell"),
            self.noun,
            self.n_moved
        )?;
        let mut moved: Vec<&CellDifference> = self.cells.iter().filter(|it| it.moved).collect();
        moved.sort_by(|one, other| other.difference.abs().total_cmp(&one.difference.abs()));
        for CellDifference { cell, b_s_from, b_s_to, difference, .. } in moved {
            write!(
                out,
                "\n  {}: {b_s_from:.2} to {b_s_to:.2} ({difference:+.2})",
                quantity::of_cell(cell)
            )?;
        }
        for (n, folder) in [(self.n_only_from, &self.from), (self.n_only_to, &self.to)] {
            if n > 0 {
                write!(out, "\n{} only in {}", counted(n as u64, "cell"), folder.display())?;
            }
        }
        Ok(())
    }
}
