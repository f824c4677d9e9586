//! The evidence of comparisons is that of scipy's optimisers and distributions.

use std::path::Path;

use rsrs_core::comparison::enough;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_testing::python;
use serde_json::{Value, json};

/// Real and simulated hits and runs of each cell.
type Cells = [[(u64, u64); 2]];

fn case(cells: &Cells, margin: f64) -> Value {
    let share = |(hits, n)| Share { hits, n };
    let shares: Vec<(Share, Share)> =
        cells.iter().map(|[real, simulated]| (share(*real), share(*simulated))).collect();
    let part = 1.0 / shares.len() as f64;
    let tested = |(real, simulated): &(Share, Share)| TestedCell {
        real: *real,
        simulated: *simulated,
        part,
    };
    let cell = |(real, simulated): &(Share, Share)| {
        json!({
            "n_real": real.n, "b_r": real.value(),
            "n_simulated": simulated.n, "b_s": simulated.value(), "part": part,
        })
    };
    let test = PooledTest::new(&shares.iter().map(tested).collect::<Vec<_>>(), margin);
    let cells: Vec<Value> = shares.iter().map(cell).collect();
    json!({"cells": cells, "pooled": test.summary(enough())})
}

#[test]
fn pooled_evidence_agrees_with_scipy() {
    let nine: Vec<[(u64, u64); 2]> =
        (0..9).map(|cell| [(cell % 2, 1), (80 + 2 * cell, 100)]).collect();
    let cases = [
        case(&[[(0, 1), (868, 1000)]], 0.1),
        case(&[[(16, 16), (868, 1000)]], 0.1),
        case(&[[(1, 3), (14, 16)]], 0.1),
        case(&[[(0, 4), (3, 100)]], 0.1),
        case(&[[(40, 50), (197, 200)]], 0.2),
        case(&[[(9, 10), (12, 16)], [(3, 8), (868, 1000)]], 0.1),
        case(&nine, 0.1),
        case(&[[(30, 30), (16, 16)]], 0.1),
        case(&[[(5, 9), (1000, 1000)], [(1, 2), (0, 16)]], 0.1),
    ];
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/comparison_oracle.py");
    let text = json!(cases).to_string();
    let printed = python::answer(&script, env!("CARGO_TARGET_TMPDIR"), &text);

    assert_eq!(printed.trim(), "9 cases agree");
}
