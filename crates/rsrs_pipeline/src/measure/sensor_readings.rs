//! How often a robot's sensor detected while it stood, out of the bag of the trial.

use std::path::Path;

use anyhow::{Context, bail};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::{cdr, topics};

use super::trial_window;

/// Readings of one sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Readings {
    /// How many.
    pub samples: u64,
    /// How many of them were detections.
    pub detections: u64,
}

/// Counts the first readings of a robot's sensor while the run was running, without the time in
/// which it settled: `most` of them, or all that there are. A bag that has none is an error.
pub fn count(bag: &Path, robot: &str, most: Option<u64>) -> anyhow::Result<Readings> {
    let detection = topics::DETECTION.for_robot(robot);
    let window = trial_window::read(bag, [detection.clone()])?;
    let most = most.map_or(usize::MAX, |most| usize::try_from(most).unwrap_or(usize::MAX));
    let mut found = Readings::default();
    for message in window.messages.iter().take(most) {
        let sample: Bool =
            cdr::decode(&message.bytes).with_context(|| bag.display().to_string())?;
        found.samples += 1;
        found.detections += u64::from(sample.data);
    }
    if found.samples == 0 {
        let bag = bag.display();
        bail!("{bag}: nothing on {detection} while the trial ran, expected readings");
    }
    Ok(found)
}
