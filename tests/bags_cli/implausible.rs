//! Labels of bags whose poses cannot be those of the robots that were commanded, and of robots that do
//! not move.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rsrs_core::robot::unicycle::Pose;
use serde_json::Value;

use super::place;
use crate::command::{code, json, rsrs, stderr, stdout};
use crate::simulated_bags::{Distortion, Run};

pub fn millimetres(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        (pose.x_m, pose.y_m) = (1000.0 * pose.x_m, 1000.0 * pose.y_m);
    }
}

/// The second axis of the tracker is height, in which markers differ, and orientations turn about it.
fn y_up(poses: &mut [Pose], _: &[Pose]) {
    for (robot, pose) in poses.iter_mut().enumerate() {
        let heading_rad = if libm::cos(pose.heading_rad) < 0.0 { PI } else { 0.0 };
        *pose = Pose { y_m: 0.08 + 0.03 * robot as f64, heading_rad, ..*pose };
    }
}

fn y_up_and_alike(poses: &mut [Pose], start: &[Pose]) {
    y_up(poses, start);
    for pose in poses {
        pose.y_m = 0.08;
    }
}

fn degrees(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        pose.heading_rad = libm::remainder(pose.heading_rad.to_degrees(), TAU);
    }
}

fn no_orientation(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        pose.heading_rad = 0.0;
    }
}

fn mirrored(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        *pose = Pose { y_m: -pose.y_m, heading_rad: -pose.heading_rad, ..*pose };
    }
}

fn mirrored_places(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        pose.y_m = -pose.y_m;
    }
}

fn askew(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        pose.heading_rad += FRAC_PI_2;
    }
}

fn swapped(poses: &mut [Pose], _: &[Pose]) {
    poses.swap(1, 4);
}

fn third_stands(poses: &mut [Pose], start: &[Pose]) {
    poses[2] = start[2];
}

/// The origin of the tracker is in the corner of the room.
pub fn in_the_corner(poses: &mut [Pose], _: &[Pose]) {
    for pose in poses {
        (pose.x_m, pose.y_m) = (pose.x_m + 3.0, pose.y_m + 2.0);
    }
}

fn labelled(seed: u64, distortion: Option<Distortion>) -> (String, Value) {
    let place = place();
    Run { distortion, ..Run::new(seed) }.record(place.path(), "run");
    let text = rsrs(place.path(), &["label", "run"]);
    let printed = rsrs(place.path(), &["label", "run", "--format", "json"]);
    assert_eq!((code(&text), code(&printed)), (0, 0), "{}", stderr(&text));
    (stdout(&text), json(&printed)[0].clone())
}

#[test]
fn a_label_names_what_poses_show_that_cannot_be_with_the_robots_and_the_cause() {
    let causes: [(Distortion, &str, &str, usize); 9] = [
        (millimetres, "scale", "0 times too far: millimetres?", 9),
        (y_up, "line", "poses move along x only, whatever is commanded: is y the axis that", 8),
        (degrees, "degrees", "headings turn 57 times too fast: degrees in place of radians?", 9),
        (no_orientation, "heading_stands", "headings do not turn, while the way does", 8),
        (mirrored, "mirrored", "poses turn the other way than is commanded", 6),
        (mirrored_places, "heading_mirrored", "headings turn one way and the way the other", 8),
        (askew, "askew", "° off the heading: is the body turned in the tracker?", 6),
        (swapped, "swapped", "robot_2 and robot_5 follow each other's commands: swapped?", 2),
        (third_stands, "stands", "robot_3 is commanded 0.15 m/s and has moved 0.00 m in 12 s", 1),
    ];
    for (distortion, cause, words, least) in causes {
        let (text, label) = labelled(1, Some(distortion));

        let found = label["implausible"].as_array().expect("it is found");
        assert_eq!(found.len(), 1, "{cause}: {label}");
        assert_eq!(found[0]["cause"], cause, "{label}");
        let robots = found[0]["robots"].as_array().expect("they are named");
        assert!(robots.len() >= least, "{cause}: {label}");
        let found = found[0]["text"].as_str().expect("it is in words");
        assert!(found.contains(words), "{cause}: {label}");
        assert!(text.contains(&format!("\n  implausible (look again): {found}\n")), "{text}");
    }
}

#[test]
fn robots_that_seem_to_be_on_one_spot_may_be_seen_with_another_axis_up() {
    let place = place();
    Run { distortion: Some(y_up_and_alike), ..Run::new(1) }.record(place.path(), "run");

    let output = rsrs(place.path(), &["label", "run"]);

    let printed = stderr(&output);
    assert_eq!(code(&output), 1, "{printed}");
    assert!(printed.contains("start on one spot") && printed.contains("with z up"), "{printed}");
}

#[test]
fn runs_with_nothing_wrong_are_labelled_without_a_word_about_it() {
    for seed in 1..=6 {
        let (text, label) = labelled(seed, None);

        assert!(!text.contains("implausible") && !text.contains("\n  start:"), "{text}");
        assert_eq!((&label["implausible"], &label["misplaced"]), (&Value::Null, &Value::Null));
    }
}

#[test]
fn robots_that_did_not_start_where_their_record_places_them_are_named() {
    let (text, label) = labelled(1, Some(in_the_corner));

    assert_eq!(label["implausible"], Value::Null, "the origin changes no motion: {label}");
    let misplaced = label["misplaced"].as_array().expect("they are named");
    let first = misplaced[0].as_str().expect("words");
    assert!(first.contains("m from the centre, expected at most 0.600 m"), "{label}");
    assert!(text.contains(&format!("\n  start: {first}")), "{text}");
}
