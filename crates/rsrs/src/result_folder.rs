//! The folder of a sweep: written whole or not at all, and read back.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::axis::{Axis, Cell};
use rsrs_core::choice::Choice;
use rsrs_core::comparison::Share;
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::document;
use rsrs_core::phase::Phase;
use rsrs_sim::sweep::Swept;

use crate::failure::with_help;
use crate::picture;
use crate::replicate_table;
use crate::sweep_source::ResolvedSweep;

const SWEEP: &str = "sweep.yaml";
const CELLS: &str = "cells.csv";
const CHOICE: &str = "choice.json";

/// A finished sweep.
#[derive(Clone, Debug)]
pub struct SweepResult {
    /// What was swept.
    pub source: ResolvedSweep,
    /// What came out.
    pub diagram: PhaseDiagram,
}

/// What an output folder is before a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Nothing is there.
    Nothing,
    /// The results of this very sweep are there.
    SameSweep,
}

/// Looks at an output folder before anything is computed.
///
/// # Errors
///
/// If the folder holds anything else than the results of this very sweep.
pub fn look(folder: &Path, source: &ResolvedSweep) -> anyhow::Result<Existing> {
    if !folder.exists() {
        return Ok(Existing::Nothing);
    }
    let path = folder.join(SWEEP);
    let refuse = |what: &str| {
        Err(with_help(
            format!("{} exists and {what}", folder.display()),
            "give another folder with `-o`, or remove this one",
        ))
    };
    if !path.exists() {
        return refuse("is not the folder of a sweep");
    }
    if !read_source(folder)?.same_results(source) {
        return refuse("holds another sweep");
    }
    Ok(Existing::SameSweep)
}

/// Writes a finished sweep: into a folder beside it first, which is then renamed.
///
/// # Errors
///
/// If anything cannot be written; then nothing is left behind.
pub fn write(folder: &Path, result: &SweepResult, swept: &Swept) -> anyhow::Result<()> {
    let draft = draft_beside(folder)?;
    let written = write_files(&draft, result, swept).and_then(|()| {
        std::fs::rename(&draft, folder).with_context(|| format!("cannot make {}", folder.display()))
    });
    if written.is_err() {
        // The first error is the one to report; a draft that cannot be removed is named by it.
        drop(std::fs::remove_dir_all(&draft));
    }
    written
}

fn draft_beside(folder: &Path) -> anyhow::Result<PathBuf> {
    let name = folder.file_name().context("the output folder needs a name")?;
    let parent = folder.parent().unwrap_or(Path::new(""));
    let draft = parent.join(format!(".{}.{}", name.to_string_lossy(), std::process::id()));
    std::fs::create_dir_all(&draft).with_context(|| format!("cannot make {}", draft.display()))?;
    Ok(draft)
}

fn write_files(draft: &Path, result: &SweepResult, swept: &Swept) -> anyhow::Result<()> {
    let sweep = serde_saphyr::to_string(&result.source).context("the sweep as YAML")?;
    write_file(&draft.join(SWEEP), sweep.as_bytes())?;
    write_file(&draft.join(CELLS), cells_csv(&result.diagram).as_bytes())?;
    let cells: Vec<Cell> = result.diagram.cells.iter().map(|entry| entry.cell.clone()).collect();
    replicate_table::write(
        &draft.join("replicates.parquet"),
        &result.diagram.axes,
        &cells,
        (result.source.sweep.seed, &swept.outcomes),
    )?;
    let svg = picture::of_sweep(result, &picture::Wish::default())?;
    write_file(&draft.join("diagram.svg"), svg.as_bytes())?;
    write_file(&draft.join("diagram.png"), &rsrs_view::raster::png(&svg, picture::PNG_WIDTH_PX)?)
}

