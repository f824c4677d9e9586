//! The stop of all robots beside whatever else goes on, as `rsrs stop` gives it.

use std::thread::JoinHandle;

use anyhow::Context;
use rsrs_experiment_runner::stop::{command_all, join};
use rsrs_fleet::stopper::StopCommand;
use rsrs_render::stop::StopSummary;
use rsrs_ros::session::{Session, SessionOptions};
use tokio::sync::oneshot;

use crate::stop::summary;
use rsrs_ros::runtime::runtime;

/// What comes of a thread that can stop all robots; nothing if nobody ordered it.
type Stopping = JoinHandle<anyhow::Result<Option<StopSummary>>>;

/// Who can stop all robots, on a thread of its own: no drawing delays it.
///
/// In a secured fleet it has joined before it is needed. A robot that has authenticated it obeys it at once,
/// also while a stranger keeps newcomers from being authenticated.
pub struct StandingStop {
    /// The robots that should be there.
    order: oneshot::Sender<Vec<String>>,
    thread: Stopping,
}

impl StandingStop {
    /// Gets ready; where the fleet is secured, the network has the enclave of who may stop.
    pub fn start(network: SessionOptions) -> anyhow::Result<Self> {
        let (order, ordered) = oneshot::channel();
        let thread = std::thread::Builder::new().name("stop".to_owned());
        let thread = thread.spawn(move || runtime()?.block_on(stop(&network, ordered)));
        Ok(Self { order, thread: thread.context("starting the stop")? })
    }

    /// Stops all robots: those that should be there, and others that are found by their statuses.
    pub fn order(self, robots: Vec<String>) -> StopUnderWay {
        // Should the thread have ended, its end tells why.
        self.order.send(robots).ok();
        StopUnderWay { thread: self.thread }
    }

    /// Leaves the network; nobody is stopped.
    pub fn leave(self) -> anyhow::Result<()> {
        drop(self.order);
        joined(self.thread).map(drop)
    }
}

/// A stop that is under way.
pub struct StopUnderWay {
    thread: Stopping,
}

impl StopUnderWay {
    /// Whether every robot has acknowledged, or the time is up.
    pub fn is_over(&self) -> bool {
        self.thread.is_finished()
    }

    /// Waits for what came of it.
    ///
    /// # Panics
    ///
    /// If the stop has panicked, with its panic.
    pub fn wait(self) -> anyhow::Result<StopSummary> {
        Ok(joined(self.thread)?.expect("it was ordered"))
    }
}

fn joined(thread: Stopping) -> anyhow::Result<Option<StopSummary>> {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Waits for the order, as a member of a secured network, and follows it.
async fn stop(
    network: &SessionOptions,
    mut ordered: oneshot::Receiver<Vec<String>>,
) -> anyhow::Result<Option<StopSummary>> {
    let mut session = None;
    let order = loop {
        if session.is_none() && network.enclave.is_some() {
            // A network that cannot be used now may be there when it has to be.
            session = join(network).ok();
        }
        tokio::select! {
            order = &mut ordered => break order,
            () = has_ended(session.as_ref()) => close(session.take()).await,
        }
    };
    let Ok(robots) = order else {
        close(session).await;
        return Ok(None);
    };
    let session = session.map_or_else(|| join(network), Ok)?;
    let never = std::future::pending();
    let report = command_all(session, StopCommand::Engage, &robots, never).await?;
    Ok(Some(summary(StopCommand::Engage, &report)))
}

async fn has_ended(session: Option<&Session>) {
    match session {
        Some(session) => drop(session.ended().await),
        None => std::future::pending().await,
    }
}

async fn close(session: Option<Session>) {
    if let Some(session) = session {
        session.close().await;
    }
}
