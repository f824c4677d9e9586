//! One part of the kernel and nothing else, for counting instructions:
//! ```text
//! cargo build --release -p rsrs_benches --example instructions
//! valgrind --tool=callgrind target/release/examples/instructions avx2 judge 8 300
//! ```
//! Run it for two durations: the difference of the counts over the difference of the agent-steps is
//! exact and free of start-up. Valgrind does not support AVX-512.

#![expect(clippy::print_stdout, reason = "a program")]

use std::time::Instant;

use rsrs_benches::flockbots;
use rsrs_sim::batch::{Batch, VectorUnit};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, unit, part, replicates, duration_s] = arguments.as_slice() else {
        panic!("expected: portable|avx2|avx512 step|judge REPLICATES DURATION_S");
    };
    let unit = match unit.as_str() {
        "portable" => VectorUnit::Portable,
        "avx2" => VectorUnit::Avx2,
        "avx512" => VectorUnit::Avx512,
        other => panic!("no unit {other}"),
    };
    let mut batch = Batch::on(unit).expect("this machine has the unit");
    let replicates: u64 = replicates.parse().expect("a whole number of replicates");
    let duration_s: f64 = duration_s.parse().expect("a duration in seconds");
    let conditions = flockbots(9);
    let n_steps = conditions.steps(duration_s);
    let start = Instant::now();
    if part == "judge" {
        batch.judge(&conditions, 1, 0..replicates, duration_s).expect("long enough");
    } else {
        batch.step_only(&conditions, 1, 0..replicates, n_steps).expect("they fit");
    }
    let agent_steps = replicates * n_steps * 9;
    let rate = agent_steps as f64 / start.elapsed().as_secs_f64() / 1e6;
    println!("{agent_steps} agent-steps, {rate:.1} million per second");
}
