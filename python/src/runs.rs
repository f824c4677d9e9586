//! Numbers and seeds of runs, checked.

use pyo3::prelude::*;
use rsrs_core::diagram::sweep_file::SEED_LIMIT;

use crate::error::refused;

/// Most fresh runs of a cell that somebody can mean.
const MOST_RUNS: u64 = 1_000_000_000;

/// Checks a number of runs.
pub fn runs(name: &str, n: u64) -> PyResult<u64> {
    if (1..=MOST_RUNS).contains(&n) {
        Ok(n)
    } else {
        Err(refused(format!("{name} is {n}, expected from 1 to {MOST_RUNS}")))
    }
}

/// Checks the seed of runs.
pub fn check_seed(seed: u64) -> PyResult<()> {
    if seed < SEED_LIMIT {
        Ok(())
    } else {
        Err(refused(format!("seed is {seed}, expected below 2^63")))
    }
}
