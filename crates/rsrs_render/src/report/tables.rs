//! The numbers of a report: the comparison, the robots, and where everything comes from.

use std::collections::HashSet;

use anyhow::Context;
use rsrs_core::comparison::SIGNIFICANCE;
use rsrs_core::judge::behaviour::Verb;
use rsrs_core::numerals::{percent, percentage_points, percents};
use rsrs_core::program;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::world::WorldFile;
use rsrs_view::page::Table;
use serde_json::Value;

use super::Reported;
use crate::comparison::{
    ComparedBag, ComparedCell, Report as Comparison, cause_in_words, evidence, verdict_name,
};
use crate::wording::quantity;

fn table<const N: usize>(caption: &str, head: [&str; N], rows: Vec<[String; N]>) -> Table {
    Table {
        caption: caption.to_owned(),
        head: head.map(str::to_owned).into(),
        rows: rows.into_iter().map(Vec::from).collect(),
    }
}

/// All cells together, and cell by cell.
pub fn comparison(comparison: &Comparison) -> Vec<Table> {
    let cells = comparison.cells.iter().map(row_of_cell).collect();
    let head = [
        "cell",
        "real runs",
        "simulated runs",
        "evidence for less often",
        "evidence for as often",
        "by itself",
    ];
    vec![
        table("All runs together", ["what", "found"], rows_of_all(comparison)),
        table("Cell by cell", head, cells),
    ]
}

fn rows_of_all(comparison: &Comparison) -> Vec<[String; 2]> {
    let pooled = &comparison.pooled;
    let tally = comparison.tally;
    let short = pooled.shortfall_at_most.map_or_else(
        || "not bounded".to_owned(),
        |short| format!("at most {}", percentage_points(short)),
    );
    let Verb { plain, did, .. } = comparison.behaviour().verb();
    [
        (did.to_owned(), format!("{} of {}", pooled.n_milled, pooled.n_real)),
        (format!("expected if both {plain} equally often"), format!("{:.1}", pooled.n_expected)),
        (format!("evidence that real robots {plain} less often"), evidence(pooled.e_violated)),
        (
            format!("evidence that they {plain} as often, but for the margin"),
            of_claim(pooled.e_supported),
        ),
        ("margin".to_owned(), percentage_points(pooled.margin)),
        ("evidence that decides".to_owned(), format!("{}", 1.0 / SIGNIFICANCE)),
        ("less often, as far as these runs show, by".to_owned(), short),
        (
            "B_r, averaged over the runs, is at least".to_owned(),
            pooled.b_r_at_least.map_or_else(String::new, |share| format!("{share:.2}, at 95 %")),
        ),
        ("ended as most simulated runs did".to_owned(), tally.same.to_string()),
        (format!("closer to {}", comparison.behaviour().wanted()), tally.easier.to_string()),
        ("further from it".to_owned(), tally.harder.to_string()),
    ]
    .map(|(what, found)| [what, found])
    .into()
}

/// Evidence for a claim, if there is one.
fn of_claim(e_supported: Option<f64>) -> String {
    e_supported.map_or_else(|| "no claim".to_owned(), evidence)
}

fn row_of_cell(cell: &ComparedCell) -> [String; 6] {
    let did = cell.simulated.behaviour().verb().did;
    let share = |share: f64, low: f64, high: f64, n: u64| {
        format!("{} of {n} {did} ({})", percent(share), percents(low, high))
    };
    [
        quantity::of_cell(&cell.cell),
        share(cell.b_r, cell.b_r_low, cell.b_r_high, cell.n_real),
        share(cell.b_s, cell.b_s_low, cell.b_s_high, cell.n_simulated),
        evidence(cell.e_violated),
        of_claim(cell.e_supported),
        verdict_name(cell.verdict).to_owned(),
    ]
}

/// The runs that do not count; `None` if all do.
pub fn not_counted(comparison: &Comparison) -> Option<Table> {
    let rows: Vec<[String; 3]> = comparison
        .not_counted
        .iter()
        .map(|run| {
            [
                run.bag.display().to_string(),
                cause_in_words(run.cause).to_owned(),
                run.reason.clone(),
            ]
        })
        .collect();
    let caption = "Runs that do not count";
    (!rows.is_empty()).then(|| table(caption, ["bag", "what", "cause"], rows))
}

/// Every number of a sweep's profile with its source, and of each class that has a profile of its own what differs.
pub fn profiles(measured: &RobotProfile, world: Option<&WorldFile>) -> anyhow::Result<Vec<Table>> {
    let of_sweep = numbers(measured)?;
    let sourced = |profile: &RobotProfile, rows: Vec<(String, String)>| {
        let row = |(key, value): (String, String)| {
            let source = source_of(profile, &key);
            [key, value, source]
        };
        rows.into_iter().map(row).collect::<Vec<_>>()
    };
    let named = |profile: &RobotProfile| format!("{}: {}", profile.name, profile.provenance.source);
    let head = ["quantity", "value", "source"];
    let mut of_classes = Vec::new();
    for (class, own) in world.into_iter().flat_map(WorldFile::profiles) {
        let rows = differing(numbers(own)?, &of_sweep);
        let caption = format!(
            "Class {class}, where it differs from the profile of the sweep: {}",
            named(own)
        );
        of_classes.push(table(&caption, head, sourced(own, rows)));
    }
    let caption = match of_classes.as_slice() {
        [] => named(measured),
        _ => format!("The profile of the sweep: {}", named(measured)),
    };
    let rows = sourced(measured, of_sweep);
    Ok(std::iter::once(table(&caption, head, rows)).chain(of_classes).collect())
}

