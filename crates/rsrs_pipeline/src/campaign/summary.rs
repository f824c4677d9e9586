//! What a campaign has come to.

use std::fmt;
use std::path::PathBuf;

use rsrs_core::judge::phase::Phase;
use rsrs_fleet::record::EndingKind;
use serde::Serialize;

use super::Item;
use super::folder::{BAG, CampaignFolder};
use crate::label::{Settledness, marked};
use crate::run::recording_gaps::{self, Gap};
use crate::wording::columns;
use crate::wording::shell::quoted;
use crate::wording::{count, counted};

/// What stands in the place of an ending.
const NOT_RUN: &str = "not run";

/// What a campaign has come to.
#[derive(Debug, Serialize)]
pub struct Summary {
    folder: PathBuf,
    n_finished: usize,
    experiments: Vec<Row>,
    next: String,
}

/// What one experiment has come to.
#[derive(Debug, Serialize)]
struct Row {
    experiment: String,
    speed_m_s: f64,
    turn_rate_rad_s: f64,
    n_robots: usize,
    seed: u64,
    replicate: u64,
    /// `None` for one that was not run yet.
    ending: Option<String>,
    /// Why, if it is void.
    reason: String,
    phase: Option<Phase>,
    /// Whether that phase is near another one; in `label.json` beside the bag.
    #[serde(skip)]
    settledness: Settledness,
    /// Why the judge could not label it.
    not_judged: String,
    n_messages: u64,
    /// Messages that the middleware lost on topics that are to lose none; `None` if that is unknown.
    n_lost: Option<u64>,
    gaps: Vec<Gap>,
    bag: Option<PathBuf>,
}

/// How one experiment ended, for those who show it.
#[derive(Clone, Copy, Debug)]
pub struct Ended<'a> {
    /// The experiment.
    pub experiment: &'a str,
    /// How, in a word; `not run` for one that was not run yet.
    pub ending: &'a str,
    /// Whether its label is near another one.
    pub is_borderline: bool,
}

impl Summary {
    /// How the experiments ended, in the order of the table.
    pub fn endings(&self) -> impl Iterator<Item = Ended<'_>> {
        self.experiments.iter().map(|row| Ended {
            experiment: &row.experiment,
            ending: row.ending.as_deref().unwrap_or(NOT_RUN),
            is_borderline: row.settledness.is_borderline(),
        })
    }

    /// Whether every experiment was run and completed, and lost nothing on its way to the bag.
    pub fn is_whole(&self) -> bool {
        let completed = EndingKind::Completed.key();
        self.experiments.iter().all(|row| {
            let has_overflowed = row.gaps.iter().any(|gap| gap.n_overflowed > 0);
            let has_lost = row.n_lost.is_some_and(|n_lost| n_lost > 0) || has_overflowed;
            row.ending.as_deref() == Some(completed) && !has_lost
        })
    }
}

impl Summary {
    /// Looks at all experiments of a campaign.
    ///
    /// # Arguments
    ///
    /// * `command` — the one that goes on, if there is something left.
    ///
    /// # Errors
    ///
    /// If a manifest cannot be read.
    pub fn of(folder: &CampaignFolder, items: &[Item], command: &str) -> anyhow::Result<Self> {
        let experiments = items
            .iter()
            .map(|item| {
                let manifest = folder.manifest(item)?;
                let bag = manifest.is_some().then(|| folder.of(item).join(BAG));
                let controller = item.identity.conditions.controller;
                let row = Row {
                    experiment: item.experiment.folder.clone(),
                    speed_m_s: controller.speed_m_s,
                    turn_rate_rad_s: controller.turn_rate_rad_s,
                    n_robots: item.identity.robots.len(),
                    seed: item.identity.seed,
                    replicate: item.identity.replicate,
                    ending: manifest.as_ref().map(|it| it.ending.clone()),
                    reason: manifest.as_ref().map_or_else(String::new, |it| it.reason.clone()),
                    phase: manifest.as_ref().and_then(|it| it.phase),
                    settledness: folder.settledness(item)?,
                    not_judged: manifest
                        .as_ref()
                        .map_or_else(String::new, |it| it.not_judged.clone()),
                    n_messages: manifest.as_ref().map_or(0, |it| it.n_messages),
                    n_lost: manifest.as_ref().and_then(|it| it.n_lost),
                    gaps: manifest.map_or_else(Vec::new, |it| it.gaps),
                    bag,
                };
                Ok(row)
            })
            .collect::<anyhow::Result<Vec<Row>>>()?;
        let n_finished = experiments.iter().filter(|row| row.ending.is_some()).count();
        let next = if n_finished < experiments.len() {
            command.to_owned()
        } else {
            let sweep = items.iter().find_map(|item| item.experiment.from.clone());
            let sweep = sweep.map_or_else(|| "SWEEP".to_owned(), quoted);
            format!("rsrs compare {sweep} --bags {}/*/{BAG}", quoted(folder.path()))
        };
        Ok(Self { folder: folder.path().to_owned(), n_finished, experiments, next })
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&text(self))
    }
}

