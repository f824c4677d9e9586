//! Cohen's kappa and its interval are those of statsmodels on the same labels.

use std::path::Path;

use rsrs_core::judge::agreement::Agreement;
use rsrs_core::judge::phase::Phase;
use rsrs_testing::draw::Draw;
use rsrs_testing::python;
use serde_json::{Value, json};

/// Labels of two judges, of whom the second copies the first with some probability.
fn case(seed: u64, n_runs: usize, copies: f64) -> Value {
    let mut draw = Draw::new(seed);
    // The first of five steps that the draw does not reach.
    let any = |draw: &mut Draw| {
        let drawn = draw.uniform();
        let below = |step: &usize| drawn < 0.2 * (*step as f64 + 1.0);
        Phase::BUILT_IN[(0..4).find(below).unwrap_or(4)]
    };
    let labels: Vec<(Phase, Phase)> = (0..n_runs)
        .map(|_| {
            let one = any(&mut draw);
            let other = if draw.uniform() < copies { one } else { any(&mut draw) };
            (one, other)
        })
        .collect();
    let count = |one: Phase, other: Phase| labels.iter().filter(|l| **l == (one, other)).count();
    let table = Phase::BUILT_IN.map(|one| Phase::BUILT_IN.map(|other| count(one, other)));
    json!({"table": table, "agreement": Agreement::new(&labels)})
}

#[test]
fn kappa_and_its_interval_agree_with_statsmodels() {
    let cases: Vec<Value> = (0..40)
        .map(|index: usize| case(index as u64, 5 + 7 * index, 0.1 * (index % 11) as f64))
        .collect();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/agreement_oracle.py");
    let text = json!(cases).to_string();
    let printed = python::answer(&script, env!("CARGO_TARGET_TMPDIR"), &text);

    assert_eq!(printed.trim(), "40 cases agree");
}
