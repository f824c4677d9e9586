//! Reality against the simulator, as a person in the laboratory sees it: bags in, verdict out.

use std::path::Path;
use std::process::{Command, Output};

use crate::bags_cli::implausible::{in_the_corner, millimetres};
use crate::command::{code, copy, json, repository, rsrs, stderr, stdout};
use crate::prepared_sweeps::{chosen, swept};
use crate::simulated_bags::{Part, Run, cut_in_half, ended};
use rsrs_core::comparison::fixed::FixedRun;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::EndingKind;
use rsrs_testing::python;
use serde_json::Value;

fn compare(folder: &Path, more: &[&str], bags: &[&str]) -> Output {
    rsrs(folder, &[&["compare", "out"], more, &["--bags"], bags].concat())
}

#[test]
fn a_bag_is_labelled_by_the_body_and_the_range_in_its_record() {
    let place = tempfile::tempdir().expect("a temporary folder");
    Run::new(1).record(place.path(), "ours");
    Run { lacks: Some(Part::Record), ..Run::new(1) }.record(place.path(), "foreign");

    let both = rsrs(place.path(), &["label", "ours", "foreign", "--format", "json"]);
    let labels = json(&both);
    let of_foreign = ["label", "foreign", "--reach", "0.825", "--format", "json"];
    let foreign = json(&rsrs(place.path(), &of_foreign));

    assert_eq!(labels[0]["phase"], "stable_milling");
    assert_eq!((&labels[0]["n_robots"], &labels[0]["by"]), (&9.into(), &"judge".into()));
    assert_eq!(labels[0]["evidence"]["lost"], 0.0);
    assert!(labels[0]["evidence"]["contact_onsets_per_s"].is_number());
    assert_eq!((code(&both), labels.as_array().map(Vec::len)), (1, Some(1)));
    assert!(stderr(&both).contains("foreign: holds no record"), "{}", stderr(&both));
    assert_eq!(foreign[0]["evidence"]["lost"], 0.0);
    assert_eq!(foreign[0]["evidence"]["contact_onsets_per_s"], Value::Null);
}

#[test]
fn a_profile_counts_before_the_record() {
    let place = tempfile::tempdir().expect("a temporary folder");
    Run::new(1).record(place.path(), "ours");
    let profile = rsrs_testing::conditions::FLOCKBOT;
    let label = |changes: &[(&str, &str)]| {
        let mut changed = profile.to_owned();
        for (before, after) in changes {
            assert!(changed.contains(before), "{before}");
            changed = changed.replace(before, after);
        }
        std::fs::write(place.path().join("other.yaml"), changed).expect("the folder is writable");
        let arguments = ["label", "ours", "--profile", "other.yaml", "--format", "json"];
        json(&rsrs(place.path(), &arguments))[0].clone()
    };

    let myopic = label(&[("range_m: 0.75", "range_m: 0.01")]);
    // Neighbours of this ring are between these two reaches apart.
    let short = ("range_m: 0.75", "range_m: 0.58");
    let bodies = label(&[short]);
    let centres = label(&[short, ("sees: body", "sees: centre")]);

    // Nobody has a neighbour within a centimetre.
    assert_eq!(
        (&myopic["evidence"]["lost"], &myopic["phase"]),
        (&1.0.into(), &"dispersion".into())
    );
    assert_eq!(bodies["evidence"]["lost"], 0.0);
    assert!(centres["evidence"]["lost"].as_f64().expect("a share") > 0.25, "{centres}");
}

#[test]
fn a_record_that_does_not_read_is_an_error_that_names_the_bag() {
    let place = tempfile::tempdir().expect("a temporary folder");
    Run::new(1).record_with(place.path(), "spoilt", "{\"run_id\": \"spoilt\"}");

    let output = rsrs(place.path(), &["label", "spoilt"]);

    assert_eq!(code(&output), 1);
    let printed = stderr(&output);
    assert!(
        printed.starts_with("error: spoilt: its record, experiment.json, does not read"),
        "{printed}"
    );
    assert!(printed.contains("missing field"), "{printed}");
}

