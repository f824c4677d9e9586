//! The five questions on a robot, and how many real runs decide.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rsrs_core::comparison::{MARGIN, enough};
use rsrs_core::diagram::choice::Choice;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::pooled::PooledTest;
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_sim::sweep::{Runs, Watch, sweep};
use serde_json::Value;

use crate::command::{
    answer, bring, code, done, done_line, json, repository, rsrs, run_line, shipped, stderr,
    stdout, text_in,
};
use crate::prepared_sweeps::{SPEEDS, chosen, swept, workplace};

/// One quantity of the answers.
fn quantity(answers: &Value, axis: Axis) -> Value {
    let questions = answers["questions"].as_array().expect("a list");
    let quantities = questions.iter().filter_map(|answer| answer["quantities"].as_array());
    let found = quantities.flatten().find(|quantity| quantity["axis"] == axis.key());
    found.unwrap_or_else(|| panic!("{axis} in {answers:#}")).clone()
}

/// Whether a value lies in the range of a quantity.
fn contains(answers: &Value, axis: Axis, value: f64) -> bool {
    let range = &quantity(answers, axis)["range"];
    let end = |key: &str| range[key].as_f64().unwrap_or(f64::NAN);
    (end("low")..=end("high")).contains(&value)
}

#[test]
fn of_the_papers_plane_its_cell_is_recommended_and_the_ranges_contain_it() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let sweep = &shipped("sweeps/flockbot_speed_turn.yaml");

    let answers =
        answer(place.path(), &["answer", sweep, "-o", "flockbot.png", "--format", "json"]);
    assert_eq!(answers["viable"], true);
    assert_eq!(answers["questions"].as_array().map(Vec::len), Some(5));
    for (axis, chosen) in [(Axis::Robots, 9.0), (Axis::Speed, 0.15), (Axis::TurnRate, 0.75)] {
        let quantity = quantity(&answers, axis);
        assert_eq!(quantity["recommended"], chosen, "{quantity:#}");
        assert!(contains(&answers, axis, chosen), "{quantity:#}");
    }
    let reason = quantity(&answers, Axis::Robots)["reason"].clone();
    let reason = reason.as_str().expect("a sentence");
    assert!(reason.starts_with("more robots are not always better: with "), "{reason}");
    let png = std::fs::read(place.path().join("flockbot.png")).expect("it was drawn");
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn a_profile_its_sweep_and_the_folder_of_that_have_the_same_ranges_unless_a_factor_was_decided() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let init = "init mine --name bot --robots 6 --radius 0.05 --speed 0.2 --turn-rate 2 --range 1 \
                --half-angle 0.4 --period 0.1";
    done_line(place.path(), init);
    let here = place.path().join("mine");
    done(&here, &["sweep", "sweep.yaml", "-o", "results"]);
    let sweep = text_in(&here, "sweep.yaml");
    std::fs::write(here.join("decided.yaml"), format!("{sweep}\nharsher: {{miss_factor: 3.5}}\n"))
        .expect("the folder is writable");
    let few = ["--replicates", "30", "--confirm", "100"];
    let answer = |path: &str, more: &[&str]| {
        let answered = rsrs(&here, &[&["answer", path], &few[..], more].concat());
        assert!([0, 3].contains(&code(&answered)), "{path}: {}", stderr(&answered));
        answered
    };
    let asked = |path: &str| json(&answer(path, &["--format", "json"]))["questions"].clone();

    let of_profile = asked("profile.yaml");

    assert_eq!(asked("sweep.yaml"), of_profile);
    assert_eq!(asked("results"), of_profile);
    assert_ne!(asked("decided.yaml"), of_profile);
    assert!(
        stdout(&answer("decided.yaml", &[]))
            .contains("made worse by miss_factor: 3.5 of the sweep")
    );
    assert!(!stdout(&answer("results", &[])).contains("made worse by "));
}

