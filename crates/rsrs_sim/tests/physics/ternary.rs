//! Robots on two wheels with a sensor of three answers, beside the same in a world that was written in Python.

use std::path::Path;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::robot::controller::state_machine::{Row, StateMachine};
use rsrs_core::robot::controller::{Command, Controller};

use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::python;
use serde_json::Value;

use rsrs_testing::environment::or_if_long;

/// Runs here, and in Python.
pub fn n_runs() -> u64 {
    or_if_long(16, 100)
}

/// By how much two means may differ besides chance.
const POINTS: f64 = 0.02;

/// The two wheels of a robot: their greatest speed in metres per second, and how far they are apart in metres.
pub struct Wheels {
    pub most_m_s: f64,
    pub axle_m: f64,
}

impl Wheels {
    /// What a robot does when its wheels turn at shares of their greatest speed.
    pub fn command(&self, left: f64, right: f64) -> Command {
        Command {
            speed_m_s: self.most_m_s * f64::midpoint(left, right),
            turn_rate_rad_s: self.most_m_s * (right - left) / self.axle_m,
        }
    }
}

/// A controller without states: what is commanded while each of two readings is true, the first counts, and else.
pub fn controller(
    conditions: &Conditions,
    first: (&str, Command),
    second: (&str, Command),
    nothing: Command,
) -> Controller {
    let row = |when: Option<&str>, command| Row {
        state: "start".to_owned(),
        when: when.iter().map(|name| ((*name).to_owned(), true)).collect(),
        command,
        next: Vec::new(),
    };
    Controller::Machine(StateMachine {
        rows: vec![row(Some(first.0), first.1), row(Some(second.0), second.1), row(None, nothing)],
        numbers: [].into(),
        starts: [].into(),
        sensors: conditions.robot.reading_names(),
    })
}

/// Mean and standard error of an order parameter at each time, over [`n_runs`].
pub fn ours(conditions: &Conditions, key: &str, times_s: [f64; 4]) -> Vec<(f64, f64)> {
    let parameter = Parameter::from_key(key).expect("it is in the table");
    let (bodies, period_s) = (conditions.bodies(), conditions.period_s);
    let of_run = |replicate| {
        let last_s = times_s[times_s.len() - 1] + period_s;
        let run = run_episode(conditions, Seed { seed: 7, replicate }, last_s).expect("they fit");
        times_s.map(|time_s| {
            let sample = (time_s / period_s).round() as usize;
            parameter.of(&OrderParameters::with(&run, sample..sample + 1, &bodies, &[parameter]))
        })
    };
    let runs: Vec<[f64; 4]> = (0..n_runs()).map(of_run).collect();
    let n = n_runs() as f64;
    (0..times_s.len())
        .map(|time| {
            let mean = runs.iter().map(|run| run[time]).sum::<f64>() / n;
            let squares: f64 = runs.iter().map(|run| (run[time] - mean).powi(2)).sum();
            (mean, (squares / (n - 1.0) / n).sqrt())
        })
        .collect()
}

/// Asserts that a script comes to the same means, but for chance.
pub fn assert_as_in_python(
    script: &str,
    described: &Value,
    ours: &[(f64, f64)],
    times_s: [f64; 4],
) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics").join(script);
    let printed = python::answer(&script, env!("CARGO_TARGET_TMPDIR"), &described.to_string());
    let theirs: Vec<(f64, f64)> = serde_json::from_str(&printed).expect("a list of pairs");
    assert_eq!(theirs.len(), times_s.len());
    for (time_s, ((our_mean, our_error), (their_mean, their_error))) in
        times_s.into_iter().zip(ours.iter().zip(&theirs))
    {
        let most = POINTS + 4.0 * libm::hypot(*our_error, *their_error);
        assert!((our_mean - their_mean).abs() < most, "{time_s} s: {ours:?} {theirs:?}");
    }
}
