//! Other behaviours than milling, all the way: swept, chosen, run over ROS 2, labelled and compared.

use std::path::Path;

use serde_json::Value;

use crate::command::{code, done, json, repository, rsrs, stderr, stdout, text_in};
use crate::processes::run_in_lockstep;

/// A controller that was found by `rsrs explore`: robots turn away from what they see, or gather.
struct Case {
    behaviour: &'static str,
    phases: [&'static str; 3],
    controller: &'static str,
    turns: &'static str,
}

const CASES: [Case; 3] = [
    Case {
        behaviour: "aggregation",
        phases: ["aggregated", "partly_aggregated", "not_aggregated"],
        controller: "speed_m_s: 0.175, turn_rate_rad_s: -1.239, undetected_speed_m_s: 0.037",
        turns: "[-2.5, -2.088]",
    },
    Case {
        behaviour: "dispersal",
        phases: ["spread_out", "partly_spread_out", "not_spread_out"],
        controller: "speed_m_s: -0.279, turn_rate_rad_s: -1.221, undetected_speed_m_s: -0.237",
        turns: "[2.2, 2.431]",
    },
    Case {
        behaviour: "gathering.yaml",
        phases: ["gathered", "gathering", "scattered"],
        controller: "speed_m_s: 0.175, turn_rate_rad_s: -1.239, undetected_speed_m_s: 0.037",
        turns: "[-2.5, -2.088]",
    },
];

/// A behaviour that nobody compiled in.
const GATHERING: &str = "\
name: gathering
words: {noun: gathering, swarm: a gathering swarm, verb: [gather, gathers, gathered]}
phases: [{key: gathered}, {key: gathering, colour: '#56b4e9'}, {key: scattered}]
rules:
  - {phase: gathered, when: {clustered: {at_least: 0.75}}}
  - {phase: gathering, when: {clustered: {at_least: 0.4}}}
otherwise: scattered
not_lasting: gathering
";

fn workplace(case: &Case) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Case { behaviour, controller, turns, .. } = case;
    let configs = repository().join("launch_configs");
    let sweep = format!(
        "profile: {}\nbehaviour: {behaviour}\naxes:\n  undetected_turn_rate_rad_s: {turns}\n\
         fixed: {{{controller}, robots: 9, arena_m: 4.9, walls: clamp}}\n\
         replicates: 16\nduration_s: 300\nseed: 7\n",
        configs.join("profiles/flockbot.yaml").display()
    );
    let experiment = format!(
        "fleet: {}\nplacement: {{kind: disc_facing_out, radius_m: 0.825}}\nduration_s: 300\n\
         seed: 3\nsimulator: {{time: lockstep, profile: measured}}\n",
        configs.join("fleets/nine_virtual.yaml").display()
    );
    for (name, text) in [
        ("sweep.yaml", sweep.as_str()),
        ("experiment.yaml", &experiment),
        ("gathering.yaml", GATHERING),
    ] {
        std::fs::write(folder.path().join(name), text).expect("the folder is writable");
    }
    folder
}

/// Runs the chosen cell, and returns the label of its bag.
fn run_and_label(folder: &Path) -> Value {
    run_in_lockstep(Path::new("experiment.yaml"), &["--from", "out"], &folder.join("bag"));
    let labelled = rsrs(folder, &["label", "bag", "--format", "json"]);
    assert_eq!(code(&labelled), 0, "{}", stderr(&labelled));
    json(&labelled)[0].clone()
}

