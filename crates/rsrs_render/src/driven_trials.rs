//! What driven trials came to.

use std::path::{Path, PathBuf};

use rsrs_core::numerals::counted;
use serde::Serialize;

/// What filling in tables of trials came to.
#[derive(Clone, Debug, Serialize)]
pub struct Filled {
    /// The table, or the folder of the plan.
    pub table: PathBuf,
    /// Of one table that was filled in alone, what `rsrs measure fit` calls it.
    #[serde(skip)]
    pub only: Option<&'static str>,
    /// Rows that were filled in now.
    pub n_filled: usize,
    /// Rows that are still without a result.
    pub n_left: usize,
    /// How often a trial is made one after the other, while commands pause in it.
    #[serde(skip)]
    pub n_attempts: usize,
    /// Of the rows left, those that have a result in which commands paused.
    pub n_paused: usize,
    /// Messages that the middleware lost.
    pub n_lost: u64,
}

impl Filled {
    /// Whether no trial lost messages, and in none commands paused.
    pub fn is_whole(&self) -> bool {
        self.n_lost == 0 && self.n_paused == 0
    }
}

/// How far the tables are filled in, and what comes next.
pub fn filled(filled: &Filled) -> String {
    let Filled { only, n_filled, n_left, n_attempts, n_paused, n_lost, .. } = filled;
    let table = filled.table.display();
    let mut lines =
        vec![format!("{table}: {} filled in, {n_left} left", counted(*n_filled as u64, "row"))];
    if *n_paused > 0 {
        lines.push(format!(
            "in {n_paused} of those left commands paused in {n_attempts} trials one after the \
             other: `paused_s` states for how long; give this machine less to do, or the robots \
             a better network"
        ));
    }
    if *n_lost > 0 {
        lines.push(format!("{} lost on the way to the bags", counted(*n_lost, "message")));
    }
    lines.push(match (n_left, only) {
        (0, Some(option)) => format!("next: rsrs measure fit --{option} {table} … --name NAME"),
        (0, None) => format!("next: rsrs measure fit --plan {table} --name NAME -o PROFILE.yaml"),
        _ => "next: the same command again; it goes on with the rows that are left".to_owned(),
    });
    lines.join("\n")
}

/// The result of one trial: where it was recorded, its row as a `table`, and whether commands paused.
pub fn single(bag: &Path, table: &str, paused_s: Option<f64>) -> String {
    let paused = paused_s.map_or_else(String::new, |paused_s| format!("\n{}", pause(paused_s)));
    format!("{}:\n{table}{paused}", bag.display())
}

/// What a pause of the commands means for a trial.
pub fn pause(paused_s: f64) -> String {
    format!(
        "commands paused for {paused_s:.3} s, so the trial does not measure a gain; its row is \
         marked, and `rsrs measure fit` leaves it out"
    )
}
