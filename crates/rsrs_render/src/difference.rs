//! Two sweeps, cell by cell, in words and as a map.

use std::path::PathBuf;

use rsrs_core::numerals::counted;
use rsrs_pipeline::diff::{CellDifference, Changed, SweepDifference};
use rsrs_pipeline::sweep::result::{SweepResult, World};
use rsrs_pipeline::sweep::share_difference::ShareDifference;
use serde_json::Value;

use crate::picture::{CellNumbers, DiagramOptions, Worlds, of_sweep};
use crate::wording::quantity;

/// Which cells moved, and what is not the same in both.
pub fn text(difference: &SweepDifference) -> String {
    let SweepDifference { n_cells, n_moved, noun, .. } = difference;
    let mut lines = vec![format!(
        "{}: the share of {noun} moved beyond its 95 % interval in {n_moved}",
        counted(*n_cells as u64, "cell")
    )];
    let mut moved: Vec<&CellDifference> = difference.cells.iter().filter(|it| it.moved).collect();
    moved.sort_by(|one, other| other.difference.abs().total_cmp(&one.difference.abs()));
    lines.extend(moved.into_iter().map(
        |CellDifference { cell, b_s_from, b_s_to, difference, .. }| {
            let cell = quantity::of_cell(cell);
            format!("  {cell}: {b_s_from:.2} to {b_s_to:.2} ({difference:+.2})")
        },
    ));
    let text = |value: &Value| match value {
        Value::Null => "nothing".to_owned(),
        Value::Array(_) => "a list".to_owned(),
        Value::String(text) => text.clone(),
        Value::Bool(_) | Value::Number(_) | Value::Object(_) => value.to_string(),
    };
    lines.extend(difference.changed.iter().map(|Changed { key, from, to }| {
        format!("changed: {key} from {} to {}", text(from), text(to))
    }));
    let SweepDifference { from, to, n_only_from, n_only_to, .. } = difference;
    let only = [(n_only_from, from), (n_only_to, to)].into_iter().filter(|(n, _)| **n > 0);
    lines.extend(
        only.map(|(n, folder)| {
            format!("{} only in {}", counted(*n as u64, "cell"), folder.display())
        }),
    );
    lines.join("\n")
}

/// The map of the differences, as SVG; `common` is the second sweep, with the cells that both have.
pub fn svg(
    difference: &SweepDifference,
    common: &SweepResult,
    world: World,
    options: DiagramOptions,
) -> anyhow::Result<String> {
    let shares: Vec<ShareDifference> = difference.cells.iter().map(|cell| cell.shares).collect();
    let [from, to] = names(difference);
    let name = format!("share of {}: {to} less {from}", difference.noun);
    let options = DiagramOptions {
        title: Some(format!("From {from} to {to}")),
        values: Some(CellNumbers::differences(name, &shares)),
        worlds: Worlds::One(world),
        ..options
    };
    of_sweep(common, &options)
}

/// The names of both folders, with the folders that they are in if they are alike.
fn names(difference: &SweepDifference) -> [String; 2] {
    let name = |folder: &PathBuf| {
        folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
    };
    let names = [&difference.from, &difference.to].map(name);
    let is_alike = names[0] == names[1];
    if is_alike {
        [&difference.from, &difference.to].map(|it| it.display().to_string())
    } else {
        names
    }
}
