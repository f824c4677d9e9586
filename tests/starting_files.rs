//! A folder to begin with: written, swept, and run without another word.

use std::path::Path;

use crate::command::{code, done, json, rsrs, stderr, stdout, text_in};
use crate::processes::run_in_lockstep;

const ROBOTS: &str = "--name turtlebot --robots 4 --radius 0.1 --speed 0.2 --turn-rate 1.5 --range 0.9 \
                      --half-angle 0.25 --period 0.1";

fn robots() -> Vec<&'static str> {
    ROBOTS.split(' ').collect()
}

#[test]
fn a_new_folder_is_swept_and_run_as_it_is() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let begun =
        rsrs(place.path(), &[&["init", "mine", "--format", "json"], &robots()[..]].concat());
    assert_eq!(code(&begun), 0, "{}", stderr(&begun));
    assert_eq!(json(&begun)["files"].as_array().map(Vec::len), Some(4));
    let mine = place.path().join("mine");
    // Fewer runs than a person would make.
    let sweep = text_in(&mine, "sweep.yaml");
    let small = sweep.replace("replicates: 100", "replicates: 8");
    std::fs::write(mine.join("sweep.yaml"), small.replace("duration_s: 300", "duration_s: 120"))
        .expect("it is writable");
    let experiment = text_in(&mine, "experiment.yaml");
    let experiment = experiment.replace("duration_s: 300", "duration_s: 120");
    std::fs::write(mine.join("experiment.yaml"), experiment).expect("it is writable");

    let swept = rsrs(&mine, &["sweep", "sweep.yaml", "-o", "results"]);
    let cells = text_in(&mine, "results/cells.csv");
    let first = cells.lines().nth(1).expect("there are cells").split(',').take(2);
    let cell: Vec<&str> = first.collect();
    let cell = format!("speed_m_s={},turn_rate_rad_s={}", cell[0], cell[1]);
    let from = ["--from", "results", "--cell", &cell];
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    run_in_lockstep(Path::new("experiment.yaml"), &from, &mine.join("run_1"));

    // The robots get a better sensor after the sweep.
    let profile = text_in(&mine, "profile.yaml");
    let better = profile.replace("range_m: 0.9", "range_m: 1.1");
    assert_ne!(better, profile);
    std::fs::write(mine.join("profile.yaml"), better).expect("it is writable");
    let again = ["run", "experiment.yaml", "--from", "results", "-o", "run_2", "--cell", &cell];
    let run = rsrs(&mine, &again);
    let swept = rsrs(&mine, &["sweep", "sweep.yaml", "-o", "of_better"]);
    let compare = ["compare", "of_better", "--bags", "run_1"];
    let compared = rsrs(&mine, &compare);
    let insisted = rsrs(&mine, &[&compare[..], &["--other-profile"]].concat());

    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    for refused in [&run, &compared] {
        let text = stderr(refused);
        assert_eq!(code(refused), 1, "{text}");
        assert!(text.contains("the sweep is of robots with profile"), "{text}");
        assert!(text.contains("sweep these robots") && text.contains("--other-profile"), "{text}");
    }
    assert_ne!(code(&insisted), 1, "{}", stderr(&insisted));
    assert!(stdout(&insisted).contains("with profile"), "{}", stdout(&insisted));
}

