//! The command line, at the boundary of its process: texts, exit codes, and what is left on disk.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn rsrs(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the binary was built for this test")
}

/// A folder with the Flockbot's profile and a small sweep of it.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let profile = repository().join("launch_configs/profiles/flockbot.yaml");
    std::fs::copy(profile, folder.path().join("flockbot.yaml")).expect("the profile is there");
    write_sweep(folder.path(), "sweep.yaml", "true_positive: 0.8");
    folder
}

/// Two speeds, one of them far too fast to mill.
fn write_sweep(folder: &Path, name: &str, fixed: &str) {
    let sweep = format!(
        "profile: flockbot.yaml\n\
         axes:\n  speed_m_s: [0.15, 0.30]\n  turn_rate_rad_s: [0.25, 0.75]\n\
         fixed: {{robots: 9, placement_radius_m: 0.60, arena_m: 15, {fixed}}}\n\
         replicates: 16\nduration_s: 120\nseed: 7\n"
    );
    std::fs::write(folder.join(name), sweep).expect("the folder is writable");
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ended by itself")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("messages are UTF-8")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("results are UTF-8")
}

fn bytes(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn one_thread_and_two_threads_make_the_same_folder() {
    let place = workplace();

    let one = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "one", "--threads", "1"]);
    let two = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "two", "--threads", "2"]);

    assert_eq!((code(&one), code(&two)), (0, 0), "{}{}", stderr(&one), stderr(&two));
    for file in ["sweep.yaml", "cells.csv", "replicates.parquet", "diagram.svg", "diagram.png"] {
        let (left, right) =
            (bytes(&place.path().join("one"), file), bytes(&place.path().join("two"), file));
        assert!(left == right, "{file} differs");
    }
}

#[test]
fn the_same_sweep_is_not_computed_again_and_another_one_is_refused() {
    let place = workplace();
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let before = bytes(&place.path().join("out"), "cells.csv");

    let again = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    write_sweep(place.path(), "other.yaml", "true_positive: 0.9");
    let other = rsrs(place.path(), &["sweep", "other.yaml", "-o", "out"]);

    assert_eq!(code(&again), 0);
    assert_eq!(code(&other), 1);
    assert!(stderr(&other).contains("out exists and holds another sweep"), "{}", stderr(&other));
    assert_eq!(bytes(&place.path().join("out"), "cells.csv"), before);
}

#[test]
fn a_folder_of_something_else_is_refused_and_left_alone() {
    let place = workplace();
    std::fs::create_dir(place.path().join("thesis")).expect("the folder is writable");

    let output = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "thesis"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("thesis exists and is not the folder of a sweep"));
    let entries = std::fs::read_dir(place.path()).expect("the folder is readable");
    let names: Vec<_> = entries.map(|entry| entry.expect("readable").file_name()).collect();
    assert_eq!(names.len(), 3, "nothing half-written: {names:?}");
}

#[test]
fn a_wrong_key_is_answered_with_file_line_column_and_the_nearest_key() {
    let place = workplace();
    let text = std::fs::read_to_string(place.path().join("sweep.yaml")).expect("it was written");
    let wrong = text.replace("duration_s:", "duration:");
    std::fs::write(place.path().join("wrong.yaml"), wrong).expect("the folder is writable");

    let output = rsrs(place.path(), &["sweep", "wrong.yaml", "-o", "out"]);

    assert_eq!(code(&output), 1);
    assert_eq!(
        stderr(&output),
        "error: wrong.yaml:7:1: unknown key `duration`; did you mean `duration_s`?\n\
         help: the keys here are: profile, harsher, axes, fixed, cells, replicates, duration_s, \
         seed\n"
    );
    assert!(!place.path().join("out").exists());
}

