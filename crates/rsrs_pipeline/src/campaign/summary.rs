//! What a campaign has come to.

use std::fmt;
use std::path::PathBuf;

use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::record::LostRobot;
use serde::Serialize;

use super::Item;
use super::folder::{BAG, CampaignFolder};
use crate::attempt::{Attempt, BROKEN_OFF, NOT_JUDGED};
use crate::label::{Settledness, marked};
use crate::recorded_run::gaps::{self, Gap};
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
    /// Robots of its run; of one that is to be run, those that the fleet file has now.
    robots: Vec<String>,
    /// Whether it has its result; if not, the campaign runs it again.
    is_finished: bool,
    /// Of its last run; `None` for one that was not run yet.
    ending: Option<String>,
    /// Why, if it is void or gave no result.
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
    /// Robots that were lost on the way, and when.
    lost_robots: Vec<LostRobot>,
    /// Whether it counts in a comparison although robots were lost.
    counts: bool,
    /// Runs of it that gave no result.
    attempts: Vec<Attempt>,
    /// Robots that were replaced since it was run.
    #[serde(skip)]
    replaced: Option<Replaced>,
    bag: Option<PathBuf>,
}

/// Robots of a run that the fleet file has others for by now.
#[derive(Debug, PartialEq)]
struct Replaced {
    gone: Vec<String>,
    new: Vec<String>,
}

impl Replaced {
    fn between(before: &[String], now: &[String]) -> Option<Self> {
        let lacks = |all: &[String], robot: &&String| !all.contains(robot);
        let gone: Vec<String> = before.iter().filter(|it| lacks(now, it)).cloned().collect();
        let new: Vec<String> = now.iter().filter(|it| lacks(before, it)).cloned().collect();
        (!gone.is_empty()).then_some(Self { gone, new })
    }
}

/// How one experiment ended, for those who show it.
#[derive(Clone, Copy, Debug)]
pub struct Ended<'a> {
    /// The experiment.
    pub experiment: &'a str,
    /// How, in a word or two; `not run` for one that was not run yet.
    pub ending: &'a str,
    /// What stands behind its label, if a person should look at it.
    pub warning: Option<&'static str>,
}

