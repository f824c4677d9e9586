//! How evenly commands came in a trial, and detections: a robot that gets none for a while stops.

use std::path::Path;

use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_msgs::topics;

use super::trial_window::{self, TrialWindow, intervals_s};

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
pub fn read(bag: &Path, robot: &str) -> anyhow::Result<CommandRhythm> {
    let command = topics::CMD_VEL.for_robot(robot);
    let detection = topics::DETECTION.for_robot(robot);
    let window = trial_window::read(bag, [command.clone(), detection])?;
    Ok(CommandRhythm::new(&window, &command))
}

impl CommandRhythm {
    fn new(window: &TrialWindow, command: &str) -> Self {
        let (mut commands, mut detections) = (Times::default(), Times::default());
        for message in &window.messages {
            let times = if *message.topic == *command { &mut commands } else { &mut detections };
            times.sent_ns.push(message.publish_time_ns);
            times.received_ns.push(message.log_time_ns);
        }
        // Without detections a controller publishes zero, again and again: both have to come from
        // the beginning to the end.
        let pauses_s = [&mut commands, &mut detections].map(|times| {
            times.received_ns.extend(window.bounds_ns());
            pause_s(times)
        });
        let paused_s = pauses_s.into_iter().flatten().reduce(f64::max);
        Self { paused_s, periods_s: intervals_s(&mut detections.sent_ns) }
    }
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

#[cfg(test)]
mod tests {
    use rsrs_bags::BagMessage;

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

    #[test]
    fn detections_that_begin_late_or_end_early_are_a_pause() {
        let ms = |ms: u64| ms * 1_000_000;
        let rhythm = |detections_ms: std::ops::Range<u64>| {
            let on = |topic: &str, at_ms: u64| BagMessage {
                topic: topic.into(),
                type_name: "".into(),
                log_time_ns: ms(at_ms),
                publish_time_ns: ms(at_ms),
                sequence: 0,
                bytes: Vec::new(),
            };
            let commands = (0..30).map(|number| on("cmd_vel", 100 * number));
            let detections = detections_ms.step_by(100).map(|at_ms| on("detection", at_ms));
            let messages = commands.chain(detections).collect();
            let window = TrialWindow { from_ns: Some(0), until_ns: Some(ms(3_000)), messages };
            CommandRhythm::new(&window, "cmd_vel").paused_s
        };

        assert_eq!(rhythm(0..3_000), None);
        assert_eq!(rhythm(0..2_500), Some(0.6), "zeros were commanded at the end");
        assert_eq!(rhythm(500..3_000), Some(0.5), "and here at the beginning");
        assert_eq!(rhythm(0..0), Some(3.0), "and here all the time");
    }
}
