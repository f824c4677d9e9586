//! The entries of the atlas at reduced counts: their own files, through their own commands. Each holds which way
//! the verdict of its page points; `.ci/atlas` makes the numbers.

mod over_ros;

use std::fs;
use std::path::Path;

use crate::command::{done, repository};

/// The files of an entry in a folder of its own, from where they reach the shipped ones as well.
fn files_of(entry: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let configs = repository().join("launch_configs").canonicalize().expect("it is there");
    let configs = configs.to_str().expect("a path in UTF-8");
    let place = repository().join("docs/atlas").join(entry);
    for file in fs::read_dir(place).expect("the atlas has it").flatten() {
        let text = fs::read_to_string(file.path()).expect("an entry's files are text");
        let text = text.replace("../../../launch_configs", configs);
        fs::write(folder.path().join(file.file_name()), text).expect("the folder is writable");
    }
    folder
}

/// In how many of how many runs each cell of a sweep file shows what it is judged for; `instead` has
/// lines of the file, and what stands there instead.
fn swept(place: &Path, file: &str, instead: &[(&str, &str)]) -> Vec<(u64, u64)> {
    let mut text = fs::read_to_string(place.join(file)).expect("the entry has it");
    for (line, other) in instead {
        assert!(text.contains(line), "{file} has no `{line}`:\n{text}");
        text = text.replace(line, other);
    }
    fs::write(place.join("reduced.yaml"), text).expect("the folder is writable");
    let results = tempfile::tempdir().expect("a temporary folder");
    let out = results.path().join("out");
    let out = out.to_str().expect("a path in UTF-8");
    done(place, &["sweep", "reduced.yaml", "-o", out]);
    let cells = fs::read_to_string(Path::new(out).join("cells.csv")).expect("it was swept");
    let mut lines = cells.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a line of names");
    let runs = head.iter().position(|name| *name == "n").expect("a column of runs");
    let count = |cell: &str| cell.parse::<u64>().expect("a count");
    // The wanted phase comes first.
    lines.map(|line| (count(line[runs + 1]), count(line[runs]))).collect()
}

#[test]
fn forty_e_pucks_gather_as_published_and_not_where_they_see_too_little() {
    let folder = files_of("gauci_aggregation");

    let far = swept(folder.path(), "forty.yaml", &[("replicates: 30", "replicates: 2")]);
    let near = swept(
        folder.path(),
        "range.yaml",
        &[("[0.5, 1, 1.5, 2, 3, 5]", "[0.5]"), ("replicates: 10", "replicates: 2")],
    );

    assert_eq!(far, [(2, 2)]);
    assert_eq!(near, [(0, 2)]);
}

#[test]
fn five_e_pucks_cluster_twenty_objects_as_published_and_not_in_a_larger_arena() {
    let folder = files_of("gauci_clustering");

    let trials = swept(folder.path(), "trials.yaml", &[("replicates: 100", "replicates: 8")]);
    let arenas = swept(
        folder.path(),
        "arenas.yaml",
        &[("[2, 2.5, 3.5, 4]", "[2.5, 4]"), ("replicates: 30", "replicates: 3")],
    );

    let [(shown, 8)] = trials[..] else { panic!("{trials:?}") };
    assert!((3..=8).contains(&shown), "{trials:?}");
    assert_eq!(arenas, [(3, 3), (0, 3)]);
}

/// Of the six classes, those that are shown most surely: the place of their genome among the cells, and in how many
/// of eight runs it shows them at least.
const CLASSES: [(&str, usize, u64); 3] =
    [("cyclic_pursuit", 0, 7), ("dispersed", 2, 5), ("milling_crowd", 3, 2)];

#[test]
fn genomes_of_the_six_classes_show_their_own_class_and_hardly_another() {
    let folder = files_of("brown_classes");
    for (class, own, at_least) in CLASSES {
        let behaviour = format!("behaviour: {class}.yaml");
        let instead = [
            ("behaviour: cyclic_pursuit.yaml", behaviour.as_str()),
            ("replicates: 50", "replicates: 8"),
        ];

        let cells = swept(folder.path(), "genomes.yaml", &instead);

        assert_eq!(cells.len(), 6);
        for (genome, (shown, runs)) in cells.iter().enumerate() {
            assert_eq!(*runs, 8);
            let is_right = if genome == own { *shown >= at_least } else { *shown <= 1 };
            assert!(is_right, "{class}: {cells:?}");
        }
    }
}

