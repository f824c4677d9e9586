//! The notebook of the book: it is executed on a small sweep, and agrees with the program.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use rsrs_testing::python::{SCIENCE, must_run, python_with};

use crate::command::{code, json, repository, rsrs, stderr};
use crate::prepared_sweeps::{SPEEDS, swept};
use crate::simulated_bags::Run;

/// Executes a notebook; what goes wrong in a cell is printed.
const EXECUTE: &str = "\
import sys, nbformat
from nbclient import NotebookClient
notebook = nbformat.read(sys.argv[1], as_version=4)
assert not any(cell.get('outputs') for cell in notebook.cells), 'the notebook has outputs in it'
nbformat.validate(notebook)
NotebookClient(notebook, kernel_name='python3', timeout=300).execute()";

/// The rows of a table with a header.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("the notebook writes it");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("it has a header").split(',').collect();
    let row = |line: &str| {
        let names = names.iter().map(|name| (*name).to_owned());
        names.zip(line.split(',').map(str::to_owned)).collect()
    };
    lines.map(row).collect()
}

fn number(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|error| panic!("{name} is `{}`: {error}", row[name]))
}

#[test]
fn the_notebook_makes_its_figures_and_agrees_with_the_program() {
    let place = swept(SPEEDS, "true_positive: 0.8");
    let results = place.path().join("results");
    std::fs::create_dir_all(results.join("bags")).expect("writable");
    std::fs::rename(place.path().join("out"), results.join("sweep")).expect("it was swept");
    let runs = [(0.15, 0.75, 11), (0.15, 0.75, 12), (0.30, 0.75, 13)];
    let names = runs.map(|(speed_m_s, turn_rate_rad_s, seed)| {
        let name = format!("run_{seed}");
        let run = Run { speed_m_s, turn_rate_rad_s, ..Run::new(seed) };
        run.record(&results.join("bags"), &name);
        name
    });
    let figures = place.path().join("figures");

    let python = python_with(&SCIENCE);
    let mut notebook = Command::new(python);
    notebook.args(["-c", EXECUTE]).arg(repository().join("docs/notebooks/files_alone.ipynb"));
    // A kernel writes its files there, and where matplotlib keeps its fonts.
    for folder in ["IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR"] {
        notebook.env(folder, place.path().join("jupyter"));
    }
    must_run(notebook.env("RESULTS", &results).env("FIGURES", &figures).env("MPLBACKEND", "agg"));

    for picture in ["phase_diagram.png", "order_over_time.png", "comparison.png"] {
        let n_bytes = figures.join(picture).metadata().expect("it was drawn").len();
        assert!(n_bytes > 5_000, "{picture}: {n_bytes} bytes");
    }
    check_cells(&figures, &results);
    check_runs(&figures, &results, &names);
    check_comparison(&figures, &results, &names);
}

/// Every count and share of every cell.
fn check_cells(figures: &Path, results: &Path) {
    let (found, expected) =
        (table(&figures.join("cells.csv")), table(&results.join("sweep/cells.csv")));
    assert_eq!((found.len(), expected.len()), (4, 4));
    for (found, expected) in found.iter().zip(&expected) {
        for (name, value) in found {
            let expected = number(expected, name);
            // The program writes six digits of a share.
            assert!((number(found, name) - expected).abs() < 1e-6, "{name}: {value}, {expected}");
        }
    }
}

/// The order parameters of every run, and whether it mills.
fn check_runs(figures: &Path, results: &Path, names: &[String]) {
    let found = table(&figures.join("runs.csv"));
    assert_eq!(found.len(), names.len());
    for (found, name) in found.iter().zip(names) {
        let bag = results.join("bags").join(name);
        let labelled = rsrs(results, &["label", bag.to_str().expect("text"), "--format", "json"]);
        assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
        let labelled = &json(&labelled)[0];
        assert_eq!(&found["bag"], name);
        for parameter in
            ["rotation", "orbit", "circliness", "blocked", "stuck", "lost", "mean_radius_m"]
        {
            let expected = labelled["evidence"][parameter].as_f64().expect("a number");
            let value = number(found, parameter);
            assert!((value - expected).abs() < 1e-6, "{name}: {parameter} {value}, {expected}");
        }
        assert_eq!(found["mills"] == "true", labelled["phase"] == "stable_milling", "{name}");
    }
}

/// The shares of real and simulated runs, with their intervals.
fn check_comparison(figures: &Path, results: &Path, names: &[String]) {
    let bags = names.iter().map(|name| format!("bags/{name}"));
    let mut arguments: Vec<String> =
        ["compare", "sweep", "--format", "json", "--bags"].map(str::to_owned).into();
    arguments.extend(bags);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let compared = rsrs(results, &arguments);
    assert!([0, 3].contains(&code(&compared)), "{}", stderr(&compared));
    let compared = json(&compared);
    let cells = compared["cells"].as_array().expect("a list");
    let found = table(&figures.join("comparison.csv"));
    assert_eq!((found.len(), cells.len()), (2, 2));
    for (found, expected) in found.iter().zip(cells) {
        for name in ["n_real", "b_r", "b_r_low", "b_r_high", "b_s", "b_s_low", "b_s_high"] {
            let expected = expected[name].as_f64().expect("a number");
            let value = number(found, name);
            assert!((value - expected).abs() < 1e-6, "{name}: {value}, {expected}");
        }
    }
}
