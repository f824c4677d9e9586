//! How evenly commands came in a trial, and detections: a robot that gets none for a while stops.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use rsrs_experiment_runner::plan::SETTLING_TIME_S;
use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::{cdr, topics};

use crate::recorded_run;

/// The rhythm of a trial.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommandRhythm {
    /// The longest pause between two commands, or between two of the detections that they answer, as
    /// they were sent or as they were received, in seconds; `None` if none was so long that a robot
    /// stops.
    pub paused_s: Option<f64>,
    /// Times from one detection to the next, by their sender, in seconds.
    pub periods_s: Vec<f64>,
}

/// When samples of one topic were sent and received, in nanoseconds.
#[derive(Default)]
struct Times {
    sent_ns: Vec<u64>,
    received_ns: Vec<u64>,
}

/// Reads the rhythm of a trial out of its bag, without the time in which the robot got going.
///
/// # Errors
///
/// If the bag cannot be read.
pub fn read(bag: &Path, robot: &str) -> anyhow::Result<CommandRhythm> {
    let what = || bag.display().to_string();
    let opened = recorded_run::open(bag)?;
    let command = topics::CMD_VEL.for_robot(robot);
    let detection = topics::DETECTION.for_robot(robot);
    let (mut commands, mut detections) = (Times::default(), Times::default());
    let (mut run_id, mut window_ns) = (None, None);
    let going = Duration::from_secs_f64(SETTLING_TIME_S).as_nanos();
    let going_ns = u64::try_from(going).unwrap_or(u64::MAX);
    let names = [topics::LEASE.name.to_owned(), command.clone(), detection];
    for message in opened.messages_on(names) {
        let message = message.with_context(what)?;
        if *message.topic == *topics::LEASE.name {
            let lease: RunLease = cdr::decode(&message.bytes).with_context(what)?;
            let is_running = lease.state == RunLease::RUNNING;
            if run_id.is_none() && is_running {
                window_ns = Some(message.log_time_ns + going_ns);
                run_id = Some(lease.run_id);
            } else if run_id.as_ref() == Some(&lease.run_id) && !is_running {
                commands.received_ns.push(message.log_time_ns);
                break;
            }
            continue;
        }
        if window_ns.is_none_or(|from_ns| message.log_time_ns < from_ns) {
            continue;
        }
        let times = if *message.topic == *command { &mut commands } else { &mut detections };
        times.sent_ns.push(message.publish_time_ns);
        times.received_ns.push(message.log_time_ns);
    }
    commands.received_ns.extend(window_ns);
    // Without detections a controller publishes zero, again and again.
    let pauses_s = [pause_s(&mut commands), pause_s(&mut detections)];
    let paused_s = pauses_s.into_iter().flatten().reduce(f64::max);
    Ok(CommandRhythm { paused_s, periods_s: intervals_s(&mut detections.sent_ns) })
}

/// The longest interval, if it is one in which a robot stops: its gate does, and so do most bases.
fn pause_s(commands: &mut Times) -> Option<f64> {
    let sent_s = intervals_s(&mut commands.sent_ns);
    let received_s = intervals_s(&mut commands.received_ns);
    let mut usual_s = sent_s.clone();
    usual_s.sort_by(f64::total_cmp);
    let usual_s = usual_s.get(usual_s.len() / 2).copied().unwrap_or(0.0);
    let longest_s = sent_s.into_iter().chain(received_s).fold(0.0, f64::max);
    (longest_s >= command_timeout(usual_s, Transport::Plain).as_secs_f64()).then_some(longest_s)
}

/// Times from one moment to the next, in seconds.
fn intervals_s(moments_ns: &mut [u64]) -> Vec<f64> {
    moments_ns.sort_unstable();
    let intervals_s = moments_ns.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / 1e9);
    intervals_s.filter(|interval_s| *interval_s > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paused_s(sent_ms: &[u64], late_ms: &[u64]) -> Option<f64> {
        let ns = |ms: &u64| ms * 1_000_000;
        let sent_ns: Vec<u64> = sent_ms.iter().map(ns).collect();
        let late = late_ms.iter().map(ns).chain(std::iter::repeat(0));
        let received_ns = sent_ns.iter().zip(late).map(|(sent_ns, late_ns)| sent_ns + late_ns);
        let received_ns = received_ns.collect();
        pause_s(&mut Times { sent_ns, received_ns })
    }

    #[test]
    fn commands_that_pause_where_they_are_sent_or_on_their_way_are_found() {
        assert_eq!(paused_s(&[0, 130, 260, 390, 520], &[]), None);
        assert_eq!(paused_s(&[0, 130, 260, 450, 580], &[]), None, "no robot stops for that");
        assert_eq!(paused_s(&[0, 130, 260, 705, 835], &[]), Some(0.445));
        assert_eq!(paused_s(&[0, 130, 260, 390, 520], &[0, 0, 315, 185, 55]), Some(0.445));
        assert_eq!(paused_s(&[0, 500, 1000, 1500, 2000], &[]), None, "slow robots do not pause");
    }
}
