//! Controllers in files: what they come to, and what is refused with its line.

use proptest::prelude::*;
use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::draw::Seed;
use rsrs_core::help::Help as _;
use rsrs_core::quantity::{Axis, Number};
use rsrs_core::robot::controller::state_machine::{Memory, transition_key};
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters, decide};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::wheels::Wheels;
use rsrs_core::world::{RobotClass, WorldFile};

use rsrs_testing::conditions::flockbot;
const MIRRORED: &str = include_str!("../../../launch_configs/controllers/mirrored.yaml");
const GAUCI: &str = include_str!("../../../launch_configs/controllers/gauci_aggregation.yaml");
const SEARCH: &str = include_str!("../../../launch_configs/controllers/search_and_dwell.yaml");

fn e_puck() -> RobotProfile {
    let mut robot = flockbot();
    robot.actuation.wheels = Some(Wheels { base_m: 0.051, speed_max_m_s: 0.128 });
    (robot.actuation.speed.limits_m_s, robot.actuation.turn.limits_rad_s) =
        ([0.0, 0.128], [0.0, 5.1]);
    robot
}

fn parsed(text: &str) -> ControllerTable {
    ControllerTable::parse("controller.yaml", text, &flockbot()).expect("it is a table")
}

/// The error of a file, and its cure.
fn refused_for(text: &str, robot: &RobotProfile) -> (String, String) {
    let error = ControllerTable::parse("controller.yaml", text, robot);
    let error = error.expect_err("it is wrong");
    (error.to_string(), error.help().unwrap_or_default())
}

fn refused(text: &str) -> (String, String) {
    refused_for(text, &flockbot())
}

fn number(name: &str) -> Number {
    Number::new(name).expect("it is a name")
}

#[test]
fn the_controllers_of_two_papers_are_two_commands_over_one_detection() {
    let mirrored = parsed(MIRRORED).resolve(&[], None, 0.13).unwrap();
    let set = [(number("speed_m_s"), 0.1), (number("turn_rate_rad_s"), 1.0)];
    let slower = parsed(MIRRORED).resolve(&set, None, 0.13).unwrap();
    assert_eq!(mirrored, ControllerParameters::mirrored(0.15, 0.75).into());
    assert_eq!(slower, ControllerParameters::mirrored(0.1, 1.0).into());

    let robot = e_puck();
    let gauci = ControllerTable::parse("gauci.yaml", GAUCI, &robot).unwrap();
    let gauci = gauci.resolve(&[], robot.actuation.wheels, 0.1).unwrap();
    let [seen, unseen] = gauci.parameters().unwrap().commands();
    let turn_rate_rad_s = -2.0 * 0.128 / 0.051;
    assert_eq!(seen, Command { speed_m_s: 0.0, turn_rate_rad_s });
    assert!((unseen.speed_m_s + 0.85 * 0.128).abs() < 1e-12, "{unseen:?}");
    assert!((unseen.turn_rate_rad_s + 0.3 * 0.128 / 0.051).abs() < 1e-12, "{unseen:?}");
}

#[test]
fn a_table_of_two_commands_makes_the_conditions_without_a_table_to_the_digest() {
    let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
    let plain = Settings { values, ..Settings::default() };
    let table = Settings {
        values: vec![(Axis::Robots, 9.0), (Axis::Number(number("speed_m_s")), 0.15)],
        controller: Some(parsed(MIRRORED)),
        ..Settings::default()
    };

    let [plain, table] =
        [plain, table].map(|settings| Conditions::resolve(&flockbot(), &settings).unwrap());

    assert_eq!(table, plain);
    assert_eq!(table.digest(), plain.digest());
}

#[test]
fn a_state_lasts_as_long_as_its_row_states_and_then_goes_on() {
    let text = "
rows:
  - {state: drive, command: {speed_m_s: 0.2, turn_rate_rad_s: 0}, next: {state: turn, after_s: 0.25}}
  - {state: turn, command: {speed_m_s: 0, turn_rate_rad_s: 1}, next: {state: drive}}
";
    let controller = parsed(text).resolve(&[], None, 0.1).unwrap();
    let key = transition_key(Seed { seed: 1, replicate: 0 }, controller.digest(), 0);
    let (program, mut memory) = (controller.program(), Memory::default());

    let speeds: Vec<f64> =
        (0..8).map(|_| program.decide(false.into(), &mut memory, key).speed_m_s).collect();

    // 0.25 s are three periods of 0.1 s.
    assert_eq!(speeds, [0.2, 0.2, 0.2, 0.0, 0.2, 0.2, 0.2, 0.0]);
}