impl Summary {
    /// How the experiments ended, in the order of the table.
    pub fn endings(&self) -> impl Iterator<Item = Ended<'_>> {
        self.experiments.iter().map(|row| Ended {
            experiment: &row.experiment,
            ending: row.ended(),
            warning: row.phase.and_then(|_| row.settledness.warning()),
        })
    }

    /// Whether every experiment was run, completed and judged, counts, and lost nothing on its way to the
    /// bag.
    pub fn is_whole(&self) -> bool {
        self.experiments.iter().all(|row| {
            let has_overflowed = row.gaps.iter().any(|gap| gap.n_overflowed > 0);
            let has_lost = row.n_lost.is_some_and(|n_lost| n_lost > 0) || has_overflowed;
            row.is_finished && row.phase.is_some() && row.counts && !has_lost
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
        let row = |item: &Item| Row::of(folder, item);
        let experiments = items.iter().map(row).collect::<anyhow::Result<Vec<Row>>>()?;
        let n_finished = experiments.iter().filter(|row| row.is_finished).count();
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

impl Row {
    fn of(folder: &CampaignFolder, item: &Item) -> anyhow::Result<Self> {
        let manifest = folder.manifest(item)?;
        let attempts = folder.attempts(item)?;
        // The command for a detection; of a table that of its first row.
        let Command { speed_m_s, turn_rate_rad_s } =
            item.record.conditions.controller.commands()[0];
        let mut row = Self {
            experiment: item.experiment.folder.clone(),
            speed_m_s,
            turn_rate_rad_s,
            n_robots: item.record.robots.len(),
            seed: item.record.seed,
            replicate: item.record.replicate,
            robots: item.record.robots.clone(),
            is_finished: false,
            ending: attempts.last().map(|attempt| attempt.ending.clone()),
            reason: attempts.last().map_or_else(String::new, |attempt| attempt.reason.clone()),
            phase: None,
            settledness: folder.settledness(item)?,
            not_judged: String::new(),
            n_messages: 0,
            n_lost: None,
            gaps: Vec::new(),
            lost_robots: Vec::new(),
            counts: true,
            attempts,
            replaced: None,
            bag: None,
        };
        if let Some(manifest) = manifest {
            row.is_finished = manifest.is_result();
            row.counts = manifest.record.counts_without(&manifest.lost_robots);
            row.replaced = Replaced::between(&manifest.record.robots, &row.robots);
            row.robots = manifest.record.robots;
            row.ending = Some(manifest.ending);
            row.reason = manifest.reason;
            row.phase = manifest.phase;
            row.not_judged = manifest.not_judged;
            row.n_messages = manifest.n_messages;
            row.n_lost = manifest.n_lost;
            row.gaps = manifest.gaps;
            row.lost_robots = manifest.lost_robots;
            row.bag = Some(folder.of(item).join(BAG));
        }
        Ok(row)
    }

    /// How its last run ended, in a word or two.
    fn ended(&self) -> &str {
        match self.ending.as_deref() {
            None => NOT_RUN,
            Some("completed") if !self.is_finished => "not judged",
            Some(BROKEN_OFF) => "broken off",
            Some(ending) => ending,
        }
    }

    /// What there is to state of it under the table.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (attempt, number) in self.attempts.iter().zip(1..) {
            let kept = attempt.bag.as_ref().map(|bag| format!("; kept as {bag}"));
            notes.push(format!("attempt {number}: {attempt}{}", kept.unwrap_or_default()));
        }
        let is_told = self.attempts.last().is_some_and(|last| last.reason == self.reason);
        if !self.reason.is_empty() && !is_told {
            notes.push(self.reason.clone());
        }
        if !self.not_judged.is_empty() {
            notes.push(format!("{NOT_JUDGED}{}", self.not_judged));
        }
        if let Some(n_lost @ 1..) = self.n_lost {
            notes.push(format!("{} lost on the way to the bag", counted(n_lost, "message")));
        }
        let counts = if self.counts { "; it counts" } else { "; it counts nowhere" };
        notes.extend(self.lost_robots.iter().map(|lost| format!("{lost}{counts}")));
        notes.extend(gaps::lines(&self.gaps));
        notes.iter().map(|note| format!("{}: {note}", self.experiment)).collect()
    }
}

/// Which experiments were run with robots that have been replaced since; those in a row together.
fn replaced(rows: &[Row]) -> Vec<String> {
    let runs = rows.chunk_by(|row, next| row.replaced == next.replaced);
    let line = |run: &[Row]| {
        let [first, ..] = run else { return None };
        let Replaced { gone, new } = first.replaced.as_ref()?;
        let last = &run[run.len() - 1].experiment;
        let first = &first.experiment;
        let which = if first == last { first.clone() } else { format!("{first} to {last}") };
        let (gone, new) = (gone.join(", "), new.join(", "));
        Some(format!("{which}: run with {gone}, in whose place the fleet file has {new} now"))
    };
    runs.filter_map(line).collect()
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&text(self))
    }
}

/// The experiments as a table, and what comes next.
fn text(summary: &Summary) -> String {
    let head =
        ["experiment", "m/s", "rad/s", "robots", "lost", "seed", "ended", "label", "messages"];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(summary.experiments.iter().map(cells));
    let mut lines = vec![columns(&rows)];
    lines.extend(summary.experiments.iter().flat_map(Row::notes));
    lines.extend(replaced(&summary.experiments));
    lines.push(format!(
        "{} of {} experiments are finished, in {}",
        summary.n_finished,
        summary.experiments.len(),
        summary.folder.display()
    ));
    lines.push(format!("next: {}", summary.next));
    lines.join("\n")
}

