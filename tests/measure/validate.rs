//! Real trajectories against the simulated reach.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::{ActuationGain, Pose, step};

use super::{number, read, write};
use crate::command::{bring, code, json, rsrs, shipped, stderr, stdout};

/// What is different about some robots.
struct Robots {
    command: Command,
    /// Times the speed of the first of five robots, the second, and so on.
    faster: [f64; 5],
    bias_rad_s: f64,
}

const CURVE: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };
const STRAIGHT: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.0 };
/// Gains of five robots that the measured profile (0.971, spread 0.02) could have.
const GAINS: [f64; 5] = [0.955, 0.98, 0.971, 0.99, 0.962];

/// Three trials of each robot, of 20 s.
fn trajectories(robots: &Robots) -> String {
    let mut csv =
        "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s\n".to_owned();
    let Command { speed_m_s, turn_rate_rad_s } = robots.command;
    for (robot, (gain, faster)) in GAINS.iter().zip(robots.faster).enumerate() {
        let gain = ActuationGain { speed: gain * faster, turn: 0.97 };
        let driven = Command { turn_rate_rad_s: turn_rate_rad_s + robots.bias_rad_s, speed_m_s };
        for trial in 1..=3 {
            let mut pose = Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.3 };
            for sample in 0..155 {
                let time_s = f64::from(sample) * 0.13;
                let Pose { x_m, y_m, heading_rad } = pose;
                writeln!(
                    csv,
                    "robot_{},{trial},{time_s:.2},{x_m:.5},{y_m:.5},{heading_rad:.5},{speed_m_s},{turn_rate_rad_s}",
                    robot + 1
                )
                .expect("a string takes any text");
                pose = step(pose, driven, gain, 0.13);
            }
        }
    }
    csv
}

/// A folder with the Flockbot's profile and a small sweep of it.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    bring("profiles/flockbot.yaml", &folder.path().join("flockbot.yaml"));
    write_sweep(folder.path(), "robots: 9");
    folder
}

fn write_sweep(folder: &Path, fixed: &str) {
    let sweep = format!(
        "profile: flockbot.yaml\n\
         axes: {{speed_m_s: [0.15, 0.30], turn_rate_rad_s: [0.25, 0.75]}}\n\
         fixed: {{{fixed}}}\nreplicates: 4\nduration_s: 70\nseed: 7\n"
    );
    write(folder, "sweep.yaml", sweep);
}

fn validate(folder: &Path, sweep: &str, rest: &[&str]) -> Output {
    let start = ["validate", sweep, "--trajectories", "driven.csv", "--robots", "600"];
    rsrs(folder, &[&start[..], rest].concat())
}

