//! Recorded detections into today's controller: does it still command what it did on the floor?

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context;
use rsrs_bags::{Bag, BagError, BagMessage};
use rsrs_core::draw::{Key, Seed};
use rsrs_core::robot::controller::state_machine::{Memory, Program, transition_key};
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters};
use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::{RosMessage, cdr, topics};
use serde::Serialize;

use crate::error::with_help;
use crate::recorded_run;

/// Recorded commands beside those of today's controller.
#[derive(Clone, Debug, Serialize)]
pub struct ControllerReplay {
    /// The bag.
    pub bag: PathBuf,
    /// What the controller was set to.
    pub controller: Controller,
    /// Robot by robot.
    pub robots: Vec<RobotReplay>,
    /// Commands that were compared.
    pub n_steps: u64,
    /// Commands that differ.
    pub n_different: u64,
    /// Detections that no recorded command answers.
    pub n_unanswered: u64,
    /// Recorded commands that no detection called for.
    pub n_unasked: u64,
}

/// The commands of one robot; counts as in [`ControllerReplay`].
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "the fields are those of the whole replay")]
pub struct RobotReplay {
    pub robot: String,
    pub n_steps: u64,
    pub n_different: u64,
    pub n_unanswered: u64,
    pub n_unasked: u64,
    /// The first command that differs.
    pub first: Option<Difference>,
}

/// A command that differs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// When it was recorded, in seconds of log time.
    pub time_s: f64,
    /// Whether the robot detected something, of several sensors with the first.
    pub detected: bool,
    /// What was recorded.
    pub recorded: Command,
    /// What the controller commands today.
    pub today: Command,
}

/// The messages of one robot, in order of log time.
#[derive(Default)]
struct Recorded {
    detections: Vec<(u64, Readings)>,
    /// Of readings besides `detection`, by name.
    further: BTreeMap<String, Vec<(u64, bool)>>,
    commands: Vec<(u64, Command)>,
}

impl Recorded {
    /// Puts the further readings to the detections that they were published before: in a whole bag as many of each,
    /// and else those that came last.
    fn put_together(&mut self, names: &ReadingNames) {
        let n_detections = self.detections.len();
        for (place, name) in names.iter().enumerate().skip(1) {
            let Some(readings) = self.further.get(name) else { continue };
            for (count, (at_ns, found)) in self.detections.iter_mut().enumerate() {
                let newest = if readings.len() == n_detections {
                    Some(count)
                } else {
                    readings.partition_point(|(read_ns, _)| *read_ns <= *at_ns).checked_sub(1)
                };
                found.set(place, newest.is_some_and(|newest| readings[newest].1));
            }
        }
    }
}

/// Feeds the recorded detections of every robot to the controller.
///
/// # Arguments
///
/// * `parameters` — of the controller; `None` takes those of the bag's record.
///
/// # Errors
///
/// If the bag cannot be read, has no robot with detections and commands, or does not contain what the
/// controller was set to.
pub fn replay_into_controller(
    bag: &Bag,
    parameters: Option<ControllerParameters>,
) -> anyhow::Result<ControllerReplay> {
    let name = bag.path().display().to_string();
    let record = recorded_run::record_in(bag)?;
    let controller = match (parameters, &record) {
        (Some(parameters), _) => parameters.into(),
        (None, Some(record)) => record.conditions.controller.clone(),
        (None, None) => {
            return Err(with_help(
                format!("{name}: does not state what the controller was set to"),
                "state it with `--speed M_PER_S --turn-rate RAD_PER_S`",
            ));
        }
    };
    let (program, digest) = (controller.program(), controller.digest());
    // The draws of a robot's transitions are those of its place in the run.
    let key = |robot: &str| {
        let place = record.as_ref().and_then(|it| it.robots.iter().position(|name| name == robot));
        let run = record.as_ref().map(|it| Seed { seed: it.seed, replicate: it.replicate });
        let first = Seed { seed: 0, replicate: 0 };
        transition_key(run.unwrap_or(first), digest, place.unwrap_or_default())
    };
    // And so is its start among the states.
    let start = |robot: &str| {
        let record = record.as_ref()?;
        let place = record.robots.iter().position(|name| name == robot)?;
        let classes = record.conditions.world.class_names_of(record.robots.len());
        Some(controller.start(classes[place]))
    };
    let (mut recorded, running) = collect(bag).with_context(|| name.clone())?;
    if let Controller::Machine(machine) = &controller {
        for recorded in recorded.values_mut() {
            recorded.put_together(&machine.sensors);
        }
    }
    let robots: Vec<RobotReplay> = recorded
        .into_iter()
        .filter(|(_, recorded)| !recorded.detections.is_empty() && !recorded.commands.is_empty())
        .map(|(robot, recorded)| {
            let (key, start) = (key(&robot), start(&robot).unwrap_or_default());
            compare(robot, &recorded, running, (&program, key, start))
        })
        .collect();
    if robots.is_empty() {
        return Err(with_help(
            format!("{name}: no robot has both detections and commands"),
            "record /<robot>/detection and /<robot>/cmd_vel",
        ));
    }
    let sum = |of: fn(&RobotReplay) -> u64| robots.iter().map(of).sum();
    Ok(ControllerReplay {
        bag: bag.path().to_owned(),
        controller,
        n_steps: sum(|robot| robot.n_steps),
        n_different: sum(|robot| robot.n_different),
        n_unanswered: sum(|robot| robot.n_unanswered),
        n_unasked: sum(|robot| robot.n_unasked),
        robots,
    })
}