/// The experiments as a table, and what comes next.
fn text(summary: &Summary) -> String {
    let head = ["experiment", "m/s", "rad/s", "robots", "seed", "ended", "label", "messages"];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(summary.experiments.iter().map(cells));
    let mut lines = vec![columns(&rows)];
    for row in &summary.experiments {
        let name = &row.experiment;
        if !row.reason.is_empty() {
            lines.push(format!("{name}: {}", row.reason));
        }
        if !row.not_judged.is_empty() {
            lines.push(format!("{name}: not judged: {}", row.not_judged));
        }
        if let Some(n_lost @ 1..) = row.n_lost {
            lines
                .push(format!("{name}: {} lost on the way to the bag", counted(n_lost, "message")));
        }
        lines.extend(recording_gaps::lines(&row.gaps).iter().map(|gap| format!("{name}: {gap}")));
    }
    lines.push(format!(
        "{} of {} experiments are finished, in {}",
        summary.n_finished,
        summary.experiments.len(),
        summary.folder.display()
    ));
    lines.push(format!("next: {}", summary.next));
    lines.join("\n")
}

fn cells(row: &Row) -> [String; 8] {
    let phase = row.phase.map_or_else(|| "-".to_owned(), |phase| marked(phase, row.settledness));
    let seed = match row.replicate {
        0 => row.seed.to_string(),
        replicate => format!("{} #{replicate}", row.seed),
    };
    let (ending, n_messages) = match &row.ending {
        Some(ending) => (ending.clone(), count(row.n_messages)),
        None => (NOT_RUN.to_owned(), "-".to_owned()),
    };
    [
        row.experiment.clone(),
        row.speed_m_s.to_string(),
        row.turn_rate_rad_s.to_string(),
        row.n_robots.to_string(),
        seed,
        ending,
        phase,
        n_messages,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(experiment: &str, label: &str) -> Row {
        Row {
            experiment: experiment.to_owned(),
            speed_m_s: 0.15,
            turn_rate_rad_s: 0.75,
            n_robots: 9,
            seed: 1,
            replicate: 0,
            ending: Some("completed".to_owned()),
            reason: String::new(),
            phase: Some(Phase::StableMilling),
            settledness: serde_json::from_str(label).expect("it is a label"),
            not_judged: String::new(),
            n_messages: 1234,
            n_lost: Some(0),
            gaps: Vec::new(),
            bag: None,
        }
    }

    #[test]
    fn a_label_near_another_one_is_marked_in_the_table() {
        let summary = Summary {
            folder: PathBuf::from("results"),
            n_finished: 3,
            experiments: vec![
                row("001_sure", r#"{"phase": "stable_milling", "is_settled": true}"#),
                row("002_near", r#"{"phase": "stable_milling", "is_settled": false}"#),
                row("003_by_ana", r#"{"phase": "stable_milling"}"#),
            ],
            next: "rsrs compare sweep --bags results/*/bag".to_owned(),
        };

        let table = summary.to_string();
        let rows: Vec<&str> = table.lines().skip(1).take(3).collect();
        assert!(rows[1].contains(" stable milling (not settled: look again)  1,234"), "{table}");
        assert!(!rows[0].contains("look again") && !rows[2].contains("look again"), "{table}");
        let borderline: Vec<bool> = summary.endings().map(|ended| ended.is_borderline).collect();
        assert_eq!(borderline, [false, true, false]);
    }
}
