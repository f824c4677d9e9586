//! Recorded runs as pictures and films, and why they have their label.

use crate::command::{code, json, rsrs, stderr, stdout, text_in};
use crate::prepared_sweeps::{SPEEDS, swept};
use crate::simulated_bags::{Part, Run};

#[test]
fn a_recorded_run_is_drawn_and_filmed() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    Run::new(1).record(here, "run");

    let drawn = rsrs(here, &["draw", "run", "-o", "run.svg"]);
    let small = ["--rate", "40", "--fps", "5", "--width", "160"];
    let gif = rsrs(here, &[&["film", "run", "-o", "run.gif"], &small[..]].concat());
    let apng = rsrs(here, &[&["film", "run", "-o", "run.png"], &small[..]].concat());

    for output in [&drawn, &gif, &apng] {
        assert_eq!(code(output), 0, "{}", stderr(output));
    }
    let svg = text_in(here, "run.svg");
    for text in
        ["circliness (stable milling: 0.50 or more)", "s; stable milling", "ring: mean radius"]
    {
        assert!(svg.contains(text), "{text}");
    }
    let bytes = |name: &str| std::fs::read(here.join(name)).expect("it was filmed");
    assert!(bytes("run.gif").starts_with(b"GIF89a"));
    let apng = bytes("run.png");
    assert!(apng.starts_with(b"\x89PNG") && apng.windows(4).any(|chunk| chunk == b"acTL"));
}

#[test]
fn a_run_of_any_length_is_drawn_and_filmed_without_a_label() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    for (name, duration_s) in [("short", 20.0), ("shortest", 5.0)] {
        Run { duration_s, recorded_s: duration_s, ..Run::new(1) }.record(here, name);
    }
    let cut = Run { recorded_s: 70.0, lacks: Some(Part::Ending), ..Run::new(1) };
    cut.record(here, "cut");
    let small = ["--rate", "40", "--fps", "5", "--width", "160"];

    for (name, expected) in [
        ("short", "no label: 20 s of 60"),
        ("shortest", "no label: 5 s of 60"),
        ("cut", "no label: 70 s of a run of 120"),
    ] {
        let picture = format!("{name}.svg");
        let drawn = rsrs(here, &["draw", name, "-o", &picture]);
        let film = format!("{name}.gif");
        let filmed = rsrs(here, &[&["film", name, "-o", &film], &small[..]].concat());

        assert_eq!((code(&drawn), code(&filmed)), (0, 0), "{}{}", stderr(&drawn), stderr(&filmed));
        let svg = text_in(here, &picture);
        assert!(svg.contains(expected), "{name}: {svg}");
        assert!(here.join(&film).exists());
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_before_anything_is_written() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    Run::new(1).record(here, "run");
    Run { lacks: Some(Part::Poses), ..Run::new(2) }.record(here, "blind");

    for (arguments, status, expected) in [
        (&["draw", "run", "-o", "run.jpg"][..], 2, "name the picture `-o run.svg`"),
        (&["draw", "missing", "-o", "run.svg"], 1, "missing"),
        (&["draw", "blind", "-o", "run.svg"], 1, "blind"),
        (&["film", "run", "-o", "run.mp4"], 2, "ends in none of .gif, .png and .apng"),
        (&["film", "blind", "-o", "run.gif"], 1, "blind"),
        (&["film", "run", "-o", "run.gif", "--rate=-1"], 2, "expected a positive number"),
        (&["film", "run", "-o", "run.gif", "--fps", "0"], 2, "--fps"),
    ] {
        let output = rsrs(here, arguments);

        assert_eq!(code(&output), status, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{arguments:?}: {}", stderr(&output));
    }
    assert!(!here.join("run.svg").exists() && !here.join("run.gif").exists());
}

#[test]
fn a_label_states_why_in_words() {
    let place = swept(SPEEDS, "true_positive: 0.8");
    let here = place.path();
    // Far too fast for a ring.
    let cell = "speed_m_s=0.30,turn_rate_rad_s=0.25";
    let episode = ["episode", "out", "--cell", cell, "--replicate", "0", "-o", "fast"];
    assert_eq!(code(&rsrs(here, &episode)), 0);

    let text = rsrs(here, &["label", "fast"]);
    let labelled = json(&rsrs(here, &["label", "fast", "--format", "json"]));

    assert_eq!(code(&text), 0, "{}", stderr(&text));
    let why = labelled[0]["why"][0].as_str().expect("a sentence");
    assert!(why.contains(", and ") && why.contains(" or more is "), "{why}");
    assert!(stdout(&text).contains(&format!("  why: {why}\n")), "{}", stdout(&text));
}

/// What 20 s of any swarm are labelled by.
const NEAR: &str = "\
name: staying
words: {noun: staying near, swarm: a swarm that stays, verb: [stay, stays, stayed]}
phases: [{key: stayed}, {key: went_away}]
rules: [{phase: stayed, when: {mean_radius_m: {below: 100}}}]
otherwise: went_away
window: {last_s: 20}
";

#[test]
fn a_run_is_drawn_and_filmed_for_another_behaviour_and_states_which() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let here = place.path();
    Run { duration_s: 30.0, recorded_s: 30.0, ..Run::new(1) }.record(here, "run");
    std::fs::write(here.join("near.yaml"), NEAR).expect("the folder is writable");
    let for_it = ["--behaviour", "near.yaml"];
    let small = ["--rate", "10", "--fps", "5", "--width", "160"];

    let drawn = rsrs(here, &[&["draw", "run", "-o", "run.svg"], &for_it[..]].concat());
    let usual = rsrs(here, &["draw", "run", "-o", "usual.svg"]);
    let film = |name: &str, more: &[&str]| {
        let filmed = rsrs(here, &[&["film", "run", "-o", name], &small[..], more].concat());
        assert_eq!(code(&filmed), 0, "{}", stderr(&filmed));
        std::fs::read(here.join(name)).expect("it was filmed")
    };

    assert_eq!((code(&drawn), code(&usual)), (0, 0), "{}", stderr(&drawn));
    let text = |name: &str| text_in(here, name);
    // A long line is broken where there is room.
    let drawn = text("run.svg");
    assert!(drawn.contains("stayed") && drawn.contains("judged for staying near"), "{drawn}");
    let usual = text("usual.svg");
    assert!(usual.contains("no label: 30 s of 60") && !usual.contains("judged for"), "{usual}");
    assert_ne!(film("near.gif", &for_it), film("usual.gif", &[]), "the phase is in its frames");
}
