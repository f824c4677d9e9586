//! Bags that are not the whole of what was recorded, runs that lost robots, and bags whose clocks and
//! frames are not one: each is reported or refused, wherever a bag is read.

use std::fs;
use std::path::Path;

use rsrs_fleet::experiment::RobotLost;
use rsrs_fleet::record::{Ending, LostRobot};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::{cdr, topics};

use super::bad_bags::copied;
use super::place;
use crate::command::{code, json, rsrs, stderr, stdout};
use crate::prepared_sweeps::chosen;
use crate::simulated_bags::Run;

/// Flips one bit in a chunk in the middle of a bag's file, as a worn disk does.
fn flip(bag: &Path) {
    const CHUNK: u8 = 6;
    let name = bag.file_name().expect("the bag has a name").to_string_lossy();
    let path = bag.join(format!("{name}_0.mcap"));
    let mut bytes = fs::read(&path).expect("the bag was recorded");
    let (mut at, mut chunks) = (8, Vec::new());
    while let Some(head) = bytes.get(at..at + 9) {
        let length = u64::from_le_bytes(head[1..].try_into().expect("eight bytes"));
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if head[0] == CHUNK {
            chunks.push(at + length / 2);
        }
        at = at.saturating_add(9).saturating_add(length);
    }
    bytes[chunks[chunks.len() / 2]] ^= 0x10;
    fs::write(&path, &bytes).expect("the folder is writable");
}

/// Cuts off the last fifth of a bag's file, as a full disk does.
fn cut(bag: &Path) {
    let path = bag.join("cut_0.mcap");
    let bytes = fs::read(&path).expect("the bag was recorded");
    fs::write(&path, &bytes[..bytes.len() / 5 * 4]).expect("the folder is writable");
    fs::remove_file(bag.join("metadata.yaml")).expect("the bag was finished");
}

#[test]
fn a_flipped_bit_stops_every_command_that_reads_the_bag() {
    let place = chosen();
    let here = place.path();
    Run::new(1).record(here, "good");
    flip(&Run::new(2).record(here, "worn"));
    let label = rsrs(here, &["label", "good", "--format", "json"]);
    fs::write(here.join("label.json"), stdout(&label)).expect("the folder is writable");

    for arguments in [
        &["label", "worn"][..],
        &["replay", "worn", "--into", "judge"],
        &["replay", "worn", "--into", "controller"],
        &["replay", "worn"],
        &["measure", "fit", "--bags", "worn", "--name", "x"],
    ] {
        let output = rsrs(here, arguments);
        let (printed, what) = (stderr(&output), arguments.join(" "));
        assert_eq!((code(&output), stdout(&output).as_str()), (1, ""), "{what}: {printed}");
        assert!(printed.contains("worn: the recording is damaged after "), "{what}: {printed}");
        assert!(printed.contains(": worn_0.mcap, byte "), "{what}: {printed}");
        assert!(
            printed.ends_with("help: save what can be saved: `rsrs bag recover worn`\n"),
            "{printed}"
        );
    }
    let compared = rsrs(here, &["compare", "out", "--bags", "good", "worn"]);
    let report = ["report", "out", "--bags", "good", "worn", "-o", "report.html"];
    let report = rsrs(here, &report);
    assert_eq!((code(&compared), code(&report)), (3, 3), "{}", stderr(&report));
    let page = fs::read_to_string(here.join("report.html")).expect("it was written");
    for printed in [stdout(&compared), page] {
        assert!(printed.contains("the recording is damaged after "), "{printed}");
        assert!(printed.contains("rsrs bag recover worn"), "{printed}");
    }
    let info = rsrs(here, &["bag", "info", "worn"]);
    assert_eq!(code(&info), 3, "{}", stdout(&info));
    assert!(stdout(&info).contains("\nnext: rsrs bag recover worn\n"), "{}", stdout(&info));
}

