//! Which cells may be swept, chosen and run: those that robots can be commanded, in the units that are
//! asked for, of the sweep that is asked for.

use std::path::Path;
use std::process::Output;

use crate::command::{code, done, repository, rsrs, shipped, stderr, stdout, text_in};
use crate::prepared_sweeps::{self, SPEEDS, chosen, swept, write_sweep};
use crate::processes::run_in_lockstep;
use crate::recorded::record_of;
use crate::simulated_bags::Run;
use rsrs_core::robot::region::Region;

/// What is refused in a sweep file of the Flockbot, in one line.
fn refused(folder: &Path, lines: &str) -> String {
    let sweep =
        format!("profile: flockbot.yaml\n{lines}\nreplicates: 1\nduration_s: 60\nseed: 7\n");
    std::fs::write(folder.join("odd.yaml"), sweep).expect("the folder is writable");
    let output = rsrs(folder, &["sweep", "odd.yaml", "-o", "odd"]);
    assert_eq!(code(&output), 1, "{lines}: {}", stdout(&output));
    assert!(!folder.join("odd").exists(), "{lines}");
    stderr(&output)
}

#[test]
fn a_cell_beside_an_experiment_file_with_a_sweep_is_refused_with_both_ways_out() {
    let place = prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8");
    let text = std::fs::read_to_string(shipped("experiments/flockbot_milling.yaml"))
        .expect("it is shipped");
    let text =
        text.replace("cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}", "from: out");
    assert!(text.contains("\nfrom: out\n"), "{text}");
    std::fs::write(place.path().join("mine.yaml"), text).expect("the folder is writable");
    let cell = "speed_m_s=0.1,turn_rate_rad_s=0.75,robots=9";

    let run = rsrs(place.path(), &["run", "mine.yaml", "--cell", cell]);
    let placed = rsrs(place.path(), &["place", "mine.yaml", "--cell", cell]);

    for output in [run, placed] {
        assert_eq!(code(&output), 1, "{}", stdout(&output));
        let error = "mine.yaml: its cell is `from` a sweep, and the cell \
                     `speed_m_s=0.1,turn_rate_rad_s=0.75,robots=9` is asked for, expected one of them";
        assert!(stderr(&output).contains(error), "{}", stderr(&output));
        assert!(stderr(&output).contains("help: `--from out`"), "{}", stderr(&output));
    }
}

#[test]
fn cells_beyond_the_robots_limits_are_refused_wherever_they_are_asked_for() {
    let place = prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8");
    let experiment = &shipped("experiments/flockbot_milling.yaml");
    let too_fast = "speed_m_s is 0.4, beyond the robots' limits: expected 0.02 to 0.3 m/s";
    let slower = text_in(place.path(), "flockbot.yaml");
    let slower = slower.replace("limits_m_s: [0.02, 0.30]", "limits_m_s: [0.02, 0.10]");
    std::fs::write(place.path().join("slow.yaml"), slower).expect("the folder is writable");

    let sweep = refused(
        place.path(),
        "axes: {speed_m_s: {from: 0.1, to: 0.4, steps: 4}}\n\
         fixed: {turn_rate_rad_s: 0.75, robots: 9, placement_radius_m: 0.6}",
    );
    let fixed = refused(
        place.path(),
        "axes: {speed_m_s: [0.1, 0.15]}\n\
         fixed: {turn_rate_rad_s: 2.6, robots: 9, placement_radius_m: 0.6}",
    );
    let cell = "speed_m_s=0.4,turn_rate_rad_s=0.75,robots=9";
    let run = rsrs(place.path(), &["run", experiment, "--cell", cell]);
    let placed = rsrs(place.path(), &["place", experiment, "--cell", cell]);

    assert!(sweep.contains(&format!("odd.yaml: cell `speed_m_s=0.4`: {too_fast}")), "{sweep}");
    assert!(sweep.contains("help: stay within the limits; if the robots were found"), "{sweep}");
    assert!(fixed.contains("turn_rate_rad_s is 2.6, beyond the robots' limits"), "{fixed}");
    for output in [&run, &placed] {
        assert_eq!(code(output), 1, "{}", stdout(output));
        assert!(stderr(output).contains(too_fast), "{}", stderr(output));
        assert!(
            stderr(output).contains("change `actuation.speed.limits_m_s`"),
            "{}",
            stderr(output)
        );
    }
    // Robots that are slower are not recommended the speed of others.
    let sweep = text_in(place.path(), "sweep.yaml");
    let sweep = sweep.replace("flockbot.yaml", "slow.yaml");
    std::fs::write(place.path().join("slow_sweep.yaml"), sweep).expect("the folder is writable");
    let slow = rsrs(place.path(), &["sweep", "slow_sweep.yaml", "-o", "out"]);
    assert_eq!(code(&slow), 1);
    assert!(stderr(&slow).contains("expected 0.02 to 0.1 m/s"), "{}", stderr(&slow));
}