#[test]
fn another_behaviour_goes_from_the_sweep_to_the_verdict() {
    for (case, other) in CASES[..2].iter().zip(["dispersal", "aggregation"]) {
        let folder = workplace(case);
        let place = folder.path();
        let [wanted, partly, not] = case.phases;

        for arguments in [
            ["sweep", "sweep.yaml", "-o", "out"].as_slice(),
            &["choose", "out", "--confirm", "200", "-o", "out/choice.json"],
            &["diagram", "out", "-o", "out.png"],
        ] {
            done(place, arguments);
        }
        let cells = text_in(place, "out/cells.csv");
        let columns = format!("n,{wanted},{partly},{not},phase");
        assert!(cells.lines().next().is_some_and(|head| head.contains(&columns)), "{cells}");
        let choice = text_in(place, "out/choice.json");
        let choice: Value = serde_json::from_str(&choice).expect("it is JSON");
        assert!(choice["b_s"].as_f64().is_some_and(|b_s| b_s > 0.8), "{choice}");
        assert!(choice["phases"][wanted].is_u64(), "{choice}");

        let first = case.turns.trim_start_matches('[').split(',').next().expect("a value");
        let cell = format!("undetected_turn_rate_rad_s={first}");
        let episode = ["episode", "out", "--replicate", "3", "--format", "json", "-o", "episode"];
        let episode = rsrs(place, &[episode.as_slice(), &["--cell", &cell]].concat());
        assert_eq!(code(&episode), 0, "{}", stderr(&episode));
        let seen = rsrs(place, &["label", "episode", "--format", "json"]);
        assert_eq!(json(&episode)["phase"], json(&seen)[0]["phase"], "{}", stdout(&episode));

        // A run of one behaviour is no evidence about another.
        let experiment = text_in(place, "experiment.yaml");
        let of_other = format!("{experiment}behaviour: {other}\n");
        std::fs::write(place.join("other.yaml"), of_other).expect("the folder is writable");
        let refused = rsrs(place, &["run", "other.yaml", "--from", "out", "--cell", &cell]);
        let expected =
            format!("the behaviour is {other}, expected {} as simulated", case.behaviour);
        assert_eq!(code(&refused), 1);
        assert!(stderr(&refused).contains(&expected), "{}", stderr(&refused));

        let label = run_and_label(place);
        assert_eq!(label["phase"], wanted, "{label:#}");

        // What a run is judged for is its record's, and can be asked for otherwise.
        let milling = rsrs(place, &["label", "bag", "--behaviour", "milling", "--format", "json"]);
        assert_ne!(json(&milling)[0]["phase"], wanted);
        let compared = rsrs(
            place,
            &["compare", "out", "--bags", "bag", "--margin", "0.3", "--format", "json"],
        );
        let compared = json(&compared);
        assert_eq!(compared["cells"][0]["real"][wanted], 1, "{compared:#}");
        assert_eq!(compared["cells"][0]["real"].as_object().map(serde_json::Map::len), Some(3));
    }
}

#[test]
fn another_behaviour_is_chosen_diagnosed_and_answered_in_its_own_words() {
    let folder = workplace(&CASES[0]);
    let place = folder.path();
    let sweep = rsrs(place, &["sweep", "sweep.yaml", "-o", "out"]);
    assert_eq!(code(&sweep), 0, "{}", stderr(&sweep));
    let hard = ["choose", "out", "--confirm", "100", "--viable", "0.9999"];

    let failed = rsrs(place, &hard);
    let next = stdout(&failed).lines().last().expect("a line").to_owned();
    let diagnosed = rsrs(place, &["diagnose", "out", "--confirm", "100"]);
    let answered = rsrs(place, &["answer", "out", "--confirm", "100", "--replicates", "20"]);

    assert_eq!(code(&failed), 3, "{}{}", stdout(&failed), stderr(&failed));
    assert!(next.starts_with("next: rsrs diagnose out"), "{next}");
    for output in [&sweep, &failed, &diagnosed, &answered] {
        let text = stdout(output) + &stderr(output);
        assert!(!text.contains("mill") && !text.contains("limits"), "{text}");
    }
    assert_eq!(code(&diagnosed), 0, "{}{}", stdout(&diagnosed), stderr(&diagnosed));
    assert!(stdout(&diagnosed).contains("these robots aggregate; nothing is wrong"));
    assert_eq!(code(&answered), 0, "{}{}", stdout(&answered), stderr(&answered));
    assert!(stdout(&answered).contains("turning rate without detection -2."));
}