#[test]
fn transitions_happen_as_often_as_stated_the_first_before_the_others() {
    let text = "
rows:
  - state: wait
    command: {speed_m_s: 0, turn_rate_rad_s: 1}
    next: [{state: left, probability: 0.1}, {state: right, probability: 0.5}]
  - {state: left, command: {speed_m_s: 0.1, turn_rate_rad_s: 1}, next: {state: wait}}
  - {state: right, command: {speed_m_s: 0.1, turn_rate_rad_s: -1}, next: {state: wait}}
";
    let controller = parsed(text).resolve(&[], None, 0.1).unwrap();
    let program = controller.program();
    let (mut waits, mut left, mut right) = (0_u32, 0_u32, 0_u32);
    for robot in 0..50 {
        let key = transition_key(Seed { seed: 7, replicate: 0 }, controller.digest(), robot);
        let mut memory = Memory::default();
        for _ in 0..2000 {
            let command = program.decide(true.into(), &mut memory, key);
            let count = match (command.speed_m_s, command.turn_rate_rad_s) {
                (0.0, _) => &mut waits,
                (_, 1.0) => &mut left,
                _ => &mut right,
            };
            *count += 1;
        }
    }

    let share = |count: u32| f64::from(count) / f64::from(waits);
    // Four standard errors of a share of half of some 60,000 waits.
    assert!((share(left) - 0.1).abs() < 0.008, "{}", share(left));
    assert!((share(right) - 0.45).abs() < 0.008, "{}", share(right));
}

#[test]
fn whatever_a_table_has_is_in_its_digest() {
    let base = parsed(SEARCH);
    let digest = |table: &ControllerTable, values: &[(Number, f64)]| {
        table.resolve(values, None, 0.1).unwrap().digest()
    };
    let expected = digest(&base, &[]);
    let edited = |from: &str, to: &str| {
        let text = SEARCH.replacen(from, to, 1);
        assert_ne!(text, SEARCH, "{from}");
        digest(&parsed(&text), &[])
    };

    for other in [
        digest(&base, &[(number("dwell_s"), 2.0)]),
        digest(&base, &[(number("lose_interest"), 0.5)]),
        edited("detection: true", "detection: false"),
        edited("speed_m_s: 0.2,", "speed_m_s: 0.21,"),
        edited("state: search, after_s: 2", "state: dwell, after_s: 2"),
    ] {
        assert_ne!(other, expected);
    }
}