#[test]
fn cells_that_ask_too_much_of_a_wheel_are_refused_wherever_they_are_asked_for() {
    let place = prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8");
    let profile = text_in(place.path(), "flockbot.yaml");
    let wheels = "actuation:\n  wheels: {base_m: 0.12, speed_max_m_s: 0.2}";
    let profile = profile.replace("actuation:", wheels);
    std::fs::write(place.path().join("flockbot.yaml"), profile).expect("the folder is writable");

    let swept = refused(
        place.path(),
        "axes: {speed_m_s: [0.1, 0.15, 0.2]}\n\
         fixed: {turn_rate_rad_s: 1.0, robots: 9, placement_radius_m: 0.6}",
    );

    let too_fast = "cell `speed_m_s=0.15`: 0.15 m/s at 1 rad/s ask 0.210 m/s of a wheel, beyond the \
                    robots' wheels: expected at most 0.2 m/s, 0.12 m apart";
    assert!(swept.contains(too_fast), "{swept}");
    assert!(swept.contains("help: turn or drive slower"), "{swept}");
}

#[test]
fn values_in_other_units_are_refused_wherever_a_person_types_them() {
    let place = prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8");
    let experiment = &shipped("experiments/flockbot_milling.yaml");
    let fleet = &shipped("fleets/nine_virtual.yaml");
    let fixed = "turn_rate_rad_s: 0.75, robots: 9, placement_radius_m: 0.6";
    let millimetres = "this looks like mm/s, expected m/s";
    let degrees = "this looks like degrees per second, expected rad/s";

    for (lines, expected) in [
        (
            format!("axes: {{speed_m_s: {{from: 50, to: 300, steps: 3}}}}\nfixed: {{{fixed}}}"),
            format!("odd.yaml: speed_m_s is 50: {millimetres}"),
        ),
        (
            "cells: [{speed_m_s: 0.15, turn_rate_rad_s: 43}]\nfixed: {robots: 9}".to_owned(),
            format!("turn_rate_rad_s is 43: {degrees}"),
        ),
        (
            "axes: {turn_rate_rad_s: [0.75]}\nfixed: {robots: 9, speed_m_s: 150}".to_owned(),
            format!("odd.yaml: speed_m_s is 150: {millimetres}"),
        ),
    ] {
        let printed = refused(place.path(), &lines);
        assert!(printed.contains(&expected), "{lines}: {printed}");
    }
    let cell = rsrs(place.path(), &["run", experiment, "--cell", "speed_m_s=150,robots=9"]);
    assert_eq!(code(&cell), 2);
    assert!(
        stderr(&cell).contains(&format!("speed_m_s is 150: {millimetres}")),
        "{}",
        stderr(&cell)
    );
    let plan = rsrs(place.path(), &["measure", "plan", fleet, "--speed", "20,300"]);
    assert_eq!(code(&plan), 2);
    assert!(
        stderr(&plan).contains(&format!("speed_m_s is 300: {millimetres}")),
        "{}",
        stderr(&plan)
    );
    let drive = ["measure", "drive", fleet, "--robot", "robot_1", "--duration", "20"];
    let drive = rsrs(place.path(), &[&drive[..], &["--turn-rate", "45"]].concat());
    assert_eq!(code(&drive), 1);
    assert!(
        stderr(&drive).contains(&format!("turn_rate_rad_s is 45: {degrees}")),
        "{}",
        stderr(&drive)
    );
}

#[test]
fn an_axis_that_is_swept_and_fixed_has_two_values_and_is_refused() {
    let place = prepared_sweeps::workplace(SPEEDS, "true_positive: 0.8");

    let both = refused(
        place.path(),
        "axes: {speed_m_s: [0.1, 0.15]}\n\
         fixed: {speed_m_s: 0.2, turn_rate_rad_s: 0.75, robots: 9}",
    );
    let listed = refused(
        place.path(),
        "cells: [{speed_m_s: 0.15, robots: 9}]\nfixed: {turn_rate_rad_s: 0.75, robots: 8}",
    );

    assert!(both.contains("odd.yaml: `speed_m_s` is swept and fixed, expected one"), "{both}");
    assert!(listed.contains("odd.yaml: `robots` is swept and fixed, expected one"), "{listed}");
}

