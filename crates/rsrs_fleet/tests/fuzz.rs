//! Fuzzing of what a robot, and whoever watches it, receives from anybody, and of the files in bags.

use std::collections::BTreeMap;
use std::time::Duration;

use rand::RngExt;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::e_stop::{LockCause, Locks, Message, Source};
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::fleet_file::FleetFile;
use rsrs_fleet::observation::{Event, Observation};
use rsrs_fleet::record::{Ending, ExperimentRecord};
use rsrs_fleet::robot::{self, Lapse, Robot, RobotOptions};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{Pose, Twist};
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::{self, Bool};
use rsrs_msgs::{RosMessage, cdr};
use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::fuzz::{self, Harness};
use rsrs_testing::record::fleet_record;

const ROBOT: &str = "robot_1";

/// What a message is.
#[derive(Clone, Copy)]
enum Kind {
    Lease,
    Status,
    OfController,
    Command,
    Pose,
    Clock,
    Record,
    Ending,
    EStop,
    Locks,
    Release,
}

/// A run as it should be, and how it is stopped.
fn messages_of_a_run() -> Vec<(Kind, Vec<u8>)> {
    let record = fleet_record("a profile", flockbot_conditions());
    let digest = record.conditions.digest();
    let run_id = record.run_id.clone();
    let lease = |state: LeaseState, counter| {
        cdr::encode(&RunLease {
            run_id: run_id.clone(),
            epoch: 7,
            state: state.into(),
            parameter_digest: digest,
            robots: vec![ROBOT.to_owned()],
            echoed_counter: vec![counter],
            ..RunLease::default()
        })
    };
    let status = cdr::encode(&RobotStatus {
        counter: 1,
        epoch: 7,
        run_id: run_id.clone(),
        parameter_digest: digest,
        state: u8::from(RobotState::Moving),
        ..RobotStatus::default()
    });
    let mut twist = Twist::default();
    twist.linear.x = 0.1;
    let text = |data| cdr::encode(&std_msgs::String { data });
    let locks = Locks(BTreeMap::from([(Source([1; 16]), LockCause::Engaged)]));
    let locks = cdr::encode(&wire::locks_message(&locks));
    vec![
        (Kind::Record, text(record.to_json())),
        (Kind::Lease, lease(LeaseState::Armed, 1)),
        (Kind::OfController, status.clone()),
        (Kind::Lease, lease(LeaseState::Running, 2)),
        (Kind::Status, status),
        (Kind::Clock, cdr::encode(&Clock { clock: Time { sec: 1, nanosec: 0 } })),
        (Kind::Pose, cdr::encode(&Pose::default())),
        (Kind::Command, cdr::encode(&twist)),
        (Kind::EStop, cdr::encode(&Bool { data: true })),
        (Kind::Locks, locks.clone()),
        (Kind::Release, locks),
        (Kind::Ending, text(Ending::completed().to_json(&run_id))),
    ]
}

fn decode<M: RosMessage>(bytes: &[u8]) -> Result<M, String> {
    cdr::decode(bytes).map_err(in_words)
}

fn in_words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// A robot's gate, and whoever looks at it.
struct Floor {
    robot: Robot,
    observation: Observation,
    now: Duration,
}

impl Floor {
    fn new() -> Self {
        let options = RobotOptions {
            name: ROBOT.to_owned(),
            command_timeout: Duration::from_millis(300),
            lapse: Lapse::Stops,
        };
        let observation = Observation::default();
        Self { robot: Robot::new(options), observation, now: Duration::from_secs(100) }
    }

    /// Takes a message as nodes do.
    fn receive(&mut self, kind: Kind, bytes: &[u8]) -> Result<(), String> {
        let robot = ROBOT.to_owned();
        let source = Source([2; 16]);
        let (to_robot, to_observation) = match kind {
            Kind::Lease => {
                let lease = wire::lease(decode(bytes)?).map_err(in_words)?;
                (Some(robot::Event::Lease(lease.clone())), Event::Lease(lease))
            }
            Kind::Status => {
                let status = wire::status(decode(bytes)?).map_err(in_words)?;
                (None, Event::Status { robot, status })
            }
            Kind::OfController => {
                let status = wire::status(decode(bytes)?).map_err(in_words)?;
                (Some(robot::Event::Controller(status)), Event::Found { robot })
            }
            Kind::Command => {
                let command = wire::command(&decode(bytes)?).map_err(in_words)?;
                (Some(robot::Event::Command(command)), Event::Command { robot, command })
            }
            Kind::Pose => {
                let pose = wire::pose(&decode(bytes)?).map_err(in_words)?;
                (None, Event::Pose { robot, source: PoseSource::Pose, pose })
            }
            Kind::Clock => {
                let nanos = decode::<Clock>(bytes)?.clock.to_nanos();
                (None, Event::Clock(Duration::from_nanos(nanos.ok_or("before 1970")?)))
            }
            Kind::Record => {
                let text: std_msgs::String = decode(bytes)?;
                let record = ExperimentRecord::from_json(&text.data).map_err(in_words)?;
                (None, Event::Experiment(Box::new(record)))
            }
            Kind::Ending => {
                let text: std_msgs::String = decode(bytes)?;
                let (ending, run_id) = Ending::from_json(&text.data).map_err(in_words)?;
                (None, Event::Ending { run_id, ending })
            }
            Kind::EStop => {
                let engaged = decode::<Bool>(bytes)?.data;
                let state = Message::State { source, engaged };
                (Some(robot::Event::EStop(state.clone())), Event::EStop(state))
            }
            Kind::Locks => {
                let locks = wire::locks(decode(bytes)?).map_err(in_words)?;
                let locks = Message::Locks { reporter: source, locks };
                (Some(robot::Event::EStop(locks.clone())), Event::EStop(locks))
            }
            Kind::Release => {
                let locks = wire::locks(decode(bytes)?).map_err(in_words)?;
                let sources = locks.0.into_keys().collect();
                let release = Message::Release(sources);
                (Some(robot::Event::EStop(release.clone())), Event::EStop(release))
            }
        };
        if let Some(event) = to_robot {
            self.robot.on_event(event, self.now);
        }
        self.observation.on_event(to_observation, self.now);
        Ok(())
    }

