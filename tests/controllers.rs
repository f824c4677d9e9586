//! Controllers that are tables in files, through the whole program.

use crate::command::{code, repository, rsrs as typed, stderr, stdout, text_in};

const TABLE: &str = "launch_configs/controllers/search_and_dwell.yaml";

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
        let before = text_in(place, file);
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
