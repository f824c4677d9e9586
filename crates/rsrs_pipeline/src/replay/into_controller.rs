//! Recorded detections into today's controller: does it still command what it did on the floor?

mod recorded_robot;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_core::draw::{Key, Seed};
use rsrs_core::robot::controller::state_machine::{Memory, Program, transition_key};
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters};
use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::ExperimentRecord;
use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_msgs::topics;
use serde::Serialize;

use self::recorded_robot::{RecordedRobot, Running, collect};
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
    /// Zeros that were not compared: a controller that holds the lease has to send them where its robot may not
    /// move, its last command is too old, or a sensor is silent.
    pub n_held: u64,
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
    pub n_held: u64,
    /// The first command that differs.
    pub first: Option<Difference>,
}

/// A command that differs.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// When it was recorded, in seconds of log time.
    pub time_s: f64,
    /// Whether the robot detected something, of several sensors with the first.
    pub detected: bool,
    /// Which readings were true.
    pub reported: Vec<String>,
    /// What was recorded.
    pub recorded: Command,
    /// What the controller commands today.
    pub today: Command,
}

/// Feeds the recorded detections of every robot to the controller, with these parameters or else
/// those of the bag's record.
///
/// # Errors
///
/// If the bag has no robot with detections and commands, or does not contain what the controller
/// was set to.
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
    let (mut recorded, running) = collect(bag).with_context(|| name.clone())?;
    recorded.retain(|_, robot| !robot.detections.is_empty() && !robot.commands.is_empty());
    let names = controller.reading_names();
    let program = controller.program();
    let mut robots = Vec::new();
    for (robot, mut recorded) in recorded {
        if let Some(missing) = recorded.missing(&names) {
            let topic = topics::further_detection(&robot, missing);
            return Err(with_help(
                format!("{name}: has no {topic}, and this controller decides by it as well"),
                "record every reading that its table names",
            ));
        }
        recorded.put_together(&names);
        let run = of_robot(&controller, record.as_ref(), &robot);
        robots.push(compare(robot, &recorded, running, (&program, &names, run)));
    }
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
        n_held: sum(|robot| robot.n_held),
        robots,
    })
}

impl ControllerReplay {
    /// Whether commands were compared, and all of them are the same.
    pub fn is_same(&self) -> bool {
        self.n_steps > 0 && self.n_different + self.n_unanswered + self.n_unasked == 0
    }
}

/// What a robot's controller starts with in a run, and what may keep it from commanding.
#[derive(Clone, Copy, Debug)]
struct OfRobot {
    /// Of the draws of its transitions, which are those of its place in the run.
    key: Key,
    /// And so is its start among the states.
    start: Memory,
    time: Time,
    /// Age at which its last command is stale, in nanoseconds, if it holds the lease.
    timeout_ns: Option<u64>,
}

fn of_robot(controller: &Controller, record: Option<&ExperimentRecord>, robot: &str) -> OfRobot {
    let place = record.and_then(|it| it.robots.iter().position(|name| name == robot));
    let run = record.map_or(Seed { seed: 0, replicate: 0 }, |it| Seed {
        seed: it.seed,
        replicate: it.replicate,
    });
    let start = record.zip(place).map(|(record, place)| {
        controller.start(record.conditions.world.class_names_of(record.robots.len())[place])
    });
    // Where nobody wrote down who held the lease, it may have been the controller.
    let holds_lease = record.is_none_or(|it| it.controller_only.iter().any(|name| name == robot));
    let timeout =
        command_timeout(record.map_or(0.0, |record| record.conditions.period_s), Transport::Plain);
    OfRobot {
        key: transition_key(run, controller.digest(), place.unwrap_or_default()),
        start: start.unwrap_or_default(),
        time: record.map_or(Time::RealTime, |record| record.time),
        timeout_ns: holds_lease.then(|| nanoseconds(timeout)),
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).expect("the timeout of a command is a few seconds")
}

