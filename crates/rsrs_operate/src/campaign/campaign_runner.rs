//! One experiment after the other.

use std::pin::Pin;

use rsrs_experiment_runner::plan::Plan;
use rsrs_fleet::record::{Ending, EndingKind};
use rsrs_pipeline::attempt::{Attempt, NOT_JUDGED, SIMULATED_TRIES};
use rsrs_pipeline::campaign::{BAG, CampaignFolder, Finished, Item};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_render::operator_event::{OperatorEvent, without_result};
use rsrs_render::run_summary::unconfirmed;
use rsrs_render::start_poses::RunToPlace;

use super::plan_now;
use crate::run::operator::Operator;
use crate::run::place_command::WantedPlacement;
use crate::run::simulated_fleet::SimulatedFleet;
use crate::run::start_poses::{start_poses, wanted};
use crate::run::{RunTarget, on_simulated_fleet, watched};

/// Whoever places the robots of a fleet before each run.
pub trait Placer {
    /// Has the robots placed: `run` has the experiment and where its robots start, `wanted` the
    /// same for a program.
    fn place<'a>(
        &'a mut self,
        run: &'a RunToPlace<'a>,
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

/// What came of trying an experiment once.
enum Tried {
    /// It has its result.
    Finished,
    /// It was run, and has none.
    Without(Attempt),
    /// Whoever places the robots passes it over.
    NotNow,
    /// Whoever places the robots wants no more.
    Quit,
}

/// What comes after an experiment.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Next {
    GoOn,
    Quit,
}

/// Conducts a campaign.
pub struct CampaignRunner<'a, P> {
    folder: &'a CampaignFolder,
    target: RunTarget,
    /// What is started of the simulator.
    simulated: Option<SimulatedFleet>,
    placer: P,
    operator: &'a dyn Operator,
    /// How often each experiment is tried at most, until it has a result.
    tries: u32,
}

impl<'a, P: Placer> CampaignRunner<'a, P> {
    /// Conducts the campaign of a folder.
    ///
    /// The placer puts the robots of a fleet where a run starts; the operator is asked before a
    /// run, and shown how it goes.
    pub fn new(
        folder: &'a CampaignFolder,
        target: RunTarget,
        placer: P,
        operator: &'a dyn Operator,
    ) -> Self {
        let tries = match target {
            RunTarget::Simulator(_) => SIMULATED_TRIES,
            RunTarget::Fleet(_) => 1,
        };
        Self { folder, target, simulated: None, placer, operator, tries }
    }

    /// The same, with so many tries of each experiment, the first included.
    #[must_use]
    pub fn with_tries(self, tries: Option<u32>) -> Self {
        Self { tries: tries.unwrap_or(self.tries), ..self }
    }

    /// Verifies what is finished, and runs what is not.
    ///
    /// # Errors
    ///
    /// If a file of a finished experiment was changed, or a run was not completed; what was
    /// finished until then stays.
    pub async fn run_all(mut self, items: &[Item]) -> anyhow::Result<()> {
        let mut open = Vec::new();
        for item in items {
            if !self.folder.is_finished(item)? {
                open.push(item);
            }
        }
        let ended = self.all(&open, items.len()).await;
        if let Some(mut nodes) = self.simulated {
            nodes.stop().await?;
        }
        ended
    }

    async fn all(&mut self, open: &[&Item], n_items: usize) -> anyhow::Result<()> {
        if open.len() < n_items {
            let n_finished = n_items - open.len();
            self.inform(OperatorEvent::CampaignContinued { n_finished, n_experiments: n_items });
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
            let settledness = self.folder.settledness(item)?;
            let manifest = &manifest;
            self.inform(OperatorEvent::BagAdopted { experiment: name, manifest, settledness });
            return Ok(Next::GoOn);
        }
        if let Some(kept) = self.folder.keep(item, None)? {
            self.inform(OperatorEvent::RunAgain { experiment: name, before: &kept });
        }
        let mut n_tries = 0;
        loop {
            n_tries += 1;
            let again = match self.once(item).await? {
                Tried::Finished | Tried::NotNow => return Ok(Next::GoOn),
                Tried::Quit => return Ok(Next::Quit),
                Tried::Without(attempt) => attempt,
            };
            let record = &item.record;
            if again.is_made_again(record, n_tries, self.tries) {
                let (next, most) = (n_tries + 1, self.tries);
                let attempt = &again;
                self.inform(OperatorEvent::TriedAgain { experiment: name, attempt, next, most });
                continue;
            }
            return self.give_up(name, &again);
        }
    }