#[test]
fn a_cell_with_a_capability_is_run_with_robots_that_have_it_or_not_at_all() {
    let place = swept("range_m: [0.75, 2]", "speed_m_s: 0.15");
    let files = repository().join("launch_configs");
    for folder in ["fleets", "profiles", "experiments"] {
        std::fs::create_dir(place.path().join(folder)).expect("the folder is writable");
    }
    for file in ["fleets/nine_virtual.yaml", "profiles/flockbot.yaml"] {
        std::fs::copy(files.join(file), place.path().join(file)).expect("it is shipped");
    }
    let text = text_in(&files, "experiments/flockbot_milling.yaml")
        .replace("0.825", "0.60")
        .replace("duration_s: 300", "duration_s: 120");
    let write = |name: &str, text: &str| {
        std::fs::write(place.path().join(name), text).expect("the folder is writable");
    };
    write("experiments/measured.yaml", &text);
    write("experiments/harsher.yaml", &text.replace("profile: measured", "profile: harsher"));
    let cell = "range_m=2,turn_rate_rad_s=0.75";

    let measured =
        rsrs(place.path(), &["run", "experiments/measured.yaml", "--from", "out", "--cell", cell]);
    let harsher = Path::new("experiments/harsher.yaml");
    run_in_lockstep(harsher, &["--from", "out", "--cell", cell], &place.path().join("far"));

    assert_eq!(code(&measured), 1, "{}", stdout(&measured));
    let printed = stderr(&measured);
    let expected = "cell `range_m=2,turn_rate_rad_s=0.75` of out is one of robots with range_m=2, a \
                    capability, and the run moves the robots as measured";
    assert!(printed.contains(expected), "{printed}");
    assert!(
        printed.contains("help: `simulator: {profile: harsher}` in the experiment file"),
        "{printed}"
    );
    let simulated = record_of(&place.path().join("far")).1.conditions.robot;
    let Region::Cone { range_m, .. } = simulated.region else { panic!("{simulated:?}") };
    assert_eq!(range_m.to_bits(), 2.0_f64.to_bits());
    // Of the same robots as in the sweep, to the last number: the cell's own replicate.
    let episode = ["episode", "out", "--cell", cell, "--replicate", "0", "-o", "replicate"];
    done(place.path(), &episode);
    assert_eq!(record_of(&place.path().join("replicate")).1.conditions.robot, simulated);
}

#[test]
fn a_choice_of_another_sweep_over_the_same_cells_is_refused() {
    let place = chosen();
    write_sweep(place.path(), "other.yaml", SPEEDS, "true_positive: 0.9");
    let other = rsrs(place.path(), &["sweep", "other.yaml", "-o", "other"]);
    assert_eq!(code(&other), 0, "{}", stderr(&other));
    let choice = place.path().join("out/choice.json");
    std::fs::copy(&choice, place.path().join("other/choice.json")).expect("both are there");
    Run::new(1).record(place.path(), "monday");
    let experiment = &shipped("experiments/flockbot_milling.yaml");

    let compared = rsrs(place.path(), &["compare", "other", "--bags", "monday"]);
    let run = rsrs(place.path(), &["run", experiment, "--from", "other"]);
    done(place.path(), &["compare", "out", "--bags", "monday"]);
    for output in [&compared, &run] {
        assert_eq!(code(output), 1, "{}", stdout(output));
        let printed = stderr(output);
        assert!(printed.contains("was chosen from another sweep: sweep_digest is "), "{printed}");
        assert!(printed.contains("`rsrs choose other -o other/choice.json`"), "{printed}");
    }
    // One that does not state whose it is could be anyone's.
    let mut anonymous: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&choice).expect("it is there")).expect("it is JSON");
    anonymous
        .as_object_mut()
        .expect("an object")
        .remove("sweep_digest")
        .expect("it states whose it is");
    std::fs::write(&choice, anonymous.to_string()).expect("the folder is writable");
    let compared = rsrs(place.path(), &["compare", "out", "--bags", "monday"]);
    assert_eq!(code(&compared), 1);
    let printed = stderr(&compared);
    assert!(printed.contains("does not state from which sweep it was chosen"), "{printed}");
}

/// One replicate of a sweep as a bag.
fn episode(folder: &Path, sweep: &str, bag: &str) {
    let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75";
    done(folder, &["episode", sweep, "--cell", cell, "--replicate", "0", "-o", bag]);
}

#[test]
fn a_sweep_is_not_compared_with_its_own_replicates() {
    let place = chosen();
    let sweep = text_in(place.path(), "sweep.yaml");
    for seed in [8, 9] {
        let other = sweep.replace("seed: 7", &format!("seed: {seed}"));
        std::fs::write(place.path().join("other.yaml"), other).expect("the folder is writable");
        let folder = format!("seed_{seed}");
        done(place.path(), &["sweep", "other.yaml", "-o", &folder]);
        episode(place.path(), &folder, &format!("of_{seed}"));
    }
    episode(place.path(), "out", "own");
    let compare = |bags: &[&str]| -> Output {
        rsrs(place.path(), &[&["compare", "out", "--bags"], bags].concat())
    };

    let own = compare(&["own"]);
    let others = compare(&["of_8", "of_9"]);
    let twice = compare(&["of_8", "of_8"]);

    assert_eq!(code(&own), 1, "{}", stdout(&own));
    let expected = "own: is a replicate of the sweep itself, with its robots and its seed, 7";
    assert!(stderr(&own).contains(expected), "{}", stderr(&own));
    // Replicates 0 of sweeps that differ in their seed alone are two runs.
    assert_eq!(code(&others), 0, "{}", stderr(&others));
    assert!(stdout(&others).contains("of 2 runs milled"), "{}", stdout(&others));
    let ids = ["of_8", "of_9"].map(|bag| record_of(&place.path().join(bag)).1.run_id);
    assert_ne!(ids[0], ids[1]);
    assert_eq!(code(&twice), 1);
    assert!(stderr(&twice).contains("of_8 is the same run as of_8"), "{}", stderr(&twice));
}
