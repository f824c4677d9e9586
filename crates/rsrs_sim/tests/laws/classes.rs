//! The laws of classes of robots, which sensors tell from each other.

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::controller::state_machine::{Row, StateMachine};
use rsrs_core::robot::controller::{Command, Controller};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, SensorDetails};

use rsrs_core::world::{RobotClass, WorldFile};
use rsrs_sim::batch::runs_in_lanes;

use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_testing::conditions::exact_reading;

use crate::support::{
    self, HARSHER, PERFECT, SEED, assert_judged_alike, at, flockbots, perfect_at,
};

fn classes(names: &[&str]) -> WorldFile {
    let class = |name: &&str| RobotClass { name: (*name).to_owned(), ..RobotClass::default() };
    WorldFile { classes: names.iter().map(class).collect(), ..WorldFile::NOTHING }
}

/// What the robot at the origin reports that looks along x: those of its class are the third and the fifth, and the
/// second and the fourth are of another one.
fn reported(details: SensorDetails, ahead_m: [f64; 4], world: WorldFile) -> Vec<String> {
    let mut starts = vec![at(0.0, 0.0, 0.0)];
    starts.extend(ahead_m.map(|x_m| at(x_m, 0.05, 0.0)));
    let mut conditions = perfect_at(starts);
    conditions.arena = Arena { side_m: 8.0, walls: Walls::Clamp };
    conditions.world = world;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.1, range_m: 2.0 };
    conditions.robot.details = details;
    support::reported(&conditions).swap_remove(0)
}

fn ternary(hidden_by: Vec<Detects>) -> SensorDetails {
    let or = vec![exact_reading("other", Detects::Other)];
    SensorDetails { detects: Detects::Kin, hidden_by, or, ..SensorDetails::default() }
}

#[test]
fn of_kin_and_others_the_nearest_is_reported() {
    let two = || classes(&["a", "b"]);
    let sees = |ahead_m| reported(ternary(Vec::new()), ahead_m, two());

    assert_eq!(sees([-3.0, 1.0, -2.0, -1.0]), ["detection"], "the third is kin");
    assert_eq!(sees([1.0, -3.0, -2.0, -1.0]), ["other"], "the second is not");
    assert_eq!(sees([0.5, 1.0, 1.5, 2.0]), ["other"]);
    assert_eq!(sees([1.0, 1.5, 2.0, 0.5]), ["detection"]);
    assert_eq!(sees([-1.0, -1.5, -2.0, -0.5]), [""; 0]);
    let three = classes(&["a", "b", "c"]);
    assert_eq!(reported(ternary(Vec::new()), [-1.0, 0.5, 1.0, -2.0], three), ["other"]);
    assert_eq!(reported(ternary(Vec::new()), [0.5, 1.0, 1.5, 2.0], classes(&["a"])), ["detection"]);
}

#[test]
fn kin_and_others_alone_are_seen_past_each_other_unless_they_are_hidden() {
    let of = |detects, hidden_by: Vec<Detects>| {
        let details = SensorDetails { detects, hidden_by, ..SensorDetails::default() };
        !reported(details, [0.5, 1.0, -2.0, -1.0], classes(&["a", "b"])).is_empty()
    };

    for (detects, hidden_by, expected) in [
        (Detects::Kin, vec![], true),
        (Detects::Kin, vec![Detects::Robot], false),
        (Detects::Kin, vec![Detects::Other], false),
        (Detects::Kin, vec![Detects::Kin], true),
        (Detects::Other, vec![], true),
        (Detects::Other, vec![Detects::Kin, Detects::Robot], true),
        (Detects::Robot, vec![Detects::Other], true),
    ] {
        assert_eq!(of(detects, hidden_by.clone()), expected, "{detects} {hidden_by:?}");
    }
}

const SORT: &str = "
name: sort
words: {noun: sorting, swarm: a swarm that sorts itself, verb: [sort, sorts, sorted]}
phases: [{key: sorted}, {key: mixed}]
rules:
  - {phase: sorted, when: {segregated: {at_least: 0.6}, least_segregated: {at_least: 0.3}}}
