//! What a campaign has come to.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::controller::Controller;
use rsrs_files::quoted;
use rsrs_fleet::record::LostRobot;
use serde::Serialize;

use super::Item;
use super::folder::{BAG, CampaignFolder};
use crate::attempt::Attempt;
use crate::label::Settledness;
use crate::recorded_run::gaps::Gap;

/// What a campaign has come to.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// The folder of the campaign.
    pub folder: PathBuf,
    /// Experiments that have their result.
    pub n_finished: usize,
    /// The experiments, in their order.
    pub experiments: Vec<Row>,
    /// The command that comes next.
    pub next: String,
}

/// What one experiment has come to.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub experiment: String,
    /// Speed that was commanded, in metres per second; `None` with the table of a controller.
    pub speed_m_s: Option<f64>,
    /// Turning rate that was commanded, in radians per second; `None` with the table of a controller.
    pub turn_rate_rad_s: Option<f64>,
    /// The named numbers of the table.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// Number of robots.
    pub n_robots: usize,
    /// Its seed.
    pub seed: u64,
    /// Its replicate.
    pub replicate: u64,
    /// Robots of its run; of one that is to be run, those that the fleet file has now.
    pub robots: Vec<String>,
    /// Whether it has its result; if not, the campaign runs it again.
    pub is_finished: bool,
    /// Of its last run; `None` for one that was not run yet.
    pub ending: Option<String>,
    /// Why, if it is void or gave no result.
    pub reason: String,
    /// What the judge found.
    pub phase: Option<Phase>,
    /// Whether that phase is near another one; in `label.json` beside the bag.
    #[serde(skip)]
    pub settledness: Settledness,
    /// Why the judge could not label it.
    pub not_judged: String,
    /// Messages in its bag.
    pub n_messages: u64,
    /// Messages that the middleware lost on topics that are to lose none; `None` if that is unknown.
    pub n_lost: Option<u64>,
    /// What is missing in its bag, by topic.
    pub gaps: Vec<Gap>,
    /// Robots that were lost on the way, and when.
    pub lost_robots: Vec<LostRobot>,
    /// Whether it counts in a comparison although robots were lost.
    pub counts: bool,
    /// Runs of it that gave no result.
    pub attempts: Vec<Attempt>,
    /// Robots that were replaced since it was run.
    #[serde(skip)]
    pub replaced: Option<Replaced>,
    /// Its bag; `None` if it has none that counts.
    pub bag: Option<PathBuf>,
}

/// Robots of a run that the fleet file has others for by now.
#[derive(Debug, PartialEq)]
pub struct Replaced {
    /// Those of the run.
    pub gone: Vec<String>,
    /// Those in their place.
    pub new: Vec<String>,
}

impl Replaced {
    /// Those that differ between the robots of a run and those that the fleet file has now.
    pub fn between(before: &[String], now: &[String]) -> Option<Self> {
        let lacks = |all: &[String], robot: &&String| !all.contains(robot);
        let gone: Vec<String> = before.iter().filter(|it| lacks(now, it)).cloned().collect();
        let new: Vec<String> = now.iter().filter(|it| lacks(before, it)).cloned().collect();
        (!gone.is_empty()).then_some(Self { gone, new })
    }
}

impl Summary {
    /// Whether every experiment was run, completed and judged, counts, and lost nothing on its way to the
    /// bag.
    pub fn is_whole(&self) -> bool {
        self.experiments.iter().all(|row| {
            let has_overflowed = row.gaps.iter().any(|gap| gap.n_overflowed > 0);
            let has_lost = row.n_lost.is_some_and(|n_lost| n_lost > 0) || has_overflowed;
            row.is_finished && row.phase.is_some() && row.counts && !has_lost
        })
    }

    /// Looks at all experiments of a campaign; `command` is the one that goes on, if there is
    /// something left.
    pub fn new(folder: &CampaignFolder, items: &[Item], command: &str) -> anyhow::Result<Self> {
        let row = |item: &Item| Row::new(folder, item);
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
    fn new(folder: &CampaignFolder, item: &Item) -> anyhow::Result<Self> {
        let manifest = folder.manifest(item)?;
        let attempts = folder.attempts(item)?;
        let (detected, numbers) = match &item.record.conditions.controller {
            Controller::Parameters(parameters) => (Some(parameters.commands()[0]), BTreeMap::new()),
            Controller::Machine(machine) => (None, machine.numbers.clone()),
        };
        let mut row = Self {
            experiment: item.experiment.folder.clone(),
            speed_m_s: detected.map(|command| command.speed_m_s),
            turn_rate_rad_s: detected.map(|command| command.turn_rate_rad_s),
            numbers,
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
}
