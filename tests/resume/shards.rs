//! Sweeps that several machines share.

use crate::command::{code, stderr};
use crate::work::{SweepFolder, bytes, contents};

/// A sweep of 16 blocks, done whole and in two shards.
fn shared() -> SweepFolder {
    let place = SweepFolder::with_sweep(2048);
    place.sweep_into("whole");
    for (folder, shard) in [("odd", "1/2"), ("even", "2/2")] {
        let output = place.rsrs(&["sweep", "sweep.yaml", "-o", folder, "--shard", shard]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    place
}

/// What the program prints when it refuses.
fn refusal(place: &SweepFolder, arguments: &[&str]) -> String {
    let output = place.rsrs(arguments);
    assert_eq!(code(&output), 1);
    stderr(&output)
}

#[test]
fn merged_shards_are_the_folder_of_one_machine_and_stay_as_they_are() {
    let place = shared();
    let before =
        (contents(&place.path("odd/unfinished")), contents(&place.path("even/unfinished")));
    assert_eq!((before.0.len(), before.1.len()), (9, 9), "eight blocks and the lock");

    let output = place.rsrs(&["merge", "even", "odd", "-o", "merged"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(contents(&place.path("merged")), contents(&place.path("whole")));
    let after = (contents(&place.path("odd/unfinished")), contents(&place.path("even/unfinished")));
    assert_eq!(after, before);
}

#[test]
fn a_shard_that_was_killed_goes_on_and_does_no_other_ones_work() {
    let place = SweepFolder::with_sweep(2048);
    let shard = ["sweep", "sweep.yaml", "-o", "odd", "--shard", "1/2"];
    let mut child = place.spawn(&shard);
    place.wait_for_blocks("odd", 1);
    child.kill().unwrap();
    child.wait().unwrap();

    let unfinished = refusal(&place, &["choose", "odd"]);
    let again = place.rsrs(&shard);

    assert!(unfinished.contains("or put shards together with `rsrs merge`"), "{unfinished}");
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    let numbers: Vec<String> = place
        .blocks("odd")
        .iter()
        .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    let even: Vec<String> = (0..16).step_by(2).map(|it| format!("block_{it:06}")).collect();
    assert_eq!(numbers, even);
}

#[test]
fn what_is_missing_damaged_or_of_another_sweep_is_not_merged() {
    let place = shared();
    place.change("sweep.yaml", "other.yaml", "seed: 7", "seed: 8");
    let other = place.rsrs(&["sweep", "other.yaml", "-o", "other", "--shard", "2/2"]);
    assert_eq!(code(&other), 0, "{}", stderr(&other));

    let missing = refusal(&place, &["merge", "odd", "-o", "merged"]);
    let itself = refusal(&place, &["merge", "odd", "even", "-o", "odd"]);
    let whole = refusal(&place, &["merge", "odd", "whole", "-o", "merged"]);
    let different = refusal(&place, &["merge", "odd", "other", "-o", "merged"]);
    let block = place.path("even/unfinished/block_000001");
    let mut damaged = bytes(&block);
    damaged[100] ^= 1;
    std::fs::write(&block, &damaged).unwrap();
    let torn = refusal(&place, &["merge", "odd", "even", "-o", "merged"]);

    assert!(missing.contains("of this sweep 8192 runs are missing in odd"), "{missing}");
    assert!(itself.contains("odd is one of the shards"), "{itself}");
    assert!(whole.contains("whole holds a whole sweep"), "{whole}");
    assert!(different.contains("shards of different sweeps: seed is 8 there"), "{different}");
    assert!(torn.contains("of this sweep 1024 runs are missing in odd, even"), "{torn}");
    assert_eq!(bytes(&block), damaged, "the shard is not touched");
    assert!(!place.path("merged").exists());
}

#[test]
fn a_shard_that_is_named_twice_is_refused_as_such() {
    let place = shared();

    let twice = refusal(&place, &["merge", "odd", "odd", "-o", "merged"]);
    let disguised = refusal(&place, &["merge", "odd", "./even/../odd", "-o", "merged"]);

    assert!(twice.starts_with("error: odd is given twice\nhelp: name every shard once"), "{twice}");
    assert!(
        disguised.starts_with("error: odd and ./even/../odd are the same folder"),
        "{disguised}"
    );
    assert!(!place.path("merged").exists());
}

#[test]
fn a_small_sweep_is_shared_and_so_is_one_in_the_reference_world() {
    let place = SweepFolder::with_sweep(20);
    let world = "objects: [{count: 3, radius_m: 0.05}]\n";
    std::fs::write(place.path("world.yaml"), world).unwrap();
    place.change("sweep.yaml", "with_objects.yaml", "seed: 7", "seed: 7\nworld: world.yaml");
    place.change("with_objects.yaml", "with_objects.yaml", "replicates: 20", "replicates: 2");
    for (file, n_runs) in [("sweep.yaml", 8 * 20), ("with_objects.yaml", 8 * 2)] {
        let runs = ["1/2", "2/2"].map(|shard| {
            let folder = format!("{file}_{}", shard.replace('/', "_of_"));
            let sweep = ["sweep", file, "-o", &folder, "--shard", shard, "--format", "json"];
            let output = place.rsrs(&sweep);
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            report["runs"].as_u64().unwrap()
        });

        assert_eq!(runs[0] + runs[1], n_runs, "{file}");
        assert!(runs[0].abs_diff(runs[1]) <= n_runs / 4, "{file}: {runs:?}");
    }
}
