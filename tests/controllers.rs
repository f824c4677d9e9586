//! Controllers that are tables in files, through the whole program.

use std::path::Path;

use crate::command::{code, repository, rsrs as typed, stderr, stdout};
use crate::fleet::experiment;
use crate::processes::confined_rsrs;
use crate::recorded::messages;
use rsrs_bags::Bag;
use rsrs_core::robot::controller::Controller;
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::rsrs::WorldDigest;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

const TABLE: &str = "launch_configs/controllers/search_and_dwell.yaml";

/// Writes an experiment of three robots with the shipped table of three states, and another time for one of them.
fn files(folder: &Path, duration_s: u64) -> std::path::PathBuf {
    std::fs::copy(repository().join(TABLE), folder.join("search.yaml")).expect("it is shipped");
    let cell = "cell: {controller.dwell_s: 1.5, robots: 3}\ncontroller: ../search.yaml";
    let usual = "cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}";
    experiment(folder, duration_s, &[(usual, cell)])
}

#[test]
fn a_controller_with_states_over_ros_2_in_lockstep_is_the_replicate_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), 62);
    let path = folder.path().join("bag");
    let run = || {
        let mut command = confined_rsrs();
        command.arg("run").arg(&file).arg("-o").arg(&path);
        command.output().expect("the program was built for this test")
    };

    let mut output = run();
    // As in `rsrs dry-run`, which tries again what a busy machine has frozen.
    for _ in 0..2 {
        if stdout(&output).contains("void: frozen") {
            std::fs::remove_dir_all(&path).expect("it is there");
            output = run();
        }
    }

    assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
    let bag = Bag::open(&path).expect("a bag");
    let attached = &bag.attachment(ATTACHMENT).expect("it is attached").data;
    let record = ExperimentRecord::from_json(&String::from_utf8_lossy(attached)).expect("one");
    let Controller::Machine(machine) = &record.conditions.controller else {
        panic!("{:?}", record.conditions.controller);
    };
    assert_eq!(machine.states(), ["search", "dwell", "leave"]);
    assert_eq!(machine.numbers["dwell_s"].to_bits(), 1.5_f64.to_bits());
    assert!(bag.attachment("controller.yaml").is_some(), "the file is there, too");
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let expected = episode_digests(&record.conditions, seed, record.duration_s).expect("it fits");
    let digests: Vec<WorldDigest> = messages(&bag, "swarm", "world_digest");
    let found: Vec<u64> = digests.iter().map(|digest| digest.digest).collect();
    assert!(found.len() > 400, "{}", found.len());
    assert_eq!(found, expected[..found.len()]);
    let episode = run_episode(&record.conditions, seed, record.duration_s).expect("it fits");
    for (place, robot) in record.robots.iter().enumerate() {
        let commands: Vec<TwistStamped> = messages(&bag, robot, "cmd_vel");
        assert!(commands.len() > 400, "{}", commands.len());
        for (step, command) in commands.iter().enumerate() {
            let expected = episode.commands[step * record.robots.len() + place];
            let found = (command.twist.linear.x, command.twist.angular.z);
            assert_eq!(found, (expected.speed_m_s, expected.turn_rate_rad_s), "{robot} {step}");
        }
    }

    let replay = typed(folder.path(), &["replay", "bag", "--into", "controller"]);
    assert_eq!(code(&replay), 0, "{}{}", stdout(&replay), stderr(&replay));
    assert!(stdout(&replay).contains(" 0 different"), "{}", stdout(&replay));
}

#[test]
fn a_search_goes_through_the_numbers_of_a_table_and_leaves_sweeps_of_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [profile, table] =
        ["launch_configs/profiles/flockbot.yaml", TABLE].map(|file| repository().join(file));
    let [profile, table] = [&profile, &table].map(|path| path.to_str().expect("it is text"));
    let search = |output: &str| {
        let options = ["--controllers", "12", "--replicates", "2", "--duration", "70"];
        let asked = ["explore", profile, "--controller", table, "--robots", "4", "-o", output];
        typed(folder.path(), &[&asked[..], &options].concat())
    };

    let found = search("gallery");

    assert_eq!(code(&found), 0, "{}{}", stdout(&found), stderr(&found));
    let read = |name: &str| {
        std::fs::read_to_string(folder.path().join("gallery").join(name)).expect("it is written")
    };
    let trials = read("trials.jsonl");
    assert_eq!(trials.lines().count(), 12);
    assert!(trials.lines().all(|line| line.contains(r#""numbers":{"dwell_s":"#)), "{trials}");
    assert!(stdout(&found).contains("dwell_s: "), "{}", stdout(&found));
    assert!(read("controller.yaml").contains("lose_interest"));
    let sweeps = std::fs::read_dir(folder.path().join("gallery/sweeps")).expect("it is made");
    for sweep in sweeps.flatten() {
        let text = std::fs::read_to_string(sweep.path()).expect("it is text");
        assert!(text.contains("controller: ../controller.yaml"), "{text}");
        assert!(text.contains("controller.dwell_s"), "{text}");
    }
    let again = search("gallery");
    assert_eq!(stdout(&again), stdout(&found), "and goes on where it was");
    let forward = ["explore", profile, "--controller", table, "--forward", "-o", "other"];
    assert_eq!(code(&typed(folder.path(), &forward)), 2);
}