/// The numbers and words of a profile by the dotted paths of their keys.
fn numbers(profile: &RobotProfile) -> anyhow::Result<Vec<(String, String)>> {
    let value = serde_json::to_value(profile).context("the profile as data")?;
    let mut rows = Vec::new();
    let parts = value.as_object().into_iter().flatten();
    for (key, value) in parts.filter(|(key, _)| !["name", "provenance"].contains(&key.as_str())) {
        flatten(key, value, &mut rows);
    }
    Ok(rows)
}

/// The rows that are not among others, and `none` for what only those have.
fn differing(own: Vec<(String, String)>, others: &[(String, String)]) -> Vec<(String, String)> {
    let keys: HashSet<String> = own.iter().map(|(key, _)| key.clone()).collect();
    let lacking = others.iter().filter(|(key, _)| !keys.contains(key));
    let lacking = lacking.map(|(key, _)| (key.clone(), "none".to_owned()));
    own.into_iter().filter(|row| !others.contains(row)).chain(lacking).collect()
}

/// The values of a document by the dotted paths of their keys; entries of lists are numbered from 0.
fn flatten(path: &str, value: &Value, rows: &mut Vec<(String, String)>) {
    match value {
        Value::Object(parts) => {
            for (key, value) in parts {
                flatten(&format!("{path}.{key}"), value, rows);
            }
        }
        Value::Array(entries) => {
            for (index, value) in entries.iter().enumerate() {
                flatten(&format!("{path}.{index}"), value, rows);
            }
        }
        Value::String(text) => rows.push((path.to_owned(), text.clone())),
        Value::Null | Value::Bool(_) | Value::Number(_) => {
            rows.push((path.to_owned(), value.to_string()));
        }
    }
}

/// Where a number comes from: what is stated of it, or of what it is a part of.
fn source_of(profile: &RobotProfile, key: &str) -> String {
    let numbers = &profile.provenance.numbers;
    let is_of = |(path, _): &(&String, &String)| {
        key.strip_prefix(path.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let longest = numbers.iter().filter(is_of).max_by_key(|(path, _)| path.len());
    longest.map_or_else(String::new, |(_, source)| source.clone())
}

/// What made the report, the sweep and every run.
pub fn provenance(of: &Reported) -> Table {
    let Reported { folder, result, comparison, .. } = of;
    let source = &result.source;
    let made_by = |version: &str, commit: &str| format!("rsrs {version}, commit {commit}");
    let mut rows = vec![
        ["report".to_owned(), made_by(program::VERSION, program::commit())],
        ["sweep".to_owned(), made_by(&source.provenance.version, &source.provenance.commit)],
        ["folder of the sweep".to_owned(), folder.display().to_string()],
        ["seed of the sweep".to_owned(), source.sweep.seed.to_string()],
        ["digest of the sweep".to_owned(), source.digest()],
        ["digest of the profile".to_owned(), source.provenance.profile_digest.clone()],
    ];
    let classes = source.sweep.world().into_iter().flat_map(WorldFile::profiles);
    rows.extend(
        classes
            .map(|(class, own)| [format!("digest of the profile of class {class}"), own.digest()]),
    );
    rows.extend(
        comparison.map(|comparison| ["labels of the runs".to_owned(), comparison.labels.clone()]),
    );
    let runs = comparison.iter().flat_map(|comparison| &comparison.bags);
    rows.extend(runs.map(|run: &ComparedBag| {
        let of = &run.record.provenance;
        let made_by = made_by(&of.version, &of.commit);
        [run.name(), format!("{made_by}; conditions {}", of.conditions_digest)]
    }));
    table("Where it comes from", ["what", "from"], rows)
}

#[cfg(test)]
mod tests {
    use rsrs_core::document::source::Source;
    use rsrs_core::world::RobotClass;

    use super::*;

    #[test]
    fn every_number_of_a_profile_is_in_its_table_with_its_source() {
        let flockbot = rsrs_testing::conditions::flockbot();

        let [table] = &profiles(&flockbot, None).unwrap()[..] else { panic!("one profile") };

        let row = |key: &str| table.rows.iter().find(|row| row[0] == key).expect("it is there");
        assert_eq!(
            row("actuation.speed.gain_by_command.0.commanded_m_s")[1..],
            ["0.025", "tab:speed1"]
        );
        assert_eq!(row("computation.period_s")[1], "0.13");
        let numbers = table.rows.iter().filter(|row| row[1].parse::<f64>().is_ok());
        for row in numbers {
            assert!(!row[2].is_empty(), "{} has no source", row[0]);
        }
    }

    #[test]
    fn each_class_with_a_profile_of_its_own_has_a_table_of_what_differs() {
        let flockbot = rsrs_testing::conditions::flockbot();
        let mut near = flockbot.clone();
        near.name = "near".to_owned();
        near.sensing.true_positive = 0.9;
        let class = |name: &str, profile: Option<&RobotProfile>| RobotClass {
            name: name.to_owned(),
            profile: profile.cloned().map(Source::Read),
            ..RobotClass::default()
        };
        let classes = vec![class("a", None), class("b", Some(&near))];
        let world = WorldFile { classes, ..WorldFile::NOTHING };

        let tables = profiles(&flockbot, Some(&world)).unwrap();

        let [of_sweep, of_class] = &tables[..] else { panic!("{tables:?}") };
        let alone = &profiles(&flockbot, None).unwrap()[0];
        assert_eq!(of_sweep.rows, alone.rows);
        assert!(of_sweep.caption.starts_with("The profile of the sweep: flockbot: "));
        let of = "Class b, where it differs from the profile of the sweep: near: ";
        assert!(of_class.caption.starts_with(of), "{}", of_class.caption);
        let [row] = &of_class.rows[..] else { panic!("{:?}", of_class.rows) };
        assert_eq!(row[..2], ["sensing.true_positive", "0.9"]);
    }
}
