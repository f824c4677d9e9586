//! Three kinds of robot, made up, and the trials that a person would have written down.

use std::fmt::Write as _;

use rsrs_core::trials::fit::{Tables, Unmeasured, fit};
use rsrs_core::trials::trial::{
    MovedBy, detection_trials, period_trials, speed_trials, turn_trials,
};

use rsrs_testing::draw::Draw;

/// All files by their path below `launch_configs/profiles/`.
pub fn files() -> Vec<(String, String)> {
    let flockbot = Trials { speed: flockbot_speed(), ..trials(&FLOCKBOT) };
    let mut files = flockbot.files("flockbot_trials");
    files.push(("flockbot_trials/README.md".to_owned(), readme(&FLOCKBOT)));
    for kind in [&SMARS, &LTA] {
        let trials = trials(kind);
        let folder = format!("{}_trials", kind.name);
        files.push((format!("{}.yaml", kind.name), trials.profile(kind)));
        files.push((format!("{folder}/README.md"), readme(kind)));
        files.extend(trials.files(&folder));
    }
    files
}

/// A kind of robot that does not exist.
struct Kind {
    name: &'static str,
    about: &'static str,
    seed: u64,
    radius_m: f64,
    yaw_lag_s: f64,
    /// Commanded speeds, with the mean gain at each.
    speeds: &'static [(f64, f64)],
    /// Commanded turning rates, with the mean gain at each.
    turns: &'static [(f64, f64)],
    robot_sd: f64,
    trial_sd: f64,
    bias_sd_rad_s: f64,
    heading_noise_sd_rad: f64,
    gust_sd_m_s: f64,
    range_m: f64,
    half_angle_rad: f64,
    true_positive: f64,
    false_positive: f64,
    period_s: f64,
    jitter_s: f64,
}

const FLOCKBOT: Kind = Kind {
    name: "flockbot",
    about: "The speeds have the means and standard deviations of `tab:speed1` in the paper, of three \
            robots at 25 and 50 mm/s; its other numbers (nearly 100 % detection, 5 to 8 % false \
            positives, 130 ms) are drawn from. Everything else is invented.",
    seed: 1,
    radius_m: 0.075,
    yaw_lag_s: 0.0,
    speeds: &[(0.025, 0.88), (0.05, 0.97)],
    turns: &[(0.25, 0.96), (0.75, 0.97), (1.5, 0.97)],
    robot_sd: 0.015,
    trial_sd: 0.01,
    bias_sd_rad_s: 0.0005,
    heading_noise_sd_rad: 0.001,
    gust_sd_m_s: 0.0,
    range_m: 0.75,
    half_angle_rad: 0.2,
    true_positive: 0.98,
    false_positive: 0.065,
    period_s: 0.13,
    jitter_s: 0.004,
};

const SMARS: Kind = Kind {
    name: "smars",
    about: "A small tracked robot with a bad sensor: short, narrow, and often wrong.",
    seed: 2,
    radius_m: 0.06,
    yaw_lag_s: 0.0,
    speeds: &[(0.05, 0.85), (0.1, 0.92), (0.15, 0.93)],
    turns: &[(0.5, 0.85), (1.0, 0.9)],
    robot_sd: 0.03,
    trial_sd: 0.02,
    bias_sd_rad_s: 0.01,
    heading_noise_sd_rad: 0.005,
    gust_sd_m_s: 0.0,
    range_m: 0.4,
    half_angle_rad: 0.15,
    true_positive: 0.9,
    false_positive: 0.15,
    period_s: 0.1,
    jitter_s: 0.01,
};

const LTA: Kind = Kind {
    name: "lta",
    about: "A lighter-than-air vehicle: a good sensor, and large disturbances.",
    seed: 3,
    radius_m: 0.3,
    yaw_lag_s: 0.5,
    speeds: &[(0.2, 0.9), (0.4, 0.95)],
    turns: &[(0.3, 0.9), (0.6, 0.92)],
    robot_sd: 0.03,
    trial_sd: 0.03,
    bias_sd_rad_s: 0.02,
    heading_noise_sd_rad: 0.015,
    gust_sd_m_s: 0.05,
    range_m: 3.0,
    half_angle_rad: 0.3,
    true_positive: 0.97,
    false_positive: 0.03,
    period_s: 0.13,
    jitter_s: 0.005,
};

const ROBOTS: [&str; 5] = ["made_up_1", "made_up_2", "made_up_3", "made_up_4", "made_up_5"];
const REPETITIONS: usize = 5;
/// Length of the track, in metres (§IV step 1).
const TRACK_M: f64 = 2.0;
/// Correlation time of gusts, in seconds.
const GUST_S: f64 = 2.0;

/// The tables of one kind.
struct Trials {
    speed: String,
    turn: String,
    detection: String,
    period: String,
}

