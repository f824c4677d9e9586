//! Bags on the command line: what is in them, what can be saved, simulated runs as bags, and labels by
//! people.

pub mod bad_bags;
mod converted;
pub mod implausible;
mod integrity;
mod labels;
mod standing;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use crate::cells::{CELLS, conditions, flockbot};
use crate::command::{code, json, rsrs, stderr, stdout};
use crate::prepared_sweeps::{SPEEDS, swept};
use crate::simulated_bags::{Run, cut_in_half};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use rsrs_bags::Bag;
use rsrs_bags::trajectory::{TrajectoryOptions, read_trajectory};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::{Phase, Verdict, label};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{Backend, ExperimentRecord};
use rsrs_testing::environment::or_if_long;
use rsrs_testing::record::fleet_record;

fn place() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

// What is in a bag, and what can be saved.

#[test]
fn info_lists_what_is_in_a_bag() {
    let place = place();
    Run { robots: 2, recorded_s: 70.0, ..Run::new(1) }.record(place.path(), "run");

    let text = rsrs(place.path(), &["bag", "info", "run"]);
    let info = json(&rsrs(place.path(), &["bag", "info", "run", "--format", "json"]));

    assert_eq!(code(&text), 0, "{}", stderr(&text));
    let lines: Vec<String> = stdout(&text).lines().map(str::to_owned).collect();
    assert!(lines[0].starts_with("run: 69.9 s, 2,154 messages on 5 topics, "), "{lines:?}");
    assert!(lines[0].ends_with(" in 1 file"), "{lines:?}");
    assert_eq!(
        lines[1..7],
        [
            "recorded: 0.000 s to 69.940 s",
            "run: run, 2 robots, set to last 120 s, seed 1, completed",
            "robots moved by: themselves",
            "controller: 0.15 m/s at 0.75 rad/s where something is detected, else 0.15 m/s at -0.75 rad/s",
            "judged for: milling",
            "written by: rsrs 0.1.0; ROS jazzy; metadata version 8; zstd",
        ]
    );
    assert_eq!(
        lines[7..11],
        [
            "topics:",
            "  /robot_1/cmd_vel  geometry_msgs/msg/TwistStamped  538  7.7 Hz  reliable, volatile, \
             depth 200",
            "  /robot_1/odom     nav_msgs/msg/Odometry           538  7.7 Hz  reliable, volatile, \
             depth 200",
            "  /robot_2/cmd_vel  geometry_msgs/msg/TwistStamped  538  7.7 Hz  reliable, volatile, \
             depth 200",
        ]
    );
    assert_eq!(
        (&info["n_messages"], &info["n_robots"]),
        (&serde_json::json!(2154), &serde_json::json!(2))
    );
    assert_eq!(
        (&info["ending"], &info["damage"]),
        (&serde_json::json!("completed"), &serde_json::json!([]))
    );
    assert_eq!(info["topics"][0]["offered_qos"][0]["reliability"], "reliable");
}

#[test]
fn a_bag_that_breaks_off_is_reported_and_saved_up_to_there() {
    let place = place();
    let here = place.path();
    let whole = Run { robots: 2, ..Run::new(1) }.record(here, "whole");
    let cut = Run { robots: 2, ..Run::new(1) }.record(here, "cut");
    cut_in_half(&cut);
    let label = ["label", "cut", "--as", "unformed", "--by", "ana"];
    assert_eq!(code(&rsrs(here, &label)), 0);
    let before = read(&cut.join("cut_0.mcap"));

    let info = rsrs(here, &["bag", "info", "cut"]);
    let recover = rsrs(here, &["bag", "recover", "cut", "--format", "json"]);
    let again = rsrs(here, &["bag", "recover", "cut"]);
    let given = rsrs(here, &["bag", "recover", "cut", "-o", "other"]);

    assert_eq!((code(&info), code(&recover), code(&again), code(&given)), (3, 3, 1, 3));
    assert!(stdout(&info).contains("damage: the recording breaks off after"), "{}", stdout(&info));
    assert!(stdout(&info).contains("next: rsrs bag recover cut"), "{}", stdout(&info));
    assert!(stdout(&info).starts_with("cut, up to its damage: "), "{}", stdout(&info));
    assert!(stdout(&info).contains("its end is behind the damage"), "{}", stdout(&info));
    assert!(stderr(&again).contains("cut_recovered exists already"), "{}", stderr(&again));
    let recovered = json(&recover);
    let saved = Bag::open(&here.join("cut_recovered")).expect("it is a bag");
    let all = Bag::open(&whole).expect("it is a bag");
    assert!(saved.damage().is_empty() && saved.n_messages() > 100);
    assert_eq!(recovered["n_messages"], saved.n_messages());
    assert_eq!(
        (&recovered["is_complete"], &recovered["n_labels"]),
        (&serde_json::json!(false), &serde_json::json!(1))
    );
    let first: Vec<_> = all.messages().map(Result::ok).collect();
    let kept: Vec<_> = saved.messages().map(Result::ok).collect();
    let bytes = |messages: &[Option<rsrs_bags::BagMessage>]| -> Vec<Option<Vec<u8>>> {
        messages.iter().map(|message| message.as_ref().map(|it| it.bytes.clone())).collect()
    };
    assert!(bytes(&first[..kept.len()]) == bytes(&kept), "the messages saved are those recorded");
    assert!(stdout(&given).contains("messages saved, 0.000 s to "), "{}", stdout(&given));
    assert!(stdout(&given).contains("\nlost: "), "{}", stdout(&given));
    assert_eq!(read(&cut.join("cut_0.mcap")), before, "the damaged bag stays as it is");
    assert!(here.join("cut_recovered/labels.yaml").exists());
}

