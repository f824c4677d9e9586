//! Trials drawn from known populations: intervals cover the truth as often as they claim.
//!
//! Nominal are 95 %. Of 2000 populations the share has a standard error of 0.5 %, so a share of
//! 93.5 % or more shows a coverage above 93 %. Exact intervals of counts are conservative and may
//! cover more than 98 %; the others may not.

use std::fmt::Write as _;

use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::{Fit, Rate, SensorMap, Unmeasured, fit, sensor_map};
use rsrs_core::trials::trial::{
    DetectionTrial, PeriodTrial, SpeedTrial, Trials, TurnTrial, detection_trials,
};
use rsrs_testing::draw::Draw;

use crate::tables::{tables, trials};

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
    mean_gains: [f64; 3],
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
    mean_gains: [0.88, 0.95, 0.97],
};

const COMMANDS_M_S: [f64; 3] = [0.05, 0.1, 0.2];
const PERIOD_S: f64 = 0.13;

fn names(n_robots: usize) -> Vec<String> {
    (0..n_robots).map(|robot| format!("robot_{robot}")).collect()
}

fn speeds(truth: &Truth, draw: &mut Draw) -> Trials<SpeedTrial> {
    let mut rows = Vec::new();
    for robot in 0..truth.n_robots {
        let common = draw.normal(0.0, truth.robot_sd * truth.common_share.sqrt());
        let bias_rad_s = draw.normal(0.0, truth.bias_sd_rad_s);
        for (command, commanded_m_s) in COMMANDS_M_S.into_iter().enumerate().take(truth.n_commands)
        {
            let own = draw.normal(0.0, truth.robot_sd * (1.0 - truth.common_share).sqrt());
            for _ in 0..truth.n_trials {
                let gain =
                    truth.mean_gains[command] + common + own + draw.normal(0.0, truth.trial_sd);
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
    trials("speed.csv", names(truth.n_robots), rows)
}

fn turns() -> Trials<TurnTrial> {
    let turn = |duration_s| TurnTrial {
        robot: 0,
        line: 2,
        commanded_rad_s: 0.75,
        angle_rad: std::f64::consts::TAU,
        duration_s,
    };
    trials("turn.csv", names(1), vec![turn(8.6), turn(8.7)])
}

/// The least that makes a sensor, where it does not matter.
fn any_detections() -> Trials<DetectionTrial> {
    let text = "robot,distance_m,bearing_rad,samples,detections\n\
                a,0.2,-0.2,9,9\na,0.4,0.2,9,9\na,0.4,-0.2,9,9\na,,,9,1\n";
    detection_trials("detection.csv", text).expect("it is valid")
}

/// From one tried place to the next.
const GRID_M: f64 = 0.1;
const GRID_RAD: f64 = 0.2;

/// Readings of a sensor that sees centres in a sector: 40 at each place, 500 without a neighbour.
fn detections(truth: &Sector, draw: &mut Draw) -> Trials<DetectionTrial> {
    let mut text = "robot,distance_m,bearing_rad,samples,detections\n".to_owned();
    for distance in 0..9 {
        for bearing in -5..=5 {
            let distance_m = 0.15 + GRID_M * f64::from(distance);
            let bearing_rad = GRID_RAD * f64::from(bearing);
            let is_inside = distance_m < truth.range_m && bearing_rad.abs() < truth.half_angle_rad;
            let share = if is_inside { truth.true_positive } else { truth.false_positive };
            let hits = binomial(draw, 40, share);
            writeln!(text, "robot_0,{distance_m},{bearing_rad},40,{hits}")
                .expect("a string takes all");
        }
    }
    let alarms = binomial(draw, 500, truth.false_positive);
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
    let (turn, detection) = (turns(), any_detections());
    let tables = tables(&speed, &turn, &detection, None);
    fit(tables, &Unmeasured { period_s: PERIOD_S, ..Unmeasured::default() })
        .expect("it was measured")
}

/// Fits many populations and checks every interval of their motion.
fn check(name: &str, truth: impl Fn(&mut Draw) -> Truth) {
    let [mut mean, mut robots, mut trials, mut bias, mut noise] =
        [(); 5].map(|()| Coverage::default());
    for population in 0..N_POPULATIONS {
        // Apart from the draws of the trials themselves.
        let truth = truth(&mut Draw::new(1_000_000 + population));
        let details = fitted(&truth, population).details;
        let drift = details.drift.expect("it was measured");
        mean.count_estimate(details.speed.by_command[0].gain, truth.mean_gains[0]);
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
fn robots_are_recovered_however_they_differ() {
    for (name, truth) in [
        ("alike at every command", PAPER),
        ("anew at every command", Truth { common_share: 0.0, n_commands: 3, ..PAPER }),
        ("in both ways", Truth { common_share: 0.5, n_commands: 3, n_trials: 3, ..PAPER }),
        ("hardly", Truth { robot_sd: 0.006, n_commands: 1, n_robots: 8, ..PAPER }),
    ] {
        check(name, |_| truth);
    }
}

#[test]
fn populations_of_any_means_and_spreads_are_recovered() {
    check("any", |draw| {
        let count = |draw: &mut Draw, low: usize, high: usize| {
            let steps = draw.uniform() * (high - low + 1) as f64;
            low + (1..=high - low).filter(|step| *step as f64 <= steps).count()
        };
        Truth {
            robot_sd: 0.01 + 0.04 * draw.uniform(),
            common_share: draw.uniform(),
            trial_sd: 0.005 + 0.025 * draw.uniform(),
            n_robots: count(draw, 3, 10),
            n_commands: count(draw, 1, 3),
            n_trials: count(draw, 2, 8),
            bias_sd_rad_s: 0.003 + 0.02 * draw.uniform(),
            heading_noise_sd_rad: 0.003 + 0.02 * draw.uniform(),
            mean_gains: [(); 3].map(|()| 0.7 + 0.4 * draw.uniform()),
        }
    });
}

#[test]
fn the_gain_of_each_robot_is_recovered() {
    // The truth of one robot is its own gain, so the population has no spread here.
    let truth = Truth { robot_sd: 0.0, ..PAPER };
    let mut coverage = Coverage::default();
    for population in 0..N_POPULATIONS {
        let speed = fitted(&truth, population).speed;
        let first = &speed[0];
        coverage.count(first.gain_low.unwrap(), PAPER.mean_gains[0], first.gain_high.unwrap());
    }

    coverage.assert_nominal("gain of one robot");
}

/// A sensor of one rate within a sector, and how it was measured.
#[derive(Clone, Copy)]
struct Sector {
    range_m: f64,
    half_angle_rad: f64,
    true_positive: f64,
    false_positive: f64,
}

/// What fits of many sensors came to.
#[derive(Default)]
struct SensorCoverage {
    hits: Coverage,
    alarms: Coverage,
    /// Hits by the readings that drew the polygon.
    same: Coverage,
    /// Areas of the polygons, over that of the sector.
    areas: Vec<f64>,
}

/// The rate in the polygon, by the readings that drew it.
fn of_the_same_readings(map: &SensorMap) -> Option<Rate> {
    let sides = || map.polygon_m.iter().zip(map.polygon_m.iter().cycle().skip(1));
    let is_inside = |[x_m, y_m]: [f64; 2]| {
        sides()
            .all(|([x, y], [to_x, to_y])| (to_x - x) * (y_m - y) - (to_y - y) * (x_m - x) >= -1e-9)
    };
    let inside = map.nodes.iter().filter(|node| is_inside(node.place_m()));
    let (detections, samples) = inside.fold((0, 0), |(detections, samples), node| {
        (detections + node.rate.detections, samples + node.rate.samples)
    });
    (samples > 0).then(|| Rate::new(detections, samples))
}

fn sensors(n: u64, sector: impl Fn(&mut Draw) -> Sector) -> SensorCoverage {
    let mut found = SensorCoverage::default();
    for population in 0..n {
        let mut draw = Draw::new(population);
        let truth = sector(&mut draw);
        let trials = detections(&truth, &mut draw);
        let map = sensor_map(&trials, 0.075).expect("there is a region");
        if let Some(same) = of_the_same_readings(&map) {
            found.same.count(same.low, truth.true_positive, same.high);
        }
        let (hit, alarm) = (map.true_positive, map.false_positive);
        found.hits.count(hit.low, truth.true_positive, hit.high);
        found.alarms.count(alarm.low, truth.false_positive, alarm.high);
        for [x_m, y_m] in &map.polygon_m {
            // Between the last place inside and the first outside, no trial was made.
            assert!(libm::hypot(*x_m, *y_m) <= truth.range_m + GRID_M, "{map:?}");
            let bearing_rad = libm::atan2(*y_m, *x_m).abs();
            // The tip is the robot's own centre, rounded.
            let is_tip = libm::hypot(*x_m, *y_m) < 0.001;
            assert!(is_tip || bearing_rad <= truth.half_angle_rad + GRID_RAD, "{map:?}");
        }
        let corners = map.polygon_m.iter().zip(map.polygon_m.iter().cycle().skip(1));
        let area_m2: f64 = corners.map(|([x, y], [to_x, to_y])| (x * to_y - to_x * y) / 2.0).sum();
        found.areas.push(area_m2 / (truth.range_m * truth.range_m * truth.half_angle_rad));
    }
    found
}

#[test]
fn sensors_of_any_region_and_rates_are_recovered() {
    let mut found = sensors(500, |draw| Sector {
        range_m: 0.4 + 0.5 * draw.uniform(),
        half_angle_rad: 0.3 + 0.5 * draw.uniform(),
        true_positive: 0.88 + 0.11 * draw.uniform(),
        false_positive: 0.01 + 0.2 * draw.uniform(),
    });

    found.hits.assert_conservative("true positives");
    found.alarms.assert_conservative("false positives");
    found.areas.sort_by(f64::total_cmp);
    // Places are 10 cm and 0.2 rad apart, and the edge is taken to be half of the way between them; the
    // polygon is convex, and cuts a little off a sector.
    let (least, median) = (found.areas[0], found.areas[250]);
    assert!(least > 0.4 && (0.87..1.0).contains(&median), "{least}, {median}");
}

#[test]
fn a_sensor_that_is_hardly_reliable_is_not_taken_for_a_better_one() {
    for true_positive in [0.84, 0.8] {
        let (range_m, half_angle_rad) = (0.5, 0.4);
        let found = sensors(500, |_| Sector {
            range_m,
            half_angle_rad,
            true_positive,
            false_positive: 0.05,
        });

        found.hits.assert_conservative(&format!("true positives near {true_positive}"));
        // A place is in the polygon because its readings were good: they cannot be asked again.
        let same = found.same.n_covered as f64 / found.same.n as f64;
        assert!(same < 0.93, "the same readings: {same}");
    }
}

#[test]
fn a_share_is_covered_at_least_as_often_as_stated() {
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
        let period = trials("period.csv", names(4), rows);
        let speed = speeds(&PAPER, &mut draw);
        let (turn, detection) = (turns(), any_detections());
        let tables = tables(&speed, &turn, &detection, Some(&period));
        let found = fit(tables, &Unmeasured::default()).unwrap().details.period.unwrap();
        mean.count_estimate(found.period_s, PERIOD_S);
        jitter.count_estimate(found.jitter_s.unwrap(), 0.004);
    }

    mean.assert_nominal("period");
    jitter.assert_nominal("jitter");
}
