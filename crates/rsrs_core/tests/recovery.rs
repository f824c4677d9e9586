//! Trials drawn from known populations: intervals cover the truth as often as they say.
//!
//! Nominal are 95 %. Of 2000 populations the share has a standard error of 0.5 %, so a share of
//! 93.5 % or more shows a coverage above 93 %. Exact intervals of counts are conservative and may
//! cover more than 98 %; the others may not.

#[path = "../examples/make_trials/draw.rs"]
mod draw;

use std::fmt::Write as _;

use draw::Draw;
use rsrs_core::fit::{Fit, Rate, Tables, Unmeasured, fit};
use rsrs_core::trial::{
    DetectionTrial, PeriodTrial, SpeedTrial, Trials, TurnTrial, detection_trials,
};
use rsrs_core::variance::Estimate;

const N_POPULATIONS: u64 = 2000;

/// A population of robots, and how it is measured.
#[derive(Clone, Copy)]
struct Truth {
    robot_sd: f64,
    /// Of `robot_sd`'s variance, the share that a robot differs by at every command alike.
    common_share: f64,
    trial_sd: f64,
    n_robots: usize,
    n_commands: usize,
    n_trials: usize,
    bias_sd_rad_s: f64,
    heading_noise_sd_rad: f64,
}

const PAPER: Truth = Truth {
    robot_sd: 0.02,
    common_share: 1.0,
    trial_sd: 0.01,
    n_robots: 5,
    n_commands: 2,
    n_trials: 5,
    bias_sd_rad_s: 0.01,
    heading_noise_sd_rad: 0.01,
};

const COMMANDS_M_S: [f64; 3] = [0.05, 0.1, 0.2];
const MEAN_GAINS: [f64; 3] = [0.88, 0.95, 0.97];
const PERIOD_S: f64 = 0.13;

fn names(n_robots: usize) -> Vec<String> {
    (0..n_robots).map(|robot| format!("robot_{robot}")).collect()
}

fn speeds(truth: &Truth, draw: &mut Draw) -> Trials<SpeedTrial> {
    let mut rows = Vec::new();
    for robot in 0..truth.n_robots {
        let common = draw.normal(0.0, truth.robot_sd * truth.common_share.sqrt());
        let bias_rad_s = draw.normal(0.0, truth.bias_sd_rad_s);
        for command in 0..truth.n_commands {
            let own = draw.normal(0.0, truth.robot_sd * (1.0 - truth.common_share).sqrt());
            for _ in 0..truth.n_trials {
                let commanded_m_s = COMMANDS_M_S[command];
                let gain = MEAN_GAINS[command] + common + own + draw.normal(0.0, truth.trial_sd);
                let duration_s = 2.0 / (gain * commanded_m_s);
                let noise_rad = truth.heading_noise_sd_rad * (duration_s / PERIOD_S).sqrt();
                rows.push(SpeedTrial {
                    robot,
                    line: rows.len() as u64 + 2,
                    commanded_m_s,
                    distance_m: 2.0,
                    duration_s,
                    lateral_m: None,
                    heading_change_rad: Some(draw.normal(bias_rad_s * duration_s, noise_rad)),
                });
            }
        }
    }
    Trials { file: "speed.csv".to_owned(), robots: names(truth.n_robots), rows }
}

fn turns() -> Trials<TurnTrial> {
    let turn = |duration_s| TurnTrial {
        robot: 0,
        line: 2,
        commanded_rad_s: 0.75,
        angle_rad: std::f64::consts::TAU,
        duration_s,
    };
    Trials { file: "turn.csv".to_owned(), robots: names(1), rows: vec![turn(8.6), turn(8.7)] }
}

/// The least that makes a sensor, where it does not matter.
fn any_detections() -> Trials<DetectionTrial> {
    let text = "robot,distance_m,bearing_rad,samples,detections\n\
                a,0.2,-0.2,9,9\na,0.4,0.2,9,9\na,0.4,-0.2,9,9\na,,,9,1\n";
    detection_trials("detection.csv", text).expect("it is valid")
}