#[test]
fn what_is_written_wrong_is_refused_with_its_line_and_a_cure() {
    let stop = "command: {speed_m_s: 0, turn_rate_rad_s: 1}";
    let go = "command: {speed_m_s: 0.1, turn_rate_rad_s: 1}";
    for (text, expected, cure) in [
        (
            format!("rows:\n  - {{when: {{detection: true}}, {stop}}}\n"),
            "controller.yaml:2: state `start` has no row for `detection: false`",
            "add a row with `state: start` and without `when` behind its others",
        ),
        (
            format!("rows:\n  - {{{stop}}}\n  - {{state: idle, {go}}}\n"),
            "controller.yaml:3: state `idle` is never reached",
            "let a row's `next` lead to `idle`",
        ),
        (
            format!("rows:\n  - {{{stop}}}\n  - {{when: {{detection: true}}, {go}}}\n"),
            "controller.yaml:3: this row never matches",
            "put it before them",
        ),
        (
            format!("rows:\n  - {{{stop}, next: {{state: stat}}}}\n"),
            "controller.yaml:2: unknown state `stat`; did you mean `start`?",
            "a state is there once a row has it",
        ),
        (
            format!("rows:\n  - {{when: {{detecton: true}}, {stop}}}\n"),
            "controller.yaml:2: unknown sensor `detecton`; did you mean `detection`?",
            "these robots report `detection`",
        ),
        (
            "numbers: {turn_rad_s: {value: 1, from: 0, to: 2}}\nrows:\n  - {command: {speed_m_s: 0, \
             turn_rate_rad_s: $trun_rad_s}}\n"
                .to_owned(),
            "controller.yaml:3: unknown number `$trun_rad_s`; did you mean `$turn_rad_s`?",
            "write it under `numbers`",
        ),
        (
            "numbers: {turn: {value: 1, from: 0, to: 1}}\nrows:\n  - {command: {speed_m_s: 0, \
             turn_rate_rad_s: $turn}}\n"
                .to_owned(),
            "controller.yaml:3: `turn_rate_rad_s` is `$turn`, which is a probability, expected rad/s",
            "end with `_rad_s`",
        ),
        (
            format!("numbers:\n  turn_rad_s: {{value: 1, from: 0, to: 2}}\nrows:\n  - {{{stop}}}\n"),
            "controller.yaml:2: number `turn_rad_s` is in no row",
            "use it in a row as `$turn_rad_s`",
        ),
        (
            "numbers:\n  turn_rad_s: {value: 3, from: 0, to: 2}\nrows:\n  - {command: {speed_m_s: 0, \
             turn_rate_rad_s: $turn_rad_s}}\n"
                .to_owned(),
            "controller.yaml:2: `turn_rad_s.value` is 3, expected a number from 0 to 2",
            "",
        ),
        (
            "numbers:\n  turn_rad_s: {value: .nan, from: 0, to: 2}\nrows:\n  - {command: {speed_m_s: 0, \
             turn_rate_rad_s: $turn_rad_s}}\n"
                .to_owned(),
            "controller.yaml:2: `turn_rad_s.value` is NaN, expected a number from 0 to 2",
            "",
        ),
        (
            "rows:\n  - {command: {speed_m_s: 0.4, turn_rate_rad_s: 1}}\n".to_owned(),
            "controller.yaml:2: speed_m_s is 0.4, beyond the robots' limits: expected 0.02 to 0.3 m/s",
            "`actuation.speed.limits_m_s`",
        ),
        (
            "rows:\n  - {command: {left_m_s: 0.1, right_m_s: 0.1}}\n".to_owned(),
            "controller.yaml:2: `left_m_s` and `right_m_s` are wheels, and the robots' profile has no \
             `actuation.wheels`",
            "add `wheels: {base_m: …, speed_max_m_s: …}`",
        ),
        (
            "rows:\n  - {command: {left_m_s: 0.1}}\n".to_owned(),
            "controller.yaml:2: `command` has `left_m_s`, expected",
            "",
        ),
        (
            format!("rows:\n  - {{{stop}, next: {{state: start, probability: 1.5}}}}\n"),
            "controller.yaml:2: `probability` is 1.5, expected a number from 0 to 1",
            "",
        ),
        (
            format!("rows:\n  - {{{stop}, next: {{state: start, probability: 0}}}}\n"),
            "controller.yaml:2: `next` to `start` never happens: its probability is 0",
            "give it a `probability` above 0",
        ),
        (
            format!(
                "numbers: {{go: {{value: 0.5, from: 0, to: 1}}}}\nrows:\n  - {{{stop}, next: {{state: start, \
                 probability: -$go}}}}\n"
            ),
            "controller.yaml:3: `probability` is -$go, which goes from 0 to -1, expected a number from 0 to 1",
            "",
        ),
        (
            "numbers: {turn: {value: 1, from: 0, to: 2}}\nrows:\n  - {command: {speed_m_s: 0, \
             turn_rate_rad_s: $turn}}\n"
                .to_owned(),
            "controller.yaml:1: `turn` has no unit at its end, which makes it a probability, and `to` is 2",
            "a turning rate `turn_rad_s`",
        ),
        (
            format!(
                "rows:\n  - {{{stop}, next: [{{state: go}}, {{state: start}}]}}\n  - {{state: go, {go}}}\n"
            ),
            "controller.yaml:2: `next` to `start` never happens: one before it always does",
            "put it before that one",
        ),
        (
            format!("rows:\n  - {{{stop}, nex: {{state: start}}}}\n"),
            "controller.yaml:2:",
            "the keys here are: state, when, command, next",
        ),
        ("rows: []\n".to_owned(), "controller.yaml:1: there are 0 rows", ""),
    ] {
        let (error, help) = refused(&text);
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
        assert!(help.contains(cure), "{error}\n{help}");
    }
}