#[test]
fn a_recovered_bag_states_what_it_lacks_and_is_not_compared() {
    let place = chosen();
    let here = place.path();
    flip(&Run::new(1).record(here, "worn"));
    cut(&Run::new(2).record(here, "cut"));
    for bag in ["worn", "cut"] {
        assert_eq!(code(&rsrs(here, &["bag", "recover", bag])), 3);
    }

    let worn = rsrs(here, &["label", "worn_recovered"]);
    let cut = rsrs(here, &["label", "cut_recovered"]);
    let part = rsrs(here, &["label", "cut_recovered", "--part"]);
    let part_json = json(&rsrs(here, &["label", "cut_recovered", "--part", "--format", "json"]));
    let info = rsrs(here, &["bag", "info", "worn_recovered"]);
    let compared = rsrs(here, &["compare", "out", "--bags", "worn_recovered", "cut_recovered"]);

    let lacks = "recovered from a damaged bag: ";
    // A chunk is a second, and where it is lost robots are taken to have gone straight on.
    assert_eq!((code(&worn), code(&cut), code(&part)), (0, 1, 0), "{}", stderr(&part));
    let worn = stdout(&worn);
    assert!(worn.contains("\n  mended: robot_1: no pose from ") && worn.contains(lacks), "{worn}");
    let printed = stderr(&cut);
    assert!(printed.contains("s recorded, and the run was set to last 120 s"), "{printed}");
    assert!(printed.contains("a part is not judged as the whole"), "{printed}");
    assert!(printed.contains("`rsrs label BAG --part`"), "{printed}");
    assert!(stdout(&part).contains("\n  only a part of the run: "), "{}", stdout(&part));
    assert_eq!(part_json[0]["part"]["set_s"], 120.0);
    assert!(part_json[0]["damage"].as_str().is_some_and(|text| text.starts_with(lacks)));
    assert_eq!(code(&info), 3);
    assert!(stdout(&info).contains(&format!("\ndamage: {lacks}")), "{}", stdout(&info));
    let compared = stdout(&compared);
    assert_eq!(
        compared.matches("(not whole: recovered from a damaged bag: ").count(),
        2,
        "{compared}"
    );
    assert!(compared.contains("(no run counts)"), "{compared}");
}

/// The ending of a run that went on without a robot.
fn without(robot: &str) -> Ending {
    let reason = "silent for more than 1 s".to_owned();
    let lost = LostRobot { robot: robot.to_owned(), after_s: 20.3, reason };
    Ending { lost: vec![lost], ..Ending::completed() }
}

#[test]
fn a_lost_robot_is_named_wherever_its_run_is_and_counts_only_on_request() {
    let place = chosen();
    let here = place.path();
    Run { ending: without("robot_2"), ..Run::new(1) }.record(here, "short_handed");
    Run::new(2).record(here, "good");
    let bags = ["short_handed", "good"];
    let compare = ["compare", "out", "--bags", bags[0], bags[1]];
    let printed = "robot_2 lost after 20.3 s: silent for more than 1 s";

    let info = stdout(&rsrs(here, &["bag", "info", "short_handed"]));
    let info_json = json(&rsrs(here, &["bag", "info", "short_handed", "--format", "json"]));
    let label = stdout(&rsrs(here, &["label", "short_handed"]));
    let label_json = json(&rsrs(here, &["label", "short_handed", "good", "--format", "json"]));
    let left_out = rsrs(here, &compare);
    let left_out_json = json(&rsrs(here, &[&compare[..], &["--format", "json"]].concat()));
    let counted = rsrs(here, &[&compare[..], &["--with-lost-robots"]].concat());
    let report = ["report", "out", "--bags", bags[0], bags[1], "-o", "report.html"];
    let report = rsrs(here, &report);

    assert!(info.contains(&format!("\n{printed}\n")), "{info}");
    assert_eq!(info_json["lost_robots"][0]["robot"], "robot_2");
    assert!(label.contains(&format!("\n  {printed}")), "{label}");
    assert_eq!(label_json[0]["lost_robots"][0]["after_s"], 20.3);
    assert!(label_json[1].get("lost_robots").is_none(), "{label_json}");
    let text = stdout(&left_out);
    assert!(
        text.contains(&format!("not counted: short_handed (went on without a robot: {printed})")),
        "{text}"
    );
    assert!(text.contains("`--with-lost-robots` counts such runs, too"), "{text}");
    assert_eq!(left_out_json["cells"][0]["n_real"], 1);
    assert_eq!(left_out_json["not_counted"][0]["lost_robots"][0]["robot"], "robot_2");
    let text = stdout(&counted);
    assert!(text.contains(&format!("note: short_handed counts, though {printed}")), "{text}");
    assert!(text.contains("of 2 runs milled"), "{text}");
    assert!(code(&report) == 0, "{}", stderr(&report));
    let html = fs::read_to_string(here.join("report.html")).expect("it was written");
    assert!(html.contains(printed), "the report names the robot");
}

