//! What a bag has of each robot for its controller: readings, commands, and whether it was to move.

use std::collections::BTreeMap;

use anyhow::Context;
use rsrs_bags::{Bag, BagError, BagMessage};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_fleet::controller::MOST_BEHIND;
use rsrs_fleet::timing::HEARTBEAT_PERIOD;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::{RosMessage, cdr, topics};

/// The messages of one robot, in order of log time.
#[derive(Default)]
pub(super) struct RecordedRobot {
    /// What its sensors reported.
    pub(super) detections: Vec<Detection>,
    /// What it was commanded, by log time in nanoseconds.
    pub(super) commands: Vec<(u64, Command)>,
    /// Of readings besides `detection`, by name.
    further: BTreeMap<String, Vec<(u64, bool)>>,
    /// Whether its gate let it move ...
    gate: Vec<(u64, bool)>,
    /// ... and whether its controller took it to.
    controller: Vec<(u64, bool)>,
}

/// A detection with the further readings of its time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detection {
    /// Log time, in nanoseconds.
    pub(super) at_ns: u64,
    /// What all sensors reported.
    pub(super) found: Readings,
    /// What the controller may have received instead: a further reading came at about the same time.
    pub(super) otherwise: [Readings; 2],
    /// Whether each further reading was there; a robot of which one is silent is not commanded.
    pub(super) is_whole: bool,
}

/// The time in which the lease was RUNNING, both ends included; all of it without a lease.
pub(super) type Running = (u64, u64);

impl RecordedRobot {
    /// By how much a recorder may receive two messages the other way round: a quarter of a period, in
    /// nanoseconds.
    pub(super) fn slack_ns(&self) -> u64 {
        let mut distances: Vec<u64> = self
            .detections
            .windows(2)
            .map(|pair| pair[1].at_ns.saturating_sub(pair[0].at_ns))
            .collect();
        distances.sort_unstable();
        distances.get(distances.len() / 2).copied().unwrap_or(0) / 4
    }

    /// The reading that the controller needs and the bag does not have.
    pub(super) fn missing<'a>(&self, names: &'a ReadingNames) -> Option<&'a str> {
        names.further().find(|name| !self.further.contains_key(*name))
    }

    /// Puts the further readings to the detections that they were published before: in a whole bag as many of each,
    /// and else those that came last.
    pub(super) fn put_together(&mut self, names: &ReadingNames) {
        let (n_detections, slack_ns) = (self.detections.len(), self.slack_ns());
        for (place, name) in names.iter().enumerate().skip(1) {
            let Some(readings) = self.further.get(name) else { continue };
            let until = |at_ns: u64| readings.partition_point(|(read_ns, _)| *read_ns <= at_ns);
            let mut times = Vec::with_capacity(n_detections);
            for (count, detection) in self.detections.iter_mut().enumerate() {
                let (early, late) = (
                    until(detection.at_ns.saturating_sub(slack_ns)).checked_sub(1),
                    until(detection.at_ns.saturating_add(slack_ns)).checked_sub(1),
                );
                times.push(detection.at_ns);
                let is_true = |newest: Option<usize>| newest.is_some_and(|it| readings[it].1);
                if readings.len() == n_detections {
                    detection.found.set(place, readings[count].1);
                    for otherwise in &mut detection.otherwise {
                        otherwise.set(place, readings[count].1);
                    }
                    continue;
                }
                detection.found.set(place, is_true(until(detection.at_ns).checked_sub(1)));
                for (otherwise, newest) in detection.otherwise.iter_mut().zip([early, late]) {
                    otherwise.set(place, is_true(newest));
                }
                // It may have come before a detection that is recorded before it.
                let n_behind = early.map(|newest| {
                    let before_ns = readings[newest].0.saturating_sub(slack_ns);
                    times.len() - times.partition_point(|at_ns| *at_ns < before_ns)
                });
                let is_there = n_behind.is_some_and(|it| it <= MOST_BEHIND as usize);
                detection.is_whole &= is_there;
            }
        }
    }

    /// Whether a zero of this time is explained by the status of the gate: it did not let the robot move, or was
    /// about to report that.
    pub(super) fn is_held(&self, at_ns: u64) -> bool {
        let slack_ns = 2 * u64::from(HEARTBEAT_PERIOD.subsec_nanos());
        let after = |at_ns: u64| self.gate.partition_point(|(known_ns, _)| *known_ns <= at_ns);
        let (first, last) = (after(at_ns.saturating_sub(slack_ns)), after(at_ns + slack_ns));
        self.gate[first.saturating_sub(1)..last].iter().any(|(_, may_move)| !may_move)
    }

    /// Whether the controller took the robot to move, as it does where nothing is known of it.
    pub(super) fn moves(&self, at_ns: u64) -> bool {
        let n_before = self.controller.partition_point(|(known_ns, _)| *known_ns <= at_ns);
        n_before.checked_sub(1).is_none_or(|newest| self.controller[newest].1)
    }
}