/// A sensor that sees centres in a sector of 0.4 rad to either side, up to 0.5 m.
fn detections(true_positive: f64, false_positive: f64, draw: &mut Draw) -> Trials<DetectionTrial> {
    let mut text = "robot,distance_m,bearing_rad,samples,detections\n".to_owned();
    for distance_m in [0.15, 0.25, 0.35, 0.45, 0.55] {
        for bearing_rad in [-0.6, -0.3, 0.0, 0.3, 0.6_f64] {
            let is_inside = distance_m < 0.5 && bearing_rad.abs() < 0.4;
            let share = if is_inside { true_positive } else { false_positive };
            let hits = binomial(draw, 40, share);
            writeln!(text, "robot_0,{distance_m},{bearing_rad},40,{hits}")
                .expect("a string takes all");
        }
    }
    let alarms = binomial(draw, 500, false_positive);
    writeln!(text, "robot_0,,,500,{alarms}").expect("a string takes all");
    detection_trials("detection.csv", &text).expect("it is valid")
}

/// How often something with a probability happened.
fn binomial(draw: &mut Draw, n: u64, probability: f64) -> u64 {
    (0..n).filter(|_| draw.uniform() < probability).count() as u64
}

/// How often intervals covered the truth.
#[derive(Default)]
struct Coverage {
    n: u64,
    n_covered: u64,
}

impl Coverage {
    fn count(&mut self, low: f64, truth: f64, high: f64) {
        self.n += 1;
        self.n_covered += u64::from(low <= truth && truth <= high);
    }

    fn count_estimate(&mut self, estimate: Estimate, truth: f64) {
        let (Some(low), Some(high)) = (estimate.low, estimate.high) else {
            panic!("{estimate:?} has no interval")
        };
        self.count(low, truth, high);
    }

    fn assert_nominal(&self, what: &str) {
        let share = self.n_covered as f64 / self.n as f64;
        assert!(self.n >= 500 && (0.935..=0.98).contains(&share), "{what}: {share}");
    }

    fn assert_conservative(&self, what: &str) {
        let share = self.n_covered as f64 / self.n as f64;
        assert!(self.n >= 500 && share >= 0.945, "{what}: {share}");
    }
}

fn fitted(truth: &Truth, population: u64) -> Fit {
    let mut draw = Draw::new(population);
    let speed = speeds(truth, &mut draw);
    let detection = any_detections();
    let tables =
        Tables { speed: &speed, turn: &turns(), detection: &detection, period: None, driven: &[] };
    fit(tables, &Unmeasured { period_s: PERIOD_S, ..Unmeasured::default() })
        .expect("it was measured")
}

/// Fits many populations and checks every interval of their motion.
fn check(name: &str, truth: &Truth) {
    let [mut mean, mut robots, mut trials, mut bias, mut noise] =
        [(); 5].map(|()| Coverage::default());
    for population in 0..N_POPULATIONS {
        let details = fitted(truth, population).details;
        let drift = details.drift.expect("it was measured");
        mean.count_estimate(details.speed.by_command[0].gain, MEAN_GAINS[0]);
        robots.count_estimate(details.speed.robot_sd.expect("it was measured"), truth.robot_sd);
        trials.count_estimate(details.speed.trial_sd.expect("it was measured"), truth.trial_sd);
        bias.count_estimate(drift.bias_sd_rad_s, truth.bias_sd_rad_s);
        noise.count_estimate(
            drift.heading_noise_sd_rad.expect("it was measured"),
            truth.heading_noise_sd_rad,
        );
    }
    mean.assert_nominal(&format!("{name}: mean gain"));
    robots.assert_nominal(&format!("{name}: spread between robots"));
    trials.assert_nominal(&format!("{name}: spread between trials"));
    bias.assert_nominal(&format!("{name}: bias"));
    noise.assert_nominal(&format!("{name}: heading noise"));
}

#[test]
fn five_robots_that_differ_alike_at_every_command_are_recovered() {
    check("paper", &PAPER);
}