/// Writes one file, naming it when that fails.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Axes, number of replicates, one count for each phase, majority, share of stable milling with
/// its interval.
fn cells_csv(diagram: &PhaseDiagram) -> String {
    let mut csv = String::new();
    for axis in &diagram.axes {
        csv.push_str(axis.key());
        csv.push(',');
    }
    csv.push('n');
    for phase in Phase::ALL {
        csv.push(',');
        csv.push_str(phase.key());
    }
    csv.push_str(",phase,b_s,b_s_low,b_s_high\n");
    for entry in &diagram.cells {
        for (_, value) in entry.cell.iter() {
            write!(csv, "{value},").expect("a string takes any text");
        }
        write!(csv, "{}", entry.counts.total()).expect("a string takes any text");
        for phase in Phase::ALL {
            write!(csv, ",{}", entry.counts.get(phase)).expect("a string takes any text");
        }
        let phase = entry.counts.majority().map_or("", Phase::key);
        let share = Share::milling(&entry.counts);
        let interval = share.interval();
        writeln!(csv, ",{phase},{:.6},{:.6},{:.6}", share.value(), interval.low, interval.high)
            .expect("a string takes any text");
    }
    csv
}

/// Reads the folder of a sweep back.
///
/// # Errors
///
/// If it is not the folder of a sweep, or a file in it was changed.
pub fn read(folder: &Path) -> anyhow::Result<SweepResult> {
    let source = read_source(folder)?;
    let path = folder.join(CELLS);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let axes = source.sweep.swept_axes();
    let cells = read_cells(&text, &axes).with_context(|| path.display().to_string())?;
    let swept: Vec<Cell> = cells.iter().map(|entry| entry.cell.clone()).collect();
    if swept != source.sweep.all_cells() {
        bail!("{} does not hold the cells of {SWEEP}", path.display());
    }
    Ok(SweepResult { source, diagram: PhaseDiagram { axes, cells } })
}

/// Reads the choice that lies beside a sweep's files; `None` if there is none.
///
/// # Errors
///
/// If there is a file that is no choice.
pub fn read_choice(folder: &Path) -> anyhow::Result<Option<Choice>> {
    let path = folder.join(CHOICE);
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let choice =
        serde_json::from_str(&text).with_context(|| format!("{} is no choice", path.display()))?;
    Ok(Some(choice))
}

fn read_source(folder: &Path) -> anyhow::Result<ResolvedSweep> {
    let path = folder.join(SWEEP);
    if !path.exists() {
        return Err(with_help(
            format!("{} is not the folder of a sweep: it has no {SWEEP}", folder.display()),
            "make one with `rsrs sweep SWEEP.yaml -o DIR`",
        ));
    }
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    Ok(document::parse(&path.display().to_string(), &text)?)
}

fn read_cells(text: &str, axes: &[Axis]) -> anyhow::Result<Vec<DiagramCell>> {
    text.lines()
        .enumerate()
        .skip(1)
        .map(|(line, row)| {
            let fields: Vec<&str> = row.split(',').collect();
            read_cell(&fields, axes).with_context(|| format!("line {}", line + 1))
        })
        .collect()
}

fn read_cell(fields: &[&str], axes: &[Axis]) -> anyhow::Result<DiagramCell> {
    let expected = axes.len() + 1 + Phase::ALL.len() + 4;
    if fields.len() != expected {
        bail!("found {} fields, expected {expected}", fields.len());
    }
    let (values, rest) = fields.split_at(axes.len());
    let number = |text: &&str| text.parse::<f64>().with_context(|| format!("`{text}`"));
    let values = values.iter().map(number).collect::<anyhow::Result<Vec<f64>>>()?;
    let mut counts = PhaseCounts::default();
    for (phase, field) in Phase::ALL.into_iter().zip(&rest[1..]) {
        let n: u64 = field.parse().with_context(|| format!("`{field}` as a count"))?;
        counts.add_many(phase, n);
    }
    Ok(DiagramCell { cell: Cell::new(axes.iter().copied().zip(values))?, counts })
}