#[test]
fn what_wheels_cannot_do_is_refused_with_its_line() {
    let text = "rows:\n  - {command: {left_m_s: 0.1, right_m_s: 0.14}}\n";

    let (error, _) = refused_for(text, &e_puck());

    let wheels = "controller.yaml:2: with wheels of 0.1 and 0.14 m/s, 0.12 m/s at ";
    assert!(error.starts_with(wheels), "{error}");
    assert!(error.contains("of a wheel, beyond the robots' wheels"), "{error}");
    let slow = "rows:\n  - {command: {left_m_s: 0.1, right_m_s: 0.1001}}\n";
    let mut steady = e_puck();
    steady.actuation.turn.limits_rad_s[0] = 0.1;
    let (error, _) = refused_for(slow, &steady);
    let wheels = "with wheels of 0.1 and 0.1001 m/s, turn_rate_rad_s is 0.001";
    assert!(error.contains(wheels), "{error}");
}

#[test]
fn axes_that_are_not_of_the_controller_are_refused() {
    let resolve = |axis: &str, controller: Option<&str>| {
        let values = vec![(Axis::Robots, 9.0), (axis.parse().unwrap(), 0.2)];
        let controller = controller.map(parsed);
        let settings = Settings { values, controller, ..Settings::default() };
        let error = Conditions::resolve(&flockbot(), &settings).unwrap_err();
        (error.to_string(), error.help().unwrap_or_default())
    };

    let (error, help) = resolve("controller.sped_m_s", Some(MIRRORED));
    assert!(error.ends_with("table; did you mean `controller.speed_m_s`?"), "{error}");
    assert!(help.ends_with("controller.speed_m_s, controller.turn_rate_rad_s"), "{help}");
    let (error, _) = resolve("speed_m_s", Some(MIRRORED));
    assert_eq!(error, "speed_m_s is that of a controller without a table");
    let (error, help) = resolve("controller.speed_m_s", None);
    assert!(error.ends_with("and none is named"), "{error}");
    assert!(help.starts_with("name its file: `controller: "), "{help}");
    let values = vec![(Axis::Robots, 9.0), (Axis::Number(number("speed_m_s")), 0.5)];
    let controller = Some(parsed(MIRRORED));
    let settings = Settings { values, controller, ..Settings::default() };
    let error = Conditions::resolve(&flockbot(), &settings).unwrap_err().to_string();
    assert_eq!(
        error,
        "controller.speed_m_s is 0.5, expected a number from 0.02 to 0.3, its bounds in the controller"
    );
}

#[test]
fn a_table_and_its_machine_read_back_what_they_print() {
    let table = parsed(SEARCH);
    let controller = table.resolve(&[], None, 0.1).unwrap();

    let yaml: ControllerTable = serde_saphyr::from_str(&table.to_yaml()).unwrap();
    let json: Controller =
        serde_json::from_str(&serde_json::to_string(&controller).unwrap()).unwrap();

    assert_eq!(yaml, table);
    assert_eq!(json, controller);
    assert!(controller.parameters().is_none());
}

#[test]
fn conditions_with_a_machine_that_cannot_run_make_no_world() {
    let settings = Settings {
        values: vec![(Axis::Robots, 9.0)],
        controller: Some(parsed(SEARCH)),
        ..Settings::default()
    };
    let mut conditions = Conditions::resolve(&flockbot(), &settings).unwrap();
    assert_eq!(conditions.check(), Ok(()));
    let Controller::Machine(machine) = &mut conditions.controller else { unreachable!() };

    machine.rows[0].next[0].state = "nowhere".to_owned();

    let error = conditions.check().unwrap_err().to_string();
    assert_eq!(error, "controller.rows[0]: unknown state `nowhere`");
}

