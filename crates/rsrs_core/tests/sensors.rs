//! Lists of sensors in profiles: what they come to, what is made worse of them, and what is refused with its line.

use rsrs_core::capability::{lost_capabilities, violations};
use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::conditions::{Conditions, Settings, Walls};
use rsrs_core::help::Help as _;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::sensor::Detects;

use rsrs_testing::conditions::{FLOCKBOT, flockbot};

/// One sensor of today, in a list.
const PLAIN: &str = "
  - {name: detection, cone: {half_angle_rad: 0.2, range_m: 0.75}, true_positive: 0.98, false_positive: 0.065}";

/// A sensor that tells robots from walls, and one that feels what is on the left.
const TERNARY: &str = "
  - one_of:
      - {name: detection, detects: robot, true_positive: 0.95, false_positive: 0.02, taken_for: {wall: 0.03}}
      - {name: wall, detects: wall, true_positive: 0.97, false_positive: 0.01}
    cone: {half_angle_rad: 0, range_m: 1.5}
    hidden_by: [robot]
    latency_steps: 1
  - name: left
    bearing_rad: 1.2
    sees: centre
    polygon_m: [[0, -0.2], [0.4, -0.2], [0.4, 0.2], [0, 0.2]]
    true_positive: 0.9
    false_positive: 0.05";

/// The Flockbot with a list in place of its sensor; the list begins in line 25.
fn with_sensors(list: &str) -> String {
    let (before, behind) = FLOCKBOT.split_once("sensing:\n").expect("it is shipped");
    let (_, behind) = behind.split_once("computation:").expect("it is shipped");
    format!("{before}sensors:{list}\ncomputation:{behind}")
}

fn profile(list: &str) -> RobotProfile {
    RobotProfile::parse("robot.yaml", &with_sensors(list)).expect("it is a robot")
}

fn conditions(robot: &RobotProfile) -> Conditions {
    let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 3.0)];
    Conditions::resolve(robot, &Settings { values, ..Settings::default() }).expect("a world")
}

#[test]
fn a_list_of_one_plain_sensor_is_the_profile_of_today_to_the_digest() {
    let today = flockbot();

    let listed = profile(PLAIN);

    assert_eq!(listed, today);
    assert_eq!(listed.digest(), today.digest());
    assert_eq!(conditions(&listed).digest(), conditions(&today).digest());
    assert!(serde_json::to_string(&listed).unwrap().contains("\"sensing\":{\"sees\""));
}

#[test]
fn a_list_reads_back_as_it_was_written() {
    let robot = profile(TERNARY);
    let json = serde_json::to_string(&robot).unwrap();
    let world = conditions(&robot);
    let of_world = serde_json::to_string(&world).unwrap();

    assert_eq!(serde_json::from_str::<RobotProfile>(&json).unwrap(), robot);
    assert_eq!(serde_json::from_str::<Conditions>(&of_world).unwrap(), world);
    assert_eq!(robot.reading_names().iter().collect::<Vec<_>>(), ["detection", "wall", "left"]);
    assert_ne!(robot.digest(), profile(PLAIN).digest());
    assert!((robot.reach_m() - 1.575).abs() < 1e-12, "that of the farthest: {}", robot.reach_m());
    let hidden = profile(&PLAIN.replace("cone:", "hidden_by: [robot], cone:"));
    assert_ne!(conditions(&hidden).digest(), conditions(&profile(PLAIN)).digest());
}

