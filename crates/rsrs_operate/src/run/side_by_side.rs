//! Simulated experiments, several at a time, each fleet in a network of its own.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::pin::Pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};

use anyhow::Context;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::record::EndingKind;
use rsrs_pipeline::attempt::{Attempt, SIMULATED_TRIES, keep_aside, number_aside};
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_render::operator_event::OperatorEvent;
use tokio::sync::watch;

use super::on_simulated_fleet;
use super::operator::{Operator, Verbosity};
use super::own_network::OwnNetwork;
use super::simulated_fleet::SimulatedFleet;
use rsrs_ros::runtime::runtime;

/// Experiments to run.
#[derive(Clone, Copy)]
pub struct Experiments<'a> {
    /// In the order in which they count; each with the path of its bag.
    pub requests: &'a [Request],
    /// How many are run at a time, at most.
    pub n_at_once: usize,
    /// The network of the first fleet.
    pub network: &'a OwnNetwork,
    /// Whoever watches.
    pub operator: &'a (dyn Operator + Sync),
    /// Is informed of a run that gave no result and is made again: the index of its request, and what it
    /// came to.
    pub made_again: &'a (dyn Fn(usize, &Attempt) + Sync),
}

/// An experiment that was completed.
#[derive(Clone, Debug)]
pub struct Completed {
    /// The run.
    pub summary: RunSummary,
    /// Runs that gave no result before it, and where their recordings are.
    pub before: Vec<RunSummary>,
}

/// Runs experiments until enough of them are completed.
///
/// Which ones are run depends on nothing but their results: those that were begun beyond the last
/// that counts are stopped, and nothing of them is left. `take` gets them in the order of the
/// requests, and decides whether to go on. An experiment that is not completed, as often as it may
/// be tried, ends all.
pub fn run(
    experiments: Experiments<'_>,
    mut take: impl FnMut(usize, Completed) -> anyhow::Result<ControlFlow<()>>,
) -> anyhow::Result<()> {
    let next = AtomicUsize::new(0);
    let (enough, is_enough) = watch::channel(false);
    let (sender, results) = channel();
    let n_workers = experiments.n_at_once.clamp(1, experiments.requests.len().max(1));
    let n_workers = if experiments.network.is_confined() { n_workers } else { 1 };
    let mut n_taken = 0;
    let taken = std::thread::scope(|scope| {
        for worker in 0..n_workers {
            let worker = Worker {
                experiments,
                is_first: worker == 0,
                next: &next,
                is_enough: is_enough.clone(),
                results: sender.clone(),
            };
            scope.spawn(move || worker.work());
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut in_order = || {
            for (index, result) in &results {
                waiting.insert(index, result);
                while let Some(result) = waiting.remove(&n_taken) {
                    let flow = take(n_taken, result?)?;
                    n_taken += 1;
                    if flow.is_break() {
                        return Ok(());
                    }
                }
            }
            anyhow::ensure!(n_taken == experiments.requests.len(), "an experiment was lost");
            Ok(())
        };
        let taken = in_order();
        enough.send_replace(true);
        taken
    });
    // Where it failed, what there is stays, to be looked at.
    if taken.is_ok() {
        for request in &experiments.requests[n_taken..] {
            request.bag.as_deref().map_or(Ok(()), remove_all_of)?;
        }
    }
    taken
}

/// Runs one experiment after the other in a network of its own.
struct Worker<'a> {
    experiments: Experiments<'a>,
    is_first: bool,
    next: &'a AtomicUsize,
    is_enough: watch::Receiver<bool>,
    results: Sender<(usize, anyhow::Result<Completed>)>,
}

