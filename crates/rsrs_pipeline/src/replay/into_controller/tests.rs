//! Bags of the fleet's own controller, at every turn at which it stands.

use std::path::Path;

use rsrs_bags::{Bag, BagOptions, BagWriter, Sample};
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::state_machine::StateMachine;
use rsrs_core::robot::controller::{Controller, Reaction};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::controller::{self, Action, Event, Stamp};
use rsrs_fleet::message::{Echo, Lease, LeaseState};
use rsrs_fleet::record::ATTACHMENT;
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time as Instant;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Topic};
use rsrs_msgs::{RosMessage, cdr};
use rsrs_testing::record::fleet_record;

use super::*;

use rsrs_testing::conditions::FLOCKBOT;
const SENSORS: &str = "\
sensors:
  - {name: detection, cone: {half_angle_rad: 0.2, range_m: 0.75}, true_positive: 0.9, false_positive: 0.05}
  - {name: left, bearing_rad: 1.2, cone: {half_angle_rad: 0.3, range_m: 0.5}, true_positive: 0.9, false_positive: 0.05}
";
const ROBOT: &str = "robot_1";
const PERIOD_MS: u64 = 130;

/// It goes for two periods and turns for one, and turns away from what is at its left.
const TABLE: &str = r#"{"sensors":[["detection"],["left"]],"rows":[
    {"state":"go","when":{"left":true},"command":{"speed_m_s":0.0,"turn_rate_rad_s":0.5},
     "next":[{"state":"turn","probability":1.0,"after_periods":2}]},
    {"state":"go","when":{"detection":true},"command":{"speed_m_s":0.1,"turn_rate_rad_s":-0.5},
     "next":[{"state":"turn","probability":1.0,"after_periods":2}]},
    {"state":"go","command":{"speed_m_s":0.2,"turn_rate_rad_s":0.0},
     "next":[{"state":"turn","probability":1.0,"after_periods":2}]},
    {"state":"turn","command":{"speed_m_s":0.0,"turn_rate_rad_s":1.0},
     "next":[{"state":"go","probability":1.0,"after_periods":0}]}]}"#;

/// A controller that holds the lease, and the bag of what it receives and sends.
struct Recorded {
    machine: controller::Controller,
    counter: u64,
    now_ms: u64,
    writer: BagWriter,
    channels: Vec<(String, rsrs_bags::ChannelId)>,
    record: ExperimentRecord,
    /// What it sent that the recorder has not received yet, if that is busy.
    under_way: Option<Vec<Command>>,
}

impl Recorded {
    fn new(path: &Path) -> Self {
        let (before, sensing) = FLOCKBOT.split_once("sensing:").expect("it has a sensor");
        let is_of_next = |line: &&str| line.starts_with(|first: char| first.is_ascii_lowercase());
        let behind = sensing.lines().skip(1).skip_while(|line| !is_of_next(line));
        // Where its numbers are from.
        let behind = behind.filter(|line| !line.trim_start().starts_with("sensing."));
        let behind: Vec<&str> = behind.collect();
        let text = format!("{before}{SENSORS}{}", behind.join("\n"));
        let profile = RobotProfile::parse("flockbot.yaml", &text).expect("its sensors are right");
        let values = [(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 1.0)];
        let settings = Settings { values: values.to_vec(), ..Settings::default() };
        let mut conditions =
            Conditions::resolve(&profile, &settings).expect("the cell is possible");
        conditions.controller = Controller::Machine(StateMachine::from_json(TABLE).expect("one"));
        let settings = controller::Settings {
            controller: conditions.controller.clone(),
            transition_key: Key::from_bits(0),
            start: Memory::default(),
            stamp: Stamp::Wall,
            reaction: Reaction::ToDetections,
        };
        let timeout = command_timeout(conditions.period_s, Transport::Plain);
        let controller_only = vec![ROBOT.to_owned()];
        let record =
            ExperimentRecord { controller_only, ..fleet_record(&profile.digest(), conditions) };
        Self {
            machine: controller::Controller::holding_lease(ROBOT, settings, timeout),
            counter: 0,
            now_ms: 1_000,
            writer: BagWriter::create(path, BagOptions::default()).expect("it is new"),
            channels: Vec::new(),
            record,
            under_way: None,
        }
    }

