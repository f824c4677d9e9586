//! Which time of a run is judged: the last seconds, all of it, or any minute.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::{JudgeError, Verdict, judged_samples, label_with};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::samples_in;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;

const PERIOD_S: f64 = 0.5;
const BODIES: Bodies = Bodies {
    radius_m: Some(0.1),
    reach_m: Some(1.0),
    arena_m: None,
    world: WorldFile::NOTHING,
    classes: Vec::new(),
};

/// Four robots that head one way in some of the time, and each its own in the rest.
fn aligned_in(times_s: std::ops::Range<f64>, duration_s: f64) -> Trajectory {
    let n_samples = samples_in(duration_s, PERIOD_S);
    let poses = (0..n_samples * 4).map(|row| {
        let (time_s, robot) = ((row / 4) as f64 * PERIOD_S, row % 4);
        let own_rad = std::f64::consts::FRAC_PI_2 * robot as f64;
        let heading_rad = if times_s.contains(&time_s) { 0.0 } else { own_rad };
        Pose { x_m: robot as f64, y_m: 0.0, heading_rad }
    });
    Trajectory::of_poses(PERIOD_S, 4, poses.collect())
}

fn text(window: &str) -> String {
    let name = format!("flock_{}", window.len());
    format!(
        "name: {name}\nwords: {{noun: flocking, swarm: a flock, verb: [flock, flocks, flocked]}}\n\
         phases: [{{key: {name}_yes}}, {{key: {name}_for_a_while}}, {{key: {name}_no}}]\n\
         rules: [{{phase: {name}_yes, when: {{polarisation: {{at_least: 0.8}}}}}}]\n\
         otherwise: {name}_no\nnot_lasting: {name}_for_a_while\n{window}"
    )
}

fn flock(window: &str) -> Behaviour {
    Behaviour::parse("flock.yaml", &text(window)).expect("it is a behaviour")
}

/// Its place among the phases: 0 for the wanted one, 1 for the one that does not last, 2 for none.
fn judged(trajectory: &Trajectory, behaviour: Behaviour) -> Result<(usize, Verdict), JudgeError> {
    let verdict = label_with(trajectory, &BODIES, &behaviour.rules())?;
    Ok((verdict.phase.place(), verdict))
}

#[test]
fn the_window_of_a_behaviour_decides_on_which_time_a_run_is_judged() {
    let once = aligned_in(30.0..110.0, 200.0);
    let place = |window| judged(&once, flock(window)).expect("it is long enough").0;

    assert_eq!(place(""), 2, "the last minute has no flock");
    assert_eq!(place("window: {last_s: 160}"), 2, "for half of that time there is one");
    assert_eq!(place("window: whole_run"), 2);
    assert_eq!(place("window: ever"), 0);

    let at_last = aligned_in(170.0..200.0, 200.0);
    let place = |window| judged(&at_last, flock(window)).expect("it is long enough").0;
    assert_eq!(place("window: {last_s: 30}"), 0);
    assert_eq!(place("window: ever"), 2, "half a minute is not enough");
}

#[test]
fn who_was_ever_in_the_wanted_phase_was_so_in_the_first_such_minute_which_is_what_is_shown() {
    let once = aligned_in(30.0..110.0, 200.0);
    let behaviour = flock("window: ever");

    let (_, verdict) = judged(&once, behaviour).expect("it is long enough");
    let samples = judged_samples(&once, &BODIES, &behaviour.rules());

    // From 20 s to 80 s five of six blocks are good, and the mean is above the bound.
    assert_eq!(samples, 40..160);
    let polarisation =
        serde_json::to_value(verdict.evidence).expect("plain")["polarisation"].as_f64();
    assert!((polarisation.expect("it is asked for") - 50.0 / 60.0).abs() < 1e-6);
    assert_eq!(verdict.blocks.len(), 6);
}

#[test]
fn the_end_of_a_run_is_a_minute_too_wherever_its_blocks_begin() {
    let at_last = aligned_in(105.0..165.0, 165.0);

    assert_eq!(judged(&at_last, flock("")).expect("it is long enough").0, 0);
    assert_eq!(judged(&at_last, flock("window: ever")).expect("it is long enough").0, 0);
}

#[test]
fn one_in_six_blocks_of_any_window_may_stray_and_no_more() {
    // Two of twelve blocks, and three.
    let (two, three) = (aligned_in(20.0..120.0, 120.0), aligned_in(23.0..120.0, 120.0));
    let place = |trajectory| judged(trajectory, flock("window: whole_run")).expect("it is long").0;

    assert_eq!(place(&two), 0);
    assert_eq!(place(&three), 1);
}

#[test]
fn a_run_must_be_as_long_as_what_is_judged() {
    let short = aligned_in(0.0..50.0, 50.0);
    let refused = |window| judged(&short, flock(window)).map(|(place, _)| place);

    assert_eq!(refused("window: {last_s: 50}"), Ok(0));
    for window in ["", "window: whole_run", "window: ever", "window: {last_s: 51}"] {
        let error = refused(window).expect_err("it is too short");
        assert!(matches!(error, JudgeError::TooShort { .. }), "{window}: {error}");
    }
    let error = refused("window: {last_s: 51}").expect_err("it is too short");
    assert_eq!(error.to_string(), "50.0 s recorded, expected at least 51 s");
}

#[test]
fn the_usual_window_need_not_be_written_and_another_one_is_another_behaviour() {
    let written = format!("{}window: {{last_s: 60}}", text(""));
    let written = Behaviour::parse("flock.yaml", &written).expect("it is a behaviour");
    let [usual, ever] = ["", "window: ever"].map(flock);

    assert_eq!(written, usual);
    assert!(!serde_json::to_string(&usual).expect("plain").contains("window"));
    let json = serde_json::to_string(&ever).expect("plain");
    assert!(json.ends_with(r#","window":"ever"}"#), "{json}");
}