proptest! {
    #[test]
    fn a_table_of_one_state_commands_what_the_two_commands_of_its_rows_are(
        commands in prop::array::uniform2((-0.3..0.3, -2.5..2.5)),
        detections in prop::collection::vec(any::<bool>(), 1..50),
        sides in any::<bool>(),
    ) {
        let [seen, unseen] =
            commands.map(|(speed_m_s, turn_rate_rad_s)| Command { speed_m_s, turn_rate_rad_s });
        let row = |when: bool, command: Command| {
            let Command { speed_m_s, turn_rate_rad_s } = command;
            format!(
                "  - {{when: {{detection: {when}}}, command: {{speed_m_s: {speed_m_s}, turn_rate_rad_s: \
                 {turn_rate_rad_s}}}}}\n"
            )
        };
        let mut rows = [row(true, seen), row(false, unseen)];
        if sides {
            rows.swap(0, 1);
        }
        let mut robot = flockbot();
        robot.actuation.speed.limits_m_s[0] = 0.0;
        robot.actuation.turn.limits_rad_s[0] = 0.0;
        let text = format!("rows:\n{}{}", rows[0], rows[1]);
        let table = ControllerTable::parse("table.yaml", &text, &robot).unwrap();

        let controller = table.resolve(&[], None, 0.1).unwrap();

        let parameters = ControllerParameters::new(seen, unseen);
        prop_assert_eq!(&controller, &parameters.into());
        prop_assert_eq!(controller.digest(), parameters.digest());
        let (program, mut memory) = (controller.program(), Memory::default());
        let key = transition_key(Seed { seed: 1, replicate: 0 }, 0, 0);
        for detected in detections {
            let command = program.decide(detected.into(), &mut memory, key);
            prop_assert_eq!(command, decide(detected, parameters));
        }
    }
}

const STARTS: &str = "\
starts: {shepherd: herd, sheep: graze}
rows:
  - {state: herd, when: {detection: true}, command: {speed_m_s: 0.05, turn_rate_rad_s: 0.5}}
  - {state: herd, command: {speed_m_s: 0.15, turn_rate_rad_s: -0.5}}
  - {state: graze, command: {speed_m_s: 0.1, turn_rate_rad_s: 0.3}}
";

#[test]
fn each_class_starts_in_its_own_state_and_a_start_of_nobody_is_refused() {
    let table = parsed(STARTS);
    let controller = table.resolve(&[], None, 0.13).unwrap();
    let starts = [Some("sheep"), Some("shepherd"), Some("dog"), None];
    assert_eq!(starts.map(|class| controller.start(class).state), [1, 0, 0, 0]);
    let (error, cure) = refused(&STARTS.replace(", sheep: graze", ""));
    assert!(error.starts_with("controller.yaml:5: state `graze` is never reached"), "{error}");
    assert!(cure.contains("as in `starts: {CLASS: graze}`"), "{cure}");
    let (error, _) = refused(&STARTS.replace("sheep: graze", "sheep: grase"));
    assert_eq!(error, "controller.yaml:1: unknown state `grase`; did you mean `graze`?");

    let class = |name: &str| RobotClass { name: name.to_owned(), ..RobotClass::default() };
    let resolved = |classes: &[&str]| {
        let classes = classes.iter().map(|name| class(name)).collect();
        let world = WorldFile { classes, ..WorldFile::NOTHING };
        let values = vec![(Axis::Robots, 4.0)];
        let settings =
            Settings { values, world, controller: Some(table.clone()), ..Settings::default() };
        Conditions::resolve(&flockbot(), &settings)
    };
    let conditions = resolved(&["shepherd", "sheep"]).expect("both are there");
    let Controller::Machine(machine) = &conditions.controller else { panic!("it has states") };
    assert_eq!(machine.starts.len(), 2);
    let json = serde_json::to_string(&conditions).unwrap();
    assert_eq!(serde_json::from_str::<Conditions>(&json).unwrap(), conditions);
    let error = resolved(&["shepherd", "sheeps"]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "controller.starts has class `sheep`, and no robot is of it; did you mean `sheeps`?"
    );
    assert!(error.help().is_some_and(|help| help.contains("`classes: [{name: sheep}, …]`")));
}