impl Worker<'_> {
    fn work(self) {
        let take = || {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            (index < self.experiments.requests.len() && !*self.is_enough.borrow()).then_some(index)
        };
        let Some(mut index) = take() else { return };
        let network = match self.network() {
            Ok(network) => network,
            Err(error) => return self.report(index, Err(error)),
        };
        let runtime = match runtime() {
            Ok(runtime) => runtime,
            Err(error) => return self.report(index, Err(error)),
        };
        runtime.block_on(async {
            let mut fleet = None;
            loop {
                let result = self.until_completed(index, &network, &mut fleet).await;
                let has_failed = result.is_err();
                self.report(index, result);
                let Some(following) = take().filter(|_| !has_failed) else { break };
                index = following;
            }
            if let Some(mut fleet) = fleet
                && let Err(error) = fleet.stop().await
            {
                log::warn!("nodes of a simulated fleet: {error:#}");
            }
        });
    }

    fn network(&self) -> anyhow::Result<OwnNetwork> {
        if self.is_first {
            return Ok(self.experiments.network.clone());
        }
        self.experiments.network.another()
    }

    fn report(&self, index: usize, result: anyhow::Result<Completed>) {
        // Nobody listens any more where enough are completed.
        self.results.send((index, result)).ok();
    }

    /// Runs an experiment, again where it gave no result for a cause that was known before.
    async fn until_completed(
        &self,
        index: usize,
        network: &OwnNetwork,
        fleet: &mut Option<SimulatedFleet>,
    ) -> anyhow::Result<Completed> {
        let operator =
            UntilEnough { operator: self.experiments.operator, is_enough: &self.is_enough };
        let mut before = Vec::new();
        loop {
            let plan = Plan::read(&self.experiments.requests[index])?;
            let fleet = match fleet {
                Some(fleet) => fleet,
                None => fleet.insert(SimulatedFleet::start(network, &plan)?),
            };
            let mut summary = on_simulated_fleet(&plan, network, fleet, &operator).await?;
            if summary.ending == EndingKind::Completed {
                return Ok(Completed { summary, before });
            }
            let attempt = summary.attempt(&plan.record);
            let n_tries = u32::try_from(before.len() + 1).unwrap_or(u32::MAX);
            if !attempt.is_made_again(&plan.record, n_tries, SIMULATED_TRIES) {
                anyhow::bail!("experiment {}: {attempt}", index + 1);
            }
            (self.experiments.made_again)(index, &attempt);
            summary.bag = keep_aside(&plan.bag)?;
            before.push(summary);
        }
    }
}

/// An operator whose runs are also stopped when enough of them are completed.
struct UntilEnough<'a> {
    operator: &'a (dyn Operator + Sync),
    is_enough: &'a watch::Receiver<bool>,
}

impl Operator for UntilEnough<'_> {
    fn inform(&self, event: &OperatorEvent<'_>) {
        self.operator.inform(event);
    }

    fn watch_run(
        &self,
        name: &str,
        verbosity: Verbosity,
    ) -> Box<dyn FnMut(rsrs_experiment_runner::Progress) + '_> {
        self.operator.watch_run(name, verbosity)
    }

    fn stop_requested(&self) -> Pin<Box<dyn Future<Output = String> + '_>> {
        let mut is_enough = self.is_enough.clone();
        Box::pin(async move {
            tokio::select! {
                reason = self.operator.stop_requested() => reason,
                _ = is_enough.wait_for(|enough| *enough) => "enough are completed".to_owned(),
            }
        })
    }
}

/// Removes a bag, and what was kept aside of the same experiment.
fn remove_all_of(bag: &Path) -> anyhow::Result<()> {
    let (Some(folder), Some(name)) = (bag.parent(), bag.file_name()) else { return Ok(()) };
    let Ok(entries) = folder.read_dir() else { return Ok(()) };
    let name = name.to_string_lossy();
    for entry in entries {
        let entry = entry.with_context(|| format!("cannot list {}", folder.display()))?;
        let found = entry.file_name().to_string_lossy().into_owned();
        if found == name || number_aside(&name, &found).is_some() {
            let path = entry.path();
            std::fs::remove_dir_all(&path)
                .with_context(|| format!("cannot remove {}", path.display()))?;
        }
    }
    Ok(())
}
