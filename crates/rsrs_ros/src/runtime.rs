//! The runtime of everything that waits for messages.

use std::time::Duration;

use anyhow::Context;
use tokio::time::{Interval, MissedTickBehavior};

/// A runtime on this thread, by whose end the nodes notice that of this process.
pub fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("starting the runtime")
}

/// What ticks now and every so often, and makes up for no tick that was missed.
pub fn beat(period: Duration) -> Interval {
    let mut beat = tokio::time::interval(period);
    beat.set_missed_tick_behavior(MissedTickBehavior::Skip);
    beat
}