#[test]
fn foot_bots_of_four_classes_segregate_and_not_where_they_see_too_little() {
    let folder = files_of("mitrano_segregation");
    let angles = "[0.0873, 0.1745, 0.2618, 0.3491, 0.4363, 0.5236, 0.6109, 0.6981, 0.7854]";

    let far = swept(
        folder.path(),
        "beam_angle.yaml",
        &[(angles, "[0.3491]"), ("replicates: 20", "replicates: 3")],
    );
    let near = swept(
        folder.path(),
        "beam_length.yaml",
        &[
            ("[0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5]", "[0.25]"),
            ("replicates: 20", "replicates: 3"),
        ],
    );

    assert_eq!(far, [(3, 3)]);
    assert_eq!(near, [(0, 3)]);
}

#[test]
fn twenty_e_pucks_come_to_consensus_and_not_where_they_see_too_little() {
    let folder = files_of("ozdemir_consensus");
    let few = ("replicates: 50", "replicates: 4");

    let far = swept(folder.path(), "trials.yaml", &[few]);
    let near = swept(
        folder.path(),
        "trials.yaml",
        &[few, ("{robots: [20]}", "{range_m: [0.1]}"), ("{arena_m", "{robots: 20, arena_m")],
    );

    let [(shown, 4)] = far[..] else { panic!("{far:?}") };
    assert!(shown >= 3, "{far:?}");
    assert_eq!(near, [(0, 4)]);
}

#[test]
fn five_shepherds_bring_twenty_sheep_to_a_goal_in_few_runs_and_in_none_where_they_never_see_it() {
    let folder = files_of("ozdemir_shepherding");
    let robot = fs::read_to_string(folder.path().join("e_puck.yaml")).expect("the entry has it");
    let (before, goal) = robot.split_once("- name: goal").expect("they see the goal");
    let blind = goal.replacen("true_positive: 1.0", "true_positive: 0.0", 1);
    assert_ne!(blind, goal);
    fs::write(folder.path().join("blind.yaml"), format!("{before}- name: goal{blind}"))
        .expect("the folder is writable");
    let twenty = ("[15, 25, 35, 45, 55]", "[25]");

    let trials = swept(folder.path(), "five.yaml", &[twenty, ("replicates: 10", "replicates: 5")]);
    let blind = [twenty, ("replicates: 10", "replicates: 2"), ("e_puck.yaml", "blind.yaml")];
    let blind = swept(folder.path(), "five.yaml", &blind);

    let [(shown, 5)] = trials[..] else { panic!("{trials:?}") };
    assert!((1..=3).contains(&shown), "{trials:?}");
    assert_eq!(blind, [(0, 2)]);
}

#[test]
fn twenty_five_e_pucks_cover_an_arena_as_published_and_walking_at_random_they_do_not() {
    let folder = files_of("ozdemir_coverage");
    let few = [("replicates: 100", "replicates: 8")];

    let found = swept(folder.path(), "trials.yaml", &few);
    let at_random = swept(folder.path(), "walk.yaml", &few);

    let [(shown, 8)] = found[..] else { panic!("{found:?}") };
    assert!(shown >= 4, "{found:?}");
    assert_eq!(at_random, [(0, 8)]);
}

#[test]
fn twenty_e_pucks_bring_an_object_to_a_goal_and_not_where_they_never_see_it() {
    let folder = files_of("chen_transport");
    let robot = fs::read_to_string(folder.path().join("e_puck.yaml")).expect("the entry has it");
    let (before, goal) = robot.split_once("- name: goal").expect("they see the goal");
    let blind = goal.replacen("true_positive: 1.0", "true_positive: 0.0", 1);
    assert_ne!(blind, goal);
    fs::write(folder.path().join("blind.yaml"), format!("{before}- name: goal{blind}"))
        .expect("the folder is writable");
    let few = [("replicates: 45", "replicates: 2"), ("duration_s: 900", "duration_s: 240")];

    let by_the_rule = swept(folder.path(), "trials.yaml", &few);
    let blind = [few[0], ("duration_s: 900", "duration_s: 60"), ("e_puck.yaml", "blind.yaml")];
    let blind = swept(folder.path(), "trials.yaml", &blind);

    assert_eq!(by_the_rule, [(2, 2)]);
    assert_eq!(blind, [(0, 2)]);
}
