//! Runs with odometry and a tracker in one bag: each robot's odometry has an origin of its own, and a
//! run is judged by what it went by.

use std::path::Path;
use std::process::Command;

use crate::command::{code, done, json, repository, rsrs, stderr, stdout, text_in};
use crate::prepared_sweeps::chosen;
use crate::simulated_bags::{Run, SeenBy};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_operate::watch::recording;
use rsrs_testing::python;
use serde_json::Value;

/// Of a run of real robots, by a program that did not write down where poses come from.
const EARLIER: &str = include_str!("pose_sources/experiment_of_2026_11_22.json");

/// Nine robots of a type.
const FLEET: &str = "\
fileversion: 1
all: {profile: flockbot.yaml, driver: {kind: ros}}
robot_types: {tracked: {pose: pose}, untracked: {pose: odom}}
robots:
  spare: {enabled: false, type: untracked}
";

/// A fleet file whose first robots are tracked, and the others are not.
fn fleet(n_tracked: usize) -> String {
    let line = |robot: usize| {
        let robot_type = if robot <= n_tracked { "tracked" } else { "untracked" };
        format!("  robot_{robot}: {{enabled: true, type: {robot_type}}}\n")
    };
    (1..=9).map(line).fold(FLEET.to_owned(), |file, line| file + &line)
}

/// A mill that a tracker sees, and robots that believe to be elsewhere.
fn tracked(pose_source: Option<PoseSource>) -> Run {
    Run { seen_by: SeenBy::ATracker, pose_source, ..Run::new(1) }
}

fn label(folder: &Path, arguments: &[&str]) -> Value {
    let output = rsrs(folder, &[&["label", "--format", "json"], arguments].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    json(&output)[0].clone()
}

/// The phase, the source of the poses, and by what that is known.
fn judged(label: &Value) -> [&str; 3] {
    ["phase", "poses", "poses_by"].map(|key| label[key].as_str().expect("a word"))
}

#[test]
fn every_command_judges_the_poses_that_the_run_went_by() {
    let place = chosen();
    let folder = place.path();
    tracked(Some(PoseSource::Pose)).record(folder, "run");

    let recorded = label(folder, &["run"]);
    assert_eq!(judged(&recorded), ["stable_milling", "pose", "record"]);
    assert_eq!(recorded.get("findings"), None, "nothing was guessed");
    let asked = label(folder, &["run", "--poses", "odom"]);
    assert_eq!(judged(&asked), ["dispersion", "odom", "request"]);

    let compared = |more: &[&str]| {
        let arguments = ["compare", "out", "--format", "json", "--bags", "run"];
        json(&rsrs(folder, &[&arguments, more].concat()))["bags"][0].clone()
    };
    assert_eq!(judged(&compared(&[])), ["stable_milling", "pose", "record"]);
    assert_eq!(judged(&compared(&["--poses", "odom"])), ["dispersion", "odom", "request"]);

    for (more, phase) in [(&[][..], "stable milling"), (&["--poses", "odom"], "dispersion")] {
        done(folder, &[&["draw", "run", "-o", "run.svg"], more].concat());
        let drawn = text_in(folder, "run.svg");
        assert!(drawn.contains(&format!("s; {phase}")), "{more:?}");
        let film = ["film", "run", "-o", "run.gif", "--fps", "1", "--speed", "60"];
        done(folder, &[&film, more].concat());
        let report = ["report", "out", "-o", "report.html", "--bags", "run"];
        let report = rsrs(folder, &[&report, more].concat());
        assert_eq!(code(&report), 0, "{}", stderr(&report));
        let page = text_in(folder, "report.html");
        assert!(page.contains(&format!("judge: {phase}")), "{more:?}");
    }

    std::fs::write(folder.join("label.json"), recorded.to_string()).expect("writable");
    let replay = ["replay", "run", "--into", "judge", "--recorded", "label.json"];
    let replay = rsrs(folder, &replay);
    assert!(stdout(&replay).contains("the same label"), "{}", stdout(&replay));
}

#[test]
fn robots_of_a_recorded_run_are_shown_where_it_is_judged() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let farthest_m = |pose_source| {
        let name = format!("{pose_source:?}");
        let bag = tracked(pose_source).record(place.path(), &name);
        let mut watched = recording::read(&bag).expect("there is something to see").playback;
        watched.seek(watched.duration() / 2);
        let now = watched.at();
        let places = watched.observation().robots().map(|(_, robot)| {
            let pose = robot.pose(now).expect("it is seen").value;
            libm::hypot(pose.x_m, pose.y_m)
        });
        assert_eq!(places.len(), 9);
        places.fold(0.0, f64::max)
    };

    assert!(farthest_m(Some(PoseSource::Pose)) < 3.0);
    assert!(farthest_m(Some(PoseSource::Odom)) > 6.0, "odometry, as it is judged");
}

#[test]
fn a_run_of_an_earlier_version_is_judged_by_the_fleet_file_in_its_bag() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path();
    Run { fleet: Some(fleet(9)), ..tracked(None) }.record_with(folder, "tracked", EARLIER);
    Run { fleet: Some(fleet(0)), ..tracked(None) }.record_with(folder, "untracked", EARLIER);
    Run { fleet: Some(fleet(4)), ..tracked(None) }.record_with(folder, "both", EARLIER);

    assert_eq!(judged(&label(folder, &["tracked"])), ["stable_milling", "pose", "fleet_file"]);
    assert_eq!(judged(&label(folder, &["untracked"])), ["dispersion", "odom", "fleet_file"]);
    let both = rsrs(folder, &["label", "both"]);
    assert_eq!(code(&both), 1);
    let said = "both: its record states no source of poses, and by its fleet.yaml the poses of robot_1 \
                come from `pose` and those of robot_5 from `odom`, expected one `pose:` for all robots \
                of a run";
    assert!(stderr(&both).contains(said), "{}", stderr(&both));
    assert_eq!(judged(&label(folder, &["both", "--poses", "pose"]))[0], "stable_milling");
}

#[test]
fn in_a_bag_that_another_program_wrote_a_tracker_goes_before_odometry_and_that_is_said() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path();
    let python = python::python_with(&python::BAGS);
    let script = repository().join("tests/pose_sources/rewritten.py");
    for (name, pose_source) in [("stated", Some(PoseSource::Odom)), ("unstated", None)] {
        tracked(pose_source).record(folder, "original");
        let into = folder.join(name);
        let mut write = Command::new(&python);
        python::must_run(write.arg(&script).arg(folder.join("original")).arg(&into));
        std::fs::remove_dir_all(folder.join("original")).expect("it is ours");
    }

    // The record is a message, too.
    let stated = label(folder, &["stated"]);
    assert_eq!(judged(&stated), ["dispersion", "odom", "record"]);

    let unstated = label(folder, &["unstated"]);
    assert_eq!(judged(&unstated), ["stable_milling", "pose", "guess"]);
    let finding = serde_json::json!({"what": "unstated", "taken": "pose", "others": ["odom"]});
    assert_eq!(unstated["findings"], serde_json::json!([finding]));
    let words = stdout(&rsrs(folder, &["label", "unstated"]));
    let said = "note: poses of pose are taken, and nothing states which ones count: there are those of \
                odom, too (`--poses`)";
    assert!(words.contains(said), "{words}");
}