fn cells(row: &Row) -> [String; 9] {
    let phase = row.phase.map_or_else(|| "-".to_owned(), |phase| marked(phase, row.settledness));
    let seed = match row.replicate {
        0 => row.seed.to_string(),
        replicate => format!("{} #{replicate}", row.seed),
    };
    let n_messages = row.bag.as_ref().map_or_else(|| "-".to_owned(), |_| count(row.n_messages));
    [
        row.experiment.clone(),
        row.speed_m_s.to_string(),
        row.turn_rate_rad_s.to_string(),
        row.n_robots.to_string(),
        row.lost_robots.len().to_string(),
        seed,
        row.ended().to_owned(),
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
            robots: vec!["robot_1".to_owned(), "robot_3".to_owned()],
            is_finished: true,
            ending: Some("completed".to_owned()),
            reason: String::new(),
            phase: Some(Phase::StableMilling),
            settledness: serde_json::from_str(label).expect("it is a label"),
            not_judged: String::new(),
            n_messages: 1234,
            n_lost: Some(0),
            gaps: Vec::new(),
            lost_robots: Vec::new(),
            counts: true,
            attempts: Vec::new(),
            replaced: None,
            bag: Some(PathBuf::from("bag")),
        }
    }

    fn summary(experiments: Vec<Row>) -> Summary {
        let n_finished = experiments.iter().filter(|row| row.is_finished).count();
        let next = "rsrs compare sweep --bags results/*/bag".to_owned();
        Summary { folder: PathBuf::from("results"), n_finished, experiments, next }
    }

    const SURE: &str = r#"{"phase": "stable_milling", "is_settled": true}"#;

    fn lost() -> Vec<LostRobot> {
        let (robot, reason) = ("robot_1".to_owned(), "silent for more than 1 s".to_owned());
        vec![LostRobot { robot, after_s: 61.2, reason }]
    }

    #[test]
    fn a_robot_that_was_lost_is_in_the_table_and_such_a_campaign_is_not_whole() {
        let without = Row { lost_robots: lost(), counts: false, ..row("001_lost", SURE) };
        let short_handed = summary(vec![without, row("002_whole", SURE)]);

        let table = short_handed.to_string();
        let rows: Vec<&str> = table.lines().collect();
        assert!(rows[0].contains(" robots  lost  seed "), "{table}");
        let columns: Vec<&str> = rows[1].split_whitespace().collect();
        assert_eq!(columns[..6], ["001_lost", "0.15", "0.75", "9", "1", "1"], "{table}");
        let note =
            "001_lost: robot_1 lost after 61.2 s: silent for more than 1 s; it counts nowhere";
        assert!(rows.contains(&note), "{table}");
        assert!(!short_handed.is_whole());

        let counts = Row { lost_robots: lost(), ..row("001_lost", SURE) };
        assert!(summary(vec![counts]).is_whole(), "its rule was fixed beforehand");
    }

    #[test]
    fn every_attempt_stays_in_the_summary_with_its_cause_and_its_recording() {
        let attempt = |ending: &str, reason: &str, bag: Option<&str>| Attempt {
            run_id: "run".to_owned(),
            robots: Vec::new(),
            ending: ending.to_owned(),
            reason: reason.to_owned(),
            has_started: bag.is_some(),
            lost_robots: Vec::new(),
            bag: bag.map(str::to_owned),
        };
        let open = Row {
            attempts: vec![
                attempt("failed", "robot_3: did not arm: silent", None),
                attempt("void", "frozen for 5 s", Some("bag.unfinished_1")),
            ],
            is_finished: false,
            ending: Some("void".to_owned()),
            reason: "frozen for 5 s".to_owned(),
            phase: None,
            bag: None,
            ..row("001_open", "{}")
        };
        let summary = summary(vec![open]);

        let table = summary.to_string();
        for line in [
            "001_open: attempt 1: failed: robot_3: did not arm: silent",
            "001_open: attempt 2: void: frozen for 5 s; kept as bag.unfinished_1",
            "0 of 1 experiments are finished, in results",
        ] {
            assert!(table.lines().any(|it| it == line), "{line}: {table}");
        }
        assert_eq!(table.matches("frozen").count(), 1, "{table}");
        assert!(!summary.is_whole());
    }

    #[test]
    fn robots_that_were_replaced_are_named_with_the_experiments_that_they_took_part_in() {
        let all = |names: [&str; 2]| names.map(str::to_owned);
        let replaced =
            Replaced::between(&all(["robot_1", "robot_3"]), &all(["robot_8", "robot_1"]));
        assert_eq!(Replaced::between(&all(["a", "b"]), &all(["b", "a"])), None, "another order");
        let before = |name: &str| Row {
            replaced: Replaced::between(&all(["robot_1", "robot_3"]), &all(["robot_8", "robot_1"])),
            ..row(name, SURE)
        };
        assert!(replaced.is_some());

        let table = summary(vec![before("001_a"), before("002_a"), row("003_a", SURE)]).to_string();

        let line =
            "001_a to 002_a: run with robot_3, in whose place the fleet file has robot_8 now";
        assert!(table.lines().any(|it| it == line), "{table}");
    }

    #[test]
    fn a_label_near_another_one_is_marked_in_the_table() {
        let summary = summary(vec![
            row("001_sure", SURE),
            row("002_near", r#"{"phase": "stable_milling", "is_settled": false}"#),
            row("003_by_ana", r#"{"phase": "stable_milling"}"#),
        ]);

        let table = summary.to_string();
        let rows: Vec<&str> = table.lines().skip(1).take(3).collect();
        assert!(rows[1].contains(" stable milling (not settled: look again)  1,234"), "{table}");
        assert!(!rows[0].contains("look again") && !rows[2].contains("look again"), "{table}");
        let borderline: Vec<bool> =
            summary.endings().map(|ended| ended.warning.is_some()).collect();
        assert_eq!(borderline, [false, true, false]);
    }
}