/// Answers every detection of the running time as the controller does today.
///
/// A command answers the latest detection that came before it, or up to a quarter of a period after
/// it: a recorder may receive two topics the other way round. Of several that came within a period before it, none of
/// them answered yet, a busy recorder has received the first one's answer late: it answers that if it is what the
/// controller commands for it.
fn compare(
    robot: String,
    recorded: &RecordedRobot,
    running: Running,
    (program, names, run): (&Program, &ReadingNames, OfRobot),
) -> RobotReplay {
    let detections = &recorded.detections;
    let is_running = |at_ns: u64| (running.0..=running.1).contains(&at_ns);
    let slack_ns = recorded.slack_ns();
    let mut report = RobotReplay {
        robot,
        n_steps: 0,
        n_different: 0,
        n_unanswered: 0,
        n_unasked: 0,
        n_held: 0,
        first: None,
    };
    // What a silent sensor leaves without a command needs none.
    let mut is_answered: Vec<bool> = detections.iter().map(|it| !it.is_whole).collect();
    let mut newest_answered = None;
    let mut deciding = Deciding { recorded, program, run, memory: run.start };
    // Detections before the run are of none.
    let mut n_decided = detections.partition_point(|it| it.at_ns < running.0);
    for (place, &(at_ns, command)) in recorded.commands.iter().enumerate() {
        if !is_running(at_ns) {
            continue;
        }
        let before = place.checked_sub(1).map(|place| recorded.commands[place]);
        let is_zero = command == Command::STOP && run.timeout_ns.is_some();
        let is_held = is_zero && recorded.is_held(at_ns);
        let is_zero_due = is_held || is_zero && is_stale(recorded, run, (at_ns, before));
        let n_before = detections.partition_point(|it| it.at_ns <= at_ns.saturating_add(slack_ns));
        let answered = n_before.checked_sub(1).filter(|newest| newest_answered != Some(*newest));
        let Some(answered) = answered else {
            if is_zero_due {
                report.n_held += 1;
            } else {
                report.n_unasked += 1;
            }
            continue;
        };
        let memory = deciding.memory;
        let is_late = |it: &usize| detections[*it].at_ns.saturating_add(4 * slack_ns) > at_ns;
        let late = (newest_answered.map_or(n_decided, |newest| newest + 1)..answered).find(is_late);
        let late = late.filter(|late| {
            let is_its_answer = deciding.answer(n_decided.min(*late)..=*late, command) == command;
            deciding.memory = memory;
            is_its_answer
        });
        let answered = late.unwrap_or(answered);
        let today = deciding.answer(n_decided.min(answered)..=answered, command);
        if today != command && is_zero_due {
            // Of a robot that may not move it is the answer; else that comes behind a zero of the same time.
            deciding.memory = memory;
            is_answered[answered] |= is_held;
            report.n_held += 1;
            continue;
        }
        (is_answered[answered], newest_answered) = (true, Some(answered));
        n_decided = answered + 1;
        report.n_steps += 1;
        if today != command {
            report.n_different += 1;
            let found = detections[answered].found;
            let is_true = |(place, name): (usize, &str)| found.has(place).then(|| name.to_owned());
            report.first.get_or_insert_with(|| Difference {
                time_s: at_ns as f64 / 1e9,
                detected: found.detection(),
                reported: names.iter().enumerate().filter_map(is_true).collect(),
                recorded: command,
                today,
            });
        }
    }
    // The answer to the last detection may have come after the end.
    let last = detections.iter().rposition(|it| is_running(it.at_ns)).unwrap_or(0);
    let unanswered = detections[..last].iter().zip(&is_answered);
    report.n_unanswered = unanswered
        .filter(|(detection, is_answered)| is_running(detection.at_ns) && !**is_answered)
        .count() as u64;
    report
}

/// Whether a controller that holds the lease sends a zero between its answers: its last one is too old, or is a zero,
/// which is repeated for a second.
fn is_stale(
    recorded: &RecordedRobot,
    run: OfRobot,
    (at_ns, before): (u64, Option<(u64, Command)>),
) -> bool {
    before.is_none_or(|(before_ns, command)| {
        let age_ns = at_ns.saturating_sub(before_ns).saturating_add(recorded.slack_ns());
        command == Command::STOP || run.timeout_ns.is_some_and(|timeout_ns| age_ns >= timeout_ns)
    })
}

/// The controller of today, in the course of a run.
struct Deciding<'a> {
    recorded: &'a RecordedRobot,
    program: &'a Program,
    run: OfRobot,
    memory: Memory,
}

impl Deciding<'_> {
    /// The command for the last of these detections: the recorded one, if the controller may have received what
    /// leads to it. What has states goes through all of them in their order.
    fn answer(&mut self, these: std::ops::RangeInclusive<usize>, command: Command) -> Command {
        let answered = *these.end();
        for detection in &self.recorded.detections[*these.start()..answered] {
            if detection.is_whole {
                self.decide(detection.found, detection.at_ns);
            }
        }
        let detection = &self.recorded.detections[answered];
        let before = self.memory;
        for found in [detection.found].into_iter().chain(detection.otherwise) {
            self.memory = before;
            if self.decide(found, detection.at_ns) == command {
                return command;
            }
        }
        self.memory = before;
        self.decide(detection.found, detection.at_ns)
    }

    /// One command. In lockstep each step is one of the run; elsewhere a robot that does not move stays at the start.
    fn decide(&mut self, found: Readings, at_ns: u64) -> Command {
        let is_of_run = self.run.time == Time::Lockstep || self.recorded.moves(at_ns);
        let mut start = self.run.start;
        let memory = if is_of_run { &mut self.memory } else { &mut start };
        self.program.decide(found, memory, self.run.key)
    }
}

#[cfg(test)]
mod tests;