/// Five robots that see 1.5 m far would be 6 m apart on an ideal ring, and mill, 1.7 m apart.
#[test]
fn rings_of_another_kind_are_explained_by_no_geometry_and_contradict_its_lines() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let init = "init mine --name tb --robots 5 --radius 0.17 --speed 0.31 --turn-rate 1.9 --range 1.5 \
                --half-angle 0.6 --period 0.05";
    done_line(place.path(), init);
    let sweep = "profile: profile.yaml\naxes: {turn_rate_rad_s: [0.57, 1.0], robots: [3, 4, 5]}\n\
                 fixed: {speed_m_s: 0.25, placement_radius_m: 1.7, arena_m: 30, walls: stop}\n\
                 replicates: 50\nduration_s: 300\nseed: 7\n";
    std::fs::write(place.path().join("mine/few.yaml"), sweep).expect("the folder is writable");
    done(place.path(), &["sweep", "mine/few.yaml", "-o", "out"]);

    let answered =
        rsrs(place.path(), &["answer", "out", "--replicates", "100", "--format", "json"]);
    let drawn = rsrs(place.path(), &["diagram", "out", "-o", "out.svg"]);

    let robots = quantity(&json(&answered), Axis::Robots);
    let share = |n: usize| robots["curve"][n - 2]["b_s"].as_f64().expect("a share");
    assert!(share(5) > 0.6, "{robots:#}");
    let reason = robots["reason"].as_str().expect("a sentence");
    assert!(!reason.contains("no ring") && !reason.contains("on the ring"), "{reason}");
    assert_eq!(code(&drawn), 0, "{}", stderr(&drawn));
    let svg = text_in(place.path(), "out.svg");
    assert!(!svg.contains("the robot ahead is in reach"), "{svg}");
}

/// On one folder the three commands state the same; of a profile, with the robots of the fleet beside it.
#[test]
fn choose_answer_and_diagnose_name_one_setting() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = |line: &str| run_line(place.path(), line);
    let begun =
        run("init mine --name epuck --robots 6 --radius 0.035 --speed 0.15 --turn-rate 5.6 \
                     --range 0.6 --half-angle 0.3 --period 0.1");
    assert_eq!(code(&begun), 0, "{}", stderr(&begun));
    let swept = run("sweep mine/sweep.yaml -o out");
    assert_eq!(code(&swept), 0, "{}", stderr(&swept));
    let confirm = "--confirm 100 --format json";

    let chosen = json(&run(&format!("choose out {confirm}")));
    let answered = json(&run(&format!("answer out --replicates 10 {confirm}")));
    let diagnosed = json(&run(&format!("diagnose out {confirm}")));
    let of_profile = json(&run(&format!("answer mine/profile.yaml --replicates 20 {confirm}")));
    let of_five = json(&run(&format!("diagnose mine/profile.yaml --robots 5 {confirm}")));
    let refused = run("choose out --robots 9");

    for key in ["cell", "denser_start", "other_numbers"] {
        assert_eq!(chosen[key], answered[key], "{key}");
        assert_eq!(chosen[key], diagnosed[key], "{key}");
    }
    let worlds = [&chosen["b_s"], &chosen["as_measured"]["share"]].map(Value::as_f64);
    let least = worlds.into_iter().flatten().reduce(f64::min);
    assert_eq!(answered["b_s"].as_f64(), least, "{chosen:#}");
    assert_eq!(diagnosed["b_s"].as_f64(), least);
    assert_eq!(chosen["other_numbers"][1]["robots"], 5, "{chosen:#}");
    assert!(chosen["denser_start"]["b_s"].as_f64() > least, "{chosen:#}");
    // What `init` has written down is what is tried without it.
    for axis in ["speed_m_s", "turn_rate_rad_s"] {
        assert_eq!(of_profile["cell"][axis], chosen["cell"][axis], "{of_profile:#}");
    }
    assert_eq!(of_profile["cell"]["robots"], 6.0, "{of_profile:#}");
    assert_eq!(of_five["cell"]["robots"], 5.0, "{of_five:#}");
    // Values next to what is recommended belong to its range.
    for axis in [Axis::Speed, Axis::TurnRate] {
        let quantity = quantity(&of_profile, axis);
        let range = &quantity["range"];
        assert!(range["high"].as_f64() > range["low"].as_f64(), "{quantity:#}");
    }
    assert_eq!(code(&refused), 1);
    let expected = "no cell has 9 robots, but 6";
    assert!(stderr(&refused).contains(expected), "{}", stderr(&refused));
}

