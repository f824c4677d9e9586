//! A replicate that was run again, in words.

use rsrs_core::numerals::counted;
use rsrs_files::quoted;
use rsrs_pipeline::episode::replicate::Episode;

use crate::settling;

/// What its swarm settled into, and where it is.
pub fn text(episode: &Episode) -> String {
    let Episode { bag, cell, replicate, seed, phase, duration_s, .. } = episode;
    let from = |converged_s: f64| format!(" from {converged_s:.0} s on");
    let mut lines = vec![format!(
        "{}: {phase}{}, replicate {replicate} of {cell}, seed {seed} ({}, {duration_s:.0} s, {})",
        bag.display(),
        episode.converged_s.map_or_else(String::new, from),
        counted(episode.n_robots as u64, "robot"),
        counted(episode.n_messages, "message")
    )];
    lines.extend(episode.settling.iter().map(|it| format!("  {}", settling::text(it))));
    lines.push(format!("next: rsrs label {}", quoted(bag)));
    lines.join("\n")
}