#[test]
fn a_whole_bag_is_saved_without_loss_and_what_is_no_bag_is_refused() {
    let place = place();
    let here = place.path();
    Run { robots: 1, ..Run::new(1) }.record(here, "whole");
    std::fs::write(here.join("notes.mcap"), "no bag").expect("the folder is writable");

    let whole = rsrs(here, &["bag", "recover", "whole", "-o", "copy"]);
    let notes = rsrs(here, &["bag", "recover", "notes.mcap"]);
    let nothing = rsrs(here, &["bag", "info", "nothing"]);

    assert_eq!((code(&whole), code(&notes), code(&nothing)), (0, 1, 1));
    assert!(stdout(&whole).contains("lost: nothing that was recorded"), "{}", stdout(&whole));
    assert!(stderr(&notes).starts_with("error: notes.mcap is not an MCAP file\nhelp: "));
    assert!(!here.join("notes_recovered").exists(), "nothing half-made is left");
}

// Simulated runs as bags.

/// Cell (speed, turning rate), replicate and phase of every row of robots made worse.
fn replicates(folder: &Path) -> Vec<(f64, f64, i64, String)> {
    let file = std::fs::File::open(folder.join("replicates.parquet")).expect("it was written");
    let reader = SerializedFileReader::new(file).expect("it is Parquet");
    let rows = reader.get_row_iter(None).expect("it has rows");
    let is_worse = |row: &Vec<(String, Field)>| {
        row.iter().any(|(name, field)| name == "world" && *field == Field::Str("harsher".into()))
    };
    rows.map(|row| row.expect("the row reads").into_columns())
        .filter(is_worse)
        .map(|row| {
            let field = |wanted: &str| {
                let column = row.iter().find(|(name, _)| name == wanted);
                &column.unwrap_or_else(|| panic!("no column {wanted}")).1
            };
            let (
                Field::Double(speed),
                Field::Double(turn_rate),
                Field::Long(replicate),
                Field::Str(phase),
            ) = (field("speed_m_s"), field("turn_rate_rad_s"), field("replicate"), field("phase"))
            else {
                panic!("columns of other types: {row:?}")
            };
            (*speed, *turn_rate, *replicate, phase.clone())
        })
        .collect()
}

#[test]
fn a_replicate_as_a_bag_has_the_label_that_the_sweep_gave_it() {
    let place = swept(SPEEDS, "true_positive: 0.8");
    let here = place.path();
    let rows = replicates(&here.join("out"));

    // The last two of each cell.
    let chosen = rows.iter().filter(|(_, _, replicate, _)| *replicate >= 14);
    let mut seen = Vec::new();
    for (index, (speed, turn_rate, replicate, phase)) in chosen.enumerate() {
        let cell = format!("speed_m_s={speed},turn_rate_rad_s={turn_rate}");
        let (bag, replicate) = (format!("bag_{index}"), replicate.to_string());
        let arguments = ["episode", "out", "--cell", &cell, "--replicate", &replicate, "-o", &bag];
        let written = rsrs(here, &[&arguments[..], &["--format", "json"]].concat());
        assert_eq!(code(&written), 0, "{}", stderr(&written));
        let labels = json(&rsrs(here, &["label", &bag, "--format", "json"]));
        assert_eq!(labels[0]["phase"], **phase, "{cell} {replicate}");
        assert_eq!(json(&written)["phase"], **phase, "{cell} {replicate}");
        seen.push(phase.clone());
    }
    seen.sort();
    seen.dedup();
    assert!(seen.len() >= 3, "the cells should differ, found only {seen:?}");

    let beyond = ["episode", "out", "--cell", "speed_m_s=0.15,turn_rate_rad_s=0.75", "-o", "x"];
    let beyond = rsrs(here, &[&beyond[..], &["--replicate", "16"]].concat());
    let unswept = ["episode", "out", "--cell", "speed_m_s=0.2,turn_rate_rad_s=0.75", "-o", "x"];
    let unswept = rsrs(here, &[&unswept[..], &["--replicate", "0"]].concat());
    assert_eq!((code(&beyond), code(&unswept)), (1, 1));
    assert!(stderr(&beyond).contains("`--replicate 15` is the last"), "{}", stderr(&beyond));
    assert!(stderr(&unswept).contains("the nearest swept cell is"), "{}", stderr(&unswept));
}