#[test]
fn every_sensor_is_made_worse_and_none_better() {
    let measured = profile(TERNARY);

    let factors = HarsherFactors::for_robot(&measured);
    let simulated = factors.apply(&measured).expect("they make it worse");

    assert_eq!(simulated.check(), Ok(()));
    let sensors: Vec<_> = simulated.sensors().map(|(_, sensing)| sensing.clone()).collect();
    // The least certain reading sets the factor: 0.9 × 0.8 = 0.72 is left, which misses 2.8 times as often.
    assert!((factors.miss_factor - 2.8).abs() < 1e-12, "{factors:?}");
    assert!((sensors[0].true_positive - 0.86).abs() < 1e-9, "{:?}", sensors[0]);
    assert!((sensors[0].details.taken_for["wall"] - 0.084).abs() < 1e-9, "{:?}", sensors[0]);
    assert!((sensors[0].details.or[0].true_positive - 0.916).abs() < 1e-9);
    assert!((sensors[1].true_positive - 0.72).abs() < 1e-9);
    assert_eq!(sensors.iter().map(|it| it.latency_steps).collect::<Vec<_>>(), [2, 1]);
    assert!((sensors[1].polygon_m.as_ref().unwrap()[1][0] - 0.38).abs() < 1e-9);
    assert_eq!(violations(&measured, &conditions(&simulated)).unwrap(), []);
    assert_eq!(lost_capabilities(&measured, &simulated), []);
    let mut better = conditions(&measured);
    better.robot.details.or[0].true_positive = 0.99;
    better.robot.further_sensors[0].false_positive = 0.0;
    let found = violations(&measured, &better).unwrap();
    let named: Vec<_> = found.iter().map(|violation| &*violation.capability).collect();
    assert_eq!(
        named,
        ["reading `wall`: true positive rate", "reading `left`: false positive rate"]
    );
    let wild = HarsherFactors { false_positive_factor: 1000.0, miss_factor: 1000.0, ..factors };
    assert_eq!(wild.apply(&measured).unwrap().check(), Ok(()), "one thing is reported at a time");
}

#[test]
fn a_list_that_cannot_be_is_refused_with_line_reason_and_cure() {
    let with = |from: &str, to: &str| {
        assert!(TERNARY.contains(from), "{from}");
        TERNARY.replace(from, to)
    };
    let first = "robot.yaml:25: ";
    let second = "robot.yaml:31: ";
    for (list, place, reason, cure) in [
        (" []".to_owned(), "robot.yaml:1: ", "`sensors` is an empty list", "give a sensor"),
        (with("name: left", "name: detection"), second, "name of two readings", "another name"),
        (with("name: left", "name: Left-1"), second, "`Left-1` is no name", "write it as `left_1`"),
        (with("name: left", "detects: robot"), second, "missing key `name`", "give `name:"),
        (with("    true_positive: 0.9\n", ""), second, "missing key `true_positive`", "give `true"),
        (with("true_positive: 0.9\n", "true_positive: 9\n"), second, "`true_positive` is 9,", ""),
        (with("bearing_rad: 1.2", "bearing_rad: 90"), second, "`bearing_rad` is 90,", ""),
        (with("[0, 0.2]]", "[0.3, 0]]"), second, "`polygon_m` has 4 corners", "left turn after"),
        (with("name: detection", "name: ahead"), first, "`ahead`, expected `detection`", "put the"),
        (with("range_m: 1.5", "range_m: 0"), first, "`range_m` is 0,", ""),
        (
            with("angle_rad: 0", "angle_rad: 2"),
            first,
            "expected from 0, a line of sight, to 1.5",
            "",
        ),
        (with("{wall: 0.03}", "{wal: 0.03}"), first, "did you mean `wall`?", "name what else"),
        (with("{wall: 0.03}", "{wall: 0.3}"), first, "where a robot is, something", "lower"),
        (
            with("false_positive: 0.02", "false_positive: 0.995"),
            first,
            "where nothing is,",
            "lower",
        ),
        (with("detects: wall", "detects: robot"), first, "both detect `robot`", "leave one"),
        (
            with("    latency", "    true_positive: 0.5\n    latency"),
            first,
            "beside `one_of`",
            "move",
        ),
        (
            with("cone: {half_angle_rad: 0, range_m: 1.5}", "sees: body"),
            first,
            "exactly one of",
            "give",
        ),
    ] {
        let error = RobotProfile::parse("robot.yaml", &with_sensors(&list)).expect_err(reason);

        let (text, help) = (error.to_string(), error.help().unwrap_or_default());
        assert!(text.starts_with(place) && text.contains(reason), "{reason}: {text}");
        assert!(help.contains(cure) && help.is_empty() == cure.is_empty(), "{reason}: {help}");
    }
    let one = "\n  - {name: X, true_positive: 1, false_positive: 0, cone: {half_angle_rad: 1, range_m: 1}}";
    let nine: Vec<String> = (0..9)
        .map(|place| {
            one.replace('X', if place == 0 { "detection" } else { &"abcdefghi"[place..=place] })
        })
        .collect();
    let error = RobotProfile::parse("robot.yaml", &with_sensors(&nine.concat())).unwrap_err();
    assert_eq!(
        error.to_string(),
        "robot.yaml:33: the readings of all sensors are 9, expected at most 8"
    );
}

