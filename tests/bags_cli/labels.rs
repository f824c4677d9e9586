//! Labels by people, beside those of the judge.

use super::{place, read};
use crate::command::{code, done, json, rsrs, stderr, stdout};
use crate::prepared_sweeps::{SPEEDS, swept};
use crate::simulated_bags::{Part, Run};

#[test]
fn a_label_by_hand_is_added_and_never_changes_what_is_there() {
    let place = place();
    let here = place.path();
    Run::new(1).record(here, "run");
    let blind = Run { lacks: Some(Part::Poses), ..Run::new(2) }.record(here, "blind");
    let file = here.join("run/labels.yaml");

    let by_ana = ["label", "run", "blind", "--as", "semi_stable_milling", "--by", "ana"];
    let first = rsrs(here, &[&by_ana[..], &["--note", "one: outside"]].concat());
    let before = read(&file);
    let second = rsrs(here, &["label", "run", "--as", "stable_milling", "--by", "ana"]);
    let after = read(&file);
    let judged = json(&rsrs(here, &["label", "run", "--format", "json"]));
    let not_judged = rsrs(here, &["label", "blind"]);

    assert_eq!((code(&first), code(&second), code(&not_judged)), (0, 0, 1), "{}", stderr(&first));
    assert_eq!(
        stdout(&first),
        "run: semi-stable milling by ana, label 1 in run/labels.yaml\n\
         blind: semi-stable milling by ana, label 1 in blind/labels.yaml\n"
    );
    assert!(after.starts_with(&before) && after.len() > before.len());
    assert_eq!(
        (&judged[0]["phase"], &judged[0]["by"]),
        (&serde_json::json!("stable_milling"), &serde_json::json!("judge"))
    );
    assert_eq!(judged[0]["labels"][0]["note"], "one: outside");
    assert_eq!(judged[0]["labels"][1]["phase"], "stable_milling");
    assert!(blind.join("labels.yaml").exists());
    assert!(stderr(&not_judged).contains("rsrs label BAG --as PHASE"), "{}", stderr(&not_judged));
}

#[test]
fn a_single_file_has_its_labels_beside_it() {
    let place = place();
    let bag = Run { robots: 1, ..Run::new(1) }.record(place.path(), "run");
    let file = bag.join("run_0.mcap");
    let file = file.to_str().expect("the path is text");

    done(place.path(), &["label", file, "--as", "dispersion", "--by", "ana"]);
    assert!(bag.join("run_0.labels.yaml").exists() && !bag.join("labels.yaml").exists());
}

#[test]
fn labels_that_were_edited_by_hand_and_do_not_read_are_refused_by_line() {
    let place = place();
    let here = place.path();
    Run { robots: 1, ..Run::new(1) }.record(here, "run");
    let file = here.join("run/labels.yaml");
    let good = "- phase: dispersion\n  by: ana\n  time: 2026-11-21T08:00:00Z\n";

    for (text, expected) in [
        (good.replace("dispersion", "dispersed"), "run/labels.yaml:1:10: "),
        (good.replace("by: ana", "who: ana"), "run/labels.yaml:2:3: unknown key `who`"),
        (good.replace("by: ana", "by: judge"), "a label by `judge`"),
        (good.replace("2026-11-21T08:00:00Z", "yesterday"), "a label of \"yesterday\""),
        (format!("{good}- phase"), "run/labels.yaml:4:"),
    ] {
        std::fs::write(&file, &text).expect("the folder is writable");

        let judge = rsrs(here, &["label", "run"]);
        let add = rsrs(here, &["label", "run", "--as", "dispersion", "--by", "bo"]);
        let info = rsrs(here, &["bag", "info", "run"]);

        assert_eq!((code(&judge), code(&add), code(&info)), (1, 1, 1), "{text}");
        for printed in [stderr(&judge), stderr(&add), stderr(&info)] {
            assert!(printed.contains(expected), "{printed}");
        }
        assert_eq!(read(&file), text.as_bytes(), "what cannot be read is left alone");
    }
}

