//! How many agent-steps a second of CPU time makes, for `benches/peers/run.sh`: the loop that one
//! would write first, the reference world, and the batch, with and without judging.
//!
//! Prints lines of `name,robots,agent_steps,cpu_s`.

#![expect(clippy::print_stdout, reason = "a program")]

use std::hint::black_box;

use rsrs_benches::flockbots;
use rsrs_benches::plain::PlainWorld;
use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::{Command, decide};
use rsrs_sim::batch::{Batch, VectorUnit};
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;

const SEED: Seed = Seed { seed: 1, replicate: 0 };

/// Steps of a run of 300 s.
const STEPS: u64 = rsrs_benches::STEPS;

fn main() {
    let nine = flockbots(9);
    plain(&nine, 500_000);
    reference(&nine, 1_000_000);
    for unit in VectorUnit::available() {
        let mut batch = Batch::on(unit).expect("an available unit");
        // Placement is in it: it is part of what a sweep pays for each replicate.
        let replicates = 4800;
        let agent_steps = replicates * STEPS * 9;
        report(&format!("batch on {unit:?}, steps only"), 9, agent_steps, || {
            batch.step_only(&nine, 1, 0..replicates, STEPS).expect("the robots fit");
        });
        report(&format!("batch on {unit:?}, judged"), 9, agent_steps, || {
            black_box(batch.judge(&nine, 1, 0..replicates, 300.0).expect("fit and long enough"));
        });
    }
    let many = flockbots(1000);
    plain(&many, 200);
    reference(&many, 5000);
    reference(&flockbots(100_000), 50);
}

fn plain(conditions: &Conditions, n_steps: u64) {
    let mut world = PlainWorld::new(conditions, SEED);
    let agent_steps = n_steps * conditions.robots as u64;
    report("plain loop (Rust, f64)", conditions.robots, agent_steps, || {
        for _ in 0..n_steps {
            world.step();
        }
        black_box(world.poses().next());
    });
}

fn reference(conditions: &Conditions, n_steps: u64) {
    let mut world = World::new(conditions, SEED).expect("the robots fit");
    let mut commands: Vec<Command> = Vec::with_capacity(conditions.robots);
    let agent_steps = n_steps * conditions.robots as u64;
    report("reference world", conditions.robots, agent_steps, || {
        for _ in 0..n_steps {
            commands.clear();
            commands.extend(world.sense().iter().map(|seen| {
                decide(*seen, conditions.controller.parameters().expect("two commands"))
            }));
            world.advance(&commands);
        }
        black_box(world.digest());
    });
}

fn report(name: &str, n_robots: usize, agent_steps: u64, work: impl FnOnce()) {
    let start_s = cpu_s();
    work();
    // Commas separate the columns.
    println!("{},{n_robots},{agent_steps},{:.6}", name.replace(',', ";"), cpu_s() - start_s);
}

/// CPU time of this thread, in seconds, as Linux counts it: what other programs take is not in it.
/// It is brought up to date every few milliseconds, so what is measured takes some hundred.
fn cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux counts it");
    let on_cpu = text.split_whitespace().next().expect("three numbers");
    on_cpu.parse::<f64>().expect("nanoseconds") * 1e-9
}
