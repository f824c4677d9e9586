//! `cells.csv`: one line for each cell, written and read back.

use std::fmt::Write;

use anyhow::{Context, bail};
use rsrs_core::axis::{Axis, Cell};
use rsrs_core::comparison::Share;
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::interval_kind::IntervalKind;
use rsrs_core::phase::Phase;

/// Axes, number of replicates, one count for each phase, majority, share of stable milling with its
/// interval; where cells have different numbers of replicates, also the kind of the interval.
pub fn to_csv(diagram: &PhaseDiagram, kind: IntervalKind) -> String {
    let phases = Phase::ALL.map(Phase::key);
    let axes = diagram.axes.iter().map(|axis| axis.key());
    let columns = axes.chain(["n"]).chain(phases).chain(["phase", "b_s", "b_s_low", "b_s_high"]);
    let columns: Vec<&str> = columns.chain(kind_column(kind).map(|(name, _)| name)).collect();
    let mut csv = columns.join(",") + "\n";
    for entry in &diagram.cells {
        write_line(&mut csv, entry, kind).expect("a string takes any text");
    }
    csv
}

/// The last column of adaptive sweeps, with its value.
fn kind_column(kind: IntervalKind) -> Option<(&'static str, &'static str)> {
    (kind != IntervalKind::ClopperPearson).then(|| ("interval", kind.key()))
}

fn write_line(csv: &mut String, entry: &DiagramCell, kind: IntervalKind) -> std::fmt::Result {
    for (_, value) in entry.cell.iter() {
        write!(csv, "{value},")?;
    }
    write!(csv, "{}", entry.counts.total())?;
    for phase in Phase::ALL {
        write!(csv, ",{}", entry.counts.get(phase))?;
    }
    let phase = entry.counts.majority().map_or("", Phase::key);
    let share = Share::milling(&entry.counts);
    let interval = kind.interval(share.hits, share.n);
    write!(csv, ",{phase},{:.6},{:.6},{:.6}", share.value(), interval.low, interval.high)?;
    if let Some((_, key)) = kind_column(kind) {
        write!(csv, ",{key}")?;
    }
    writeln!(csv)
}

/// Reads what [`to_csv`] wrote.
///
/// # Errors
///
/// If a line is not that of a cell with these axes and this kind of interval.
pub fn from_csv(text: &str, axes: &[Axis], kind: IntervalKind) -> anyhow::Result<Vec<DiagramCell>> {
    let n_fields = axes.len() + 1 + Phase::ALL.len() + 4 + kind_column(kind).iter().len();
    text.lines()
        .enumerate()
        .skip(1)
        .map(|(line, row)| {
            let fields: Vec<&str> = row.split(',').collect();
            if fields.len() != n_fields {
                bail!("line {}: found {} fields, expected {n_fields}", line + 1, fields.len());
            }
            read_cell(&fields, axes).with_context(|| format!("line {}", line + 1))
        })
        .collect()
}

fn read_cell(fields: &[&str], axes: &[Axis]) -> anyhow::Result<DiagramCell> {
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