/// Reads what a bag has of each robot, and when they ran.
pub(super) fn collect(bag: &Bag) -> anyhow::Result<(BTreeMap<String, RecordedRobot>, Running)> {
    let wanted = bag.topics().into_iter().map(|topic| topic.name).filter(|name| {
        name == topics::LEASE.name
            || topics::further_reading(name).is_some()
            || [topics::DETECTION, topics::CMD_VEL, topics::STATUS, topics::CONTROLLER_STATUS]
                .iter()
                .any(|topic| topic.robot_of(name).is_some())
    });
    let wanted: Vec<String> = wanted.collect();
    let has_lease = wanted.iter().any(|name| name == topics::LEASE.name);
    let mut recorded: BTreeMap<String, RecordedRobot> = BTreeMap::new();
    let (mut start_ns, mut end_ns) = if has_lease { (None, None) } else { (Some(0), None) };
    for message in bag.messages_on(wanted) {
        let message = match message {
            Ok(message) => message,
            // What came before the break is compared.
            Err(BagError::Incomplete { .. }) => continue,
            Err(error) => return Err(error.into()),
        };
        let at_ns = message.log_time_ns;
        if message.type_name.as_ref() == RunLease::TYPE_NAME {
            let lease: RunLease = decode(&message)?;
            match (lease.state == LeaseState::Running, start_ns) {
                (true, None) => start_ns = Some(at_ns),
                (false, Some(_)) => end_ns = end_ns.or(Some(at_ns)),
                (true, Some(_)) | (false, None) => {}
            }
        } else if let Some(robot) = topics::DETECTION.robot_of(&message.topic) {
            let Bool { data } = decode(&message)?;
            let (found, otherwise) = (data.into(), [data.into(); 2]);
            of(&mut recorded, robot).detections.push(Detection {
                at_ns,
                found,
                otherwise,
                is_whole: true,
            });
        } else if let Some((robot, reading)) = topics::further_reading(&message.topic) {
            let Bool { data } = decode(&message)?;
            of(&mut recorded, robot)
                .further
                .entry(reading.to_owned())
                .or_default()
                .push((at_ns, data));
        } else if let Some(robot) = topics::CMD_VEL.robot_of(&message.topic) {
            let twist = if message.type_name.as_ref() == TwistStamped::TYPE_NAME {
                decode::<TwistStamped>(&message)?.twist
            } else {
                decode::<Twist>(&message)?
            };
            let command = Command { speed_m_s: twist.linear.x, turn_rate_rad_s: twist.angular.z };
            of(&mut recorded, robot).commands.push((at_ns, command));
        } else if let Some(robot) = topics::CONTROLLER_STATUS.robot_of(&message.topic) {
            let status: RobotStatus = decode(&message)?;
            of(&mut recorded, robot).controller.push((at_ns, status.state == RobotState::Moving));
        } else if let Some(robot) = topics::STATUS.robot_of(&message.topic) {
            let status: RobotStatus = decode(&message)?;
            of(&mut recorded, robot).gate.push((at_ns, status.state == RobotState::Moving));
        }
    }
    // A lease that was never RUNNING leaves nothing to compare.
    Ok((recorded, (start_ns.unwrap_or(u64::MAX), end_ns.unwrap_or(u64::MAX))))
}

fn of<'a>(recorded: &'a mut BTreeMap<String, RecordedRobot>, robot: &str) -> &'a mut RecordedRobot {
    recorded.entry(robot.to_owned()).or_default()
}

fn decode<M: RosMessage>(message: &BagMessage) -> anyhow::Result<M> {
    let time_s = message.log_time_ns as f64 / 1e9;
    cdr::decode(&message.bytes)
        .with_context(|| format!("a message on {} at {time_s:.3} s does not decode", message.topic))
}