#[test]
fn a_mirrored_controller_drives_forward_and_any_other_either_way() {
    let folder = workplace(&CASES[0]);
    let text = text_in(folder.path(), "sweep.yaml");
    for (from, to, expected) in [
        (
            "speed_m_s: 0.175, turn_rate_rad_s: -1.239, undetected_speed_m_s: 0.037",
            "speed_m_s: 0.175, turn_rate_rad_s: -1.239, undetected_speed_m_s: -0.5",
            "undetected_speed_m_s is -0.5, beyond the robots' limits: expected 0.02 to 0.3 m/s",
        ),
        ("behaviour: aggregation", "behaviour: aggregate", "did you mean `aggregation`?"),
    ] {
        std::fs::write(folder.path().join("wrong.yaml"), text.replace(from, to)).expect("writable");

        let refused = rsrs(folder.path(), &["sweep", "wrong.yaml", "-o", "none"]);

        assert_eq!(code(&refused), 1);
        assert!(stderr(&refused).contains(expected), "{}", stderr(&refused));
    }
}

#[test]
fn a_behaviour_of_a_file_is_in_the_results_as_a_whole_and_its_colours_are_in_pictures() {
    let folder = workplace(&CASES[2]);
    let place = folder.path();
    for arguments in
        [["sweep", "sweep.yaml", "-o", "out"].as_slice(), &["diagram", "out", "-o", "out.svg"]]
    {
        done(place, arguments);
    }
    std::fs::remove_file(place.join("gathering.yaml")).expect("it was there");

    let chosen = done(place, &["choose", "out", "--confirm", "100"]);
    assert!(chosen.contains("it gathers in"), "{chosen}");
    let picture = text_in(place, "out.svg");
    assert!(picture.contains("Phases of a gathering swarm"));
    let other = text_in(place, "out/sweep.yaml");
    std::fs::write(place.join("other.yaml"), other.replace("0.75", "0.7")).expect("it is writable");
    let other = rsrs(place, &["sweep", "other.yaml", "-o", "out"]);
    assert_eq!(code(&other), 1, "another bound is another sweep: {}", stdout(&other));
}

#[test]
fn in_the_words_of_the_paper_a_mill_that_is_not_round_is_stable_if_nobody_touches() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = folder.path();
    let configs = repository().join("launch_configs");
    let share = |behaviour: &str, out: &str| {
        let sweep = format!(
            "profile: {}\nbehaviour: {behaviour}\naxes: {{speed_m_s: [0.25], turn_rate_rad_s: [0.5]}}\n\
             fixed: {{robots: 9, placement_radius_m: 0.825}}\nreplicates: 100\nduration_s: 300\nseed: 1\n",
            configs.join("profiles/flockbot.yaml").display()
        );
        std::fs::write(place.join("sweep.yaml"), sweep).expect("the folder is writable");
        done(place, &["sweep", "sweep.yaml", "-o", out]);
        let cells =
            std::fs::read_to_string(place.join(out).join("cells.csv")).expect("it is there");
        let row: Vec<f64> = cells
            .lines()
            .nth(1)
            .map(|row| row.split(',').take(4).flat_map(str::parse).collect())
            .expect("a row");
        row[3] / row[2]
    };

    let of_paper = configs.join("behaviours/paper_milling.yaml");
    let built_in = share("milling", "built_in");
    let of_the_paper = share(&of_paper.display().to_string(), "of_paper");

    assert!(built_in < 0.1 && of_the_paper > 0.4, "{built_in} {of_the_paper}");
}

/// A behaviour of an arena: a robot in most of its nine parts, and for most of the time.
const COVERING: &str = "\
name: covering
words: {noun: covering, swarm: a covering swarm, verb: [cover their arena, covers its arena, covered their arena]}
phases: [{key: covered}, {key: half_covered}, {key: bare}]
rules:
  - {phase: covered, when: {coverage: {at_least: 0.6}, polarisation: {at_least: 0}}}
  - {phase: half_covered, when: {coverage: {at_least: 0.4}}}
otherwise: bare
";

