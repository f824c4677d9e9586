//! A virtual fleet, measured over DDS.

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use super::{number, read, trials, write};
use crate::command::{code, done, json, repository, rsrs, run_line, shipped, stderr, stdout};
use crate::processes::Process;

/// One trial of one virtual robot; the command goes into a network of its own.
fn drive(folder: &Path, robot: &str, rest: &[&str]) -> Output {
    let fleet = shipped("fleets/nine_virtual.yaml");
    rsrs(folder, &[&["measure", "drive", &fleet, "--robot", robot], rest].concat())
}

/// What `rsrs measure plan` prints of trials with one speed and one turning rate.
struct Planned {
    robots: Vec<String>,
    repetitions: usize,
    speed: String,
    turn_rate: String,
}

fn planned(folder: &Path) -> Planned {
    let fleet = shipped("fleets/nine_virtual.yaml");
    let options =
        ["--robots", "3", "--commands", "1", "--speed", "0.05,0.15", "--turn-rate", "0.5,1.0"];
    let rest = ["--precision", "0.032", "--format", "json"];
    let output = rsrs(folder, &[&["measure", "plan", &fleet], &options[..], &rest].concat());
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

/// Keeps every second distance and bearing of a planned table, and all rows without a neighbour.
fn coarse(table: &str) -> String {
    let rows: Vec<[&str; 3]> = table
        .lines()
        .skip(1)
        .map(|row| {
            let mut fields = row.split(',').skip(1);
            [row, fields.next().expect("a distance"), fields.next().expect("a bearing")]
        })
        .collect();
    let every_second = |column: usize| -> Vec<&str> {
        let mut values: Vec<&str> = Vec::new();
        for value in rows.iter().map(|row| row[column]).filter(|value| !value.is_empty()) {
            if !values.contains(&value) {
                values.push(value);
            }
        }
        values.into_iter().step_by(2).collect()
    };
    let (distances, bearings) = (every_second(1), every_second(2));
    let is_kept = |row: &&[&str; 3]| {
        row[1].is_empty() || (distances.contains(&row[1]) && bearings.contains(&row[2]))
    };
    let kept: Vec<&str> = rows.iter().filter(is_kept).map(|row| row[0]).collect();
    format!("{}\n{}\n", table.lines().next().expect("a header"), kept.join("\n"))
}

/// How far from the robot the Flockbot's sensor, as it is simulated, detects a body at a bearing.
///
/// A cone of 0.2 rad and 0.75 m, and bodies of 0.075 m of which any part may lie in it.
fn reach_m(bearing_rad: f64) -> f64 {
    let beyond_rad = bearing_rad.abs() - 0.2;
    let by_side_m = if beyond_rad > 0.0 { 0.075 / libm::sin(beyond_rad) } else { f64::INFINITY };
    by_side_m.min(0.75 + 0.075)
}

/// Whether an interval of a report holds a number.
fn holds(estimate: &serde_json::Value, truth: f64) -> bool {
    number(&estimate["low"]) <= truth && truth <= number(&estimate["high"])
}

/// Whether a rate's interval holds a number. One interval of 95 % in twenty misses; those of 99.9 % are
/// 1.68 times as wide.
fn nearly_holds(rate: &serde_json::Value, truth: f64) -> bool {
    let width = number(&rate["high"]) - number(&rate["low"]);
    (number(&rate["value"]) - truth).abs() < 1.68 * width / 2.0
}

/// Fills in the detection trials of a plan on a coarse grid, over DDS.
fn detections(folder: &Path) {
    let fleet = shipped("fleets/nine_virtual.yaml");
    let planned = rsrs(folder, &["measure", "plan", &fleet, "--robots", "2", "-o", "planned"]);
    assert_eq!(code(&planned), 0, "{}", stderr(&planned));
    write(folder, "detection.csv", coarse(&read(folder, "planned/detection.csv")));
    let arguments = [
        "measure",
        "drive",
        &fleet,
        "--template",
        "detection.csv",
        "--backend",
        "sim",
        "--seed",
        "7",
    ];

    let filled = rsrs(folder, &arguments);
    let table = read(folder, "detection.csv");
    let again = rsrs(folder, &arguments);

    assert_eq!(code(&filled), 0, "{}", stderr(&filled));
    // 5 distances, 5 bearings, and each of the robots alone.
    assert!(stdout(&filled).contains("27 rows filled in, 0 left"), "{}", stdout(&filled));
    assert!(stdout(&again).contains("0 rows filled in, 0 left"), "{}", stdout(&again));
    assert_eq!(read(folder, "detection.csv"), table);
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
            let rest = [flag, command, "--duration", "20", "--seed", &seed, "-o", &bag];
            let rest = [&rest[..], &["--table", &table, "--backend", "sim"]].concat();

            let output = drive(place.path(), robot, &rest);

            assert_eq!(code(&output), 0, "{bag}: {}{}", stdout(&output), stderr(&output));
            bags.push(bag);
        }
    }

    detections(place.path());
    let mut arguments = vec!["measure", "fit", "--detection", "detection.csv", "--name", "virtual"];
    arguments.extend(["--format", "json", "--bags"]);
    arguments.extend(bags.iter().map(String::as_str));
    let from_bags = rsrs(place.path(), &arguments);
    let line = "measure fit --speed driven_straight.csv --turn driven_turn.csv --detection detection.csv \
                --name virtual --format json";
    let from_tables = run_line(place.path(), line);

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
        let sensor = &details["sensor"];
        assert!(nearly_holds(&sensor["true_positive"], 0.98), "{sensor}");
        assert!(nearly_holds(&sensor["false_positive"], 0.065), "{sensor}");
        let contour = sensor["contour_m"].as_array().expect("points").iter();
        let contour = contour.map(|point| (number(&point[0]), number(&point[1])));
        let bearings: Vec<f64> = contour
            .filter(|(x_m, _)| *x_m > 0.0)
            .map(|(x_m, y_m)| {
                let bearing_rad = libm::atan2(y_m, x_m);
                // The edge is determined to the distance of two places.
                let off_m = libm::hypot(x_m, y_m) - reach_m(bearing_rad);
                assert!(off_m.abs() < 0.197, "{off_m} m at {bearing_rad} rad: {sensor}");
                bearing_rad
            })
            .collect();
        assert_eq!(bearings.len(), 5, "{sensor}");
        let drift = &details["drift"];
        assert!(number(&drift["bias_sd_rad_s"]["value"]) < 1e-3, "{drift}");
    }
    let period_s = number(&json(&from_bags)["period_s"]);
    assert!((period_s - 0.13).abs() < 1e-6, "{period_s}");
    assert_eq!(read(place.path(), "driven_turn.csv").lines().count(), 13);
}

