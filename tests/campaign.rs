//! Campaigns: killed, gone on with, tampered with, and asked of a person who places robots.

mod fleet;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::bags_cli::bad_bags::copied;
use crate::command::{code, copy, json, stderr, text_in};
use crate::processes::{Process, confined_rsrs, nodes_of};
use crate::recorded::record_of;
use crate::terminal::Terminal;
use base16ct::HexDisplay;
use rsrs_ros::confine::Confinement;
use rsrs_testing::environment::number;
use rsrs_testing::network::TIMEOUT;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Long enough for the judge, and no longer.
const DURATION_S: u32 = 64;

/// A folder with a campaign of two short runs of three robots.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs");
    for file in ["profiles/flockbot.yaml", "fleets/nine_virtual.yaml"] {
        let to = place.path().join(file);
        std::fs::create_dir_all(to.parent().expect("it is in a folder")).expect("it is writable");
        std::fs::copy(shipped.join(file), to).expect("it is shipped");
    }
    let experiment = format!(
        "fleet: fleets/nine_virtual.yaml\n\
         cell: {{speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 3}}\n\
         placement: {{kind: disc_facing_out, radius_m: 0.6}}\n\
         duration_s: {DURATION_S}\nseed: 1\n"
    );
    write(place.path(), "three.yaml", &experiment);
    write(
        place.path(),
        "campaign.yaml",
        "experiments:\n- {experiment: three.yaml, seeds: [1], repetitions: 2}\n",
    );
    place
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("the folder is writable");
}

fn campaign(place: &Path) -> Command {
    let mut command = confined_rsrs();
    command.current_dir(place).args(["campaign", "campaign.yaml", "-o", "out", "--format", "json"]);
    command
}

/// Runs the campaign to its end.
fn to_the_end(place: &Path) -> Output {
    campaign(place).output().expect("the program was built for this test")
}

fn manifest(folder: &Path) -> Value {
    let text = text_in(folder, "manifest.json");
    serde_json::from_str(&text).expect("a manifest is JSON")
}

/// Every file below a folder, with its bytes.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in folder.read_dir().expect("the folder is there") {
        let path = entry.expect("it can be listed").path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            let bytes = std::fs::read(&path).expect("it can be read");
            found.insert(path, bytes);
        }
    }
    found
}

/// Checks by hand that a manifest lists what is there.
fn check_manifest(folder: &Path) {
    let manifest = manifest(folder);
    let listed = manifest["files"].as_array().expect("a list");
    let names: Vec<&str> = listed.iter().filter_map(|file| file["path"].as_str()).collect();
    let attempts = folder.join("attempts.json").exists().then_some("attempts.json");
    let others = [
        "bag/bag_0.mcap",
        "bag/metadata.yaml",
        "experiment.yaml",
        "fleet.yaml",
        "label.json",
        "profile.yaml",
    ];
    assert_eq!(names, attempts.into_iter().chain(others).collect::<Vec<_>>());
    for file in listed {
        let bytes = std::fs::read(folder.join(file["path"].as_str().expect("text")));
        let bytes = bytes.expect("it is there");
        let digest = format!("{:x}", HexDisplay(&Sha256::digest(&bytes)));
        assert_eq!(file["size_bytes"], bytes.len());
        assert_eq!(file["sha256"], digest.as_str());
    }
}