#[test]
fn a_behaviour_about_an_arena_is_swept_run_labelled_and_drawn_and_refused_where_there_is_none() {
    let folder = workplace(&CASES[1]);
    let place = folder.path();
    let sweep = text_in(place, "sweep.yaml");
    let sweep = sweep
        .replace("behaviour: dispersal", "behaviour: covering.yaml")
        .replace("axes:\n", "axes:\n  arena_m: [3.0, 4.9]\n")
        .replace("arena_m: 4.9, walls", "walls");
    std::fs::write(place.join("sweep.yaml"), &sweep).expect("the folder is writable");
    std::fs::write(place.join("covering.yaml"), COVERING).expect("the folder is writable");

    let nowhere = sweep.replace("walls: clamp", "walls: none");
    std::fs::write(place.join("nowhere.yaml"), nowhere).expect("the folder is writable");
    let refused = rsrs(place, &["sweep", "nowhere.yaml", "-o", "nowhere"]);
    assert_eq!(code(&refused), 1);
    let text = stderr(&refused);
    assert!(text.contains("coverage is of an arena with walls, and there is none"), "{text}");
    assert!(text.contains("help: give it one: `fixed: {arena_m: 3, walls: stop}`"), "{text}");
    assert!(!place.join("nowhere").exists());

    for arguments in [
        ["sweep", "sweep.yaml", "-o", "out"].as_slice(),
        &["choose", "out", "--confirm", "100", "--viable", "0.1", "-o", "out/choice.json"],
        &["diagram", "out", "-o", "coverage.svg", "--value", "coverage"],
    ] {
        done(place, arguments);
    }
    let unasked = rsrs(place, &["diagram", "out", "-o", "x.svg", "--value", "spread_m"]);
    assert!(stderr(&unasked).contains("covering does not ask for it"), "{}", stderr(&unasked));

    let label = run_and_label(place);
    let coverage = label["evidence"]["coverage"].as_f64().expect("it is asked for");
    let phase = if coverage >= 0.6 { "covered" } else { "half_covered" };
    assert!(coverage >= 0.4 && label["phase"] == phase, "{label:#}");
    assert!(label["evidence"]["spread_m"].is_null(), "{label:#}");
    assert_eq!(label["margins"][0]["parameter"], "coverage");
    let text = stdout(&rsrs(place, &["label", "bag"]));
    assert!(text.contains(&format!(", coverage {coverage:.2}")), "{text}");
    done(place, &["draw", "bag", "-o", "run.svg"]);
    let picture = text_in(place, "run.svg");
    assert!(picture.contains("coverage (covered: 0.60 or more)"));
}

#[test]
fn a_run_that_was_once_what_it_is_judged_for_is_so_in_sweeps_episodes_labels_replays_and_compared()
{
    let folder = workplace(&CASES[2]);
    let place = folder.path();
    let ever = format!("{GATHERING}window: ever\n");
    std::fs::write(place.join("gathering.yaml"), ever).expect("the folder is writable");
    for arguments in [
        ["sweep", "sweep.yaml", "-o", "out"].as_slice(),
        &["choose", "out", "--confirm", "100", "-o", "out/choice.json"],
    ] {
        done(place, arguments);
    }
    let cell = ["--cell", "undetected_turn_rate_rad_s=-2.5"];
    let episode = ["episode", "out", "--replicate", "3", "--format", "json", "-o", "episode"];
    let episode = rsrs(place, &[episode.as_slice(), &cell].concat());
    assert_eq!(code(&episode), 0, "{}", stderr(&episode));

    let seen = rsrs(place, &["label", "episode", "--format", "json"]);
    let label = run_and_label(place);
    std::fs::write(place.join("label.json"), label.to_string()).expect("the folder is writable");
    let replay = ["replay", "bag", "--into", "judge", "--recorded", "label.json"];
    let replay = rsrs(place, &[replay.as_slice(), &["--format", "json"]].concat());
    let compared = ["compare", "out", "--bags", "bag", "--margin", "0.3", "--format", "json"];
    let compared = json(&rsrs(place, &compared));

    let [episode, seen] = [json(&episode), json(&seen)[0].clone()];
    assert_eq!(episode["phase"], seen["phase"]);
    assert_eq!(episode["evidence"], seen["evidence"], "the first minute that was gathered");
    assert_eq!(label["phase"], "gathered", "{label:#}");
    assert_eq!(json(&replay)["is_same"], true, "{}", stdout(&replay));
    assert_eq!(compared["cells"][0]["real"]["gathered"], 1, "{compared:#}");
    done(place, &["draw", "bag", "-o", "run.svg"]);
}