/// Rows of a table that have their last result.
fn n_done(table: &str, column: usize) -> usize {
    let rows = table.lines().skip(1);
    rows.filter(|row| row.split(',').nth(column).is_some_and(|field| !field.is_empty())).count()
}

#[test]
fn a_plan_that_is_killed_goes_on_with_the_rows_that_are_left() {
    let place = trials();
    let fleet = shipped("fleets/nine_virtual.yaml");
    let plan = ["measure", "plan", &fleet, "--robots", "2", "--commands", "1", "--track", "1"];
    let coarse = ["--speed", "0.1,0.2", "--turn-rate", "0.5,1.5", "--precision", "0.05"];
    let grid = ["--distances", "4", "--bearings", "3", "--rate-precision", "0.2", "-o", "trials"];
    done(place.path(), &[&plan[..], &coarse, &grid].concat());
    let arguments =
        ["measure", "drive", &fleet, "--plan", "trials", "--backend", "sim", "--seed", "3"];
    let speed = || read(place.path(), "trials/speed.csv");

    let mut killed = crate::processes::rsrs();
    killed.current_dir(place.path()).args(arguments);
    let mut killed = Process::start(&mut killed);
    let start = Instant::now();
    while n_done(&speed(), 3) < 2 {
        assert!(start.elapsed() < Duration::from_secs(300), "{}", speed());
        std::thread::sleep(Duration::from_millis(5));
    }
    killed.0.kill().expect("it is our child");
    killed.0.wait().expect("it is our child");
    let before = speed();
    let output = done(place.path(), &arguments);
    assert!(output.contains(" rows filled in, 0 left"), "{output}");
    let done = |row: &&str| row.split(',').nth(3).is_some_and(|field| !field.is_empty());
    for row in before.lines().filter(done) {
        assert!(speed().contains(row), "{row} was measured again:\n{}", speed());
    }
    for (table, column, n_rows) in
        [("speed", 3, 6), ("turn", 3, 6), ("arcs", 4, 6), ("detection", 4, 14), ("period", 1, 40)]
    {
        let text = read(place.path(), &format!("trials/{table}.csv"));
        assert_eq!(n_done(&text, column), n_rows, "{table}: {text}");
        assert_eq!(text.lines().count(), n_rows + 1, "{table}: {text}");
    }
    let fitted = rsrs(
        place.path(),
        &["measure", "fit", "--plan", "trials", "--name", "v", "-o", "v.yaml", "--format", "json"],
    );
    assert_eq!(code(&fitted), 0, "{}", stderr(&fitted));
    let details = &json(&fitted)["details"];
    // Virtual robots of the Flockbot's profile turn alike while they drive, and without a lag.
    assert!(holds(&details["arc"]["by_command"][0]["gain"], 0.97), "{details}");
    assert!(read(place.path(), "v.yaml").contains("driving_gain_by_command"));
    assert!(read(place.path(), "v.yaml").contains("yaw_lag_s: 0"), "{}", details["yaw_lag"]);
}