    /// What comes after an experiment that gave no result and is not tried again now.
    fn give_up(&self, name: &str, last: &Attempt) -> anyhow::Result<Next> {
        // The next one may do better.
        if let Some(EndingKind::Completed | EndingKind::Void) = EndingKind::from_key(&last.ending) {
            self.inform(OperatorEvent::WithoutResult { experiment: name, attempt: last });
            return Ok(Next::GoOn);
        }
        let message = format!("{name} {}: {}", last.ending, last.reason);
        let bag = last.bag.as_ref().map(|bag| self.folder.path().join(name).join(bag));
        Err(match bag {
            Some(bag) => with_help(message, format!("what was recorded is in {}", bag.display())),
            None => anyhow::anyhow!(message),
        })
    }

    /// Runs an experiment once, if whoever places the robots agrees.
    async fn once(&mut self, item: &Item) -> anyhow::Result<Tried> {
        let folder = self.folder.of(item);
        let plan = plan_now(item, folder.join(BAG))?;
        match self.ask(&plan, item).await? {
            OperatorDecision::Start => {}
            OperatorDecision::Skip => return Ok(Tried::NotNow),
            OperatorDecision::Quit => return Ok(Tried::Quit),
        }
        std::fs::create_dir_all(&folder)?;
        for (file, text) in &plan.files {
            write_file(&folder.join(file), text.as_bytes())?;
        }
        let summary = self.run(&plan).await?;
        let tried = self.settle(item, plan, &summary)?;
        // The simulator stands still by itself; nobody can go and look there.
        let is_fleet = matches!(self.target, RunTarget::Fleet(_));
        if is_fleet && !summary.not_standing.is_empty() {
            let (name, stands) = (&item.experiment.folder, unconfirmed(&summary.not_standing));
            return Err(match &tried {
                Tried::Without(attempt) => {
                    anyhow::anyhow!("{name}: {}\n  {stands}", without_result(attempt))
                }
                _ => anyhow::anyhow!("{name}: {stands}"),
            });
        }
        Ok(tried)
    }

    /// Has the robots placed; in the simulator they place themselves.
    async fn ask(&mut self, plan: &Plan, item: &Item) -> anyhow::Result<OperatorDecision> {
        let RunTarget::Fleet(_) = self.target else { return Ok(OperatorDecision::Start) };
        let starts = start_poses(plan)?;
        let wanted = wanted(&starts, item.experiment.folder.clone());
        let run = RunToPlace {
            experiment: &item.experiment.folder,
            controller: &plan.record.conditions.controller,
            duration_s: plan.record.duration_s,
            starts: &starts,
        };
        self.placer.place(&run, &wanted).await
    }

    async fn run(&mut self, plan: &Plan) -> anyhow::Result<RunSummary> {
        let network = match &self.target {
            RunTarget::Fleet(network) => {
                return watched(plan, network, self.operator.stop_requested(), self.operator).await;
            }
            RunTarget::Simulator(network) => network,
        };
        if let Some(mut other) = self.simulated.take_if(|it| !it.is_for(plan)) {
            other.stop().await?;
        }
        let nodes = match &mut self.simulated {
            Some(nodes) => nodes,
            none => none.insert(SimulatedFleet::start(network, plan)?),
        };
        on_simulated_fleet(plan, network, nodes, self.operator).await
    }

    /// Makes an experiment of a run that has ended, or keeps what there is of it aside.
    fn settle(&self, item: &Item, plan: Plan, summary: &RunSummary) -> anyhow::Result<Tried> {
        let mut attempt = summary.attempt(&plan.record);
        if summary.ending == EndingKind::Completed {
            let (lost, paused) = (summary.lost_robots.clone(), summary.paused_robots.clone());
            let ending =
                Ending { kind: summary.ending, reason: summary.reason.clone(), lost, paused };
            match self.folder.finish(item, plan.record, &ending, Some(summary.n_lost))? {
                Finished::Result(manifest) => {
                    self.inform(OperatorEvent::ExperimentFinished {
                        experiment: &item.experiment.folder,
                        manifest: &manifest,
                        settledness: self.folder.settledness(item)?,
                        paused_robots: &summary.paused_robots,
                    });
                    return Ok(Tried::Finished);
                }
                Finished::NotJudged(reason) => attempt.reason = format!("{NOT_JUDGED}{reason}"),
            }
        }
        let kept = self.folder.keep(item, Some(attempt))?;
        Ok(Tried::Without(kept.expect("it was given")))
    }

    fn inform(&self, event: OperatorEvent<'_>) {
        self.operator.inform(&event);
    }
}