#[test]
fn kinds_that_include_each_other_are_none_to_tell_apart() {
    for (kinds, shared) in [(["robot", "kin"], "kin"), (["other", "robot"], "other")] {
        let list = TERNARY
            .replace("detects: robot", &format!("detects: {}", kinds[0]))
            .replace("detects: wall", &format!("detects: {}", kinds[1]));
        let error = RobotProfile::parse("robot.yaml", &with_sensors(&list)).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("robot.yaml:25: `detection` and `wall` both detect `{shared}`")
        );
    }
    let list = TERNARY.replace("detects: robot", "detects: kin");
    let robot = profile(&list.replace("detects: wall", "detects: other"));
    assert!((robot.reach_m() - 1.575).abs() < 1e-12, "to robots of whatever class");
    let list = TERNARY.replace("detects: wall", "detects: kins");
    let text = RobotProfile::parse("robot.yaml", &with_sensors(&list)).unwrap_err().to_string();
    assert!(text.starts_with("robot.yaml:27:") && text.contains("`kins`"), "{text}");
}

#[test]
fn a_profile_has_one_sensor_or_a_list() {
    let both = FLOCKBOT.replace("sensing:\n", &format!("sensors:{PLAIN}\nsensing:\n"));
    let error = RobotProfile::parse("robot.yaml", &both).unwrap_err();
    assert_eq!(error.to_string(), "a profile needs exactly one of `sensing` and `sensors`");
    assert!(error.help().unwrap().contains("`sensors` for a list"));
}

#[test]
fn walls_are_detected_where_there_are_some() {
    let robot = profile(TERNARY);
    let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 3.0)];
    let open = Settings { values, walls: Walls::None, ..Settings::default() };

    let error = Conditions::resolve(&robot, &open).unwrap_err();

    assert_eq!(error.to_string(), "sensor `detection` detects walls, and there are none");
    assert!(error.help().unwrap().contains("`walls: stop`"));
}

#[test]
fn a_table_answers_every_case_that_its_robots_can_report() {
    let robot = profile(TERNARY);
    let parse = |rows: &str| ControllerTable::parse("table.yaml", rows, &robot);
    let row = |when: &str, turn: f64| {
        format!("  - {{when: {{{when}}}, command: {{speed_m_s: 0.1, turn_rate_rad_s: {turn}}}}}\n")
    };
    // Robot and wall together cannot be, as one sensor reports one of them.
    let rows = [
        row("detection: true, wall: false", 0.5),
        row("wall: true, detection: false", -0.5),
        row("detection: false, wall: false, left: true", 1.0),
        row("detection: false, wall: false, left: false", 2.0),
    ];
    let whole = format!("rows:\n{}", rows.concat());

    let table = parse(&whole).expect("it answers every case");
    let values = vec![(Axis::Robots, 3.0)];
    let settings = Settings { values, controller: Some(table), ..Settings::default() };
    let conditions = Conditions::resolve(&robot, &settings).expect("a world");
    let Controller::Machine(machine) = &conditions.controller else {
        panic!("it decides by more than one reading: {:?}", conditions.controller);
    };
    assert_eq!(machine.sensors, robot.reading_names());
    let again = serde_json::from_str::<Conditions>(&serde_json::to_string(&conditions).unwrap());
    assert_eq!(again.unwrap().check(), Ok(()));

    let without = format!("rows:\n{}", rows[..3].concat());
    let error = parse(&without).unwrap_err();
    let case = "state `start` has no row for `detection: false, wall: false, left: false`";
    assert_eq!(error.to_string(), format!("table.yaml:2: {case}"));
    let never = format!("{whole}{}", row("detection: true, wall: true", 0.2));
    let error = parse(&never).unwrap_err().to_string();
    assert!(error.starts_with("table.yaml:6: this row never matches"), "{error}");
    let unknown = parse(&whole.replace("left", "lft")).unwrap_err();
    assert_eq!(unknown.to_string(), "table.yaml:4: unknown sensor `lft`; did you mean `left`?");
    assert_eq!(unknown.help().unwrap(), "these robots report `detection`, `wall`, `left`");

    let mut other = conditions;
    other.robot.further_sensors.clear();
    let error = other.check().unwrap_err().to_string();
    assert_eq!(error, "controller.sensors are not what the robots report: detection, wall");
    assert_eq!(robot.sensing.details.hidden_by, [Detects::Robot]);
}