#[test]
fn a_plan_needs_no_profile_and_no_fleet() {
    let place = trials();
    write(
        place.path(),
        "fleet.yaml",
        "fileversion: 1\nall: {driver: {kind: ros}, lease: controller}\nrobots:\n  a: {enabled: true}\n",
    );

    let of_fleet = rsrs(place.path(), &["measure", "plan", "fleet.yaml", "-o", "one"]);
    let of_limits = ["measure", "plan", "--robots", "2", "--speed", "0.1,0.2"];
    let of_limits = rsrs(place.path(), &[&of_limits[..], &["-o", "two"]].concat());
    let simulated = ["measure", "drive", "fleet.yaml", "--robot", "a", "--alone"];
    let simulated = rsrs(place.path(), &simulated);

    assert_eq!([&of_fleet, &of_limits, &simulated].map(code), [0, 0, 1]);
    assert!(read(place.path(), "one/speed.csv").contains("\na,0.02,2,,,,,\n"));
    assert!(read(place.path(), "two/arcs.csv").contains("\nrobot_2,0.15,"));
    let printed = stderr(&simulated);
    assert!(
        printed.contains("a has no `profile`, so it cannot be simulated; with `--backend fleet`"),
        "{printed}"
    );
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
fn a_detection_trial_that_cannot_be_is_refused_before_anything_is_placed() {
    let place = trials();
    let header = "robot,distance_m,bearing_rad,samples,detections\n";
    write(place.path(), "near.csv", format!("{header}robot_1,0.3,0,70,\nrobot_1,0.1,0,70,\n"));
    let fleet = shipped("fleets/nine_virtual.yaml");

    let fill = ["measure", "drive", &fleet, "--backend", "sim", "--template"];

    let near = drive(place.path(), "robot_1", &["--distance", "0.1", "--bearing", "0"]);
    let nowhere = drive(place.path(), "robot_1", &["--distance", "0.3"]);
    let table = rsrs(place.path(), &[&fill[..], &["near.csv"]].concat());
    let other = rsrs(place.path(), &[&fill[..], &["period.csv"]].concat());

    assert_eq!([&near, &nowhere, &table, &other].map(code), [1, 2, 1, 1]);
    let expected = "the neighbour is 0.1 m away, expected 0.15 m or more";
    assert!(stderr(&near).contains(expected), "{}", stderr(&near));
    assert!(stderr(&table).contains("near.csv:3"), "{}", stderr(&table));
    assert!(stderr(&table).contains(expected), "{}", stderr(&table));
    assert!(stderr(&other).contains("period.csv:1: the header is"), "{}", stderr(&other));
    assert!(read(place.path(), "near.csv").contains("robot_1,0.3,0,70,\n"), "nothing was measured");
}

#[test]
fn a_full_disk_loses_no_row_of_a_table() {
    let place = trials();
    let fleet = repository().join("launch_configs/fleets/nine_virtual.yaml");
    // A disk that is as good as full, in a namespace of its own.
    let script = "set -e; mkdir disk; mount -t tmpfs -o size=16k tmpfs disk
        cp before.csv disk/speed.csv; dd if=/dev/zero of=disk/filler bs=1k 2> /dev/null || true
        code=0
        \"$0\" measure drive \"$1\" --robot robot_1 --speed 0.1 --duration 3 -o bag \\
            --backend sim --table disk/speed.csv 2> printed || code=$?
        cp disk/speed.csv after.csv; ls -A disk > left; exit $code";
    let header = "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad";
    write(place.path(), "before.csv", format!("{header}\n{}", "robot_2,0.1,1.02,,,\n".repeat(40)));

    let output = Command::new("unshare")
        .args(["--map-root-user", "--mount", "--", "sh", "-c", script])
        .args([env!("CARGO_BIN_EXE_rsrs"), fleet.to_str().expect("the path is UTF-8")])
        .current_dir(place.path())
        .output()
        .expect("unshare is there");

    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert_eq!(read(place.path(), "after.csv"), read(place.path(), "before.csv"));
    assert_eq!(read(place.path(), "left"), "filler\nspeed.csv\n");
    let printed = read(place.path(), "printed");
    assert!(
        printed.contains("the row of this trial is not in the table: `robot_1,0.1,"),
        "{printed}"
    );
    assert!(printed.contains("speed.csv; it is as it was"), "{printed}");
    assert!(printed.contains("No space left on device"), "{printed}");
}

/// The text of a picture, whose lines are elements of their own.
fn words_of_picture(svg: &str) -> String {
    let outside = svg.split('<').filter_map(|part| part.split_once('>').map(|(_, text)| text));
    outside.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

#[test]
fn what_the_simulator_drove_is_marked_wherever_it_goes() {
    let place = trials();
    for (flag, command, name) in
        [("--speed", "0.15", "straight"), ("--turn-rate", "0.75", "turned")]
    {
        let table = format!("{name}.csv");
        let trial = [flag, command, "--duration", "20", "-o", name, "--table", &table];
        let output = drive(place.path(), "robot_1", &[&trial[..], &["--backend", "sim"]].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(read(place.path(), &table).ends_with(",sim\n"), "{}", stdout(&output));
    }
    let by_hand = read(place.path(), "detection.csv");
    let header = by_hand.lines().next().expect("a header");
    let rows: Vec<String> = by_hand.lines().skip(1).map(|row| format!("{row},sim\n")).collect();
    write(place.path(), "sensed.csv", format!("{header},backend\n{}", rows.concat()));
    write(place.path(), "bad.csv", format!("{header},backend\nrobot_1,0.3,0,70,60,floor\n"));
    let fit = |detection: &str, rest: &[&str]| {
        let tables = ["--speed", "straight.csv", "--turn", "turned.csv", "--detection", detection];
        rsrs(place.path(), &[&["measure", "fit", "--name", "x"], &tables[..], rest].concat())
    };

    let all = fit("sensed.csv", &["-o", "all.yaml", "--pictures", "pictures"]);
    let bags = [&["--bags", "straight", "turned", "--detection", "sensed.csv"][..]].concat();
    let bags = rsrs(place.path(), &[&["measure", "fit", "--name", "x"], &bags[..]].concat());
    let mixture = fit("detection.csv", &["-o", "mixture.yaml"]);
    let mixed = fit("detection.csv", &["-o", "mixed.yaml", "--mixed"]);
    let neither = fit("bad.csv", &[]);

    for output in [&all, &bags] {
        assert_eq!(code(output), 0, "{}", stderr(output));
        assert!(stdout(output).contains("trials of the simulator:"), "{}", stdout(output));
    }
    let profile = read(place.path(), "all.yaml");
    assert!(profile.contains("trials: simulated"), "{profile}");
    assert!(profile.contains("fitted to trials of the simulator: straight.csv"), "{profile}");
    for picture in ["pictures/speeds.svg", "pictures/sensor.svg"] {
        let words = words_of_picture(&read(place.path(), picture));
        assert!(words.contains("trials of the simulator"), "{picture}: {words}");
    }
    assert_eq!(code(&mixture), 1);
    assert!(stderr(&mixture).contains("are of the simulator, the others"), "{}", stderr(&mixture));
    assert!(!place.path().join("mixture.yaml").exists());
    assert_eq!(code(&mixed), 0, "{}", stderr(&mixed));
    assert!(read(place.path(), "mixed.yaml").contains("trials: partly_simulated"));
    assert!(
        stderr(&neither).contains("bad.csv:2: backend is `floor`, expected `sim`, `fleet`"),
        "{}",
        stderr(&neither)
    );

    let sweep = "profile: all.yaml\naxes: {speed_m_s: [0.15], turn_rate_rad_s: [0.5, 0.75]}\n\
                 fixed: {robots: 5}\nreplicates: 4\nduration_s: 70\nseed: 3\n";
    write(place.path(), "sweep.yaml", sweep);
    let swept = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let validate = ["validate", "out", "--robots", "200", "--trajectories", "straight"];
    let refused = rsrs(place.path(), &validate);
    let note = "profile was fitted to trials of the simulator";
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    assert!(read(place.path(), "out/diagram.svg").contains(note));
    assert_eq!(code(&refused), 1);
    assert!(stderr(&refused).contains("moved by the simulator"), "{}", stderr(&refused));
    let told = rsrs(place.path(), &[&validate[..], &["--simulated"]].concat());
    assert_ne!(code(&told), 1, "{}", stderr(&told));
    assert!(stdout(&told).contains("nothing is validated by them"), "{}", stdout(&told));
    let diagram = read(place.path(), "out/diagram.svg");
    assert!(diagram.contains("not validated: held against trials of the simulator"), "{diagram}");
    assert!(read(place.path(), "out/reach_1.svg").contains("trials of the simulator"));

    let info = rsrs(place.path(), &["bag", "info", "straight"]);
    assert!(stdout(&info).contains("robots moved by: the simulator"), "{}", stdout(&info));
}

#[test]
fn trials_of_the_simulator_are_not_added_to_those_of_robots() {
    let place = trials();
    let header = "robot,distance_m,bearing_rad,samples,detections";
    let (by_hand, by_sim) = ("robot_1,0.3,0,70,60", "robot_1,0.3,0,70,60,sim");
    write(place.path(), "hand.csv", format!("{header}\n{by_hand}\nrobot_1,0.4,0,70,\n"));
    write(place.path(), "sim.csv", format!("{header},backend\n{by_sim}\nrobot_1,0.4,0,70,,\n"));
    let fleet = shipped("fleets/nine_virtual.yaml");
    let real = "fileversion: 1\nall: {driver: {kind: ros}}\nrobots: {robot_1: {enabled: true}}\n";
    write(place.path(), "fleet.yaml", real);
    let alone = ["--distance", "0.4", "--bearing", "0", "--backend", "sim", "--table", "hand.csv"];

    let unnamed = rsrs(place.path(), &["measure", "drive", &fleet, "--template", "hand.csv"]);
    let onto_hand = ["measure", "drive", &fleet, "--template", "hand.csv", "--backend", "sim"];
    let onto_hand = rsrs(place.path(), &onto_hand);
    let added = drive(place.path(), "robot_1", &alone);
    let onto_sim = ["measure", "drive", "fleet.yaml", "--template", "sim.csv"];
    let onto_sim = [&onto_sim[..], &["--backend", "fleet", "--interface", "127.0.0.1"]].concat();
    let onto_sim = rsrs(place.path(), &onto_sim);

    assert_eq!(code(&unnamed), 2);
    assert!(stderr(&unnamed).contains("--backend <BACKEND>"), "{}", stderr(&unnamed));
    for output in [&onto_hand, &added] {
        assert_eq!(code(output), 1);
        let expected = "hand.csv:2 is a trial of a robot, or made by hand";
        assert!(stderr(output).contains(expected), "{}", stderr(output));
    }
    assert_eq!(code(&onto_sim), 1);
    let expected = "sim.csv:2 is a trial of the simulator, expected one of a robot";
    assert!(stderr(&onto_sim).contains(expected), "{}", stderr(&onto_sim));
}

#[test]
fn a_fleet_is_not_driven_by_accident() {
    let place = trials();

    let output = drive(
        place.path(),
        "robot_1",
        &["--speed", "0.1", "--duration", "20", "--backend", "fleet"],
    );

    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("no network interface is chosen"), "{}", stderr(&output));
}