#[test]
fn a_robot_lost_in_the_judged_time_is_no_reason_to_leave_a_run_out_if_that_was_fixed_beforehand() {
    let place = chosen();
    let here = place.path();
    let lost = |after_s: f64| {
        let mut ending = without("robot_2");
        ending.lost[0].after_s = after_s;
        ending
    };
    // They last 120 s, of which the last 60 are judged.
    let run = |seed, after_s| Run {
        robot_lost: RobotLost::AbortUntilJudged,
        ending: lost(after_s),
        ..Run::new(seed)
    };
    run(1, 60.0).record(here, "late");
    run(2, 59.9).record(here, "early");

    let label = stdout(&rsrs(here, &["label", "late"]));
    let labels = json(&rsrs(here, &["label", "late", "early", "--format", "json"]));
    let compared = rsrs(here, &["compare", "out", "--bags", "late", "early", "--format", "json"]);

    assert!(label.contains("`robot_lost: abort_until_judged` of its experiment the run counts"));
    assert_eq!(labels[0]["counts_without_lost"], true);
    assert_eq!(labels[1]["counts_without_lost"], false);
    let compared = json(&compared);
    assert_eq!(compared["cells"][0]["n_real"], 1, "{compared}");
    let left_out = compared["not_counted"][0]["bag"].as_str();
    assert_eq!(left_out, Some("early"), "{compared}");
}

#[test]
fn a_run_whose_robot_was_not_seen_to_its_end_is_not_judged() {
    let place = place();
    let here = place.path();
    let run = Run { ending: without("robot_2"), ..Run::new(1) }.record(here, "run");
    let dead = copied(&run, "dead", |message| {
        let is_late = message.log_time_ns > 20_000_000_000;
        let is_dead = message.topic.starts_with("/robot_2/") && is_late;
        if is_dead { Vec::new() } else { vec![message] }
    });
    dead.finish().expect("the disk has room");

    let output = rsrs(here, &["label", "dead"]);

    assert_eq!((code(&output), stdout(&output).as_str()), (1, ""));
    let printed = stderr(&output);
    assert!(
        printed.starts_with(
            "error: dead: robot robot_2 has no pose after 19.9 s of 120.0 s: a run is judged by its \
             end; robot_2 lost after 20.3 s: silent for more than 1 s\n"
        ),
        "{printed}"
    );
    assert!(printed.contains("\nhelp: judge the run by eye: `rsrs label BAG --as PHASE --by WHO`"));
}