/// Waits until something is there.
fn wait_for(what: &str, is_there: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_there() {
        assert!(begun.elapsed() < TIMEOUT, "never came: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Kills a campaign in the middle of its second experiment.
fn kill_in_the_second(place: &Path) {
    let mut process = Process::start(&mut campaign(place));
    let pid = process.0.id();
    let recording = place.join("out/002_three/bag/bag_0.mcap");
    let is_at_work = || std::fs::metadata(&recording).is_ok_and(|file| file.len() > 20_000);
    wait_for("the second recording", is_at_work);
    process.0.kill().expect("it is our child");
    process.0.wait().expect("it is our child");
    wait_for("the end of its nodes", || nodes_of(pid).is_empty());
}

#[test]
fn a_campaign_that_is_killed_goes_on_where_it_was_and_runs_nothing_twice() {
    let place = place();
    let out = place.path().join("out");
    kill_in_the_second(place.path());
    let first = contents(&out.join("001_three"));
    let broken = std::fs::read(out.join("002_three/bag/bag_0.mcap")).expect("it was begun");
    assert!(!out.join("002_three/manifest.json").exists(), "it was not finished");

    let resumed = to_the_end(place.path());

    assert_eq!(code(&resumed), 0, "{}", stderr(&resumed));
    let summary = json(&resumed);
    assert_eq!(summary["n_finished"], 2, "{summary}");
    assert_eq!(summary["experiments"][1]["ending"], "completed");
    assert!(contents(&out.join("001_three")) == first, "the first one was touched");
    let aside = out.join("002_three/bag.unfinished_1/bag_0.mcap");
    assert!(std::fs::read(aside).expect("it is kept") == broken);
    assert_eq!(manifest(&out.join("002_three"))["kept_aside"][0], "bag.unfinished_1");
    let attempt = &manifest(&out.join("002_three"))["attempts"][0];
    assert_eq!(
        (&attempt["ending"], &attempt["bag"], &attempt["has_started"]),
        (&Value::from("broken_off"), &Value::from("bag.unfinished_1"), &Value::from(true)),
        "{attempt}"
    );
    assert_eq!(&summary["experiments"][1]["attempts"][0], attempt);
    for (folder, replicate) in [("001_three", 0), ("002_three", 1)] {
        check_manifest(&out.join(folder));
        let (bag, record) = record_of(&out.join(folder).join("bag"));
        assert_eq!((record.seed, record.replicate, bag.damage().len()), (1, replicate, 0));
    }

    what_is_finished_is_verified(place.path());
}

/// The rest of the story of one campaign, whose runs need not be made again for it.
fn what_is_finished_is_verified(place: &Path) {
    let out = place.join("out");
    let before = contents(&out);
    let again = to_the_end(place);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    assert!(contents(&out) == before, "a finished campaign changes nothing");

    // Killed behind the bag and before the manifest: the run was whole.
    std::fs::remove_file(out.join("002_three/manifest.json")).expect("it is there");
    std::fs::remove_file(out.join("002_three/label.json")).expect("it is there");
    let adopted = to_the_end(place);
    assert_eq!(code(&adopted), 0, "{}", stderr(&adopted));
    let of_second = out.join("002_three/manifest.json");
    let without = |all: &BTreeMap<PathBuf, Vec<u8>>| {
        let mut all = all.clone();
        all.remove(&of_second);
        all
    };
    assert!(without(&contents(&out)) == without(&before), "the closed bag was run again");
    // What the middleware had lost is unknown now.
    assert_eq!(manifest(&out.join("002_three"))["n_lost"], Value::Null);
    check_manifest(&out.join("002_three"));

    // A person's label is no tampering.
    write(&out.join("001_three/bag"), "labels.yaml", "[]\n");
    assert_eq!(code(&to_the_end(place)), 0);

    let bag = out.join("001_three/bag/bag_0.mcap");
    let mut bytes = before[&bag].clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&bag, bytes).expect("it is writable");
    let tampered = to_the_end(place);
    assert_eq!(code(&tampered), 1);
    let printed = stderr(&tampered);
    assert!(
        printed.contains("out/001_three/bag/bag_0.mcap is not what was recorded: its SHA"),
        "{printed}"
    );

    std::fs::write(&bag, &before[&bag]).expect("it is writable");
    std::fs::remove_file(out.join("002_three/fleet.yaml")).expect("it is there");
    let missing = to_the_end(place);
    assert_eq!(code(&missing), 1);
    let printed = stderr(&missing);
    assert!(printed.contains("out/002_three/fleet.yaml is not what was recorded"), "{printed}");
    std::fs::write(out.join("002_three/fleet.yaml"), &before[&out.join("002_three/fleet.yaml")])
        .expect("it is writable");

    write(place, "campaign.yaml", "experiments:\n- {experiment: three.yaml, seeds: [2]}\n");
    let other = to_the_end(place);
    assert_eq!(code(&other), 1);
    let printed = stderr(&other);
    assert!(printed.contains("out holds another campaign: 001_three is not the same"), "{printed}");
}

/// Campaigns that are killed at a moment, where nothing else is asked for.
const KILLS: u32 = 4;

#[test]
fn a_campaign_that_is_killed_at_any_moment_loses_nothing_that_was_finished() {
    let place = place();
    let out = place.path().join("out");
    let manifests = || {
        ["001_three", "002_three"]
            .map(|name| std::fs::read(out.join(name).join("manifest.json")).ok())
    };
    let kills = number("RSRS_KILLS").unwrap_or(KILLS);

    let mut finished = manifests();
    for kill in 0..kills {
        let mut process = Process::start(&mut campaign(place.path()));
        let pid = process.0.id();
        // Moments all over the time that a run takes, in no order.
        std::thread::sleep(Duration::from_millis(u64::from(kill * 1_700 % 4_100)));
        process.0.kill().expect("it is our child");
        process.0.wait().expect("it is our child");
        wait_for("the end of its nodes", || nodes_of(pid).is_empty());
        let now = manifests();
        let is_kept = finished.iter().zip(&now).all(|(old, new)| old.is_none() || old == new);
        assert!(is_kept, "after kill {kill}");
        finished = now;
        if finished.iter().all(Option::is_some) {
            for name in ["001_three", "002_three"] {
                check_manifest(&out.join(name));
            }
            std::fs::remove_dir_all(&out).expect("it is ours");
            finished = [None, None];
        }
    }
    let last = to_the_end(place.path());

    assert_eq!(code(&last), 0, "{}", stderr(&last));
    for name in ["001_three", "002_three"] {
        check_manifest(&out.join(name));
    }
}

/// Makes the campaign of a place one of a single run.
fn of_one_run(place: &Path) {
    write(place, "campaign.yaml", "experiments:\n- {experiment: three.yaml, seeds: [1]}\n");
}

#[test]
fn a_run_that_fails_before_its_robots_move_is_tried_again_and_every_attempt_is_listed() {
    let place = place();
    of_one_run(place.path());
    let file = place.path().join("three.yaml");
    let whole = std::fs::read_to_string(&file).expect("it is there");
    write(place.path(), "three.yaml", &format!("{whole}record: {{topics: [/nobodys]}}\n"));

    let mut process = Process::start(&mut campaign(place.path()));
    // The first run is planned by then.
    wait_for("the first run", || place.path().join("out/001_three/experiment.yaml").exists());
    write(place.path(), "three.yaml", &whole);
    let stdout = process.0.stdout.take().expect("it is piped");
    let reading = std::thread::spawn(move || std::io::read_to_string(stdout).expect("it is text"));
    let (status, errors) = process.wait();

    assert_eq!(status.code(), Some(0), "{errors}");
    assert!(errors.contains("; tried again, 2 of 3"), "{errors}");
    let summary: Value = serde_json::from_str(&reading.join().expect("no panic")).expect("JSON");
    let row = &summary["experiments"][0];
    assert_eq!((&row["ending"], &row["is_finished"]), (&"completed".into(), &true.into()));
    let [attempt] = &row["attempts"].as_array().expect("a list")[..] else { panic!("{row}") };
    assert_eq!((&attempt["ending"], &attempt["has_started"]), (&"failed".into(), &false.into()));
    assert!(attempt["reason"].as_str().is_some_and(|reason| reason.contains("/nobodys")));
    assert_eq!(attempt.get("bag"), None, "nothing was recorded");
    let folder = place.path().join("out/001_three");
    check_manifest(&folder);
    assert_eq!(&manifest(&folder)["attempts"][0], attempt);
    assert_eq!(manifest(&folder)["record"]["seed"], 1);

    what_an_earlier_version_took_for_finished(place.path());
}

#[test]
fn a_run_in_which_the_world_waits_in_vain_is_void_and_tried_again_with_its_seed() {
    let place = place();
    of_one_run(place.path());
    let mut process = Process::start(&mut campaign(place.path()));
    let folder = place.path().join("out/001_three");
    let length = |file: &str| std::fs::metadata(folder.join(file)).map_or(0, |file| file.len());
    wait_for("the first steps", || length("bag/bag_0.mcap") > 100_000);
    // Which all of its nodes are in.
    let pid = process.0.id();
    let namespace = |pid: &str| std::fs::read_link(format!("/proc/{pid}/ns/user")).expect("Linux");
    let user_namespace = namespace("self") != namespace(&pid.to_string());
    let enter = Confinement { pid, user_namespace }.enter_command();
    let set_loopback = |state: &str| {
        let line = format!("{enter} ip link set lo {state}");
        let set = Command::new("sh").args(["-c", &line]).status();
        assert!(set.expect("every system has a shell").success(), "{line}");
    };
    set_loopback("down");
    wait_for("the end of the run", || folder.join("bag.unfinished_1").exists());
    set_loopback("up");
    let (status, errors) = process.wait();

    assert_eq!(status.code(), Some(0), "{errors}");
    assert!(errors.contains("; tried again, 2 of 3"), "{errors}");
    let manifest = manifest(&folder);
    let [attempt] = &manifest["attempts"].as_array().expect("a list")[..] else {
        panic!("{manifest}")
    };
    assert_eq!(attempt["ending"], "void", "{attempt}");
    assert_eq!(manifest["record"]["seed"], 1);
    assert_eq!(manifest["ending"], "completed", "{manifest}");
}

#[test]
fn a_run_whose_controllers_are_never_found_is_tried_again_with_nodes_that_are_started_anew() {
    let place = place();
    of_one_run(place.path());
    let mut process = Process::start(&mut campaign(place.path()));
    let nodes = || nodes_of(process.0.id());
    wait_for("both nodes", || nodes().len() == 2);
    let before = nodes();
    let controllers = before.iter().find(|pid| {
        let words = std::fs::read_to_string(format!("/proc/{pid}/cmdline"));
        words.is_ok_and(|words| words.contains("controller"))
    });
    let controllers = controllers.expect("one of them").to_string();
    let stopped = Command::new("kill").args(["-STOP", &controllers]).status();
    assert!(stopped.expect("every system has `kill`").success());

    let (status, errors) = process.wait();

    assert_eq!(status.code(), Some(0), "{errors}");
    assert!(errors.contains("; tried again, 2 of 3"), "{errors}");
    let manifest = manifest(&place.path().join("out/001_three"));
    assert_eq!(manifest["ending"], "completed", "{manifest}");
}

/// Makes the manifest of a version that took runs without a result for finished.
fn without_result(folder: &Path, changes: &[(&str, Value)]) {
    let mut manifest = manifest(folder);
    for (key, value) in changes {
        manifest[key] = value.clone();
    }
    for key in ["attempts", "lost_robots"] {
        manifest.as_object_mut().expect("it is one").remove(key);
    }
    drop(std::fs::remove_file(folder.join("attempts.json")));
    drop(std::fs::remove_file(folder.join("label.json")));
    let files = manifest["files"].as_array_mut().expect("a list");
    files.retain_mut(|file| {
        let Ok(bytes) = std::fs::read(folder.join(file["path"].as_str().expect("text"))) else {
            return false;
        };
        file["size_bytes"] = bytes.len().into();
        file["sha256"] = format!("{:x}", HexDisplay(&Sha256::digest(&bytes))).into();
        true
    });
    write(folder, "manifest.json", &manifest.to_string());
}

/// The rest of the story of one campaign, whose run need not be made again for it.
fn what_an_earlier_version_took_for_finished(place: &Path) {
    let folder = place.join("out/001_three");
    let bag = || std::fs::read(folder.join("bag/bag_0.mcap")).expect("it is there");
    let whole = bag();

    // Judged by now: nothing is run.
    let unjudged = [("phase", Value::Null), ("not_judged", Value::from("a gap of 1.1 s"))];
    without_result(&folder, &unjudged);
    let judged = to_the_end(place);
    assert_eq!(code(&judged), 0, "{}", stderr(&judged));
    assert!(bag() == whole, "the same bag, judged again");
    assert!(manifest(&folder)["phase"].is_string());

    // Still not judged: kept, listed, and run again.
    let lacking = copied(&folder.join("bag"), "lacking", |message| {
        let is_late =
            message.topic.starts_with("/robot_2/odom") && message.log_time_ns > 9_000_000_000;
        if is_late { Vec::new() } else { vec![message] }
    });
    lacking.finish().expect("the disk has room");
    std::fs::remove_dir_all(folder.join("bag")).expect("it is ours");
    std::fs::rename(folder.join("lacking"), folder.join("bag")).expect("it is ours");
    let mcap = folder.join("bag/lacking_0.mcap");
    let recorded = std::fs::read(&mcap).expect("it was copied");
    without_result(&folder, &unjudged);
    let mut old = manifest(&folder);
    let files = old["files"].as_array_mut().expect("a list");
    files.push(serde_json::json!({
        "path": "bag/lacking_0.mcap",
        "size_bytes": recorded.len(),
        "sha256": format!("{:x}", HexDisplay(&Sha256::digest(&recorded))),
    }));
    write(&folder, "manifest.json", &old.to_string());

    let again = to_the_end(place);

    assert_eq!(code(&again), 0, "{}", stderr(&again));
    let kept = folder.join("bag.unfinished_1/lacking_0.mcap");
    assert!(std::fs::read(kept).expect("it is kept") == recorded);
    let manifest = manifest(&folder);
    assert!(manifest["phase"].is_string(), "{manifest}");
    let attempt = &manifest["attempts"][0];
    assert_eq!(attempt["reason"], "not judged: a gap of 1.1 s");
    assert_eq!((&attempt["ending"], &attempt["has_started"]), (&"completed".into(), &true.into()));
    check_manifest(&folder);
}

#[test]
fn a_campaign_of_an_earlier_version_is_gone_on_with_after_a_robot_was_replaced() {
    // One run was finished, too short for a label, and the program was killed in the next one.
    let place = tempfile::tempdir().expect("a temporary folder");
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/campaign/half_finished");
    copy(&stored, place.path());
    let out = place.path().join("out");
    let finished = contents(&out.join("001_short"));
    let fleet = text_in(place.path(), "fleets/fleet.yaml");
    let of_spare = fleet.replace("robot_2: {enabled: true", "robot_2: {enabled: false");
    assert_ne!(of_spare, fleet);
    write(&place.path().join("fleets"), "fleet.yaml", &of_spare);

    let resumed = to_the_end(place.path());

    let errors = stderr(&resumed);
    assert_eq!(code(&resumed), 3, "the first has no label: {errors}");
    assert!(contents(&out.join("001_short")) == finished, "it is finished");
    let summary = json(&resumed);
    assert_eq!(summary["n_finished"], 2, "{summary}");
    let robots = |index: usize| summary["experiments"][index]["robots"].clone();
    assert_eq!(robots(0), serde_json::json!(["robot_1", "robot_2"]));
    assert_eq!(robots(1), serde_json::json!(["robot_1", "robot_3"]));
    assert_eq!(manifest(&out.join("002_long"))["record"]["robots"], robots(1));
    let attempt = &manifest(&out.join("002_long"))["attempts"][0];
    assert_eq!(attempt["ending"], "broken_off");
    assert_eq!(attempt["robots"], robots(0));
    check_manifest(&out.join("002_long"));

    // Another change is one of the experiment.
    let long = text_in(place.path(), "two.yaml");
    write(place.path(), "two.yaml", &long.replace("radius_m: 0.6", "radius_m: 0.7"));
    let other = to_the_end(place.path());
    assert_eq!(code(&other), 1);
    let printed = stderr(&other);
    assert!(printed.contains("out holds another campaign: 002_long is not the same"), "{printed}");
}

#[test]
fn nothing_is_mixed_into_a_folder_that_holds_something_else() {
    let place = place();
    std::fs::create_dir(place.path().join("out")).expect("it is writable");
    write(&place.path().join("out"), "thesis.tex", "");

    let refused = to_the_end(place.path());

    assert_eq!(code(&refused), 1);
    let printed = stderr(&refused);
    assert!(
        printed.contains("out is not the folder of a campaign: it holds thesis.tex"),
        "{printed}"
    );
}

#[test]
fn without_a_terminal_no_fleet_is_started() {
    let place = place();

    let mut command = campaign(place.path());
    let refused = command.args(["--backend", "fleet", "--interface", "127.0.0.1"]).output();
    let refused = refused.expect("the program was built for this test");

    assert_eq!(code(&refused), 1);
    let printed = stderr(&refused);
    assert!(printed.contains("stdin is not a terminal"), "{printed}");
    assert!(printed.contains("--yes"), "{printed}");
    assert!(!place.path().join("out").exists(), "nothing was begun");
}

#[test]
fn who_places_the_robots_may_skip_and_quit() {
    let place = place();
    let mut terminal = Terminal::open();
    let mut command = campaign(place.path());
    command.args(["--backend", "fleet", "--interface", "127.0.0.1"]).stdin(terminal.input());

    let mut process = Process::start(&mut command);
    let mut printed = String::new();
    let mut stderr = process.0.stderr.take().expect("it is piped");
    let mut until = |ends: usize| {
        while printed.matches("Enter starts, s skips, q quits").count() < ends {
            let mut piece = [0; 4096];
            let n = stderr.read(&mut piece).expect("it can be read");
            assert!(n > 0, "it ended: {printed}");
            printed.push_str(&String::from_utf8_lossy(&piece[..n]));
        }
    };
    until(1);
    terminal.type_line("start");
    until(2);
    terminal.type_line("s");
    until(3);
    terminal.type_line("q");
    let (status, _) = process.wait();

    assert_eq!(status.code(), Some(3), "{printed}");
    assert!(
        printed.contains("001_three: 0.15 m/s, 0.75 rad/s, for 64 s\nplace the robots:"),
        "{printed}"
    );
    assert!(printed.contains("002_three: 0.15 m/s"), "{printed}");
    assert!(printed.contains("robot_3 "), "{printed}");
    assert!(!place.path().join("out/001_three").exists(), "nothing was run");
}

#[test]
fn a_campaign_whose_program_is_rebuilt_goes_on_with_the_old_one() {
    let place = place();
    let program = place.path().join("rsrs");
    // By a process of its own: while this one writes a file, those that other tests start hold it open, and
    // a program that is open for writing does not start.
    let copied = Command::new("cp").arg(env!("CARGO_BIN_EXE_rsrs")).arg(&program).status();
    assert!(copied.expect("every system has `cp`").success());
    let mut command = Command::new(&program);
    rsrs_ros::confine::start_in_own_network(&mut command);
    command.current_dir(place.path()).args(["campaign", "campaign.yaml", "-o", "out"]);

    let mut process = Process::start(&mut command);
    wait_for("the first recording", || place.path().join("out/001_three/bag/bag_0.mcap").exists());
    std::fs::remove_file(&program).expect("it is there");
    std::fs::write(&program, "#!/bin/sh\nexit 70\n").expect("the folder is writable");
    let (status, errors) = process.wait();

    assert!(status.success(), "{errors}");
    check_manifest(&place.path().join("out/002_three"));
}