#[test]
fn agreement_counts_who_labels_alike_and_lists_where_they_differ() {
    let place = place();
    let here = place.path();
    Run::new(1).record(here, "one");
    Run::new(2).record(here, "two");
    Run { lacks: Some(Part::Poses), ..Run::new(3) }.record(here, "blind");
    let label = |bag: &str, phase: &str, by: &str| {
        done(here, &["label", bag, "--as", phase, "--by", by]);
    };

    let nobody = rsrs(here, &["label", "--agreement", "one", "two"]);
    label("one", "dispersion", "ana");
    // The last label of a person counts.
    label("one", "stable_milling", "ana");
    label("two", "semi_stable_milling", "ana");
    label("blind", "unformed", "ana");
    label("blind", "unformed", "bo");
    label("two", "semi_stable_milling", "bo");
    let output = rsrs(here, &["label", "--agreement", "one", "two", "blind", "--format", "json"]);
    let text = rsrs(here, &["label", "--agreement", "one", "two", "blind"]);

    assert_eq!((code(&nobody), code(&output)), (1, 0), "{}", stderr(&output));
    assert!(stderr(&nobody).contains("no person has labelled"), "{}", stderr(&nobody));
    let result = json(&output);
    let pair = |index: usize| &result["pairs"][index];
    assert_eq!(pair(0)["by"], serde_json::json!(["judge", "ana"]));
    assert_eq!((&pair(0)["n"], &pair(0)["n_same"]), (&serde_json::json!(2), &serde_json::json!(1)));
    assert_eq!(pair(1)["by"], serde_json::json!(["judge", "bo"]));
    assert_eq!(pair(2)["by"], serde_json::json!(["ana", "bo"]));
    assert_eq!(
        (&pair(2)["n"], &pair(2)["kappa"]),
        (&serde_json::json!(2), &serde_json::json!(1.0))
    );
    assert_eq!(result["disagreements"].as_array().map(Vec::len), Some(1));
    let differs = &result["disagreements"][0];
    assert_eq!(differs["bag"], "two");
    assert_eq!(differs["labels"]["judge"], "stable_milling");
    assert_eq!(result["not_judged"][0]["bag"], "blind");
    assert!(stdout(&text).contains("look again at 1 of 3 bags:\n  two: "), "{}", stdout(&text));
}

#[test]
fn a_comparison_can_take_the_labels_of_a_person() {
    let place = swept(SPEEDS, "true_positive: 0.8");
    let here = place.path();
    Run::new(1).record(here, "one");
    Run::new(2).record(here, "two");
    let label = ["label", "one", "--as", "dispersion", "--by", "Ana Lima"];
    assert_eq!(code(&rsrs(here, &label)), 0);

    let compare = |labels: &str, bags: &[&str]| {
        let arguments = ["compare", "out", "--labels", labels, "--format", "json", "--bags"];
        rsrs(here, &[&arguments[..], bags].concat())
    };
    let by_ana = json(&compare("human:Ana Lima", &["one"]));
    let by_judge = json(&compare("judge", &["one"]));
    let unlabelled = compare("human:Ana Lima", &["one", "two"]);
    let nobody = compare("somebody", &["one"]);

    assert_eq!(
        (&by_ana["labels"], &by_judge["labels"]),
        (&serde_json::json!("human:Ana Lima"), &serde_json::json!("judge"))
    );
    assert_eq!(by_ana["bags"][0]["phase"], "dispersion");
    assert_eq!(by_ana["cells"][0]["real"]["dispersion"], 1);
    assert_eq!(by_judge["cells"][0]["real"]["stable_milling"], 1);
    assert_eq!((code(&unlabelled), code(&nobody)), (3, 2));
    let unlabelled = json(&unlabelled);
    let not_counted = &unlabelled["not_counted"][0];
    assert_eq!(not_counted["cause"], "not_labelled");
    let reason = not_counted["reason"].as_str().unwrap_or_default();
    assert!(reason.contains("has no label by Ana Lima"), "{reason}");
}
