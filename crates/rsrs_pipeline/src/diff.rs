//! Two sweeps, cell by cell: where robots end as wanted more often in one of them than in the other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rsrs_core::diagram::DiagramCell;
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::share::Share;
use serde::Serialize;
use serde_json::Value;

use crate::error::with_help;
use crate::sweep::folder;
use crate::sweep::result::{SweepResult, World};
use crate::sweep::share_difference::ShareDifference;
use crate::sweep::source::ResolvedSweep;

/// Two sweeps in one world.
#[derive(Clone, Debug, Serialize)]
pub struct SweepDifference {
    /// Folder of the first one.
    pub from: PathBuf,
    /// Folder of the second one.
    pub to: PathBuf,
    /// The world: `harsher` or `as_measured`.
    pub world: &'static str,
    /// What differs between the two: robots, floor, factors, seed, number of runs.
    pub changed: Vec<Changed>,
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
    /// What the robots are to do, as a noun.
    #[serde(skip)]
    pub noun: &'static str,
}

/// One value that is not the same in two sweeps; `null` where one of them does not have it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Changed {
    /// Where it is: `profile.sensing.cone.range_m`.
    pub key: String,
    /// In the first one.
    pub from: Value,
    /// In the second one.
    pub to: Value,
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
    /// Both shares.
    #[serde(skip)]
    pub shares: ShareDifference,
}

/// Compares two sweeps; the results are both of them, with the cells that both have.
///
/// # Errors
///
/// If they are about different behaviours or axes, or no cell is in both.
pub fn diff(
    from: &Path,
    to: &Path,
    world: World,
) -> anyhow::Result<(SweepDifference, [SweepResult; 2])> {
    let (mut one, mut other) = (folder::read(from)?, folder::read(to)?);
    let (first, second) = (one.of_world(world)?, other.of_world(world)?);
    let behaviours = [&one, &other].map(|result| result.source.sweep.behaviour.known());
    if behaviours[0] != behaviours[1] {
        let [(from, before), (to, now)] =
            [(from.display(), behaviours[0]), (to.display(), behaviours[1])];
        let message = if before.to_string() == now.to_string() {
            format!("{from} and {to} both call it {now}, by different rules")
        } else {
            format!("{from} is about {before}, and {to} about {now}")
        };
        return Err(with_help(message, "compare sweeps of one behaviour"));
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
        changed: changed(&one.source, &other.source)?,
        n_cells: cells.len(),
        n_moved: cells.iter().filter(|cell| cell.moved).count(),
        n_only_from: first.cells.len() - cells.len(),
        n_only_to: second.cells.len() - cells.len(),
        noun: other.source.sweep.behaviour.known().noun(),
        cells,
    };
    let is_common = |entry: &DiagramCell| difference.cells.iter().any(|it| it.cell == entry.cell);
    for result in [&mut one, &mut other] {
        for diagram in std::iter::once(&mut result.diagram).chain(&mut result.as_measured) {
            diagram.cells.retain(is_common);
        }
    }
    Ok((difference, [one, other]))
}

/// The values of two sweeps and their profiles that differ; axes are compared by their cells.
fn changed(from: &ResolvedSweep, to: &ResolvedSweep) -> anyhow::Result<Vec<Changed>> {
    let values = |source: &ResolvedSweep| -> anyhow::Result<BTreeMap<String, Value>> {
        let mut values = BTreeMap::new();
        flatten("profile", &serde_json::to_value(&source.profile)?, &mut values);
        flatten("", &serde_json::to_value(&source.sweep)?, &mut values);
        values.retain(|key, _| {
            !key.starts_with("axes") && !key.contains("provenance") && !key.contains("interval")
        });
        Ok(values)
    };
    let (from, to) = (values(from)?, values(to)?);
    let keys: BTreeSet<&String> = from.keys().chain(to.keys()).collect();
    let of = |values: &BTreeMap<String, Value>, key: &String| {
        values.get(key).cloned().unwrap_or(Value::Null)
    };
    let pairs = keys.into_iter().map(|key| (key, of(&from, key), of(&to, key)));
    let different = pairs.filter(|(_, from, to)| from != to);
    Ok(different.map(|(key, from, to)| Changed { key: key.clone(), from, to }).collect())
}

/// The values of a document by their keys, which have dots between them.
fn flatten(key: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(parts) => {
            for (part, value) in parts {
                let inner = if key.is_empty() { part.clone() } else { format!("{key}.{part}") };
                flatten(&inner, value, into);
            }
        }
        Value::Array(entries) if entries.iter().any(Value::is_object) => {
            for (index, entry) in entries.iter().enumerate() {
                flatten(&format!("{key}[{index}]"), entry, into);
            }
        }
        _ => drop(into.insert(key.to_owned(), value.clone())),
    }
}