#[test]
fn robots_that_are_faster_than_flockbots_go_from_the_first_sweep_to_the_verdict() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let robots = "--name fast --robots 4 --radius 0.1 --speed 0.6 --turn-rate 3.5 --range 1.5 --half-angle 0.4 \
                  --period 0.1 --arena 30";
    let robots: Vec<&str> = robots.split_whitespace().collect();
    done(place.path(), &[&["init", "mine"], &robots[..]].concat());
    let mine = place.path().join("mine");
    let sweep = text_in(&mine, "sweep.yaml");
    let axes = sweep.lines().filter(|line| line.contains("m_s: [") || line.contains("rad_s: ["));
    let small = axes.fold(sweep.clone(), |small, line| small.replace(line, ""));
    // All beyond the Flockbots' 0.3 m/s.
    let fast =
        "axes:\n  speed_m_s: [0.5, 0.55, 0.6]\n  turn_rate_rad_s: [1.2, 1.6, 2.0, 2.6, 3.0]\n";
    let small =
        small.replace("axes:", &format!("{fast}#")).replace("replicates: 100", "replicates: 40");
    std::fs::write(mine.join("sweep.yaml"), small.replace("duration_s: 300", "duration_s: 120"))
        .expect("it is writable");
    let experiment = text_in(&mine, "experiment.yaml");
    let experiment = experiment.replace("duration_s: 300", "duration_s: 120");
    std::fs::write(mine.join("experiment.yaml"), experiment).expect("it is writable");

    let swept = rsrs(&mine, &["sweep", "sweep.yaml", "-o", "results"]);
    let choose = ["choose", "results", "--confirm", "200", "-o", "results/choice.json"];
    let chosen = rsrs(&mine, &[&choose[..], &["--viable", "0.3"]].concat());
    assert_eq!((code(&swept), code(&chosen)), (0, 0), "{}{}", stderr(&swept), stderr(&chosen));
    let from = ["--from", "results"];
    run_in_lockstep(Path::new("experiment.yaml"), &from, &mine.join("run_1"));
    let labelled = rsrs(&mine, &["label", "run_1"]);
    let compared = rsrs(&mine, &["compare", "results", "--bags", "run_1"]);

    assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
    assert_ne!(code(&compared), 1, "{}", stderr(&compared));
}

#[test]
fn a_folder_that_would_not_work_is_not_written() {
    let place = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(place.path().join("there")).expect("writable");
    let with = |flag: &'static str, value: &'static str| {
        let mut robots = robots();
        let index = robots.iter().position(|other| *other == flag).expect("it is one of them");
        robots[index + 1] = value;
        robots
    };
    for (folder, robots, expected) in [
        ("there", robots(), "there exists"),
        ("new", with("--speed", "200"), "this looks like mm/s"),
        (
            "new",
            with("--half-angle", "15"),
            "--half-angle: the half-angle of the sensor is 15: this",
        ),
        ("new", with("--half-angle", "4"), "4° are 0.070 rad"),
        (
            "new",
            with("--half-angle", "3"),
            "--half-angle: the half-angle of the sensor is 3, expected at",
        ),
        ("new", with("--robots", "1"), "--robots: one robot is no swarm"),
        ("new", with("--robots", "0"), "--robots: expected a whole number from 2 to 1000"),
        ("new", with("--range", "0.01"), "the range of the sensor is 0.01 m, and the body"),
        (
            "new",
            with("--range", "0"),
            "--range: the range of the sensor is 0, expected a number above 0",
        ),
        ("new", with("--name", "Turtle Bot"), "expected letters, digits and `_`"),
        ("new", with("--name", "e-puck2"), "`e_puck2`"),
        ("new", with("--radius", "35"), "--radius: the radius is 35: this looks like mm or cm"),
        ("new", with("--radius", "0,035"), "expected a number with a decimal point"),
        ("new", with("--speed", "inf"), "--speed: the speed is inf, expected a number above 0"),
        ("new", with("--speed", "-0.15"), "--speed: the speed is -0.15, expected a number above 0"),
        ("new", [&robots()[..], &["--arena", "0.1"]].concat(), "4 robots do not fit"),
        ("new", robots()[..4].to_vec(), "--radius, --speed, --turn-rate, --range, --half-angle"),
    ] {
        let refused = rsrs(place.path(), &[&["init", folder], robots.as_slice()].concat());

        assert_ne!(code(&refused), 0, "{robots:?}");
        assert!(stderr(&refused).contains(expected), "{robots:?}: {}", stderr(&refused));
        assert!(!place.path().join("new").exists(), "{robots:?}");
    }
}