#[test]
fn candidates_are_confirmed_until_one_holds_however_many_that_takes() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let profile = &shipped("profiles/flockbot.yaml");

    let answers =
        answer(place.path(), &["answer", profile, "--replicates", "50", "--format", "json"]);
    let number = |value: &Value, key: &str| value[key].as_f64().expect("a number");
    // In the first ten of the most robust settings they mill in hardly more than 80 % of the runs.
    assert!(number(&answers, "b_s_low") >= number(&answers, "wanted"), "{answers:#}");
    for axis in [Axis::Robots, Axis::Speed, Axis::TurnRate] {
        let recommended = number(&quantity(&answers, axis), "recommended");
        assert!(contains(&answers, axis, recommended), "{:#}", quantity(&answers, axis));
    }
}

#[test]
fn robots_that_do_not_mill_are_sent_to_their_diagnosis() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let profile = &shipped("profiles/lta.yaml");

    let output = rsrs(place.path(), &["answer", profile, "--replicates", "100"]);

    assert_eq!(code(&output), 3, "{}{}", stdout(&output), stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("lta: they do not mill; "), "{text}");
    assert!(text.contains("`rsrs diagnose` names what to change"), "{text}");
}

#[test]
fn what_cannot_be_answered_from_is_refused() {
    let place = workplace(SPEEDS, "true_positive: 0.8");
    let profile = text_in(place.path(), "flockbot.yaml");
    let contradictory = profile.replace("limits_m_s: [0.02, 0.30]", "limits_m_s: [0.3, 0.1]");
    std::fs::write(place.path().join("contradictory.yaml"), contradictory).expect("writable");

    for (arguments, expected, status) in [
        (&["missing.yaml"][..], "missing.yaml", 1),
        (&["contradictory.yaml"], "expected limits with 0 <= least < most", 1),
        (&["flockbot.yaml", "-o", "wall.jpg"], "wall.jpg ends in none of .svg, .png and .pdf", 2),
        (&["flockbot.yaml", "--b-s=1"], "expected a share between 0 and 1", 2),
    ] {
        let output = rsrs(place.path(), &[&["answer"], arguments].concat());

        assert_eq!(code(&output), status, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
}

#[test]
fn how_exact_the_numbers_of_a_controller_need_to_be_is_a_sixth_question() {
    let place = tempfile::tempdir().expect("a temporary folder");
    for file in ["profiles/flockbot.yaml", "controllers/mirrored.yaml"] {
        let from = repository().join("launch_configs").join(file);
        let to = place.path().join(from.file_name().expect("a file"));
        std::fs::copy(from, to).expect("the file is there");
    }
    let sweep = "profile: flockbot.yaml\ncontroller: mirrored.yaml\n\
                 axes: {controller.turn_rate_rad_s: [0.6, 0.75, 0.9]}\n\
                 fixed: {robots: 9, placement_radius_m: 0.6, arena_m: 15}\n\
                 replicates: 20\nduration_s: 120\nseed: 7\n";
    std::fs::write(place.path().join("sweep.yaml"), sweep).expect("the folder is writable");
    done(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);
    let few = ["answer", "out", "--replicates", "20", "--confirm", "100", "--b-s", "0.5"];

    let answered =
        rsrs(place.path(), &[&few[..], &["-o", "wall.svg", "--format", "json"]].concat());
    let text = stdout(&rsrs(place.path(), &few));

    let answers = json(&answered);
    assert_eq!(answers["questions"].as_array().map(Vec::len), Some(6), "{answers:#}");
    let numbers = answers["questions"][5]["quantities"].as_array().expect("a list");
    assert_eq!(numbers.len(), 2, "{numbers:#?}");
    for (number, (key, most)) in
        numbers.iter().zip([("controller.speed_m_s", 0.3), ("controller.turn_rate_rad_s", 2.5)])
    {
        assert_eq!(number["axis"], key);
        let recommended = number["recommended"].as_f64();
        assert!(
            number["range"]["low"].as_f64() <= recommended
                && recommended <= number["range"]["high"].as_f64()
        );
        let curve = number["curve"].as_array().expect("a list");
        assert!(
            curve.len() >= 20 && curve.iter().all(|point| point["value"].as_f64() <= Some(most)),
            "{number}"
        );
    }
    assert_eq!(numbers[0]["recommended"], 0.15);
    assert!(text.contains("6. How exact do the numbers of the controller need to be?"), "{text}");
    assert!(
        text.contains(
            "2. How fast should they be moving?\n   as the file of the controller has it"
        ),
        "{text}"
    );
    let svg = text_in(place.path(), "wall.svg");
    assert!(svg.contains("speed 0.15 (") && svg.contains("turn rate (rad/s)"), "{svg}");
}

#[test]
fn a_sweep_of_one_axis_is_drawn_as_a_curve() {
    let place = tempfile::tempdir().expect("a temporary folder");
    bring("profiles/flockbot.yaml", &place.path().join("flockbot.yaml"));
    let sweep = "profile: flockbot.yaml\naxes:\n  robots: [3, 6, 9, 12]\n\
                 fixed: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, placement_radius_m: 0.7, arena_m: 15}\n\
                 replicates: 8\nduration_s: 60\nseed: 7\n";
    std::fs::write(place.path().join("sweep.yaml"), sweep).expect("the folder is writable");
    done(place.path(), &["sweep", "sweep.yaml", "-o", "out"]);

    done(place.path(), &["diagram", "out", "-o", "curve.svg"]);
    let svg = text_in(place.path(), "curve.svg");
    assert!(svg.contains("the share of runs that mill, and its 95 % interval"), "{svg}");
    assert!(svg.contains("number of robots") && svg.contains("of 8 mill"), "{svg}");
}

/// The conditions of the chosen cell with robots as measured, and its name.
fn as_measured(folder: &Path) -> (Choice, ResolvedSweep, usize) {
    let choice = text_in(folder, "out/choice.json");
    let choice: Choice = serde_json::from_str(&choice).expect("a choice");
    let source = ResolvedSweep::read_either(&folder.join("out/sweep.yaml")).expect("a sweep");
    let measured = source.as_measured().expect("the robots are made worse");
    let cells = measured.cells("sweep.yaml").expect("its cells");
    let index = cells.iter().position(|(cell, _)| *cell == choice.cell).expect("it was swept");
    (choice, measured, index)
}

/// Campaigns of simulated robots as measured are decided as often as was planned.
#[test]
fn so_many_campaigns_are_decided_as_was_planned() {
    const CAMPAIGNS: u64 = 500;
    let place = swept(SPEEDS, "true_positive: 0.8");
    let choose = ["choose", "out", "-o", "out/choice.json"];
    assert_eq!(code(&rsrs(place.path(), &choose)), 0);
    let planned =
        answer(place.path(), &["plan-experiments", "out", "--margin", "0.1", "--format", "json"]);
    let runs = planned["runs"].as_u64().expect("a number");
    let last = planned["by_runs"].as_array().and_then(|rows| rows.last()).expect("a row").clone();
    let (choice, measured, index) = as_measured(place.path());
    let conditions = measured.conditions_of(index).expect("it can be simulated");
    // Seeds that neither the sweep nor its confirmation had.
    let fresh = Runs {
        seed: 0x5eed_0001,
        replicates: CAMPAIGNS * runs,
        duration_s: measured.sweep.duration_s,
        n_threads: 2,
    };

    let watch = Watch { progress: &|_| (), cancel: &AtomicBool::new(false) };
    let swept = sweep(&[conditions], fresh, watch).expect("it can be simulated");

    let simulated = Share::milling(&choice.phases.expect("it states how its fresh runs ended"));
    let phases: Vec<Phase> = swept.outcomes.iter().map(|outcome| outcome.phase).collect();
    let n_runs = usize::try_from(runs).expect("few");
    let is_decided = |campaign: &&[Phase]| {
        (1..=campaign.len()).any(|n| {
            let mills = campaign[..n].iter().filter(|phase| **phase == Phase::STABLE_MILLING);
            let real = Share { hits: mills.count() as u64, n: n as u64 };
            let test = PooledTest::new(&[TestedCell { real, simulated, part: 0.5 }], MARGIN);
            test.is_supported(enough()) || test.is_violated(enough())
        })
    };
    let n_decided = phases.chunks(n_runs).filter(is_decided).count();
    let found = n_decided as f64 / CAMPAIGNS as f64;
    let stated = last["decided"].as_f64().expect("a number");
    assert!((found - stated).abs() <= 0.03, "{runs} runs: stated {stated}, found {found}");
}

#[test]
fn runs_are_planned_where_they_are_asked_for() {
    let place = swept(SPEEDS, "true_positive: 0.8");

    let nothing = rsrs(place.path(), &["plan-experiments", "out"]);
    let cell = "speed_m_s=0.15,turn_rate_rad_s=0.75";
    let one = rsrs(place.path(), &["plan-experiments", "out", "--cell", cell]);
    let twice = rsrs(place.path(), &["plan-experiments", "out", "--cell", cell, "--cell", cell]);
    let elsewhere = rsrs(place.path(), &["plan-experiments", "out", "--cell", "speed_m_s=0.2"]);

    assert_eq!(code(&nothing), 1);
    assert!(stderr(&nothing).contains("no choice.json"), "{}", stderr(&nothing));
    assert_eq!(code(&one), 0, "{}{}", stdout(&one), stderr(&one));
    let cell: Cell = cell.parse().expect("a cell");
    assert!(stdout(&one).contains(&format!("  {cell}  ")), "{}", stdout(&one));
    assert!(stdout(&one).contains("(`B_r ≥ B_s − 0.1`)"), "{}", stdout(&one));
    assert_eq!(code(&twice), 1);
    assert!(stderr(&twice).contains("is named twice"), "{}", stderr(&twice));
    assert_eq!(code(&elsewhere), 1, "{}", stdout(&elsewhere));
}

#[test]
fn a_plan_that_is_fixed_is_not_written_over() {
    let place = chosen();
    std::fs::write(place.path().join("experiment.yaml"), "").expect("the folder is writable");
    let fix = |margin: &str| {
        let few = "--decided 0.5 --replicates 200 -o floor.yaml";
        run_line(place.path(), &format!("plan-experiments out --margin {margin} --fixed {few}"))
    };

    let first = fix("0.3");
    let written = text_in(place.path(), "floor.yaml");
    let again = fix("0.3");
    let other = fix("0.2");

    assert_eq!(code(&first), 0, "{}{}", stdout(&first), stderr(&first));
    let campaign = "next: rsrs campaign floor.yaml -o floor\n";
    assert!(stdout(&first).ends_with(campaign), "{}", stdout(&first));
    assert_eq!((code(&again), stdout(&again)), (0, stdout(&first)));
    assert_eq!(code(&other), 1, "{}", stdout(&other));
    let refused = "floor.yaml exists, with other contents\nhelp: give another file with `-o`";
    assert!(stderr(&other).contains(refused), "{}", stderr(&other));
    assert_eq!(text_in(place.path(), "floor.yaml"), written);
}

#[test]
fn no_run_is_planned_where_nothing_is_claimed() {
    let place = chosen();
    std::fs::write(place.path().join("experiment.yaml"), "").expect("the folder is writable");
    let never = "out --replicates 200 --cell speed_m_s=0.3,turn_rate_rad_s=0.25";

    let free = run_line(place.path(), &format!("plan-experiments {never}"));
    let fixed = run_line(place.path(), &format!("plan-experiments {never} --fixed -o floor.yaml"));

    for planned in [&free, &fixed] {
        let text = stdout(planned);
        assert_eq!(code(planned), 3, "{text}{}", stderr(planned));
        assert!(text.starts_with("no claim: simulated robots mill too rarely"), "{text}");
        assert!(!text.contains("next:") && !text.contains("decided"), "{text}");
    }
    assert!(stdout(&fixed).ends_with("floor.yaml was not written, as nothing is claimed\n"));
    assert!(!place.path().join("floor.yaml").exists());
}
