//! Which rule chooses the best cell from a sweep: the table behind `rsrs choose`.
//!
//! `cargo run --release -p rsrs_sim --example rules_of_choice` runs every cell of the default plane
//! 1,000 times in both worlds, robots made worse and as measured. That is taken for the truth. Then
//! it draws 300 sweeps from it for each number of replicates, and lets every rule choose from each of
//! them; a confirmation is drawn from the truth, too. Some of its rows are in `docs/rules_of_choice.md`.
//!
//! With `-- seeds`, it sweeps with seeds 1 to 10 in place of drawing, and confirms on fresh seeds, as
//! the program does: the rule of `rsrs choose` alone, one line for each sweep.
//!
//! With `-- inequality`, it looks for cells in which robots as measured mill less often than robots made
//! worse, in the truth of that plane, and around its middle with eight and with ten robots.

#![expect(clippy::print_stdout, reason = "a table for people")]

mod plane;
mod rules;

use rsrs_core::statistics::share::Share;

use plane::{Plane, REPLICATES, Sweeper};
use rules::{Outcome, RULES};

const SWEEPS: u64 = 300;

fn main() {
    let sweeper = Sweeper::new();
    match std::env::args().nth(1).as_deref() {
        Some("seeds") => return seeds(&sweeper),
        Some("inequality") => return inequality(&sweeper),
        _ => (),
    }
    let truth = sweeper.truth();
    let deepest = truth.deepest();
    println!("The deepest true cells: {}.\n", sweeper.names(&deepest));
    println!(
        "| rule | replicates | a viable cell, % | no cell, % | off the deepest, cells | within 1.5 \
         cells, % | confirmed, cells |\n|---|---|---|---|---|---|---|"
    );
    for (name, rule) in RULES {
        for replicates in REPLICATES {
            let outcomes: Vec<Outcome> = (0..SWEEPS)
                .map(|sweep| rule(&truth.drawn(sweep, replicates), (&truth, sweep)))
                .collect();
            println!("| {name} | {replicates} | {} |", row(&truth, &deepest, &outcomes));
        }
    }
}

/// One row of the table, after its rule and its replicates.
fn row(truth: &Plane, deepest: &[usize], outcomes: &[Outcome]) -> String {
    let chosen: Vec<usize> = outcomes.iter().filter_map(|outcome| outcome.chosen).collect();
    let percent = |n: usize| format!("{:.1}", 100.0 * n as f64 / outcomes.len() as f64);
    let off = |cell: &usize| truth.nearest(*cell, deepest);
    let n_viable = chosen.iter().filter(|cell| truth.least(**cell) >= rules::VIABLE).count();
    let n_near = chosen.iter().filter(|cell| off(cell) <= 1.5).count();
    let mean_off = chosen.iter().map(off).sum::<f64>() / chosen.len().max(1) as f64;
    let n_confirmed: u64 = outcomes.iter().map(|outcome| outcome.n_confirmed).sum();
    format!(
        "{} | {} | {mean_off:.2} | {} | {:.1}",
        percent(n_viable),
        percent(outcomes.len() - chosen.len()),
        percent(n_near),
        n_confirmed as f64 / outcomes.len() as f64
    )
}

/// Sweeps as the program makes them.
fn seeds(sweeper: &Sweeper) {
    let truth = sweeper.truth();
    let deepest = truth.deepest();
    println!("The deepest true cells: {}.\n", sweeper.names(&deepest));
    println!(
        "| seed | replicates | chosen | true share, worse | as measured | off, cells | confirmed, cells |\n\
         |---|---|---|---|---|---|---|"
    );
    for seed in 1..=10 {
        for replicates in REPLICATES {
            let swept = sweeper.sweep(seed, replicates);
            let Outcome { chosen, n_confirmed } =
                rules::smoothed(&swept, |cell| sweeper.confirm(seed, cell));
            let recommended = chosen.map_or_else(
                || "none | | | ".to_owned(),
                |cell| {
                    let [worse, measured] = truth.shares(cell);
                    let off = truth.nearest(cell, &deepest);
                    format!("{} | {worse:.3} | {measured:.3} | {off:.2}", sweeper.names(&[cell]))
                },
            );
            println!("| {seed} | {replicates} | {recommended} | {n_confirmed} |");
        }
    }
}

/// Where robots as measured surely mill less often than robots made worse.
fn inequality(nine: &Sweeper) {
    const LEVEL: f64 = 0.05;
    let planes = [8, 10].map(|robots| (robots, Sweeper::with_robots(robots)));
    let n_cells: usize = planes.iter().map(|(_, sweeper)| sweeper.n_cells()).sum();
    println!("| robots | cell | made worse | as measured | p (Fisher) |\n|---|---|---|---|---|");
    let mut found = vec![less_often(9, nine, LEVEL / nine.n_cells() as f64)];
    for (robots, sweeper) in &planes {
        found.push(less_often(*robots, sweeper, LEVEL / n_cells as f64));
    }
    println!("\n{}.", found.join(", "));
}

/// Fisher's exact probability of at most so many hits of the one, given all hits, if both have one share.
fn fisher_less(one: Share, other: Share) -> f64 {
    let log_factorial = |n: u64| libm::lgamma(n as f64 + 1.0);
    let log_choose = |n: u64, k| log_factorial(n) - log_factorial(k) - log_factorial(n - k);
    let (hits, n) = (one.hits + other.hits, one.n + other.n);
    let least = one.n.saturating_sub(n - hits);
    let log = |of_one: u64| log_choose(hits, of_one) + log_choose(n - hits, one.n - of_one);
    (least..=one.hits).map(|of_one| libm::exp(log(of_one) - log_choose(n, one.n))).sum()
}

/// Prints these cells, and returns how many there are.
fn less_often(robots: u32, sweeper: &Sweeper, level: f64) -> String {
    let truth = sweeper.truth();
    let mut n_found = 0;
    for cell in 0..sweeper.n_cells() {
        let [worse, measured] = truth.milling(cell);
        let p = fisher_less(measured, worse);
        if p <= level {
            n_found += 1;
            let [worse, measured] = [worse, measured].map(|share| 100.0 * share.value());
            let name = sweeper.names(&[cell]);
            println!("| {robots} | {name} | {worse:.1} | {measured:.1} | {p:.1e} |");
        }
    }
    format!("{robots} robots: {n_found} of {} cells", sweeper.n_cells())
}
