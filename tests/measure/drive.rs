//! A virtual fleet, measured over DDS.

use std::path::Path;
use std::process::Output;

use rsrs_bags::Bag;
use rsrs_msgs::cdr;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;

use super::{code, json, number, read, repository, rsrs, stderr, stdout, trials, write};

/// One trial of one virtual robot; the command goes into a network of its own.
fn drive(folder: &Path, robot: &str, rest: &[&str]) -> Output {
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    let fleet = fleet.to_str().expect("the path is UTF-8").to_owned();
    rsrs(folder, &[&["measure", "drive", &fleet, "--robot", robot], rest].concat())
}

/// What `rsrs measure plan` says of trials with one speed and one turning rate.
struct Planned {
    robots: Vec<String>,
    repetitions: usize,
    speed: String,
    turn_rate: String,
}

fn planned(folder: &Path) -> Planned {
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    let fleet = fleet.to_str().expect("the path is UTF-8").to_owned();
    let wish =
        ["--robots", "3", "--commands", "1", "--speed", "0.05,0.15", "--turn-rate", "0.5,1.0"];
    let rest = ["--precision", "0.032", "--format", "json"];
    let output = rsrs(folder, &[&["measure", "plan", &fleet], &wish[..], &rest].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let plan = json(&output);
    let robots = plan["robots"].as_array().expect("robots").iter();
    Planned {
        robots: robots.map(|name| name.as_str().expect("a name").to_owned()).collect(),
        repetitions: plan["repetitions"]
            .as_u64()
            .and_then(|n| n.try_into().ok())
            .expect("a small whole number"),
        speed: plan["speeds_m_s"][0].to_string(),
        turn_rate: plan["turn_rates_rad_s"][0].to_string(),
    }
}

/// What a robot's sensor said in its trials, where it was alone: every detection is a false one.
fn false_positives(folder: &Path, (robot, bags): (&str, &[String])) -> String {
    let (mut samples, mut detections) = (0, 0);
    for bag in bags {
        let bag = Bag::open(&folder.join(bag)).expect("the bag was closed");
        for message in bag.messages_on([topics::DETECTION.for_robot(robot)]) {
            let message = message.expect("the bag is whole");
            let said: Bool = cdr::decode(&message.bytes).expect("a detection");
            samples += 1;
            detections += u32::from(said.data);
        }
    }
    format!("{robot},,,{samples},{detections}\n")
}

/// Whether an interval of a report holds a number.
fn holds(estimate: &serde_json::Value, truth: f64) -> bool {
    number(&estimate["low"]) <= truth && truth <= number(&estimate["high"])
}

#[test]
fn a_virtual_fleet_gives_back_the_profile_that_it_was_simulated_with() {
    let place = trials();
    let plan = planned(place.path());
    let mut bags = Vec::new();
    for trial in 0..plan.robots.len() * plan.repetitions {
        let (robot, seed) = (&plan.robots[trial % plan.robots.len()], (trial + 1).to_string());
        for (kind, flag, command) in
            [("straight", "--speed", &plan.speed), ("turn", "--turn-rate", &plan.turn_rate)]
        {
            let (bag, table) = (format!("{kind}_{seed}"), format!("driven_{kind}.csv"));
            let rest =
                [flag, command, "--duration", "20", "--seed", &seed, "-o", &bag, "--table", &table];

            let output = drive(place.path(), robot, &rest);

            assert_eq!(code(&output), 0, "{bag}: {}{}", stdout(&output), stderr(&output));
            bags.push(bag);
        }
    }

    // Places of neighbours are from the table; what is detected without one is from the trials.
    let table = read(place.path(), "detection.csv");
    let with_neighbour = table.lines().filter(|row| !row.contains(",,,"));
    let mut detection = with_neighbour.collect::<Vec<_>>().join("\n") + "\n";
    for robot in &plan.robots {
        detection.push_str(&false_positives(place.path(), (robot, &bags)));
    }
    write(place.path(), "detection.csv", detection);

    let mut arguments = vec!["measure", "fit", "--detection", "detection.csv", "--name", "virtual"];
    arguments.extend(["--format", "json", "--bags"]);
    arguments.extend(bags.iter().map(String::as_str));
    let from_bags = rsrs(place.path(), &arguments);
    let from_tables = rsrs(
        place.path(),
        &[
            "measure",
            "fit",
            "--speed",
            "driven_straight.csv",
            "--turn",
            "driven_turn.csv",
            "--detection",
            "detection.csv",
            "--name",
            "virtual",
            "--format",
            "json",
        ],
    );

    assert_eq!(code(&from_bags), 0, "{}", stderr(&from_bags));
    assert_eq!(code(&from_tables), 0, "{}", stderr(&from_tables));
    for report in [json(&from_bags), json(&from_tables)] {
        let details = &report["details"];
        let (speed, turn) = (&details["speed"], &details["turn"]);
        // The Flockbot's profile: gains of 0.971 and 0.97, spread 0.02, no drift, 0.13 s. The spread of
        // virtual robots is drawn for each trial.
        assert_eq!((&speed["n_trials"], &turn["n_trials"]), (&12.into(), &12.into()));
        assert!(holds(&speed["by_command"][0]["gain"], 0.971), "{speed}");
        assert!(holds(&turn["by_command"][0]["gain"], 0.97), "{turn}");
        assert!(holds(&speed["trial_sd"], 0.02), "{speed}");
        assert!(holds(&turn["trial_sd"], 0.02), "{turn}");
        let alarm = &details["sensor"]["false_positive"];
        // One interval of 95 % in twenty misses, as this one does; those of 99.9 % are 1.68 times as wide.
        let away = (number(&alarm["value"]) - 0.065).abs();
        let width = number(&alarm["high"]) - number(&alarm["low"]);
        assert!(away < 1.68 * width / 2.0 && number(&alarm["samples"]) > 3000.0, "{alarm}");
        let drift = &details["drift"];
        assert!(number(&drift["bias_sd_rad_s"]["value"]) < 1e-3, "{drift}");
    }
    let period_s = number(&json(&from_bags)["period_s"]);
    assert!((period_s - 0.13).abs() < 1e-6, "{period_s}");
    assert_eq!(read(place.path(), "driven_turn.csv").lines().count(), 13);
}

#[test]
fn a_trial_that_cannot_be_driven_is_refused_before_anything_moves() {
    let place = trials();
    for (robot, rest, expected) in [
        ("robot_10", ["--speed", "0.1", "--duration", "20"], "has no robot `robot_10`"),
        ("robot_1", ["--speed", "0", "--duration", "20"], "speed and turning rate are both 0"),
        ("robot_1", ["--speed", "0.1", "--duration", "1"], "the trial lasts 1 s, expected 2.6 s"),
        (
            "robot_1",
            ["--speed", "-0.1", "--duration", "20"],
            "the speed is -0.1 m/s, expected 0 m/s",
        ),
    ] {
        let output = drive(place.path(), robot, &rest);

        assert_eq!(code(&output), 1, "{expected}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
}

#[test]
fn a_fleet_is_not_driven_by_accident() {
    let place = trials();

    let output = drive(
        place.path(),
        "robot_1",
        &["--speed", "0.1", "--duration", "20", "--backend", "fleet"],
    );

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("no network interface is chosen"), "{}", stderr(&output));
}