    /// Does what nodes and screens do all the time.
    fn look(&mut self) -> String {
        self.now += Duration::from_millis(130);
        self.robot.on_event(robot::Event::Tick, self.now);
        let command = self.robot.drive(self.now);
        assert!(command.speed_m_s.is_finite() && command.turn_rate_rad_s.is_finite());
        let (state, standing) = (self.robot.state(self.now), self.robot.standing(self.now));
        let observation = &self.observation;
        let robots = observation
            .robots()
            .map(|(_, robot)| (robot.condition(self.now), observation.lease_of(robot, self.now)));
        let robots: Vec<_> = robots.collect();
        let run = observation.run(self.now).is_some();
        let phase = observation.order().map(|order| order.phase);
        let has_trail = !observation.trail(5.0).is_empty();
        format!("{state:?} {standing:?} {robots:?} {run} {phase:?} {has_trail}")
    }
}

#[test]
fn fuzzed_messages_stop_neither_robots_nor_those_who_watch_them() {
    let run = messages_of_a_run();
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/received"),
        // What the message is and after which one it arrives, as places in the run, and its bytes.
        seeds: (0_u8..).zip(&run).map(|(at, (_, bytes))| [&[at, at], &**bytes].concat()).collect(),
        mutation: &|input, other, draw| {
            if draw.random_range(0..4) == 0 {
                input[draw.random_range(0..2)] = draw.random();
            }
            fuzz::behind(2, fuzz::cdr)(input, other, draw);
        },
    };

    let n_outcomes = harness.run(|input| {
        let [like, behind] = [input[0], input[1]].map(|place| usize::from(place) % run.len());
        let mut floor = Floor::new();
        let mut outcome = String::new();
        for (at, (of_run, bytes)) in run.iter().enumerate() {
            floor.receive(*of_run, bytes).expect("the run is as it should be");
            if at == behind {
                let received = floor.receive(run[like].0, &input[2..]);
                outcome = format!("{received:?} {}", floor.look());
            }
            floor.look();
        }
        outcome
    });

    assert!(n_outcomes > 20, "{n_outcomes} outcomes");
}

/// Who reads a text.
type Reader = fn(&str) -> Result<(), String>;

/// By the first byte of an input.
const READERS: [Reader; 5] = [
    |text| ExperimentRecord::from_json(text).map(drop).map_err(in_words),
    |text| Ending::from_json(text).map(drop).map_err(in_words),
    |text| FleetFile::parse("fleet.yaml", text).map(drop).map_err(in_words),
    |text| ExperimentFile::parse("experiment.yaml", text).map(drop).map_err(in_words),
    |text| RobotProfile::parse("profile.yaml", text).map(drop).map_err(in_words),
];

#[test]
fn fuzzed_records_and_files_in_bags_are_read_or_refused() {
    let record = fleet_record("a profile", flockbot_conditions());
    let ending = Ending::completed().to_json(&record.run_id);
    let texts = [
        (0, &*record.to_json()),
        (1, &*ending),
        (2, include_str!("../../../launch_configs/fleets/nine_flockbots.yaml")),
        (2, include_str!("../../../launch_configs/fleets/three_kinds.yaml")),
        (3, include_str!("../../../launch_configs/experiments/flockbot_milling.yaml")),
        (4, rsrs_testing::conditions::FLOCKBOT),
    ];
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/records"),
        seeds: texts.iter().map(|(reader, text)| [&[*reader], text.as_bytes()].concat()).collect(),
        mutation: &fuzz::behind(1, fuzz::text),
    };

    let n_outcomes = harness.run(|input| {
        let Ok(text) = std::str::from_utf8(&input[1..]) else { return "no text".to_owned() };
        let reader = usize::from(input[0]) % READERS.len();
        format!("{:?}", READERS[reader](text))
    });

    assert!(n_outcomes > 20, "{n_outcomes} outcomes");
}