fn trials(kind: &Kind) -> Trials {
    let mut draw = Draw::new(kind.seed);
    Trials {
        speed: speed(kind, &mut draw),
        turn: turn(kind, &mut draw),
        detection: detection(kind, &mut draw),
        period: period(kind, &mut draw),
    }
}

impl Trials {
    fn files(self, folder: &str) -> Vec<(String, String)> {
        [
            ("speed", self.speed),
            ("turn", self.turn),
            ("detection", self.detection),
            ("period", self.period),
        ]
        .map(|(name, text)| (format!("{folder}/{name}.csv"), text))
        .into()
    }

    fn profile(&self, kind: &Kind) -> String {
        let file = |name: &str| format!("{}_trials/{name}.csv", kind.name);
        let speed = speed_trials(&file("speed"), &self.speed).expect("made-up trials are valid");
        let turn = turn_trials(&file("turn"), &self.turn).expect("made-up trials are valid");
        let detection = detection_trials(&file("detection"), &self.detection)
            .expect("made-up trials are valid");
        let period =
            period_trials(&file("period"), &self.period).expect("made-up trials are valid");
        let unmeasured = Unmeasured {
            radius_m: kind.radius_m,
            yaw_lag_s: kind.yaw_lag_s,
            gust_time_constant_s: GUST_S,
            reason: "made up".to_owned(),
            ..Unmeasured::default()
        };
        let tables = Tables {
            speed: &speed,
            turn: &turn,
            detection: &detection,
            period: Some(&period),
            driven: &[],
            arc: None,
            from_rest: &[],
            moved_by: MovedBy::default(),
        };
        let fitted = fit(tables, &unmeasured).expect("the sensor has a reliable region");
        let mut profile = fitted.profile(kind.name, &unmeasured);
        profile.provenance.source = format!("made-up trials; {}", profile.provenance.source);
        // JSON is YAML too, but people read this file.
        let text = profile.to_yaml();
        format!(
            "# {}\n# No such robot was measured: the trials are made up and this profile is fitted \
             to them, both by\n# `cargo run -p rsrs_core --example make_trials`.\n{text}",
            kind.about
        )
    }
}

fn readme(kind: &Kind) -> String {
    format!(
        "# Trials of `{}`, made up\n\nNo robot drove these trials: they are drawn by \
         `cargo run -p rsrs_core --example make_trials`, which rewrites this folder.\nThe robots' \
         names state this in every row.\n\n{}\n",
        kind.name, kind.about
    )
}

/// The speeds of the paper's table: mean and standard deviation of each robot at each command.
fn flockbot_speed() -> String {
    // tab:speed1, in millimetres per second.
    let table = [
        (25.0, [(22.15, 0.57), (21.48, 0.04), (22.32, 0.46)]),
        (50.0, [(48.47, 0.38), (48.66, 0.12), (48.54, 0.20)]),
    ];
    let mut draw = Draw::new(FLOCKBOT.seed);
    let mut rows = SPEED_HEADER.to_owned();
    let bias_rad_s = [(); 3].map(|()| draw.normal(0.0, FLOCKBOT.bias_sd_rad_s));
    for (commanded_mm_s, robots) in table {
        for (robot, (mean_mm_s, sd_mm_s)) in robots.into_iter().enumerate() {
            for speed_mm_s in exactly(&mut draw, mean_mm_s, sd_mm_s) {
                let run =
                    Straight { speed_m_s: speed_mm_s / 1000.0, bias_rad_s: bias_rad_s[robot] };
                row(
                    &mut rows,
                    ROBOTS[robot],
                    commanded_mm_s / 1000.0,
                    &run.end(&FLOCKBOT, &mut draw),
                );
            }
        }
    }
    rows
}

/// Numbers with exactly this mean and standard deviation.
fn exactly(draw: &mut Draw, mean: f64, sd: f64) -> [f64; REPETITIONS] {
    let drawn = [(); REPETITIONS].map(|()| draw.normal(0.0, 1.0));
    let centre = drawn.iter().sum::<f64>() / REPETITIONS as f64;
    let squares: f64 = drawn.iter().map(|number| (number - centre) * (number - centre)).sum();
    let spread = (squares / (REPETITIONS as f64 - 1.0)).sqrt();
    drawn.map(|number| mean + sd * (number - centre) / spread)
}

fn speed(kind: &Kind, draw: &mut Draw) -> String {
    let mut rows = SPEED_HEADER.to_owned();
    for robot in ROBOTS {
        let differs = draw.normal(0.0, kind.robot_sd);
        let bias_rad_s = draw.normal(0.0, kind.bias_sd_rad_s);
        for (commanded_m_s, gain) in kind.speeds {
            for _ in 0..REPETITIONS {
                let gain = gain + differs + draw.normal(0.0, kind.trial_sd);
                let run = Straight { speed_m_s: commanded_m_s * gain, bias_rad_s };
                row(&mut rows, robot, *commanded_m_s, &run.end(kind, draw));
            }
        }
    }
    rows
}