    fn write<M: RosMessage>(&mut self, name: &str, topic: Topic, message: &M) {
        let known = self.channels.iter().find(|(known, _)| known == name).map(|(_, it)| *it);
        let channel = known.unwrap_or_else(|| {
            let new = self.writer.add_topic(name, topic.type_name, topic.qos).expect("it is new");
            self.channels.push((name.to_owned(), new));
            new
        });
        let time_ns = self.now_ms * 1_000_000;
        let data = cdr::encode(message);
        let sample =
            Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data: &data };
        self.writer.write(channel, sample).expect("the disk has room");
    }

    /// What happens is recorded, and then what follows from it.
    fn take(&mut self, event: Event) {
        let now = Duration::from_millis(self.now_ms);
        let of_robot = |topic: Topic| (topic.for_robot(ROBOT), topic);
        match &event {
            Event::Detection(data) => {
                let (name, topic) = of_robot(topics::DETECTION);
                self.write(&name, topic, &Bool { data: *data });
            }
            Event::Reading { is_true, .. } => {
                let name = topics::further_detection(ROBOT, "left");
                self.write(&name, topics::FURTHER_DETECTION, &Bool { data: *is_true });
            }
            Event::Lease(lease) => {
                let message = wire::lease_message(lease, Instant::default());
                self.write(topics::LEASE.name, topics::LEASE, &message);
            }
            _ => {}
        }
        for action in self.machine.on_event(event, now) {
            let (topic, status) = match action {
                Action::Command { command, .. } => {
                    match &mut self.under_way {
                        Some(commands) => commands.push(command),
                        None => self.write_command(command),
                    }
                    continue;
                }
                Action::Status(status) => (topics::CONTROLLER_STATUS, status),
                Action::GateStatus(status) => {
                    self.counter = status.counter;
                    (topics::STATUS, status)
                }
            };
            let message = wire::status_message(&status, Instant::default());
            self.write(&topic.for_robot(ROBOT), topic, &message);
        }
    }

    fn write_command(&mut self, command: Command) {
        let name = topics::CMD_VEL.for_robot(ROBOT);
        self.write(&name, topics::CMD_VEL, &wire::twist_stamped(command, Instant::default()));
    }

    /// Two detections, one behind the other, of which the recorder receives the answers afterwards.
    fn bunch(&mut self) {
        self.under_way = Some(Vec::new());
        for is_true in [true, false] {
            self.now_ms += 1;
            self.take(Event::Reading { reading: 1, is_true: false });
            self.take(Event::Detection(is_true));
        }
        for command in self.under_way.take().into_iter().flatten() {
            self.now_ms += 1;
            self.write_command(command);
        }
        // Back to the tens of milliseconds in which time passes.
        self.now_ms = self.now_ms.next_multiple_of(10);
    }

    /// Lets time pass, with what there is in it.
    fn pass(&mut self, n_ms: u64, lease: Option<LeaseState>, [detects, left]: [bool; 2]) {
        for _ in 0..n_ms / 10 {
            self.now_ms += 10;
            if let Some(state) = lease
                && self.now_ms.is_multiple_of(50)
            {
                self.take(Event::Lease(Lease {
                    run_id: "run".to_owned(),
                    epoch: 1,
                    state,
                    parameter_digest: self.record.conditions.controller.digest(),
                    robots: vec![Echo { robot: ROBOT.to_owned(), counter: self.counter }],
                }));
            }
            let is_true = self.now_ms / 1_000 % 2 == 1;
            if left && self.now_ms.is_multiple_of(PERIOD_MS) {
                self.take(Event::Reading { reading: 1, is_true });
            }
            if detects && self.now_ms.is_multiple_of(PERIOD_MS) {
                self.take(Event::Detection(self.now_ms / 700 % 2 == 1));
            }
            if self.now_ms.is_multiple_of(20) {
                self.take(Event::Tick);
            }
        }
    }

    /// The robot runs; what happens in between ends after that.
    fn run(mut self, path: &Path, between: impl FnOnce(&mut Self)) -> Bag {
        let running = Some(LeaseState::Running);
        self.pass(1_500, None, [true; 2]);
        self.pass(500, Some(LeaseState::Armed), [true; 2]);
        self.pass(4_000, running, [true; 2]);
        between(&mut self);
        self.pass(4_000, running, [true; 2]);
        self.pass(2_000, Some(LeaseState::Stopped), [true; 2]);
        let json = self.record.to_json();
        self.writer.attach(ATTACHMENT, "application/json", json.as_bytes()).expect("room");
        self.writer.finish().expect("the disk has room");
        Bag::open(path).expect("it was written")
    }
}