#[test]
fn somebody_elses_leases_do_not_cut_a_run() {
    let place = place();
    let here = place.path();
    let run = Run::new(1).record(here, "run");
    let lease = |run_id: &str, state: LeaseState| {
        let run_id = run_id.to_owned();
        cdr::encode(&RunLease { state: state.into(), run_id, epoch: 1, ..RunLease::default() })
    };
    let busy = copied(&run, "busy", |message| {
        if *message.topic == *topics::LEASE.name {
            let mut ours: RunLease = cdr::decode(&message.bytes).expect("it is one");
            ours.run_id = "run".to_owned();
            return vec![rsrs_bags::BagMessage { bytes: cdr::encode(&ours), ..message }];
        }
        let is_at_80_s =
            *message.topic == *"/robot_1/odom" && message.log_time_ns == 79_950_000_000;
        let other = rsrs_bags::BagMessage {
            topic: topics::LEASE.name.into(),
            bytes: lease("somebody_elses", LeaseState::Idle),
            ..message.clone()
        };
        if is_at_80_s { vec![other, message] } else { vec![message] }
    });
    busy.finish().expect("the disk has room");

    let alone = json(&rsrs(here, &["label", "run", "--format", "json"]));
    let busy = json(&rsrs(here, &["label", "busy", "--format", "json"]));

    assert_eq!(busy[0]["duration_s"], alone[0]["duration_s"]);
    assert_eq!(busy[0]["evidence"], alone[0]["evidence"]);
}

#[test]
fn a_trackers_own_clock_changes_no_label_and_is_reported() {
    let place = place();
    let here = place.path();
    let run = Run::new(1).record(here, "run");
    let tracked = copied(&run, "tracked", |mut message| {
        if message.topic.ends_with("/odom") {
            let mut odometry: Odometry = cdr::decode(&message.bytes).expect("it is one");
            let stamp_ns = odometry.header.stamp.to_nanos().expect("it is after 1970");
            odometry.header.stamp = Time::from_nanos(stamp_ns + 61_000_000_000);
            message.bytes = cdr::encode(&odometry);
        }
        vec![message]
    });
    tracked.finish().expect("the disk has room");

    let one = json(&rsrs(here, &["label", "run", "--format", "json"]));
    let two = json(&rsrs(here, &["label", "tracked", "--format", "json"]));
    let text = stdout(&rsrs(here, &["label", "tracked"]));

    assert_eq!(two[0]["phase"], "stable_milling");
    assert_eq!(two[0]["evidence"], one[0]["evidence"]);
    assert!(
        text.contains(
            "\n  mended: stamps of several clocks, +0.000 s to +61.000 s off the recorder's: aligned \
             by log time"
        ),
        "{text}"
    );
}

#[test]
fn odometry_in_each_robots_own_frame_is_not_judged() {
    let place = place();
    let here = place.path();
    let run = Run { robots: 3, ..Run::new(1) }.record(here, "run");
    let own = copied(&run, "own", |mut message| {
        if message.topic.ends_with("/odom") {
            let mut odometry: Odometry = cdr::decode(&message.bytes).expect("it is one");
            let stamp_s = message.log_time_ns as f64 / 1e9;
            odometry.pose.pose.position.x = 0.1 * stamp_s;
            odometry.pose.pose.position.y = 0.0;
            message.bytes = cdr::encode(&odometry);
        }
        vec![message]
    });
    own.finish().expect("the disk has room");

    let output = rsrs(here, &["label", "own"]);

    assert_eq!((code(&output), stdout(&output).as_str()), (1, ""));
    let printed = stderr(&output);
    assert!(printed.contains("robots robot_1, robot_2, robot_3 start on one spot"), "{printed}");
    assert!(printed.contains("\nhelp: poses must be in one frame"), "{printed}");
}

#[test]
fn a_bag_that_cannot_be_labelled_does_not_keep_the_others_from_it() {
    let place = place();
    let here = place.path();
    Run::new(1).record(here, "good");
    flip(&Run::new(2).record(here, "worn"));

    let output = rsrs(here, &["label", "worn", "good", "missing", "--format", "json"]);

    assert_eq!(code(&output), 1);
    let labels = json(&output);
    assert_eq!(labels.as_array().map(Vec::len), Some(1));
    assert_eq!(
        (&labels[0]["bag"], &labels[0]["phase"]),
        (&"good".into(), &"stable_milling".into())
    );
    let printed = stderr(&output);
    assert!(
        printed.starts_with("error: 2 of 3 bags cannot be labelled\n  worn: the recording"),
        "{printed}"
    );
    assert!(printed.contains("\n  cannot open missing: No such file or directory"), "{printed}");
}