#[test]
fn what_makes_no_behaviour_is_refused_with_its_place_and_a_cure() {
    let folder = workplace(&CASES[2]);
    let place = folder.path();
    let refused = [
        (
            "when: {clustered: {at_least: 0.4}}",
            "when: {clusterd: {at_least: 0.4}}",
            "did you mean `clustered`?",
        ),
        ("at_least: 0.4", "at_least: 0.8", ":6: rule 2, of `gathering`, never decides"),
        ("otherwise: scattered", "otherwise: scatered", "did you mean `scattered`?"),
        (
            "{key: scattered}",
            "{key: dispersion}",
            "`dispersion` is the name of a phase of milling, which is built in\nhelp: choose another name",
        ),
        ("name: gathering", "name: milling", ":1: `milling` is the name of a behaviour, which"),
        ("key: scattered", "key: b_s", ":3: a phase cannot be called `b_s`: tables of results"),
        ("phase: gathered", "phase: gathering", ":3: no rule gives `gathered`, the first phase"),
        (
            "at_least: 0.4",
            "below: 0",
            "never holds: no clustered is less than 0\nhelp: where none at all is meant, write `at_most: 0`",
        ),
        ("at_least: 0.4", "at_least: 0", "leave the rule out, and write `otherwise: gathering`"),
        (
            "at_least: 0.4",
            "at_least: 0.4, below: 0.3",
            "no clustered is at least 0.4 and below 0.3",
        ),
        ("at_least: 0.4", "at_most: 0.4, below: 0.3", "clustered has both `below` and `at_most`"),
        ("{at_least: 0.4}", "{}", "clustered has no bound, expected `at_least`"),
        (
            "[gather, gathers, gathered]",
            "[gather, gathers]",
            ":2:52: this list has 2 values, expected 3",
        ),
        ("'#56b4e9'", "blue", "`blue` is no colour"),
        ("otherwise: scattered\n", "", "missing key `otherwise`"),
        ("clustered: {at_least: 0.4}", "", "holds of every swarm, so that nothing after it counts"),
        ("at_least: 0.75", "at_least: .nan", "expected a number from 0 to 1"),
        ("clustered: {at_least: 0.75}", "spread_m: {below: -1}", "expected a number from 0 on"),
        ("not_lasting: gathering", "window: {last_s: 5}", "the last 5 s, expected 10 to 86400 s"),
        ("not_lasting: gathering", "window: wholerun", "expected one of last_s, whole_run, ever"),
        (
            "not_lasting: gathering",
            "window: {lasts: 60}",
            "expected one of last_s, whole_run, ever",
        ),
    ];
    for (right, wrong, expected) in refused {
        let mut text = GATHERING.replace(right, wrong);
        if wrong == "{key: dispersion}" {
            text = text.replace("otherwise: scattered", "otherwise: dispersion");
        }
        std::fs::write(place.join("gathering.yaml"), text).expect("the folder is writable");
        let output = rsrs(place, &["sweep", "sweep.yaml", "-o", "out"]);
        let text = stderr(&output);
        assert!(code(&output) == 1 && text.contains(expected), "{right}: {text}");
        assert!(text.contains("gathering.yaml"), "{text}");
        assert!(!place.join("out").exists());
    }
    std::fs::remove_file(place.join("gathering.yaml")).expect("it was there");
    let gone = rsrs(place, &["sweep", "sweep.yaml", "-o", "out"]);
    assert!(stderr(&gone).contains("cannot read"), "{}", stderr(&gone));
}