fn replayed(between: impl FnOnce(&mut Recorded)) -> ControllerReplay {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bag");
    let bag = Recorded::new(&path).run(&path, between);
    replay_into_controller(&bag, None).expect("it has all that is compared")
}

#[test]
fn zeros_that_a_controller_with_the_lease_has_to_send_are_none_of_other_commands() {
    let running = Some(LeaseState::Running);

    let undisturbed = replayed(|_| {});
    let pause = replayed(|robot| robot.pass(900, None, [true; 2]));
    let gap = replayed(|robot| robot.pass(600, running, [false; 2]));
    let silent_left = replayed(|robot| robot.pass(2_500, running, [true, false]));
    let silent = replayed(|robot| robot.pass(2_500, running, [false; 2]));
    let busy = replayed(|robot| {
        for _ in 0..6 {
            robot.bunch();
            robot.pass(3 * PERIOD_MS, running, [true; 2]);
        }
    });

    for (name, replay) in [
        ("undisturbed", &undisturbed),
        ("the lease runs out, and holds again", &pause),
        ("a detection is late", &gap),
        ("the further sensor is silent for a while", &silent_left),
        ("the robot's sensor is silent, which ends the run", &silent),
        ("a busy recorder receives two detections before the answer to the first", &busy),
    ] {
        assert!(replay.is_same(), "{name}: {:?}", replay.robots);
        assert!(replay.n_steps > 25, "{name}: {:?}", replay.robots);
    }
    assert!(pause.n_held > 2 && gap.n_held > 0 && silent_left.n_held > 5 && silent.n_held > 20);
}

#[test]
fn zeros_of_a_robot_that_may_move_are_other_commands() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bag");
    let mut recorded = Recorded::new(&path);
    // Its controller answered with zeros, and held no lease.
    recorded.record.controller_only.clear();
    let bag = recorded.run(&path, |robot| robot.pass(900, None, [true; 2]));

    let replay = replay_into_controller(&bag, None).expect("it has all that is compared");

    assert_eq!(replay.n_held, 0);
    assert!(replay.n_different > 0, "{:?}", replay.robots);
}

#[test]
fn what_a_bag_lacks_of_the_readings_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bag");
    let mut recorded = Recorded::new(&path);
    recorded.pass(1_000, Some(LeaseState::Running), [true, false]);
    let json = recorded.record.to_json();
    recorded.writer.attach(ATTACHMENT, "application/json", json.as_bytes()).expect("room");
    recorded.writer.finish().expect("the disk has room");

    let refused = replay_into_controller(&Bag::open(&path).expect("a bag"), None).unwrap_err();

    let expected = "has no /robot_1/detection/left, and this controller decides by it as well";
    assert!(refused.to_string().contains(expected), "{refused}");
}