fn episode(cell: [f64; 4], replicate: u64) -> ExperimentRecord {
    ExperimentRecord {
        run_id: format!("episode_{replicate}"),
        duration_s: 66.0,
        seed: 11,
        replicate,
        backend: Backend::Simulator,
        time: Time::Lockstep,
        ..fleet_record(&flockbot().digest(), conditions(cell))
    }
}

/// The verdict on an episode in memory and on its bag.
fn both_verdicts(folder: &Path, cell: usize, replicate: u64) -> [Verdict; 2] {
    let record = episode(CELLS[cell], replicate);
    let bag = folder.join(format!("{cell}_{replicate}"));
    let (_, in_memory) = rsrs_pipeline::episode::write(&bag, &record).expect("the disk has room");
    let opened = Bag::open(&bag).expect("it is a bag");
    let recorded =
        read_trajectory(&opened, &TrajectoryOptions::default()).expect("it has all that it takes");
    assert_eq!(recorded.findings, [], "{}", bag.display());
    std::fs::remove_dir_all(&bag).expect("it is ours");
    let bodies = record.conditions.bodies();
    [&in_memory, &recorded.trajectory].map(|it| label(it, &bodies).expect("it is long enough"))
}

#[test]
fn the_label_from_a_bag_is_the_label_in_memory() {
    let place = place();
    let n_episodes = or_if_long(100, 2000);
    let next = Mutex::new(0..n_episodes);
    let counts = Mutex::new(BTreeMap::<Phase, usize>::new());

    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(index) = next.lock().expect("no panic").next() else { return };
                    let (cell, replicate) = (index % CELLS.len(), (index / CELLS.len()) as u64);
                    let [memory, bag] = both_verdicts(place.path(), cell, replicate);
                    assert_eq!(bag.phase, memory.phase, "cell {cell}, replicate {replicate}");
                    // The way through a quaternion costs the last bits of a heading.
                    for (found, expected) in [
                        (bag.evidence.rotation, memory.evidence.rotation),
                        (bag.evidence.orbit, memory.evidence.orbit),
                        (bag.evidence.circliness, memory.evidence.circliness),
                        (bag.evidence.blocked, memory.evidence.blocked),
                        (bag.duration_s, memory.duration_s),
                    ] {
                        assert!((found - expected).abs() < 2e-9, "{found} {expected}");
                    }
                    *counts.lock().expect("no panic").entry(memory.phase).or_default() += 1;
                }
            });
        }
    });

    let counts = counts.into_inner().expect("no panic");
    assert_eq!(counts.values().sum::<usize>(), n_episodes);
    assert_eq!(
        counts.len(),
        Behaviour::MILLING.phases().len(),
        "every phase should occur: {counts:?}"
    );
}

// How sure a label is.

#[test]
fn a_label_states_how_far_it_is_from_another_phase() {
    let place = place();
    Run::new(1).record(place.path(), "run");

    let labels = json(&rsrs(place.path(), &["label", "run", "--format", "json"]));
    let text = stdout(&rsrs(place.path(), &["label", "run"]));

    let label = &labels[0];
    assert_eq!(
        (&label["is_settled"], &label["poses"]),
        (&serde_json::json!(true), &serde_json::json!("odom"))
    );
    assert_eq!(label["confidence"], 1.0);
    assert_eq!(label["margins"].as_array().map(Vec::len), Some(10));
    assert_eq!(label["nearest"]["becomes"], "semi_stable_milling");
    assert!(text.contains("\n  settled; nearest is semi-stable milling, "), "{text}");
}