otherwise: mixed
";

/// Twelve noisy robots of three classes, with the segregating controller of Mitrano et al. (2019) at a speed of their
/// own.
fn segregating() -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.robots = 12;
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: 2.0, height_m: 2.0 });
    conditions.arena = Arena { side_m: 3.0, walls: Walls::Stop };
    conditions.world = classes(&["a", "b", "c"]);
    conditions.robot.region = Region::Cone { half_angle_rad: 0.26, range_m: 3.0 };
    conditions.robot.true_positive = 0.95;
    conditions.robot.false_positive = 0.02;
    conditions.robot.details = SensorDetails {
        or: vec![Reading {
            true_positive: 0.95,
            false_positive: 0.02,
            ..exact_reading("other", Detects::Other)
        }],
        ..ternary(vec![Detects::Robot])
    };
    let row = |when: &[(&str, bool)], speed_m_s, turn_rate_rad_s| Row {
        state: "start".to_owned(),
        when: when.iter().map(|(name, is_true)| ((*name).to_owned(), *is_true)).collect(),
        command: Command { speed_m_s, turn_rate_rad_s },
        next: Vec::new(),
    };
    conditions.controller = Controller::Machine(StateMachine {
        rows: vec![
            row(&[("detection", true)], 0.1, 1.0),
            row(&[("other", true)], 0.0, 2.0),
            row(&[], -0.05, 2.0),
        ],
        numbers: [].into(),
        starts: [].into(),
        sensors: conditions.robot.reading_names(),
    });
    conditions.behaviour = Behaviour::parse("sort.yaml", SORT).expect("it is one");
    conditions.check().expect("it makes a world");
    conditions
}

#[test]
fn sensors_of_classes_are_swept_in_the_reference_world_and_judged_alike() {
    let conditions = segregating();
    assert!(!runs_in_lanes(&conditions, 120.0));

    assert_judged_alike(&conditions, 3);
}

#[test]
fn classes_that_no_sensor_tells_apart_are_judged_in_lanes_as_by_the_definition() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.world = classes(&["a", "b"]);
    conditions.behaviour = Behaviour::parse("sort.yaml", SORT).expect("it is one");
    assert!(runs_in_lanes(&conditions, 120.0));

    assert_judged_alike(&conditions, 20);
}

#[test]
fn robots_of_classes_follow_the_states_in_which_their_classes_start() {
    let mut conditions = flockbots(0.15, 0.75, &PERFECT);
    conditions.robots = 5;
    conditions.world = classes(&["stands", "drives"]);
    let row = |state: &str, speed_m_s| Row {
        state: state.to_owned(),
        when: [].into(),
        command: Command { speed_m_s, turn_rate_rad_s: 0.0 },
        next: Vec::new(),
    };
    conditions.controller = Controller::Machine(StateMachine {
        rows: vec![row("stand", 0.0), row("drive", 0.1)],
        numbers: [].into(),
        starts: [("drives".to_owned(), "drive".to_owned())].into(),
        sensors: conditions.robot.reading_names(),
    });
    conditions.check().expect("it makes a world");
    assert!(!runs_in_lanes(&conditions, 120.0));

    let run = run_episode(&conditions, SEED, 2.0).expect("they fit");

    for sample in 0..run.n_samples() {
        let speeds: Vec<f64> = run.commands_at(sample).iter().map(|it| it.speed_m_s).collect();
        assert_eq!(speeds, [0.0, 0.1, 0.0, 0.1, 0.0]);
    }
}

/// The state of robots of three classes after 200 steps: it changes only when the world does.
const GOLDEN: u64 = 0x38a2_f757_f10b_6320;

#[test]
fn robots_of_several_classes_have_the_bits_that_they_always_had() {
    let digests = episode_digests(&segregating(), SEED, 26.2).expect("they fit");

    assert_eq!(digests[200], GOLDEN, "found {:#018x}", digests[200]);
}