impl ControllerReplay {
    /// Whether commands were compared, and all of them are the same.
    pub fn is_same(&self) -> bool {
        self.n_steps > 0 && self.n_different + self.n_unanswered + self.n_unasked == 0
    }
}

/// The time in which the lease was RUNNING, both ends included; all of it without a lease.
type Running = (u64, u64);

fn collect(bag: &Bag) -> anyhow::Result<(BTreeMap<String, Recorded>, Running)> {
    let wanted = bag.topics().into_iter().map(|topic| topic.name).filter(|name| {
        name == topics::LEASE.name
            || robot_of(name, topics::DETECTION.name).is_some()
            || topics::further_reading(name).is_some()
            || robot_of(name, topics::CMD_VEL.name).is_some()
    });
    let wanted: Vec<String> = wanted.collect();
    let has_lease = wanted.iter().any(|name| name == topics::LEASE.name);
    let mut recorded: BTreeMap<String, Recorded> = BTreeMap::new();
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
        } else if let Some(robot) = robot_of(&message.topic, topics::DETECTION.name) {
            let Bool { data } = decode(&message)?;
            recorded.entry(robot.to_owned()).or_default().detections.push((at_ns, data.into()));
        } else if let Some((robot, reading)) = topics::further_reading(&message.topic) {
            let Bool { data } = decode(&message)?;
            let recorded = recorded.entry(robot.to_owned()).or_default();
            recorded.further.entry(reading.to_owned()).or_default().push((at_ns, data));
        } else if let Some(robot) = robot_of(&message.topic, topics::CMD_VEL.name) {
            let twist = if message.type_name.as_ref() == TwistStamped::TYPE_NAME {
                decode::<TwistStamped>(&message)?.twist
            } else {
                decode::<Twist>(&message)?
            };
            let command = Command { speed_m_s: twist.linear.x, turn_rate_rad_s: twist.angular.z };
            recorded.entry(robot.to_owned()).or_default().commands.push((at_ns, command));
        }
    }
    // A lease that was never RUNNING leaves nothing to compare.
    Ok((recorded, (start_ns.unwrap_or(u64::MAX), end_ns.unwrap_or(u64::MAX))))
}

/// The robot whose topic this is: `robot_3` for `/robot_3/detection`.
fn robot_of<'a>(topic: &'a str, relative: &str) -> Option<&'a str> {
    let robot = topic.strip_prefix('/')?.strip_suffix(relative)?.strip_suffix('/')?;
    let is_robot = !robot.is_empty() && !robot.contains("/hardware");
    (is_robot && topics::further_reading(topic).is_none()).then_some(robot)
}

fn decode<M: RosMessage>(message: &BagMessage) -> anyhow::Result<M> {
    let time_s = message.log_time_ns as f64 / 1e9;
    cdr::decode(&message.bytes)
        .with_context(|| format!("a message on {} at {time_s:.3} s does not decode", message.topic))
}

/// Answers every detection of the running time as the controller does today.
///
/// A command answers the latest detection that came before it, or up to a quarter of a period after
/// it: a recorder may receive two topics the other way round.
fn compare(
    robot: String,
    recorded: &Recorded,
    running: Running,
    (program, key, start): (&Program, Key, Memory),
) -> RobotReplay {
    let is_running = |at_ns: u64| (running.0..=running.1).contains(&at_ns);
    let slack_ns = period_ns(&recorded.detections) / 4;
    let mut report = RobotReplay {
        robot,
        n_steps: 0,
        n_different: 0,
        n_unanswered: 0,
        n_unasked: 0,
        first: None,
    };
    let mut is_answered = vec![false; recorded.detections.len()];
    let mut memory = start;
    // Detections before the run are of none.
    let mut n_decided = recorded.detections.partition_point(|(at_ns, _)| *at_ns < running.0);
    for &(at_ns, command) in recorded.commands.iter().filter(|(at_ns, _)| is_running(*at_ns)) {
        let n_before = recorded
            .detections
            .partition_point(|(seen_ns, _)| *seen_ns <= at_ns.saturating_add(slack_ns));
        let answered = n_before.checked_sub(1).filter(|index| !is_answered[*index]);
        let Some(answered) = answered else {
            report.n_unasked += 1;
            continue;
        };
        is_answered[answered] = true;
        report.n_steps += 1;
        let detected = recorded.detections[answered].1.detection();
        // What has states goes through all detections in their order.
        let mut today = Command::STOP;
        for (_, found) in &recorded.detections[n_decided.min(answered)..=answered] {
            today = program.decide(*found, &mut memory, key);
        }
        n_decided = answered + 1;
        if today != command {
            report.n_different += 1;
            let time_s = at_ns as f64 / 1e9;
            report.first.get_or_insert(Difference { time_s, detected, recorded: command, today });
        }
    }
    // The answer to the last detection may have come after the end.
    let last = recorded.detections.iter().rposition(|(at_ns, _)| is_running(*at_ns)).unwrap_or(0);
    let unanswered = recorded.detections[..last].iter().zip(&is_answered);
    report.n_unanswered = unanswered
        .filter(|((at_ns, _), is_answered)| is_running(*at_ns) && !**is_answered)
        .count() as u64;
    report
}

/// The median distance of detections, in nanoseconds; 0 for less than two.
fn period_ns(detections: &[(u64, Readings)]) -> u64 {
    let mut distances: Vec<u64> =
        detections.windows(2).map(|pair| pair[1].0.saturating_sub(pair[0].0)).collect();
    distances.sort_unstable();
    distances.get(distances.len() / 2).copied().unwrap_or(0)
}
