//! Robots with several sensors, over ROS 2.

use std::path::{Path, PathBuf};

use crate::command::done;
use crate::fleet::{ROBOTS, experiment, usual_sensing, without_gates};
use crate::interop_robot::{controllers_with_leases, foreign_robots, python, run_on_fleet};
use crate::processes::{assert_completed, in_own_network, run_in_lockstep};
use crate::recorded::{
    assert_commands_of_replicate, assert_digests_of_replicate, messages, record_of, seed_of,
};
use rsrs_bags::Bag;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::sensor::Readings;
use rsrs_fleet::record::ExperimentRecord;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::std_msgs::Bool;
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;

/// One sensor that tells robots from walls, and a late one to the left.
const SENSORS: &str = "\
sensors:
  - one_of:
      - {name: detection, detects: robot, true_positive: 0.95, false_positive: 0.02}
      - {name: wall, detects: wall, true_positive: 0.97, false_positive: 0.01}
    cone: {half_angle_rad: 0.1, range_m: 0.6}
    hidden_by: [robot]
  - name: left
    bearing_rad: 1.2
    cone: {half_angle_rad: 0.3, range_m: 0.5}
    true_positive: 0.9
    false_positive: 0.05
    latency_steps: 2
";

/// Who meets a robot turns away from it for a while, to the side on which there is none.
const TABLE: &str = "\
numbers: {aside_rad_s: {value: 0.5, from: 0.1, to: 2}}
rows:
  - {state: go, when: {wall: true}, command: {speed_m_s: 0.0, turn_rate_rad_s: 1.0}}
  - {state: go, when: {detection: true, left: true}, command: {speed_m_s: 0.0, turn_rate_rad_s: -1.0},
     next: {state: leave, probability: 0.3}}
  - {state: go, when: {detection: true, left: false}, command: {speed_m_s: 0.0, turn_rate_rad_s: $aside_rad_s}}
  - {state: go, command: {speed_m_s: 0.2, turn_rate_rad_s: 0.0}}
  - {state: leave, command: {speed_m_s: 0.1, turn_rate_rad_s: -0.5}, next: {state: go, after_s: 1}}
";

/// An experiment of three such robots, where `driver` moves them.
fn files(folder: &Path, driver: &str) -> PathBuf {
    std::fs::write(folder.join("avoid.yaml"), TABLE).expect("the folder is writable");
    let sensing = usual_sensing();
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    let cell =
        "cell: {robots: 3, arena_m: 2.4, controller.aside_rad_s: 1.5}\ncontroller: ../avoid.yaml";
    let driver = format!("kind: {driver}");
    let changes = [(usual, cell), (sensing.as_str(), SENSORS), ("kind: virtual", driver.as_str())];
    experiment(folder, 62, &changes)
}

#[test]
fn several_sensors_over_ros_2_in_lockstep_are_the_replicate_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual");
    let path = folder.path().join("bag");
    run_in_lockstep(&file, &[], &path);

    let (bag, record) = record_of(&path);
    let Controller::Machine(machine) = &record.conditions.controller else {
        panic!("{:?}", record.conditions.controller);
    };
    assert_eq!(machine.sensors.iter().collect::<Vec<_>>(), ["detection", "wall", "left"]);
    assert_eq!(machine.states(), ["go", "leave"]);
    assert_eq!(machine.numbers["aside_rad_s"].to_bits(), 1.5_f64.to_bits());
    assert!(bag.attachment("controller.yaml").is_some(), "the file is there, too");
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);
    let reported = reported(&record, seed_of(&record));
    for (place, robot) in record.robots.iter().enumerate() {
        for (reading, topic) in ["detection", "detection/wall", "detection/left"].iter().enumerate()
        {
            let found: Vec<Bool> = messages(&bag, robot, topic);
            let found: Vec<bool> = found.iter().map(|message| message.data).collect();
            let of_robot = reported.iter().map(|step| step[place].has(reading));
            let expected: Vec<bool> = of_robot.take(found.len()).collect();
            assert!(found.len() > 400 && found.contains(&true), "{topic}: {}", found.len());
            assert_eq!(found, expected, "{robot} {topic}");
        }
    }

    let replay = done(folder.path(), &["replay", "bag", "--into", "controller"]);
    assert!(replay.contains(" 0 different"), "{replay}");
    done(folder.path(), &["label", "bag", "--format", "json"]);
}

/// What all robots report in each step.
fn reported(record: &ExperimentRecord, seed: Seed) -> Vec<Vec<Readings>> {
    let conditions = &record.conditions;
    let mut world = World::new(conditions, seed).expect("they fit");
    let mut controllers = Controllers::new(conditions, seed);
    let steps = 0..conditions.steps(record.duration_s);
    steps
        .map(|_| {
            let readings = world.sense_all().to_vec();
            let mut commands = Vec::new();
            controllers.decide(&readings, &mut commands);
            world.advance(&commands);
            readings
        })
        .collect()
}

#[test]
fn real_robots_obey_each_of_their_sensors_and_one_that_nobody_publishes_is_named() {
    let python = python();
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = files(folder.path(), "ros");
        without_gates(
            folder.path(),
            &[("duration_s: 62", "duration_s: 8"), ("arena_m: 2.4", "arena_m: 12")],
        );
        let _controllers = controllers_with_leases(&ROBOTS[..3], "twist_stamped");
        // One of each quality of service that robots have.
        let kinds = ["default:default", "sensor:sensor", "default:kept"];
        let robots = |further: &str| {
            let of_robot = |(kind, robot)| format!("{robot}:twist_stamped:{kind}");
            let robots = kinds.iter().zip(ROBOTS).map(of_robot);
            let arguments = [format!("--further={further}")].into_iter().chain(robots);
            foreign_robots(&python, folder.path(), arguments)
        };

        let of_one = robots("left");
        let (code, printed, _) = run_on_fleet(&file, folder.path().join("refused"));
        assert_eq!(code, Some(1), "{printed}");
        assert!(
            printed.contains("/{robot_1, robot_2, robot_3}/detection/wall: no publisher"),
            "{printed}"
        );
        assert!(!printed.contains("detection/left"), "{printed}");
        drop(of_one);

        let _of_both = robots("wall,left");
        let (code, printed, bag) = run_on_fleet(&file, folder.path().join("bag"));
        assert_completed(code, &printed);
        let bag = Bag::open(&bag).expect("the run was recorded");
        for robot in &ROBOTS[..3] {
            for topic in ["detection", "detection/wall", "detection/left"] {
                let n = messages::<Bool>(&bag, robot, topic).len();
                assert!(n > 40, "{robot}: {n} of {topic}");
            }
            let commands = messages::<TwistStamped>(&bag, robot, "cmd_vel");
            let n_of = |speed_m_s: f64, turn_rate_rad_s: f64| {
                let is = |it: &&TwistStamped| {
                    (it.twist.linear.x, it.twist.angular.z) == (speed_m_s, turn_rate_rad_s)
                };
                commands.iter().filter(is).count()
            };
            let (turns, goes) = (n_of(0.0, 1.0), n_of(0.2, 0.0));
            assert!(turns > 10 && goes > 10, "{robot}: {turns} at walls, {goes} ahead");
        }
    });
}
