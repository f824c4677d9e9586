//! One experiment after the other.

use std::pin::Pin;

use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::record::{Ending, EndingKind};
use rsrs_ros::session::SessionOptions;

use super::Item;
use super::folder::{BAG, CampaignFolder, counts};
use super::manifest::Manifest;
use crate::error::with_help;
use crate::files::write_file;
use crate::label::{Settledness, marked};
use crate::run::operator::Operator;
use crate::run::own_network::OwnNetwork;
use crate::run::place_command::WantedPlacement;
use crate::run::recording_gaps;
use crate::run::simulated_fleet::SimulatedFleet;
use crate::run::start_poses::StartPoses;
use crate::run::{RunSummary, on_simulated_fleet, watched};

/// Where the robots are.
pub enum RunTarget {
    /// In a simulator that is started for the campaign.
    Simulator {
        /// Where it is.
        network: OwnNetwork,
        /// Its processes, and the robots that they stand for.
        fleet: Option<Box<(Vec<String>, SimulatedFleet)>>,
    },
    /// On the floor.
    Fleet {
        /// Where they are received.
        network: SessionOptions,
    },
}

/// Whoever places the robots of a fleet before each run.
pub trait Placer {
    /// Has the robots placed.
    ///
    /// # Arguments
    ///
    /// * `text` — the experiment, and where its robots start.
    /// * `wanted` — the same for a program.
    ///
    /// # Errors
    ///
    /// If they were not placed.
    fn place<'a>(
        &'a mut self,
        text: &'a str,
        wanted: &'a WantedPlacement,
    ) -> Pin<Box<dyn Future<Output = anyhow::Result<OperatorDecision>> + 'a>>;
}

/// What to do with an experiment whose robots were to be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperatorDecision {
    /// The robots stand: start.
    Start,
    /// Not this one now.
    Skip,
    /// No more for now.
    Quit,
}

/// What comes after an experiment.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Next {
    GoOn,
    Quit,
}

/// Conducts a campaign.
pub struct Conductor<'a, P> {
    folder: &'a CampaignFolder,
    target: RunTarget,
    placer: P,
    operator: &'a dyn Operator,
}

impl<'a, P: Placer> Conductor<'a, P> {
    /// Conducts the campaign of a folder.
    ///
    /// # Arguments
    ///
    /// * `placer` — puts the robots of a fleet where a run starts.
    /// * `operator` — asked before a run, and shown how it goes.
    pub fn new(
        folder: &'a CampaignFolder,
        target: RunTarget,
        placer: P,
        operator: &'a dyn Operator,
    ) -> Self {
        Self { folder, target, placer, operator }
    }

    /// Verifies what is finished, and runs what is not.
    ///
    /// # Errors
    ///
    /// If a file of a finished experiment was changed, or a run was not completed; what was finished
    /// until then stays.
    pub async fn conduct(mut self, items: &[Item]) -> anyhow::Result<()> {
        let mut open = Vec::new();
        for item in items {
            if self.folder.finished(item)?.is_none() {
                open.push(item);
            }
        }
        let ended = self.all(&open, items.len()).await;
        if let RunTarget::Simulator { fleet: Some(fleet), .. } = self.target {
            fleet.1.stop().await?;
        }
        ended
    }

    async fn all(&mut self, open: &[&Item], n_items: usize) -> anyhow::Result<()> {
        if open.len() < n_items {
            self.operator.note(&format!("{} of {n_items} are finished", n_items - open.len()));
        }
        let mut stop: Pin<Box<dyn Future<Output = String>>> = self.operator.stop_requested();
        for item in open {
            // Between two runs nothing else receives it.
            let stopped = tokio::select! {
                biased;
                reason = &mut stop => Some(reason),
                () = std::future::ready(()) => None,
            };
            if let Some(reason) = stopped {
                anyhow::bail!("{reason} before {}", item.experiment.folder);
            }
            if self.one(item).await? == Next::Quit {
                break;
            }
        }
        Ok(())
    }

