//! The page that holds three predictions against floors that are not ours: its tables are those of the results that
//! its command left, and the command goes the whole way. `docs/floors/compare.py` makes the numbers, in `.ci/long`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::rank_correlation::kendall_tau;
use rsrs_testing::python::{SCIENCE, must_run, python_with};
use serde_json::Value;

use crate::command::repository;

const PAGE: &str = "docs/predictors.md";

fn compare() -> PathBuf {
    repository().join("docs/floors/compare.py")
}

fn parsed(results: &str) -> Value {
    serde_json::from_str(results).expect("results are JSON")
}

fn floors(results: &Value) -> &Vec<Value> {
    results["floors"].as_array().expect("a list of floors")
}

/// Every line of the tables that a script prints of committed results is on a page, which names the machine; returns
/// the results.
pub fn has_the_tables_of(page: &str, script: &Path, results: &str) -> Value {
    let text = fs::read_to_string(repository().join(page)).expect("the page is there");
    let results = repository().join(results);
    let committed = parsed(&fs::read_to_string(&results).expect("the results are there"));
    let tables = must_run(Command::new("python3").arg(script).arg("--tables").arg(results));
    assert!(tables.lines().count() > 12, "{tables}");
    for line in tables.lines() {
        assert!(text.lines().any(|other| other == line), "{page} has no line `{line}`");
    }
    let machine = committed["machine"].as_str().expect("it is named");
    assert!(text.contains(machine), "{page} does not state that it was {machine}");
    committed
}

#[test]
fn the_page_of_predictions_has_the_tables_of_its_results() {
    let committed = has_the_tables_of(PAGE, &compare(), "docs/floors/results.json");

    for floor in floors(&committed) {
        let cells = floor["cells"].as_array().expect("a list of cells");
        assert!(cells.len() >= 9, "{floor}");
        assert!(cells.iter().all(|cell| cell["n_runs"].as_u64() >= Some(20)), "{floor}");
        assert!(floor["n_simulated"].as_u64() >= Some(100), "{floor}");
    }
}

#[test]
fn the_page_of_worlds_has_the_table_of_robots_that_push() {
    let script = repository().join("docs/floors/pushing.py");
    let committed = has_the_tables_of("docs/worlds.md", &script, "docs/floors/pushing.json");

    let pucks = committed["pucks"].as_array().expect("a list of pucks");
    for of_puck in pucks.iter().filter_map(|puck| puck["held"].as_array()).flatten() {
        assert!(of_puck["n_trials"].as_u64() >= Some(20), "{of_puck}");
    }
}

/// The keys of predictions, and what the tables call them.
const PREDICTORS: [(&str, &str); 4] = [
    ("as_measured", "as measured"),
    ("harsher", "harsher"),
    ("pseudo_mean", "pseudo-realities, mean"),
    ("pseudo_worst_tenth", "pseudo-realities, worst tenth"),
];

#[test]
fn intervals_and_rank_correlations_of_the_page_are_those_of_the_program() {
    let page = fs::read_to_string(repository().join(PAGE)).expect("the page is there");
    let results = repository().join("docs/floors/results.json");
    let results = parsed(&fs::read_to_string(results).expect("the results are there"));

    for floor in floors(&results) {
        let name = floor["name"].as_str().expect("it has a name");
        let cells = floor["cells"].as_array().expect("a list of cells");
        let counts = |cell: &Value| {
            let count = |key: &str| cell[key].as_u64().expect("a count");
            (count("n_mills"), count("n_runs"))
        };
        for cell in cells {
            let (hits, n) = counts(cell);
            let Interval { low, high } = Interval::clopper_pearson(hits, n);
            let share = hits as f64 / n as f64;
            let stated = format!("| {hits} of {n}: {share:.2} ({low:.2} to {high:.2}) |");
            assert!(page.contains(&stated), "{PAGE} has no `{stated}`");
        }
        let shares = cells.iter().map(|cell| counts(cell).0 as f64 / counts(cell).1 as f64);
        let shares: Vec<f64> = shares.collect();
        for (key, words) in PREDICTORS {
            let predicted = cells.iter().map(|cell| cell[key].as_f64().expect("a share"));
            let predicted: Vec<f64> = predicted.collect();
            let n_held = shares.iter().zip(&predicted).filter(|(share, it)| share >= it).count();
            let tau = kendall_tau(&predicted, &shares).expect("cells differ");
            let begins = format!("| {name} | {words} | {n_held} of {} |", cells.len());
            let ends = format!("| {tau:.2} |");
            let is_stated =
                |line: &str| line.starts_with(begins.as_str()) && line.ends_with(ends.as_str());
            assert!(page.lines().any(is_stated), "{PAGE} has no `{begins} … {ends}`");
        }
    }
}

#[test]
fn predictions_go_from_trials_on_a_floor_to_the_tables() {
    let python = python_with(&SCIENCE);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rsrs = PathBuf::from(env!("CARGO_BIN_EXE_rsrs"));
    let binaries = rsrs.parent().expect("a binary lies in a folder");
    assert!(
        binaries.join("examples/floors").exists(),
        "the floor of this test is not built: `cargo test -p rsrs --no-run` builds it with all others"
    );

    let printed = must_run(
        Command::new(python)
            .arg(compare())
            .arg(folder.path())
            .arg("rays")
            .env("BINARIES", binaries)
            .envs([("RUNS", "3"), ("REPLICATES", "10"), ("PROFILES", "2"), ("CELLS", "2")]),
    );

    let results = fs::read_to_string(folder.path().join("results.json")).expect("it was written");
    let results = parsed(&results);
    let [rays] = &floors(&results)[..] else { panic!("{results}") };
    let cells = rays["cells"].as_array().expect("a list of cells");
    // Six robots that start close and drive slowly mill on this floor and in every simulation, and nine do.
    assert_eq!(cells.len(), 2, "{rays}");
    assert_eq!(cells[0]["n_mills"], 3, "{rays}");
    for prediction in ["as_measured", "harsher", "pseudo_mean"] {
        assert!(cells[0][prediction].as_f64() >= Some(0.7), "{prediction}: {rays}");
    }
    assert!(printed.contains("| rays | harsher | "), "{printed}");
    assert!(folder.path().join("floors.png").exists());
}