#[test]
fn one_mill_is_undecided_with_how_many_more_would_decide() {
    let place = chosen();
    Run::new(1).record(place.path(), "monday");

    let output = compare(place.path(), &[], &["monday"]);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    insta::assert_snapshot!(stdout(&output), @r"
    claim: real robots mill at least as often as simulated ones
    speed_m_s=0.15,turn_rate_rad_s=0.75
      real       1 of 1 run milled: 100.0 % (95 % interval 2.5 to 100.0 %)
        monday: stable milling
      simulated  196 of 200 fresh runs milled: 98.0 % (95 % interval 95.0 to 99.5 %); otherwise 2 semi-stable milling, 2 unformed
      by itself  undecided: 30 further real runs would support the claim here if every one of them mills
    all runs: 1 of 1 run milled, 1.0 expected if real robots mill as often as simulated ones
      evidence that they mill less often: 0.70 (from 20 on the claim is violated)
      evidence that they mill as often, or at most 10 percentage points less often, in 1 run in 1 cell: 0.29 (from 20 on the claim is supported)
      as far as these show, how much less often they may mill is not bounded; B_r >= 0.00, at 95 %
    run by run: 1 ended as most simulated runs did, 0 closer to stable milling, 0 further from it
    verdict: undecided (the runs do not decide yet; 30 further real runs would support the claim if every one of them mills)
    next: rsrs run EXPERIMENT.yaml --from out --cell speed_m_s=0.15,turn_rate_rad_s=0.75 --backend fleet --interface NAME -o run_2
      there one run is most informative (0.090 bit); 73 further real runs there decide with a probability of 0.85, if real robots mill as those so far and as simulated ones as measured (98.5 % of 200 runs)
    ");
}

#[test]
fn robots_without_a_gate_of_their_own_are_named_wherever_their_run_is() {
    let place = chosen();
    let controller_only = vec!["robot_2".to_owned(), "robot_3".to_owned()];
    Run { controller_only, ..Run::new(1) }.record(place.path(), "borrowed");
    Run::new(2).record(place.path(), "ours");

    let label = rsrs(place.path(), &["label", "borrowed", "ours"]);
    let json_label = json(&rsrs(place.path(), &["label", "borrowed", "--format", "json"]));
    let comparison = compare(place.path(), &[], &["borrowed", "ours"]);

    let printed = stdout(&label);
    assert_eq!(printed.matches("lease: controller only: robot_2, robot_3").count(), 1, "{printed}");
    assert_eq!(json_label[0]["controller_only"], serde_json::json!(["robot_2", "robot_3"]));
    let printed = stdout(&comparison);
    let note = "note: in 1 of 2 runs the lease of some robots was their controller's only\n";
    assert!(printed.contains(note), "{printed}");
}

#[test]
fn robots_that_do_not_mill_where_simulated_ones_do_violate_the_claim() {
    let place = chosen();
    for seed in 1..=2 {
        let blind = Run { sight: 0.0, ..Run::new(seed) };
        blind.record(place.path(), &format!("blind_{seed}"));
    }

    let text = compare(place.path(), &[], &["blind_1", "blind_2"]);
    let output = compare(place.path(), &["--format", "json"], &["blind_1", "blind_2"]);

    assert_eq!((code(&text), code(&output)), (3, 3), "{}", stderr(&output));
    assert!(
        stdout(&text).ends_with(
            "verdict: violated (real robots mill less often than simulated ones; reached wrongly with a probability of \
             at most 0.05, however often one looks)\n\
             next: rsrs measure plan\n  \
             back to step 1: at speed_m_s=0.15,turn_rate_rad_s=0.75 0.0 % of real and 98.0 % of simulated \
             runs mill, so the simulated robots are not worse than the real ones\n"
        ),
        "{}",
        stdout(&text)
    );
    assert_eq!(json(&output)["next"]["what"], "return_to_step_1");
    let report = json(&output);
    assert_eq!(report["verdict"], "violated");
    let cell = &report["cells"][0];
    assert_eq!((&cell["n_real"], &cell["n_simulated"]), (&2.into(), &200.into()));
    assert_eq!(cell["is_confirmed"], true);
    assert_eq!(cell["real"]["stable_milling"], 0);
    assert_eq!(report["tally"]["harder"], 2);
    assert_ne!(report["bags"][0]["phase"], "stable_milling");
    assert_eq!(report["bags"][0]["cell"]["speed_m_s"], 0.15);
}

#[test]
fn a_cell_that_was_not_chosen_is_held_against_the_sweep() {
    let place = chosen();
    let bags: Vec<String> = (1..=5).map(|seed| format!("fast_{seed}")).collect();
    for (seed, bag) in (1..).zip(&bags) {
        let fast = Run { speed_m_s: 0.30, turn_rate_rad_s: 0.25, ..Run::new(seed) };
        fast.record(place.path(), bag);
    }
    let bags: Vec<&str> = bags.iter().map(String::as_str).collect();

    let output = compare(place.path(), &["--format", "json"], &bags);

    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let report = json(&output);
    let cell = &report["cells"][0];
    assert_eq!((&cell["n_real"], &cell["n_simulated"]), (&5.into(), &16.into()));
    assert_eq!((&cell["b_s"], &cell["is_confirmed"]), (&0.0.into(), &false.into()));
    // None of sixteen mills, so nothing can fall short: that five of five mill supports nothing.
    assert_eq!(
        (&cell["e_supported"], &report["pooled"]["e_supported"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!((&cell["verdict"], &report["verdict"]), (&"no_claim".into(), &"no_claim".into()));
    let text = stdout(&compare(place.path(), &[], &bags));
    assert!(
        text.contains(
            "verdict: no claim (simulated robots mill too rarely in the cell that was run"
        ),
        "{text}"
    );
}

/// Evidence is recomputed from what `compare` prints, by a program that shares nothing with it.
#[test]
fn the_evidence_is_that_of_an_independent_program() {
    let place = chosen();
    let here = place.path();
    for seed in 1..=4 {
        Run::new(seed).record(here, &format!("ring_{seed}"));
    }
    Run { sight: 0.0, ..Run::new(5) }.record(here, "blind");
    let fast = Run { speed_m_s: 0.30, turn_rate_rad_s: 0.25, ..Run::new(6) };
    fast.record(here, "fast");
    let rings = ["ring_1", "ring_2", "ring_3", "ring_4"];
    let reports = [
        (&["--margin", "0.25"][..], &rings[..]),
        (&[], &["ring_1", "blind"]),
        (&[], &["ring_1", "ring_2", "blind", "fast"]),
        (&[], &["fast"]),
    ]
    .map(|(more, bags)| json(&compare(here, &[&["--format", "json"], more].concat(), bags)));
    let file = here.join("reports.json");
    std::fs::write(&file, Value::from(reports.to_vec()).to_string()).expect("it is writable");
    let oracle = repository().join("crates/rsrs_core/tests/comparison_oracle.py");

    let python = python::python_with(&python::SCIENCE);
    let printed = python::must_run(Command::new(python).arg(oracle).arg(&file));

    assert_eq!(printed.trim(), "4 cases agree");
}

#[test]
fn bags_of_other_experiments_are_refused_all_at_once() {
    let place = chosen();
    let here = place.path();
    let brief = |seed| Run { recorded_s: 13.0, ..Run::new(seed) };
    brief(1).record(here, "good");
    Run { placement_radius_m: 0.75, ..brief(2) }.record(here, "wide");
    Run { robots: 8, ..brief(3) }.record(here, "eight");
    Run { turn_rate_rad_s: 0.70, ..brief(4) }.record(here, "between");
    Run { duration_s: 90.0, ..brief(5) }.record(here, "short");
    Run { lacks: Some(Part::Record), ..brief(6) }.record(here, "foreign");
    let bags = ["good", "wide", "eight", "between", "short", "foreign", "nowhere"];

    let output = compare(here, &[], &bags);

    assert_eq!((code(&output), stdout(&output).as_str()), (1, ""));
    let printed = stderr(&output);
    insta::assert_snapshot!(printed.trim_end(), @r"
    error: 6 of 7 bags cannot be compared with this sweep
      wide: the placement radius is 0.75 m, expected 0.6 m as simulated
      eight: the number of robots is 8, expected 9 as simulated
      between: cell speed_m_s=0.15,turn_rate_rad_s=0.7 is not on the swept grid; the nearest swept cell is speed_m_s=0.15,turn_rate_rad_s=0.75
      short: the duration is 90 s, expected 120 s as simulated
      foreign: holds no record of its experiment, so what was run is unknown
      cannot open nowhere: No such file or directory (os error 2)
    help: leave such bags out, or compare them with the sweep that simulates their experiment
    ");
    let missing = stderr(&compare(here, &[], &["nowhere", "neither_here"]));
    assert!(missing.contains("help: give the folder that holds metadata.yaml"), "{missing}");
}

#[test]
fn a_run_that_cannot_be_labelled_is_listed_and_the_others_are_compared() {
    let place = chosen();
    let here = place.path();
    Run::new(1).record(here, "good");
    Run { lacks: Some(Part::Poses), ..Run::new(2) }.record(here, "unseen");
    Run { recorded_s: 30.0, ..Run::new(3) }.record(here, "hasty");
    let brief = |seed| Run { recorded_s: 13.0, ..Run::new(seed) };
    Run { lacks: Some(Part::Ending), ..brief(7) }.record(here, "endless");
    cut_in_half(&brief(8).record(here, "killed"));
    let bags = ["good", "unseen", "hasty", "endless", "killed"];

    let text = compare(here, &[], &bags);
    let report = json(&compare(here, &["--format", "json"], &bags));

    assert_eq!(code(&text), 3, "something is lost: {}", stderr(&text));
    let printed = stdout(&text);
    for listed in [
        "not counted: unseen (not labelled: the bag has no poses",
        "not counted: hasty (not labelled: 29.9 s recorded, and the run was set to last 120 s",
        "not counted: endless (not whole: does not state how its run ended)",
        "not counted: killed (not whole: the recording breaks off after",
        "`rsrs bag recover killed` saves what can be saved",
        "left out after their start, and so perhaps for what the swarm did: 4 runs (unseen, hasty, \
         endless, killed)\n  without them: undecided; if none of them milled: violated; if every one \
         milled: undecided\n",
        "verdict: undecided",
    ] {
        assert!(printed.contains(listed), "{listed}: {printed}");
    }
    assert_eq!(report["bags"].as_array().map(Vec::len), Some(1));
    let unseen = &report["not_counted"][0];
    assert_eq!(
        (&unseen["cause"], &unseen["ending"]),
        (&"not_labelled".into(), &"completed".into())
    );
    assert_eq!(
        (&unseen["after_start"], &unseen["cell"]["speed_m_s"]),
        (&true.into(), &0.15.into())
    );
    assert_eq!(report["not_counted"][2]["ending"], "unknown");
    assert_eq!(report["left_out"]["bags"].as_array().map(Vec::len), Some(4));
}

/// Forty runs that mill, which support the claim, and some that were left out: what is reported of them, and
/// their bags.
fn forty_and(place: &Path, left_out: &[(&str, Run)]) -> (Value, Vec<String>) {
    let mut bags: Vec<String> = (1..=40).map(|seed| format!("run_{seed}")).collect();
    for (seed, bag) in (1..).zip(&bags) {
        if !place.join(bag).exists() {
            Run::new(seed).record(place, bag);
        }
    }
    for (name, run) in left_out {
        run.record(place, name);
        bags.push((*name).to_owned());
    }
    let named: Vec<&str> = bags.iter().map(String::as_str).collect();
    let report = json(&compare(place, &["--format", "json", "--margin", "0.3"], &named));
    (report, bags)
}

#[test]
fn support_stands_only_if_it_does_with_every_run_that_was_left_out_after_its_start() {
    let place = chosen();
    let here = place.path();
    let with = |kind, seed| Run {
        ending: ended(kind, "lost robot_3: no pose received for more than 5 s"),
        recorded_s: 20.0,
        ..Run::new(seed)
    };

    let (alone, _) = forty_and(here, &[]);
    let one = [("gone", with(EndingKind::Aborted, 100))];
    let (with_one, _) = forty_and(here, &one);
    let names: Vec<String> = (0..15).map(|n| format!("gone_{n}")).collect();
    let many: Vec<(&str, Run)> = (200..)
        .zip(&names)
        .map(|(seed, name)| (name.as_str(), with(EndingKind::Aborted, seed)))
        .collect();
    let (with_many, bags) = forty_and(here, &many);
    let bags: Vec<&str> = bags.iter().map(String::as_str).collect();
    let text = stdout(&compare(here, &["--margin", "0.3"], &bags));
    // What never began cannot be what the swarm did.
    let never: Vec<(&str, Run)> =
        many.iter().map(|(name, run)| (*name, Run { starts: false, ..run.clone() })).collect();
    for name in &names {
        std::fs::remove_dir_all(here.join(name)).expect("it is ours");
    }
    let (with_failed, _) = forty_and(here, &never);

    assert_eq!((&alone["verdict"], alone.get("left_out")), (&"supported".into(), None));
    assert_eq!(with_one["verdict"], "supported");
    assert_eq!(with_one["left_out"]["verdict_if_none_milled"], "supported");
    assert_eq!(with_many["verdict"], "undecided");
    let left_out = &with_many["left_out"];
    assert_eq!(left_out["verdict_without"], "supported");
    assert_eq!(left_out["verdict_if_none_milled"], "violated");
    assert_eq!(left_out["bags"].as_array().map(Vec::len), Some(15));
    assert_eq!(with_many["cells"][0]["verdict"], "undecided");
    assert!(
        text.contains(
            "verdict: undecided (supported by the runs that count alone, which does not stand whatever \
             those came to that were left out after their start)"
        ),
        "{text}"
    );
    assert_eq!((&with_failed["verdict"], with_failed.get("left_out")), (&"supported".into(), None));
    assert_eq!(with_failed["not_counted"][0]["after_start"], false);
}

#[test]
fn a_void_run_is_listed_and_not_counted() {
    let place = chosen();
    Run::new(1).record(place.path(), "good");
    let void = ended(EndingKind::Void, "robot_3 was carried off");
    Run { ending: void, sight: 0.0, ..Run::new(2) }.record(place.path(), "carried");

    let both = compare(place.path(), &["--format", "json"], &["good", "carried"]);
    let alone = compare(place.path(), &[], &["carried"]);

    let report = json(&both);
    assert_eq!(report["cells"][0]["n_real"], 1);
    let not_counted = &report["not_counted"][0];
    assert_eq!((&not_counted["bag"], &not_counted["ending"]), (&"carried".into(), &"void".into()));
    assert_eq!((code(&both), code(&alone)), (0, 0));
    let printed = stdout(&alone);
    let (printed, advice) = printed.rsplit_once("; ").expect("it states how many runs decide");
    assert_eq!(
        printed,
        "claim: real robots mill at least as often as simulated ones\n\
         not counted: carried (void: robot_3 was carried off)\n\
         left out after their start, and so perhaps for what the swarm did: 1 run (carried)\n\
         \x20 without them: undecided; if none of them milled: undecided; if every one milled: \
         undecided\n\
         verdict: undecided (no run counts)\n\
         next: rsrs run EXPERIMENT.yaml --from out --cell speed_m_s=0.15,turn_rate_rad_s=0.75 \
         --backend fleet --interface NAME -o run_2\n\
         \x20 there the fewest runs decide"
    );
    // As one more than after a mill: the forecast is that for the runs that the others are held against.
    assert_eq!(
        advice,
        "74 real runs there decide with a probability of 0.84, if real robots mill as simulated ones as \
         measured (98.5 % of 200 runs)\n"
    );
}

#[test]
fn a_run_counts_once() {
    let place = chosen();
    let here = place.path();
    Run::new(1).record(here, "one");
    copy(&here.join("one"), &here.join("copy"));
    let lockstep = Run { time: Time::Lockstep, ..Run::new(2) };
    let frozen = ended(EndingKind::Void, "the lease lapsed");
    Run { ending: frozen, ..lockstep.clone() }.record(here, "frozen");
    lockstep.record(here, "two");
    lockstep.record(here, "again");

    let copied = compare(here, &[], &["one", "copy"]);
    let repeated = compare(here, &[], &["one", "two", "again"]);
    let made_up_for = compare(here, &["--format", "json"], &["one", "frozen", "two"]);

    assert_eq!((code(&copied), code(&repeated), code(&made_up_for)), (1, 1, 0));
    assert_eq!(json(&made_up_for)["cells"][0]["n_real"], 2);
    let printed = stderr(&copied);
    assert!(printed.contains("copy is the same run as one"), "{printed}");
    let printed = stderr(&repeated);
    assert!(
        printed.contains("again: repeats two, a simulated run with the same seed, 2"),
        "{printed}"
    );
}

#[test]
fn a_sweep_over_what_robots_are_has_no_cell_for_a_bag_unless_it_has_one_value() {
    let several = swept("true_positive: [0.7, 0.8]", "speed_m_s: 0.15");
    let single = swept("true_positive: [0.8]", "speed_m_s: 0.15");
    Run::new(1).record(several.path(), "monday");
    Run::new(1).record(single.path(), "monday");

    let refused = compare(several.path(), &[], &["monday"]);
    let compared = compare(single.path(), &["--format", "json"], &["monday"]);

    assert_eq!((code(&refused), code(&compared)), (1, 0), "{}", stderr(&compared));
    let printed = stderr(&refused);
    assert!(printed.starts_with("error: the sweep varies true_positive (0.7, 0.8)"), "{printed}");
    assert!(printed.contains("help: "), "{printed}");
    assert_eq!(json(&compared)["cells"][0]["cell"]["true_positive"], 0.8);
}

#[test]
fn a_choice_of_another_sweep_or_without_its_phases_is_refused() {
    let place = chosen();
    Run::new(1).record(place.path(), "monday");
    let path = place.path().join("out/choice.json");
    let choice = std::fs::read_to_string(&path).expect("the choice was written");

    std::fs::write(&path, choice.replace("0.75", "0.80")).expect("the folder is writable");
    let other = compare(place.path(), &[], &["monday"]);
    let mut without: Value = serde_json::from_str(&choice).expect("the choice is JSON");
    without.as_object_mut().expect("it is an object").remove("phases");
    std::fs::write(&path, without.to_string()).expect("the folder is writable");
    let bare = compare(place.path(), &[], &["monday"]);

    assert_eq!((code(&other), code(&bare)), (1, 1));
    assert!(stderr(&other).contains("is of another sweep"), "{}", stderr(&other));
    assert!(stderr(&bare).contains("does not state how its fresh runs ended"), "{}", stderr(&bare));
    assert!(stderr(&bare).contains("rsrs choose out -o out/choice.json"), "{}", stderr(&bare));
}

#[test]
fn runs_whose_poses_cannot_be_those_of_the_robots_are_left_out_unless_told_otherwise() {
    let place = chosen();
    Run::new(1).record(place.path(), "monday");
    Run { distortion: Some(millimetres), ..Run::new(2) }.record(place.path(), "tuesday");

    let text = stdout(&compare(place.path(), &[], &["monday", "tuesday"]));
    let report = json(&compare(place.path(), &["--format", "json"], &["monday", "tuesday"]));
    let more = ["--with-implausible", "--format", "json"];
    let with_it = json(&compare(place.path(), &more, &["monday", "tuesday"]));

    let line = text.lines().find(|line| line.starts_with("not counted: ")).expect("it is listed");
    let expected = "not counted: tuesday (implausible: all 9 robots: poses move ";
    assert!(line.starts_with(expected) && line.contains("millimetres?"), "{text}");
    assert!(text.contains("note: 1 run: implausible; `--with-implausible` counts such runs, too"));
    assert_eq!(report["cells"][0]["n_real"], 1);
    let left_out = &report["not_counted"][0];
    assert_eq!(
        (&left_out["cause"], &left_out["after_start"]),
        (&"implausible".into(), &true.into())
    );
    assert_eq!(report["left_out"]["bags"], serde_json::json!(["tuesday"]));
    assert_eq!((&with_it["cells"][0]["n_real"], &with_it["left_out"]), (&2.into(), &Value::Null));
    let notes = with_it["notes"].as_array().expect("notes");
    let counts = "tuesday counts, though all 9 robots: poses move ";
    assert!(notes.iter().any(|note| note.as_str().is_some_and(|note| note.starts_with(counts))));
}

#[test]
fn runs_that_did_not_start_where_their_experiment_places_robots_are_named() {
    let place = chosen();
    Run::new(1).record(place.path(), "monday");
    Run { distortion: Some(in_the_corner), ..Run::new(2) }.record(place.path(), "corner");

    let report = json(&compare(place.path(), &["--format", "json"], &["monday", "corner"]));

    let notes = report["notes"].as_array().expect("notes");
    let notes: Vec<&str> = notes.iter().filter_map(Value::as_str).collect();
    let named: Vec<&&str> = notes.iter().filter(|note| note.contains("did not start as")).collect();
    assert_eq!(named.len(), 1, "{notes:?}");
    assert!(named[0].starts_with("corner did not start as its experiment has it: robot_1: "));
    assert!(named[0].ends_with(" more (`rsrs label` lists them)"), "{notes:?}");
    assert_eq!(report["cells"][0]["n_real"], 2);
    assert!(report["bags"][1]["misplaced"].is_array(), "{report}");
}

/// One of the runs of a campaign whose number of runs was fixed.
fn fixed_run(number: u64, runs: u64) -> Run {
    Run { fixed: Some(FixedRun { number, runs, margin: 0.3 }), ..Run::new(number) }
}

#[test]
fn a_campaign_of_a_fixed_number_of_runs_has_its_verdict_at_that_number_and_none_before() {
    let place = chosen();
    let here = place.path();
    let bags: Vec<String> = (1..=12).map(|number| format!("run_{number}")).collect();
    for (number, bag) in (1..).zip(&bags) {
        fixed_run(number, 12).record(here, bag);
    }
    let bags: Vec<&str> = bags.iter().map(String::as_str).collect();

    let before = json(&compare(here, &["--format", "json"], &bags[..11]));
    let output = compare(here, &[], &bags);
    let report = json(&compare(here, &["--format", "json"], &bags));

    assert_eq!(before["verdict"], "undecided", "{before:#}");
    assert_eq!(
        (&before["fixed"]["made"], before["fixed"].get("supported_from")),
        (&11.into(), None)
    );
    assert_eq!(before["cells"][0]["verdict"], "undecided");
    assert_eq!(report["verdict"], "supported", "{report:#}");
    assert_eq!(report["pooled"]["margin"], 0.3);
    let text = stdout(&output);
    for line in [
        "  fixed before the first run: 12 runs, a margin of 0.3; the claim is supported if 12 of 12 \
         milled, and violated if 9 or fewer of 12 did\n",
        "reached wrongly with a probability of at most 0.05, at the number of runs that was fixed)\n",
        "next: nothing\n  the number of runs was fixed; another campaign is planned and judged by itself",
    ] {
        assert!(text.contains(line), "{text}");
    }
    assert!(!text.contains("evidence"), "{text}");
    let first = stdout(&compare(here, &[], &bags[..1]));
    assert!(first.contains("next: go on with the campaign\n  11 runs of 12 left"), "{first}");
}

#[test]
fn a_run_that_was_left_out_of_a_fixed_campaign_is_held_against_either_verdict() {
    let place = chosen();
    let here = place.path();
    let mut bags: Vec<String> = (1..=12).map(|number| format!("run_{number}")).collect();
    for (number, bag) in (1..).zip(&bags) {
        fixed_run(number, 12).record(here, bag);
    }
    // Run 5 was stopped once it had begun, and made again.
    let gone = Run {
        ending: ended(EndingKind::Aborted, "lost robot_3"),
        recorded_s: 20.0,
        seed: 99,
        ..fixed_run(5, 12)
    };
    gone.record(here, "gone");
    bags.push("gone".to_owned());
    let bags: Vec<&str> = bags.iter().map(String::as_str).collect();

    let report = json(&compare(here, &["--format", "json"], &bags));

    let fixed = &report["fixed"];
    assert_eq!(
        (&fixed["made"], &fixed["left_out"], &fixed["milled"]),
        (&12.into(), &1.into(), &11.into())
    );
    assert_eq!(report["verdict"], "undecided", "{report:#}");
}

#[test]
fn runs_of_several_campaigns_or_margins_are_refused_where_the_number_was_fixed() {
    let place = chosen();
    let here = place.path();
    fixed_run(1, 12).record(here, "one");
    fixed_run(2, 20).record(here, "other");
    Run::new(4).record(here, "free");
    let refused = |more: &[&str], bags: &[&str]| {
        let output = compare(here, more, bags);
        assert_eq!(code(&output), 1, "{}", stdout(&output));
        stderr(&output)
    };

    let free = refused(&[], &["one", "free"]);
    assert!(
        free.contains("one is of 12 runs with the margin 0.3, which were fixed, and free has no"),
        "{free}"
    );
    assert!(refused(&[], &["one", "other"]).contains("other is of 20 runs"));
    let margin = refused(&["--margin", "0.1"], &["one"]);
    assert!(margin.contains("--margin is 0.1, and 0.3 was fixed before the first run"), "{margin}");
    let twice = Run { seed: 7, ..fixed_run(1, 12) };
    twice.record(here, "twice");
    let twice = refused(&[], &["one", "twice"]);
    assert!(twice.contains("one and twice are both run 1 of the 12 that were fixed"), "{twice}");
}