const SPEED_HEADER: &str =
    "robot,commanded_m_s,distance_m,duration_s,lateral_m,heading_change_rad\n";

struct Straight {
    speed_m_s: f64,
    bias_rad_s: f64,
}

/// What a person writes down: duration, lateral distance, heading change.
struct End {
    duration_s: f64,
    lateral_m: f64,
    heading_change_rad: f64,
}

impl Straight {
    /// Where a run over the track ends, from the moments of a random walk and of its integral.
    fn end(&self, kind: &Kind, draw: &mut Draw) -> End {
        let duration_s = TRACK_M / self.speed_m_s;
        let per_s = kind.heading_noise_sd_rad * kind.heading_noise_sd_rad / kind.period_s;
        let heading_change_rad =
            draw.normal(self.bias_rad_s * duration_s, (per_s * duration_s).sqrt());
        let bridge_rad = draw.normal(0.0, (per_s * duration_s / 12.0).sqrt());
        let calm_s = GUST_S * (1.0 - libm::exp(-duration_s / GUST_S));
        let gust_m = kind.gust_sd_m_s * (2.0 * GUST_S * (duration_s - calm_s)).sqrt();
        let lateral_m =
            TRACK_M * (heading_change_rad / 2.0 + bridge_rad) + draw.normal(0.0, gust_m);
        End { duration_s, lateral_m, heading_change_rad }
    }
}

fn row(rows: &mut String, robot: &str, commanded_m_s: f64, end: &End) {
    let End { duration_s, lateral_m, heading_change_rad } = end;
    writeln!(
        rows,
        "{robot},{commanded_m_s},{TRACK_M},{duration_s:.2},{lateral_m:.4},{heading_change_rad:.4}"
    )
    .expect("a string takes all");
}

fn turn(kind: &Kind, draw: &mut Draw) -> String {
    let mut rows = "robot,commanded_rad_s,angle_rad,duration_s\n".to_owned();
    for robot in ROBOTS {
        let differs = draw.normal(0.0, kind.robot_sd);
        for (commanded_rad_s, gain) in kind.turns {
            for _ in 0..REPETITIONS {
                let gain = gain + differs + draw.normal(0.0, kind.trial_sd);
                let duration_s = std::f64::consts::TAU / (commanded_rad_s * gain);
                writeln!(rows, "{robot},{commanded_rad_s},6.2832,{duration_s:.2}")
                    .expect("a string takes all");
            }
        }
    }
    rows
}

/// How often something with a probability happened.
fn binomial(draw: &mut Draw, n: u64, probability: f64) -> u64 {
    (0..n).filter(|_| draw.uniform() < probability).count() as u64
}

/// A grid of places, with a sensor that sees bodies in a cone and fades outside it.
fn detection(kind: &Kind, draw: &mut Draw) -> String {
    let mut rows = "robot,distance_m,bearing_rad,samples,detections\n".to_owned();
    let reach_m = kind.range_m + kind.radius_m;
    for step in 0..9 {
        let distance_m =
            2.0 * kind.radius_m + f64::from(step) / 7.0 * (reach_m - 2.0 * kind.radius_m);
        for side in -4..=4 {
            let bearing_rad = f64::from(side) * kind.half_angle_rad / 1.5;
            let (sine, cosine) = libm::sincos(bearing_rad);
            let (forward_m, lateral_m) = (distance_m * cosine, distance_m * sine);
            // A body touches the cone's edge.
            let edge_m = forward_m * libm::tan(kind.half_angle_rad)
                + kind.radius_m / libm::cos(kind.half_angle_rad);
            let outside_m = (lateral_m.abs() - edge_m).max(distance_m - reach_m).max(0.0);
            let fades = libm::exp(-outside_m / (0.5 * kind.radius_m));
            let share = kind.false_positive + (kind.true_positive - kind.false_positive) * fades;
            let detections = binomial(draw, 60, share);
            writeln!(rows, "{},{distance_m:.3},{bearing_rad:.3},60,{detections}", ROBOTS[0])
                .expect("a string takes all");
        }
    }
    for robot in &ROBOTS[..3] {
        let detections = binomial(draw, 1000, kind.false_positive);
        writeln!(rows, "{robot},,,1000,{detections}").expect("a string takes all");
    }
    rows
}

fn period(kind: &Kind, draw: &mut Draw) -> String {
    let mut rows = "robot,period_s\n".to_owned();
    for robot in &ROBOTS[..3] {
        for _ in 0..20 {
            let period_s = draw.normal(kind.period_s, kind.jitter_s);
            writeln!(rows, "{robot},{period_s:.4}").expect("a string takes all");
        }
    }
    rows
}
