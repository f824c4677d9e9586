//! Sweeps of this document: their files, run by `rsrs sweep`, and what came of every cell.

use std::path::Path;

use anyhow::Context;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::judge::phase::Phase;

use crate::program::Program;

/// A sweep that this document needs and no file in `launch_configs` describes.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Folder of its result.
    pub name: &'a str,
    /// Profile, in `launch_configs/profiles`.
    pub profile: &'a str,
    /// `harsher:` in YAML.
    pub harsher: &'a str,
    /// `axes:` in YAML.
    pub axes: &'a str,
    /// `fixed:` in YAML.
    pub fixed: &'a str,
    /// Length of each run, in seconds.
    pub duration_s: u32,
    /// Seed of the sweep.
    pub seed: u64,
}

/// Runs of each cell.
pub const REPLICATES: u64 = 100;

/// Runs a sweep and reads its cells.
///
/// # Errors
///
/// If the sweep fails.
pub fn sweep(program: &Program, folder: &Path, wanted: &Wanted) -> anyhow::Result<PhaseDiagram> {
    let Wanted { name, profile, harsher, axes, fixed, duration_s, seed } = wanted;
    let text = format!(
        "profile: launch_configs/profiles/{profile}.yaml\nharsher: {harsher}\naxes: {axes}\n\
         fixed: {fixed}\nreplicates: {REPLICATES}\nduration_s: {duration_s}\n\
         seed: {seed}\n"
    );
    let file = folder.join(format!("{name}.yaml"));
    std::fs::write(&file, text).with_context(|| file.display().to_string())?;
    program.run(&format!("sweep {name}.yaml -o {name}"))?;
    read(&folder.join(name).join("cells.csv"))
}

/// Reads `cells.csv` of a sweep.
///
/// # Errors
///
/// If it is not there or not a table of cells.
pub fn read(path: &Path) -> anyhow::Result<PhaseDiagram> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().context("a header")?.split(',').collect();
    let axes: Vec<Axis> = names
        .iter()
        .take_while(|name| **name != "n")
        .map(|name| name.parse())
        .collect::<Result<_, _>>()?;
    let cells = lines.map(|line| cell(&names, &axes, line)).collect::<anyhow::Result<_>>()?;
    Ok(PhaseDiagram { axes, cells })
}

fn cell(names: &[&str], axes: &[Axis], line: &str) -> anyhow::Result<DiagramCell> {
    let fields: Vec<&str> = line.split(',').collect();
    let values = axes.iter().zip(&fields).map(|(axis, field)| Ok((*axis, field.parse::<f64>()?)));
    let cell = Cell::new(values.collect::<anyhow::Result<Vec<_>>>()?)?;
    let mut counts = PhaseCounts::default();
    for phase in Phase::ALL {
        let column = names.iter().position(|name| *name == phase.key());
        let column = column.with_context(|| format!("a column {}", phase.key()))?;
        counts.add_many(phase, fields[column].parse()?);
    }
    Ok(DiagramCell { cell, counts })
}

/// How often the cell with these values milled, from 0 to 1.
///
/// # Panics
///
/// If it was not swept.
pub fn b_s(diagram: &PhaseDiagram, values: &[(Axis, f64)]) -> f64 {
    counts(diagram, values).share(Phase::StableMilling)
}

/// How the runs of the cell with these values ended.
///
/// # Panics
///
/// If it was not swept.
pub fn counts(diagram: &PhaseDiagram, values: &[(Axis, f64)]) -> PhaseCounts {
    let is_it = |entry: &&DiagramCell| {
        let near = |(axis, value): &(Axis, f64)| {
            entry.cell.get(*axis).is_some_and(|found| (found - value).abs() < 1e-9)
        };
        values.iter().all(near)
    };
    diagram.cells.iter().find(is_it).expect("only swept cells are asked for").counts
}