#[test]
fn the_chosen_cell_is_confirmed_and_drawn() {
    let place = workplace();
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    let choose = rsrs(
        place.path(),
        &["choose", "out", "--confirm", "200", "-o", "out/choice.json", "--format", "json"],
    );
    let diagram = rsrs(place.path(), &["diagram", "out", "-o", "picture.svg"]);

    assert_eq!(code(&choose), 0, "{}{}", stdout(&choose), stderr(&choose));
    let choice: serde_json::Value =
        serde_json::from_str(&stdout(&choose)).expect("the choice is JSON");
    assert_eq!(choice["cell"]["speed_m_s"], 0.15);
    assert_eq!(choice["cell"]["turn_rate_rad_s"], 0.75);
    assert_eq!(choice["n_replicates"], 200);
    assert!(choice["b_s_low"].as_f64().expect("a number") >= 0.8);
    assert_eq!(code(&diagram), 0, "{}", stderr(&diagram));
    let svg = String::from_utf8(bytes(place.path(), "picture.svg")).expect("SVG is UTF-8");
    assert!(svg.contains("chosen cell"), "the chosen cell is named in the legend");
}

#[test]
fn a_viable_share_is_from_0_to_1() {
    let place = workplace();

    for wrong in ["1.5", "-0.1", "NaN", "most"] {
        let output = rsrs(place.path(), &["choose", "out", &format!("--viable={wrong}")]);

        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
        assert!(stderr(&output).contains("--viable <SHARE>"), "{}", stderr(&output));
    }
}

#[test]
fn no_viable_cell_is_an_answer() {
    let place = workplace();
    write_sweep(place.path(), "blind.yaml", "true_positive: 0.2");
    rsrs(place.path(), &["sweep", "blind.yaml", "-o", "blind"]);

    let output = rsrs(place.path(), &["choose", "blind"]);

    assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).starts_with("no viable cell: "), "{}", stdout(&output));
}

#[test]
fn a_picture_of_an_axis_that_was_not_swept_is_refused() {
    let place = workplace();
    rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    let output = rsrs(place.path(), &["diagram", "out", "-o", "p.svg", "--x", "robots"]);
    let misspelt = rsrs(place.path(), &["diagram", "out", "-o", "p.svg", "--x", "robot"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("robots"), "{}", stderr(&output));
    assert_eq!(code(&misspelt), 2);
    assert!(stderr(&misspelt).contains("did you mean `robots`"), "{}", stderr(&misspelt));
    assert!(!place.path().join("p.svg").exists());
}

#[test]
fn a_file_that_is_no_bag_is_not_labelled() {
    let place = workplace();

    let output = rsrs(place.path(), &["label", "sweep.yaml"]);

    assert_eq!(code(&output), 1);
    assert!(stderr(&output).starts_with("error: "), "{}", stderr(&output));
}

#[test]
fn a_run_of_a_cell_that_was_not_swept_names_the_nearest() {
    let place = workplace();
    let swept = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "swept"]);
    let experiment = repository().join("launch_configs/experiments/flockbot_milling.yaml");
    let experiment = experiment.to_str().expect("the path is text");
    let beside = "speed_m_s=0.2,turn_rate_rad_s=0.75";

    let off = rsrs(place.path(), &["run", experiment, "--from", "swept", "--cell", beside]);
    let unchosen = rsrs(place.path(), &["run", experiment, "--from", "swept"]);

    assert_eq!((code(&swept), code(&off), code(&unchosen)), (0, 1, 1));
    let errors = stderr(&off);
    let nearest = "the nearest swept cell is speed_m_s=0.15,turn_rate_rad_s=0.75";
    assert!(errors.contains(nearest), "{errors}");
    let errors = stderr(&unchosen);
    assert!(errors.contains("`rsrs choose swept -o swept/choice.json`"), "{errors}");
}

#[test]
fn a_run_that_could_not_be_compared_with_its_sweep_is_refused_before_it_starts() {
    let place = workplace();
    let swept = rsrs(place.path(), &["sweep", "sweep.yaml", "-o", "swept"]);
    let experiment = repository().join("launch_configs/experiments/flockbot_milling.yaml");
    let experiment = experiment.to_str().expect("the path is text");
    let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75";

    let other = rsrs(place.path(), &["run", experiment, "--from", "swept", "--cell", cell]);

    assert_eq!((code(&swept), code(&other)), (0, 1));
    let errors = stderr(&other);
    assert!(errors.contains("the placement radius is 0.825 m, expected 0.6 m"), "{errors}");
}