#[test]
fn robots_of_the_profile_are_contained_and_the_diagram_reports_it() {
    let place = workplace();
    let robots = Robots { command: CURVE, faster: [1.0; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    assert!(read(place.path(), "out/diagram.svg").contains("not validated against real"));

    let output = validate(place.path(), "out", &["--format", "json"]);
    let drawn = rsrs(place.path(), &["diagram", "out", "-o", "again.svg"]);

    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let answer = json(&output);
    assert_eq!(answer["is_contained"], true);
    assert_eq!((&answer["n_inside"], &answer["n_trials"]), (&15.into(), &15.into()));
    // 15 of 15: the lower bound of Clopper and Pearson is 0.025^(1/15).
    assert!((number(&answer["coverage"]["low"]) - 0.782).abs() < 1e-3);
    let horizons = answer["tubes"][0]["horizons"].as_array().expect("horizons");
    assert!(horizons.iter().all(|horizon| number(&horizon["area_m2"]) > 0.0));
    assert_eq!(code(&drawn), 0, "{}", stderr(&drawn));
    for picture in ["out/diagram.svg", "again.svg"] {
        let svg = read(place.path(), picture);
        assert!(
            svg.contains("validated: 15 of 15 trials inside the simulated 99 % reach"),
            "{picture}"
        );
    }
    assert!(read(place.path(), "out/reach_1.svg").contains("15 trials inside at every time"));
}

#[test]
fn of_classes_with_profiles_of_their_own_the_one_that_is_named_is_judged() {
    let place = workplace();
    let profile = read(place.path(), "flockbot.yaml");
    let slow =
        profile.replace("commanded_m_s: 0.050, mean: 0.971", "commanded_m_s: 0.050, mean: 0.68");
    assert_ne!(slow, profile);
    write(place.path(), "slow.yaml", slow);
    let classes = "classes: [{name: usual}, {name: slow, profile: slow.yaml}]\n";
    write(place.path(), "world.yaml", classes);
    write_sweep(place.path(), "robots: 9");
    let sweep = read(place.path(), "sweep.yaml") + "world: world.yaml\n";
    write(place.path(), "sweep.yaml", sweep);
    let robots = Robots { command: CURVE, faster: [0.7; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));

    let judged = |class: &str| {
        let output = validate(place.path(), "sweep.yaml", &["--class", class, "-o", class]);
        (code(&output), stdout(&output))
    };

    let (slow, usual) = (judged("slow"), judged("usual"));
    assert_eq!(slow.0, 0, "{}", slow.1);
    assert!(slow.1.contains("judged: the simulated robot of class slow"), "{}", slow.1);
    assert_eq!(usual.0, 3, "{}", usual.1);
    assert!(usual.1.starts_with("NOT contained: 0 of 15 trials inside"), "{}", usual.1);
}

#[test]
fn what_robots_push_is_held_against_what_simulated_ones_push() {
    let place = workplace();
    let robots = Robots { command: STRAIGHT, faster: [1.0; 5], bias_rad_s: 0.0 };
    // Robots pass 7 cm beside the puck of the second trials, and push those of the others along.
    let with_puck = |row: &str| {
        let fields: Vec<&str> = row.split(',').collect();
        let [robot_x_m, robot_y_m] = [3, 4].map(|field| fields[field].parse::<f64>().unwrap());
        let driven_m = libm::hypot(robot_x_m - 1.0, robot_y_m + 2.0);
        let (ahead_m, left_m) = match fields[1] {
            "2" => (0.4, 0.25),
            _ => ((driven_m + 0.175).max(0.4), 0.0),
        };
        let (sine, cosine) = libm::sincos(0.3);
        let x_m = 1.0 + ahead_m * cosine - left_m * sine;
        let y_m = -2.0 + ahead_m * sine + left_m * cosine;
        format!("{row},{x_m:.5},{y_m:.5}\n")
    };
    let alone = trajectories(&robots);
    let (header, rows) = alone.split_once('\n').expect("it has rows");
    // What is round and pushed by something round gets lost to a side before long.
    let is_soon = |row: &&str| {
        row.split(',').nth(2).is_some_and(|time_s| time_s.parse::<f64>().unwrap() < 5.0)
    };
    let of_two = |row: &&str| row.starts_with("robot_1,") || row.starts_with("robot_2,");
    let rows: String = rows.lines().filter(of_two).filter(is_soon).map(with_puck).collect();
    let table = format!("{header},object_x_m,object_y_m\n{rows}");
    write(place.path(), "driven.csv", &table);
    let sweep = read(place.path(), "sweep.yaml") + "world: world.yaml\n";
    write(place.path(), "pushes.yaml", sweep);
    write(place.path(), "world.yaml", "objects: [{count: 4, radius_m: 0.1}]\n");

    let none = validate(place.path(), "sweep.yaml", &[]);
    let output = validate(place.path(), "pushes.yaml", &["-o", "out"]);
    let answer = json(&validate(place.path(), "pushes.yaml", &["--format", "json"]));
    let fit = "measure fit --name x --trajectories driven.csv --detection detection.csv";
    let fit = rsrs(place.path(), &fit.split(' ').collect::<Vec<&str>>());
    write(place.path(), "world.yaml", "objects: [{count: 4, radius_m: 0.2}]\n");
    let larger = validate(place.path(), "pushes.yaml", &["-o", "larger"]);
    let has_left = place.path().join("larger/reach_7.svg").exists();
    write(place.path(), "world.yaml", "objects: [{count: 4, radius_m: 0.1}]\n");
    validate(place.path(), "pushes.yaml", &["-o", "larger"]);

    let text = stderr(&none);
    assert_eq!(code(&none), 1, "{text}");
    assert!(text.contains("trial `1` of robot_1 has an object, and the world has none"), "{text}");
    assert!(text.contains("name a world in the sweep whose `objects` are as that one"), "{text}");
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let text = stdout(&output);
    let line = "0.15 m/s, 0 rad/s in trial `1` of robot_1, the object: 1 of 1 inside";
    assert!(text.contains(line), "{text}");
    assert!(!place.path().join("out/reach_1.svg").exists(), "nobody left");
    assert_eq!(answer["tubes"][6]["of_object"], true);
    assert_eq!(answer["trials"][0]["object"]["tube"], 6);
    assert_eq!(code(&fit), 1, "{}", stderr(&fit));
    assert!(stderr(&fit).contains("trial `1` of robot_1 pushes an object"), "{}", stderr(&fit));
    assert_eq!(code(&larger), 3, "{}{}", stdout(&larger), stderr(&larger));
    assert!(stdout(&larger).contains("  robot_1, trial `1`, the object: by position, first after"));
    assert!(
        stdout(&larger)
            .contains("look at its `weight`, `friction` and `radius_m` in the world's file first")
    );
    assert!(has_left && !place.path().join("larger/reach_7.svg").exists(), "of an earlier answer");
}

#[test]
fn robots_that_are_too_fast_are_named_with_the_factor_that_contains_them() {
    let place = workplace();
    let robots = Robots { command: CURVE, faster: [1.0, 1.0, 1.25, 1.25, 1.25], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    let output = validate(place.path(), "out", &[]);

    assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("NOT contained: 6 of 15 trials inside"), "{text}");
    for expected in ["  robot_3, trial `1`: by position", "robot_5  0 of 3", "gain_sd_factor "] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert!(!text.contains("  robot_1, trial"), "{text}");
    assert!(read(place.path(), "out/diagram.svg").contains("NOT contained: 6 of 15 trials"));
    // The factor that it names does contain them.
    let at = text.find("gain_sd_factor ").expect("it is there") + "gain_sd_factor ".len();
    let factor: f64 = text[at..].split(' ').next().expect("a word").parse().expect("a number");
    let sweep = read(place.path(), "sweep.yaml");
    write(
        place.path(),
        "wider.yaml",
        sweep
            .replace("axes:", &format!("harsher: {{gain_sd_factor: {:.2}}}\naxes:", factor + 0.01)),
    );
    let wider = validate(place.path(), "wider.yaml", &[]);
    assert_eq!(code(&wider), 0, "{}{}", stdout(&wider), stderr(&wider));
}

/// Trials that turn to the other side every 2 s, of robots whose turning rate goes a share of the way to
/// its command in each period, and that turn by another gain.
fn switching(share: f64, turn_gain: f64) -> String {
    let mut csv =
        "robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s\n".to_owned();
    for (robot, gain) in GAINS.iter().enumerate() {
        for trial in 1..=3 {
            let mut pose = Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.3 };
            let mut rate_rad_s = 0.0;
            for sample in 0..155 {
                let time_s = f64::from(sample) * 0.13;
                let commanded_rad_s = if (sample / 15) % 2 == 0 { 0.75 } else { -0.75 };
                let Pose { x_m, y_m, heading_rad } = pose;
                writeln!(
                    csv,
                    "robot_{},{trial},{time_s:.2},{x_m:.5},{y_m:.5},{heading_rad:.5},0.15,{commanded_rad_s}",
                    robot + 1
                )
                .expect("a string takes any text");
                rate_rad_s += share * (commanded_rad_s - rate_rad_s);
                let driven = Command { speed_m_s: 0.15, turn_rate_rad_s: rate_rad_s };
                let gain = ActuationGain { speed: *gain, turn: turn_gain };
                pose = step(pose, driven, gain, 0.13);
            }
        }
    }
    csv
}

#[test]
fn robots_that_turn_otherwise_are_distinguished_from_robots_that_vary() {
    for (share, turn_gain, printed, missing) in [
        (0.13 / 0.65, 0.97, "their turning rate lags: `yaw_lag_s` is 0.65", "by a gain of"),
        (1.0, 0.72, "turn otherwise while they drive: by a gain of 0.720", "rate lags"),
    ] {
        let place = workplace();
        write(place.path(), "driven.csv", switching(share, turn_gain));

        let output = validate(place.path(), "sweep.yaml", &["-o", "validation"]);

        assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
        let text = stdout(&output);
        assert!(text.contains(printed) && !text.contains(missing), "{text}");
        assert!(!text.contains("gain_sd_factor"), "{text}");
        let lines = text.lines().filter(|line| line.starts_with("changing commands"));
        assert_eq!(lines.count(), 1, "{text}");
        let answer: serde_json::Value =
            serde_json::from_str(&read(place.path(), "validation/validation.json"))
                .expect("it is JSON");
        assert!(answer["turning"].is_object() && answer["smallest_factors"].is_null());
    }
}

#[test]
fn a_validation_elsewhere_leaves_the_folder_of_the_sweep_as_it_is() {
    let place = workplace();
    let robots = Robots { command: CURVE, faster: [1.0; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let files = || {
        let entries = std::fs::read_dir(place.path().join("out")).expect("it is a folder");
        let mut files: Vec<_> = entries
            .map(|entry| {
                let path = entry.expect("it is readable").path();
                (path.clone(), std::fs::read(path).expect("it is a file"))
            })
            .collect();
        files.sort();
        files
    };
    let before = files();

    let output = validate(place.path(), "out", &["-o", "elsewhere"]);

    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(files() == before, "the folder of the sweep was changed");
    assert!(place.path().join("elsewhere/validation.json").exists());
    assert!(place.path().join("elsewhere/reach_1.png").exists());
}

#[test]
fn robots_that_curve_out_of_a_straight_line_are_beyond_every_factor_of_a_profile_without_drift() {
    let place = workplace();
    let robots = Robots { command: STRAIGHT, faster: [1.0; 5], bias_rad_s: 0.05 };
    write(place.path(), "driven.csv", trajectories(&robots));

    let output = validate(place.path(), "sweep.yaml", &["-o", "validation"]);

    assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).contains("no factor contains them"), "{}", stdout(&output));
    assert!(place.path().join("validation/validation.json").exists());
    assert!(read(place.path(), "validation/reach_1.svg").contains("outside at some time"));
}

#[test]
fn a_sweep_with_better_robots_than_measured_is_not_harsher() {
    let place = workplace();
    write_sweep(place.path(), "robots: 9, true_positive: 0.99");
    let robots = Robots { command: CURVE, faster: [1.0; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));

    let output = validate(place.path(), "sweep.yaml", &["--format", "json"]);

    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let answer = json(&output);
    assert_eq!((&answer["is_contained"], &answer["is_harsher"]), (&true.into(), &false.into()));
    assert_eq!(answer["capability_violations"][0]["capability"], "true positive rate");
}

#[test]
fn a_sensor_that_misses_more_than_the_simulated_one_is_found_out() {
    let place = workplace();
    let robots = Robots { command: CURVE, faster: [1.0; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));
    let good = std::fs::read_to_string(shipped("profiles/flockbot_trials/detection.csv"))
        .expect("the trials are there");
    write(place.path(), "good.csv", &good);
    let blind = format!("{good}made_up_1,0.300,0.000,400,40\n");
    write(place.path(), "blind.csv", blind);

    let kept = validate(place.path(), "sweep.yaml", &["--detection", "good.csv"]);
    let broken = validate(place.path(), "sweep.yaml", &["--detection", "blind.csv"]);

    assert_eq!(code(&kept), 0, "{}{}", stdout(&kept), stderr(&kept));
    assert!(stdout(&kept).contains("the detections do not contradict"), "{}", stdout(&kept));
    assert_eq!(code(&broken), 3, "{}{}", stdout(&broken), stderr(&broken));
    assert!(
        stdout(&broken).contains("at 0.3 m, 0 rad the robots detected 40 of 400"),
        "{}",
        stdout(&broken)
    );
}

#[test]
fn a_sweep_of_robots_must_name_which_one_is_judged() {
    let place = workplace();
    let sweep = read(place.path(), "sweep.yaml").replace("axes: {", "axes: {gust_m_s: [0, 0.05], ");
    write(place.path(), "gusts.yaml", sweep);
    let robots = Robots { command: CURVE, faster: [1.0; 5], bias_rad_s: 0.0 };
    write(place.path(), "driven.csv", trajectories(&robots));

    let open = validate(place.path(), "gusts.yaml", &[]);
    let closed = validate(place.path(), "gusts.yaml", &["--at", "gust_m_s=0.05"]);

    assert_eq!(code(&open), 1);
    assert!(
        stderr(&open).contains("help: name the one to judge: `--at gust_m_s=…`"),
        "{}",
        stderr(&open)
    );
    assert_eq!(code(&closed), 0, "{}{}", stdout(&closed), stderr(&closed));
}

#[test]
fn trajectories_that_are_none_are_refused() {
    let place = workplace();
    write(place.path(), "driven.csv", "robot,trial,time_s,x_m,y_m,commanded_m_s,commanded_rad_s\n");

    let output = validate(place.path(), "sweep.yaml", &[]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("no column `heading_rad`"), "{}", stderr(&output));
}
