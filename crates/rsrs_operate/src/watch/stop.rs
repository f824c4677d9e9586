//! The stop of all robots beside whatever else goes on, as `rsrs stop` gives it.

use std::thread::JoinHandle;

use anyhow::Context;
use rsrs_experiment_runner::stop::{StopReport, command_all};
use rsrs_fleet::stopper::StopCommand;
use rsrs_ros::session::SessionOptions;

use crate::runtime::runtime;

/// A stop that is under way, on a thread of its own: no drawing delays it.
pub struct StopUnderWay {
    thread: JoinHandle<anyhow::Result<StopReport>>,
}

impl StopUnderWay {
    /// Starts to stop all robots.
    ///
    /// # Arguments
    ///
    /// * `network` — with the enclave of who may stop, where the fleet is secured.
    /// * `robots` — those that should be there; others are found by their statuses.
    ///
    /// # Errors
    ///
    /// If the thread cannot be started.
    pub fn start(network: SessionOptions, robots: Vec<String>) -> anyhow::Result<Self> {
        let thread = std::thread::Builder::new().name("stop".to_owned()).spawn(move || {
            let never = std::future::pending();
            runtime()?.block_on(command_all(StopCommand::Engage, &robots, &network, never))
        });
        Ok(Self { thread: thread.context("starting the stop")? })
    }

    /// Whether every robot has acknowledged, or the time is up.
    pub fn is_over(&self) -> bool {
        self.thread.is_finished()
    }

    /// Waits for what came of it.
    ///
    /// # Errors
    ///
    /// If the network cannot be used.
    ///
    /// # Panics
    ///
    /// If the stop has panicked, with its panic.
    pub fn wait(self) -> anyhow::Result<StopReport> {
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}
