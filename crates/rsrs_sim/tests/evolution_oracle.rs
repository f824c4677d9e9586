//! The evolution strategy needs as many samples as that of the package `cma`, on the functions by which
//! such strategies are judged.

use std::path::Path;
use std::process::Command;

use rsrs_sim::exploration::evolution_strategy::EvolutionStrategy;
use rsrs_testing::python;
use serde_json::{Value, json};

/// A cost of a point; least at a single place, where it is 0.
type Cost = fn(&[f64]) -> f64;

/// N. Hansen's selection: one round, one stretched by a million, one bent.
const FUNCTIONS: [(&str, Cost); 3] =
    [("sphere", sphere), ("ellipsoid", ellipsoid), ("rosenbrock", rosenbrock)];

fn sphere(point: &[f64]) -> f64 {
    point.iter().map(|x| x * x).sum()
}

fn ellipsoid(point: &[f64]) -> f64 {
    let last = (point.len() - 1) as f64;
    let stretched = |(index, x): (usize, &f64)| libm::pow(1e6, index as f64 / last) * x * x;
    point.iter().enumerate().map(stretched).sum()
}

fn rosenbrock(point: &[f64]) -> f64 {
    let pair =
        |pair: &[f64]| 100.0 * (pair[0] * pair[0] - pair[1]).powi(2) + (pair[0] - 1.0).powi(2);
    point.windows(2).map(pair).sum()
}

const N: usize = 6;
const START: f64 = 0.3;
const STEP: f64 = 0.5;
const TARGET: f64 = 1e-8;
const MOST_SAMPLES: usize = 20_000;
const SEEDS: u64 = 15;

/// Samples until the target is met.
fn samples(cost: Cost, seed: u64) -> usize {
    let mut strategy = EvolutionStrategy::new(&[START; N], STEP, seed);
    let mut n_samples = 0;
    while n_samples < MOST_SAMPLES {
        let points = strategy.sample();
        let costs: Vec<f64> = points.iter().map(|point| cost(point)).collect();
        if let Some(hit) = costs.iter().position(|cost| *cost < TARGET) {
            return n_samples + hit + 1;
        }
        n_samples += points.len();
        strategy.update(&costs);
    }
    MOST_SAMPLES
}

fn median(mut numbers: Vec<usize>) -> usize {
    numbers.sort_unstable();
    numbers[numbers.len() / 2]
}

#[test]
fn standard_functions_take_as_many_samples_as_with_the_package_cma() {
    let cases: Vec<Value> = FUNCTIONS.iter().map(|(name, _)| json!(name)).collect();
    let question = json!({
        "functions": cases, "n": N, "start": START, "step": STEP, "target": TARGET,
        "most_samples": MOST_SAMPLES, "seeds": SEEDS,
        "population": EvolutionStrategy::new(&[START; N], STEP, 1).population(),
    });
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/evolution_oracle.py");
    let python = python::python_with(&python::SCIENCE);
    let printed = python::must_run(Command::new(python).arg(script).arg(question.to_string()));
    let theirs: Value = serde_json::from_str(&printed).expect("it prints JSON");

    for (name, cost) in FUNCTIONS {
        let ours = median((1..=SEEDS).map(|seed| samples(cost, seed)).collect());
        let theirs = theirs[name].as_u64().expect("a number of samples");

        let ratio = ours as f64 / theirs as f64;
        assert!(ours < MOST_SAMPLES, "{name} was not solved");
        assert!(ratio < 1.3, "{name}: {ours} samples, theirs {theirs}");
    }
}
