//! How often a robot's sensor detected while it stood, out of the bag of the trial.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use rsrs_experiment_runner::plan::SETTLING_TIME_S;
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::{cdr, topics};

use crate::recorded_run;

/// Readings of one sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Readings {
    /// How many.
    pub samples: u64,
    /// How many of them were detections.
    pub detections: u64,
}

/// Counts the first readings of a robot's sensor while the run was running, without the time in
/// which it settled.
///
/// # Arguments
///
/// * `most` — readings that are wanted; `None` takes all that there are.
///
/// # Errors
///
/// If the bag cannot be read, or has none.
pub fn count(bag: &Path, robot: &str, most: Option<u64>) -> anyhow::Result<Readings> {
    let what = || bag.display().to_string();
    let opened = recorded_run::open(bag)?;
    let detection = topics::DETECTION.for_robot(robot);
    let (mut found, mut from_ns) = (Readings::default(), None);
    // Anybody in the same network may give leases of another run.
    let mut run_id = None;
    let settling = Duration::from_secs_f64(SETTLING_TIME_S);
    let settling_ns = u64::try_from(settling.as_nanos()).unwrap_or(u64::MAX);
    for message in opened.messages_on([topics::LEASE.name.to_owned(), detection.clone()]) {
        let message = message.with_context(what)?;
        if *message.topic != *detection {
            let lease: RunLease = cdr::decode(&message.bytes).with_context(what)?;
            let is_running = lease.state == RunLease::RUNNING;
            match from_ns {
                None if is_running => {
                    from_ns = Some(message.log_time_ns + settling_ns);
                    run_id = Some(lease.run_id);
                }
                Some(_) if !is_running && run_id == Some(lease.run_id) => break,
                _ => {}
            }
            continue;
        }
        if from_ns.is_none_or(|from_ns| message.log_time_ns < from_ns) {
            continue;
        }
        let sample: Bool = cdr::decode(&message.bytes).with_context(what)?;
        found.samples += 1;
        found.detections += u64::from(sample.data);
        if Some(found.samples) == most {
            break;
        }
    }
    if found.samples == 0 {
        bail!("{}: nothing on {detection} while the trial ran, expected readings", what());
    }
    Ok(found)
}