#[test]
fn robots_that_differ_anew_at_every_command_are_recovered() {
    check("anew", &Truth { common_share: 0.0, n_commands: 3, ..PAPER });
}

#[test]
fn robots_that_differ_in_both_ways_are_recovered() {
    check("both", &Truth { common_share: 0.5, n_commands: 3, n_trials: 3, ..PAPER });
}

#[test]
fn robots_that_hardly_differ_are_recovered() {
    check("alike", &Truth { robot_sd: 0.006, n_commands: 1, n_robots: 8, ..PAPER });
}

#[test]
fn the_gain_of_each_robot_is_recovered() {
    // The truth of one robot is its own gain, so the population has no spread here.
    let truth = Truth { robot_sd: 0.0, ..PAPER };
    let mut coverage = Coverage::default();
    for population in 0..N_POPULATIONS {
        let speed = fitted(&truth, population).speed;
        let first = &speed[0];
        coverage.count(first.gain_low.unwrap(), MEAN_GAINS[0], first.gain_high.unwrap());
    }

    coverage.assert_nominal("gain of one robot");
}

#[test]
fn the_rates_of_the_sensor_are_recovered_conservatively() {
    for (true_positive, false_positive) in [(0.95, 0.065), (0.99, 0.02), (0.9, 0.15)] {
        let [mut hits, mut alarms, mut region] = [(); 3].map(|()| Coverage::default());
        for population in 0..N_POPULATIONS {
            let mut draw = Draw::new(population);
            let speed = speeds(&PAPER, &mut draw);
            let detection = detections(true_positive, false_positive, &mut draw);
            let tables = Tables {
                speed: &speed,
                turn: &turns(),
                detection: &detection,
                period: None,
                driven: &[],
            };
            let sensor = fit(tables, &Unmeasured::default()).unwrap().sensor;
            hits.count(sensor.true_positive_low, true_positive, sensor.true_positive_high);
            alarms.count(sensor.false_positive_low, false_positive, sensor.false_positive_high);
            // Between the last place inside and the first outside, nobody looked.
            let far_m = sensor.polygon_m.iter().map(|corner| libm::hypot(corner[0], corner[1]));
            region.count(0.0, far_m.fold(0.0, f64::max), 0.55);
        }

        hits.assert_conservative("true positives");
        alarms.assert_conservative("false positives");
        assert_eq!(region.n_covered, region.n);
    }
}

#[test]
fn a_share_is_covered_at_least_as_often_as_it_says() {
    let mut draw = Draw::new(7);
    let mut coverage = Coverage::default();
    for _ in 0..N_POPULATIONS {
        let rate = Rate::new(binomial(&mut draw, 30, 0.065), 30);
        coverage.count(rate.low, 0.065, rate.high);
    }

    coverage.assert_conservative("share");
}

#[test]
fn the_period_is_recovered() {
    let [mut mean, mut jitter] = [(); 2].map(|()| Coverage::default());
    for population in 0..N_POPULATIONS {
        let mut draw = Draw::new(population);
        let mut rows = Vec::new();
        for robot in 0..4 {
            let own_s = draw.normal(PERIOD_S, 0.002);
            for _ in 0..10 {
                let period_s = draw.normal(own_s, 0.004);
                rows.push(PeriodTrial { robot, line: rows.len() as u64 + 2, period_s });
            }
        }
        let period = Trials { file: "period.csv".to_owned(), robots: names(4), rows };
        let speed = speeds(&PAPER, &mut draw);
        let detection = any_detections();
        let tables = Tables {
            speed: &speed,
            turn: &turns(),
            detection: &detection,
            period: Some(&period),
            driven: &[],
        };
        let found = fit(tables, &Unmeasured::default()).unwrap().details.period.unwrap();
        mean.count_estimate(found.period_s, PERIOD_S);
        jitter.count_estimate(found.jitter_s.unwrap(), 0.004);
    }

    mean.assert_nominal("period");
    jitter.assert_nominal("jitter");
}
