//! Controllers that are tables in files, through the whole program.

use std::path::Path;

use crate::command::{code, repository, rsrs as typed, stderr, stdout};
use crate::fleet::experiment;
use crate::processes::run_in_lockstep;
use crate::recorded::{assert_commands_of_replicate, assert_digests_of_replicate, record_of};
use rsrs_core::robot::controller::Controller;

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
    let output = run_in_lockstep(&file, &path);

    assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
    let (bag, record) = record_of(&path);
    let Controller::Machine(machine) = &record.conditions.controller else {
        panic!("{:?}", record.conditions.controller);
    };
    assert_eq!(machine.states(), ["search", "dwell", "leave"]);
    assert_eq!(machine.numbers["dwell_s"].to_bits(), 1.5_f64.to_bits());
    assert!(bag.attachment("controller.yaml").is_some(), "the file is there, too");
    assert_digests_of_replicate(&bag, &record);
    assert_commands_of_replicate(&bag, &record);

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

/// What a sweep and its shards hold is named with the difference where the sweep, its controller's table or
/// its behaviour's file has been edited since.
#[test]
fn a_folder_is_not_gone_on_with_after_its_controller_or_behaviour_was_edited() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = folder.path();
    let write = |name: &str, text: &str| {
        std::fs::write(place.join(name), text).expect("the folder is writable");
    };
    let table = std::fs::read_to_string(repository().join(TABLE)).expect("it is shipped");
    let behaviour = |bound: f64| {
        format!(
            "name: gathering\nwords: {{noun: gathering, swarm: a gathering swarm, verb: [gather, gathers, \
             gathered]}}\nphases: [{{key: gathered}}, {{key: scattered}}]\nrules: [{{phase: gathered, when: \
             {{clustered: {{at_least: {bound}}}}}}}]\notherwise: scattered\n"
        )
    };
    write("search.yaml", &table);
    write("gathering.yaml", &behaviour(0.5));
    let profile = repository().join("launch_configs/profiles/flockbot.yaml");
    let profile = profile.display();
    write(
        "sweep.yaml",
        &format!(
            "profile: {profile}\ncontroller: search.yaml\nbehaviour: gathering.yaml\naxes: \
             {{controller.dwell_s: [1, 2]}}\nfixed: {{robots: 3, placement_radius_m: 1, arena_m: 4}}\n\
             replicates: 2\nduration_s: 60\nseed: 1\n"
        ),
    );
    let sweep = |arguments: &[&str]| typed(place, &[&["sweep", "sweep.yaml"], arguments].concat());
    assert_eq!(code(&sweep(&["-o", "out"])), 0);
    assert_eq!(code(&sweep(&["-o", "half", "--shard", "1/2"])), 0);

    for (file, edited, difference) in [
        (
            "search.yaml",
            table.replacen("speed_m_s: 0.2,", "speed_m_s: 0.25,", 1),
            "controller.rows[",
        ),
        (
            "gathering.yaml",
            behaviour(0.6),
            "behaviour.rules[0].when.clustered.at_least is 0.5 there, and 0.6 here",
        ),
    ] {
        let before = std::fs::read_to_string(place.join(file)).expect("it was written");
        assert_ne!(before, edited, "{file}");
        write(file, &edited);

        let again = sweep(&["-o", "out"]);
        let other = sweep(&["-o", "other", "--shard", "2/2"]);
        let merged = typed(place, &["merge", "other", "half", "-o", "whole"]);

        for (output, words) in
            [(again, "holds another sweep"), (merged, "are shards of different sweeps")]
        {
            assert_eq!((code(&output), code(&other)), (1, 0), "{file}: {}", stdout(&output));
            let error = stderr(&output);
            assert!(error.contains(words) && error.contains(difference), "{error}");
        }
        std::fs::remove_dir_all(place.join("other")).expect("it was swept");
        write(file, &before);
    }
    assert_eq!(code(&sweep(&["-o", "out"])), 0, "what is the same is still taken for it");
}
