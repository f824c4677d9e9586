//! What was recorded of a trial while its run was running and its robot had settled.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use rsrs_bags::BagMessage;
use rsrs_core::trials::trial::SETTLING_TIME_S;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::{cdr, topics};

use crate::recorded_run;

/// The window of a trial.
#[derive(Debug, Default)]
pub struct TrialWindow {
    /// When it begins, by the recorder's clock, in nanoseconds; `None` if nothing ran.
    pub from_ns: Option<u64>,
    /// When it ends; `None` if the bag ends first.
    pub until_ns: Option<u64>,
    /// The messages in it, in the order in which they were received.
    pub messages: Vec<BagMessage>,
}

impl TrialWindow {
    /// Begin and end, as far as they are there.
    pub fn bounds_ns(&self) -> impl Iterator<Item = u64> {
        self.from_ns.into_iter().chain(self.until_ns)
    }
}

/// Reads topics with these full names in the window of a trial: from when its robot has settled
/// after the first lease of a run that is running, until a lease of the same run that is not.
pub fn read(bag: &Path, topics: impl IntoIterator<Item = String>) -> anyhow::Result<TrialWindow> {
    let what = || bag.display().to_string();
    let opened = recorded_run::open(bag)?;
    let settling = Duration::from_secs_f64(SETTLING_TIME_S);
    let settling_ns = u64::try_from(settling.as_nanos()).unwrap_or(u64::MAX);
    let mut window = TrialWindow::default();
    // Anybody in the same network may give leases of another run.
    let mut run_id = None;
    for message in opened.messages_on(topics.into_iter().chain([topics::LEASE.name.to_owned()])) {
        let message = message.with_context(what)?;
        if *message.topic == *topics::LEASE.name {
            let lease: RunLease = cdr::decode(&message.bytes).with_context(what)?;
            let is_running = lease.state == LeaseState::Running;
            if run_id.is_none() && is_running {
                window.from_ns = Some(message.log_time_ns.saturating_add(settling_ns));
                run_id = Some(lease.run_id);
            } else if run_id.as_ref() == Some(&lease.run_id) && !is_running {
                window.until_ns = Some(message.log_time_ns);
                break;
            }
        } else if window.from_ns.is_some_and(|from_ns| message.log_time_ns >= from_ns) {
            window.messages.push(message);
        }
    }
    Ok(window)
}

/// Times from one moment to the next, in seconds; moments that are the same are one.
pub fn intervals_s(moments_ns: &mut [u64]) -> Vec<f64> {
    moments_ns.sort_unstable();
    let intervals_s = moments_ns.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / 1e9);
    intervals_s.filter(|interval_s| *interval_s > 0.0).collect()
}
