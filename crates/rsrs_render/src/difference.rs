//! Two sweeps, cell by cell, in words and as a map.

use std::path::PathBuf;

use rsrs_core::numerals::counted;
use rsrs_pipeline::diff::{CellDifference, Changed, SweepDifference};
use rsrs_pipeline::sweep::result::{SweepResult, World};
use rsrs_pipeline::sweep::share_difference::ShareDifference;
use serde_json::Value;

use crate::picture::{CellNumbers, DiagramOptions, Worlds, facts, of_sweep};
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

/// The map of the differences, as SVG; `common` are both sweeps, with the cells that both have.
pub fn svg(
    difference: &SweepDifference,
    common: &[SweepResult; 2],
    world: World,
    options: DiagramOptions,
) -> anyhow::Result<String> {
    let shares: Vec<ShareDifference> = difference.cells.iter().map(|cell| cell.shares).collect();
    let names = names(difference);
    let [from, to] = &names;
    let name = format!("share of {}: {to} less {from}", difference.noun);
    let options = DiagramOptions {
        title: Some(format!("From {from} to {to}")),
        values: Some(CellNumbers::differences(name, &shares)),
        worlds: Worlds::One(world),
        ..options
    };
    let [one, other] = common;
    let subtitle = subtitle(&names, &[facts(one, &options)?, facts(other, &options)?]);
    of_sweep(other, &DiagramOptions { subtitle: Some(subtitle), ..options })
}

/// What both sweeps share, and then what each has of its own.
fn subtitle(names: &[String; 2], facts: &[Vec<String>; 2]) -> String {
    let [one, other] = facts;
    let shared: Vec<String> = other.iter().filter(|fact| one.contains(fact)).cloned().collect();
    let own = |(name, facts): (&String, &Vec<String>)| {
        let own: Vec<String> =
            facts.iter().filter(|fact| !shared.contains(fact)).cloned().collect();
        (!own.is_empty()).then(|| format!("{name}: {}", own.join(", ")))
    };
    let own: Vec<String> = names.iter().zip(facts).filter_map(own).collect();
    std::iter::once(shared.join(", ")).chain(own).collect::<Vec<String>>().join("; ")
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

#[cfg(test)]
mod tests {
    use rsrs_core::statistics::share::Share;

    use super::*;
    use crate::picture::tests::{swept, words};

    #[test]
    fn a_map_of_differences_states_what_each_sweep_has_of_its_own() {
        let [fixed, nearer] = [0.9, 0.8].map(|range_m| {
            format!(
                "axes: {{speed_m_s: [0.1, 0.2], turn_rate_rad_s: [0.5, 1]}}\n\
                 fixed: {{robots: 9, arena_m: 15, half_angle_rad: 0.25, range_m: {range_m}}}"
            )
        });
        let common = [swept(&fixed, 10), swept(&nearer, 30)];
        let kinds = common.each_ref().map(|result| result.source.sweep.interval_kind());
        let shares = ShareDifference {
            from: Share { hits: 10, n: 10 },
            to: Share { hits: 30, n: 30 },
            kinds,
        };
        let cells = common[1].diagram.cells.iter().map(|entry| CellDifference {
            cell: entry.cell.clone(),
            b_s_from: 1.0,
            b_s_to: 1.0,
            difference: 0.0,
            moved: false,
            shares,
        });
        let difference = SweepDifference {
            from: PathBuf::from("results/before"),
            to: PathBuf::from("results/after"),
            world: World::Harsher.key(),
            changed: Vec::new(),
            n_cells: 4,
            n_moved: 0,
            n_only_from: 0,
            n_only_to: 0,
            cells: cells.collect(),
            noun: "stable milling",
        };

        let svg = svg(&difference, &common, World::Harsher, DiagramOptions::default())
            .expect("it can be drawn");

        for text in ["before: 10 replicates per cell", "after: 30 replicates per cell"] {
            assert!(words(&svg).contains(text), "{text} in {svg}");
        }
        let facts = common.each_ref().map(|result| facts(result, &DiagramOptions::default()));
        let facts = facts.map(|facts| facts.expect("the sweep is whole"));
        insta::assert_snapshot!(
            subtitle(&["before".to_owned(), "after".to_owned()], &facts),
            @"robots as measured, 9 robots, 120 s, arena 15 m, half-angle of the sensor 0.25 rad (14.3°); before: 10 replicates per cell, start disc 0.99 m, range of the sensor 0.9 m; after: 30 replicates per cell, start disc 0.88 m, range of the sensor 0.8 m"
        );
    }
}