    async fn one(&mut self, item: &Item) -> anyhow::Result<Next> {
        let name = &item.experiment.folder;
        if let Some(manifest) = self.folder.adopt(item)? {
            let outcome = outcome(&manifest, self.folder.settledness(item)?);
            self.operator.note(&format!("{name}: its bag was complete already{outcome}"));
            return Ok(Next::GoOn);
        }
        if let Some(aside) = self.folder.keep_aside(item)? {
            self.operator.note(&format!(
                "{name}: a recording that broke off is kept as {} and does not count",
                aside.display()
            ));
        }
        let folder = self.folder.of(item);
        let plan = item.plan(folder.join(BAG))?;
        match self.ask(&plan, item).await? {
            OperatorDecision::Start => {}
            OperatorDecision::Skip => return Ok(Next::GoOn),
            OperatorDecision::Quit => return Ok(Next::Quit),
        }
        std::fs::create_dir_all(&folder)?;
        for (file, text) in &plan.files {
            write_file(&folder.join(file), text.as_bytes())?;
        }
        let summary = self.run(&plan).await?;
        self.settle(item, plan, &summary)?;
        Ok(Next::GoOn)
    }

    /// Has the robots placed; in the simulator they place themselves.
    async fn ask(&mut self, plan: &Plan, item: &Item) -> anyhow::Result<OperatorDecision> {
        let RunTarget::Fleet { .. } = self.target else { return Ok(OperatorDecision::Start) };
        let conditions = &plan.record.conditions.controller;
        let starts = StartPoses::of(plan)?;
        let what = format!(
            "\n{}: {} m/s, {} rad/s, for {} s\nplace the robots:\n{}",
            item.experiment.folder,
            conditions.speed_m_s,
            conditions.turn_rate_rad_s,
            plan.record.duration_s,
            starts
        );
        let wanted = starts.wanted(item.experiment.folder.clone());
        self.placer.place(&what, &wanted).await
    }

    async fn run(&mut self, plan: &Plan) -> anyhow::Result<RunSummary> {
        let (network, fleet) = match &mut self.target {
            RunTarget::Fleet { network } => {
                return watched(plan, network, self.operator.stop_requested(), self.operator).await;
            }
            RunTarget::Simulator { network, fleet } => (network, fleet),
        };
        let robots = &plan.record.robots;
        if let Some(other) = fleet.take_if(|it| it.0 != *robots) {
            other.1.stop().await?;
        }
        if fleet.is_none() {
            *fleet = Some(Box::new((robots.clone(), SimulatedFleet::start(network, robots)?)));
        }
        let fleet = fleet.as_mut().expect("it was started above");
        on_simulated_fleet(plan, network, &mut fleet.1, self.operator).await
    }

    /// Makes an experiment of a run that has ended, or keeps what there is of it aside.
    fn settle(&self, item: &Item, plan: Plan, summary: &RunSummary) -> anyhow::Result<()> {
        let name = &item.experiment.folder;
        let kind = EndingKind::from_key(summary.ending).expect("a run has an ending");
        if !counts(kind) {
            let aside = self.folder.keep_aside(item)?;
            let message = format!("{name} {}: {}", summary.ending, summary.reason);
            return Err(match aside {
                Some(aside) => {
                    with_help(message, format!("what was recorded is in {}", aside.display()))
                }
                None => anyhow::anyhow!(message),
            });
        }
        let lost = summary.lost_robots.clone();
        let ending = Ending { kind, reason: summary.reason.clone(), lost };
        let manifest = self.folder.finish(item, plan.record, &ending, Some(summary.n_lost))?;
        let outcome = outcome(&manifest, self.folder.settledness(item)?);
        self.operator.note(&format!("{name}: {}{outcome}", manifest.ending));
        for lost in &summary.lost_robots {
            self.operator.note(&format!("  {lost}"));
        }
        for line in recording_gaps::lines(&manifest.gaps) {
            self.operator.note(&format!("  {line}"));
        }
        if summary.not_standing.is_empty() {
            return Ok(());
        }
        let robots = summary.not_standing.join(", ");
        Err(anyhow::anyhow!("{name}: not confirmed to stand, go and look: {robots}"))
    }
}

/// What came of an experiment, behind its name.
fn outcome(manifest: &Manifest, settledness: Settledness) -> String {
    match manifest.phase {
        Some(phase) => format!(", {}", marked(phase, settledness)),
        None => format!(", not judged: {}", manifest.not_judged),
    }
}
