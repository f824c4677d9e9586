//! Why robots do not mill: defects that are planted in sound robots are named, and mending them helps.

use std::path::Path;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_testing::environment::{is_long, number, or_if_long};
use serde_json::Value;

use crate::command::{code, done, json, repository, rsrs, stderr, text_in};

/// Few settings, among them good ones for robots like the Flockbot, scaled to the size of a body.
fn sweep(folder: &Path, scale: f64) {
    let text = format!(
        "profile: robot.yaml\n\
         axes:\n  speed_m_s: [{}, {}]\n  turn_rate_rad_s: [0.5, 0.75, 1.2]\n  robots: [6, 9]\n\
         fixed: {{placement_radius_m: {}, arena_m: 40, walls: stop}}\n\
         duration_s: 300\nseed: 3\n",
        0.08 * scale,
        0.12 * scale,
        0.5 * scale
    );
    std::fs::write(folder.join("sweep.yaml"), text).expect("the folder is writable");
}

/// A robot like the Flockbot.
#[derive(Clone)]
struct Robot {
    /// Its size over the Flockbot's.
    scale: f64,
    /// Edges of its sensor, in radians, seen as a polygon; else it has a cone.
    edges_rad: Option<[f64; 2]>,
    half_angle_rad: f64,
    range_m: f64,
    true_positive: f64,
    false_positive: f64,
    gain_sd: f64,
    heading_noise_rad: f64,
    gust_m_s: f64,
    period_s: f64,
}

const FLOCKBOT: Robot = Robot {
    scale: 1.0,
    edges_rad: None,
    half_angle_rad: 0.2,
    range_m: 0.75,
    true_positive: 0.98,
    false_positive: 0.05,
    gain_sd: 0.01,
    heading_noise_rad: 0.0,
    gust_m_s: 0.0,
    period_s: 0.13,
};

/// A sound robot that sees centres in a wedge.
const WEDGE: Robot = Robot { edges_rad: Some([-0.25, 0.25]), ..FLOCKBOT };

impl Robot {
    fn random(generator: &mut ChaCha8Rng) -> Self {
        let mut within = |least: f64, most: f64| generator.random_range(least..most);
        let robot = Self {
            scale: within(0.7, 1.5),
            range_m: within(0.72, 0.85),
            half_angle_rad: within(0.18, 0.22),
            true_positive: within(0.96, 1.0),
            false_positive: within(0.01, 0.06),
            gain_sd: within(0.005, 0.015),
            period_s: within(0.09, 0.14),
            ..FLOCKBOT
        };
        if within(0.0, 1.0) < 0.5 { robot } else { Self { edges_rad: WEDGE.edges_rad, ..robot } }
    }

    fn write(&self, folder: &Path) {
        let Self { scale, period_s, .. } = self;
        let range_m = self.range_m * scale;
        let (sees, region) = match self.edges_rad {
            None => {
                let angle_rad = self.half_angle_rad;
                ("body", format!("cone: {{half_angle_rad: {angle_rad}, range_m: {range_m}}}"))
            }
            Some([right, left]) => {
                // Centres are seen as far as bodies' edges.
                let far_m = range_m + 0.075 * scale;
                let corner = |step: u32| {
                    let (sine, cosine) =
                        libm::sincos(right + (left - right) * f64::from(step) / 4.0);
                    format!("[{:.5}, {:.5}]", far_m * cosine, far_m * sine)
                };
                let corners: Vec<String> = (0..5).map(corner).collect();
                ("centre", format!("polygon_m: [[0, 0], {}]", corners.join(", ")))
            }
        };
        let text = format!(
            "name: robot\n\
             body: {{radius_m: {}, front_half_angle_rad: 1.2217, rotates_while_blocked: true}}\n\
             actuation:\n  speed:\n    limits_m_s: [{}, {}]\n    \
             gain_by_command: [{{commanded_m_s: 0.05, mean: 0.97}}]\n    \
             robot_sd: {sd}\n    step_sd: 0\n  turn:\n    limits_rad_s: [0.1, 2.5]\n    \
             gain_by_command: [{{commanded_rad_s: 0.75, mean: 0.97}}]\n    \
             robot_sd: {sd}\n    step_sd: 0\n    bias_sd_rad_s: 0\n    \
             heading_noise_sd_rad: {}\n  gust: {{sd_m_s: {}, time_constant_s: 2}}\n  yaw_lag_s: 0\n\
             sensing:\n  sees: {sees}\n  {region}\n  true_positive: {}\n  false_positive: {}\n  \
             latency_steps: 0\n\
             computation: {{period_s: {period_s}}}\n\
             provenance: {{source: made up}}\n",
            0.075 * scale,
            0.02 * scale,
            0.3 * scale,
            self.heading_noise_rad,
            self.gust_m_s * scale,
            self.true_positive,
            self.false_positive,
            sd = self.gain_sd,
        );
        std::fs::write(folder.join("robot.yaml"), text).expect("the folder is writable");
        sweep(folder, *scale);
    }

    fn diagnosis(&self) -> Value {
        let folder = tempfile::tempdir().expect("a temporary folder");
        self.write(folder.path());
        let arguments = ["diagnose", "sweep.yaml", "--confirm", "200", "--format", "json"];
        let output = rsrs(folder.path(), &arguments);
        let expected = if json(&output)["viable"] == true { 0 } else { 3 };
        assert_eq!(code(&output), expected, "{}", stderr(&output));
        json(&output)
    }
}

/// What can be wrong.
const DEFECTS: [&str; 9] = [
    "lean",
    "lopsided",
    "range_m",
    "true_positive",
    "false_positive",
    "heterogeneity",
    "heading_noise_rad",
    "gust_m_s",
    "period_s",
];

impl Robot {
    /// The robot with a defect; the axis that mends it.
    fn plant(&mut self, defect: &str, severity: f64) -> &'static str {
        match defect {
            "lean" => {
                let by = 0.14 * severity;
                self.edges_rad = Some([-0.25 + by, 0.25 + by]);
                "sensor_bearing_rad"
            }
            "lopsided" => {
                self.edges_rad = Some([0.04 * severity, 0.5]);
                "sensor_bearing_rad"
            }
            "range_m" => {
                self.range_m = 0.27 / severity;
                "range_m"
            }
            "true_positive" => {
                self.true_positive = 0.5 / severity;
                "true_positive"
            }
            "false_positive" => {
                self.false_positive = (0.3 * severity).min(0.8);
                "false_positive"
            }
            "heterogeneity" => {
                self.gain_sd = (0.09 * severity).min(0.3);
                "heterogeneity"
            }
            "heading_noise_rad" => {
                self.heading_noise_rad = 0.3 * severity;
                "heading_noise_rad"
            }
            "gust_m_s" => {
                self.gust_m_s = 0.04 * severity;
                "gust_m_s"
            }
            _ => {
                self.period_s = 1.2 * severity;
                "period_s"
            }
        }
    }
}

/// The capabilities of all sets of changes, each in order of its letters.
fn sets(diagnosis: &Value) -> Vec<Vec<String>> {
    let name = |value: &Value| value.as_str().expect("an axis").to_owned();
    let set = |cause: &Value| {
        let others = cause["with"].as_array().into_iter().flatten().map(name);
        let mut set: Vec<String> =
            std::iter::once(name(&cause["capability"])).chain(others).collect();
        set.sort_unstable();
        set
    };
    diagnosis["causes"].as_array().expect("a list").iter().map(set).collect()
}

/// The capabilities of the first set of changes.
fn first_set(diagnosis: &Value) -> Vec<String> {
    sets(diagnosis).into_iter().next().unwrap_or_default()
}

#[test]
fn a_sensor_that_leans_to_the_left_is_to_be_aimed_to_the_right() {
    let leaning = Robot { edges_rad: Some([-0.11, 0.39]), ..WEDGE };

    let diagnosis = leaning.diagnosis();

    assert_eq!(diagnosis["viable"], false, "{diagnosis:#}");
    let cause = &diagnosis["causes"][0];
    assert_eq!(cause["capability"], "sensor_bearing_rad", "{diagnosis:#}");
    assert_eq!(cause["alone"], true);
    let needed_rad = cause["needed"].as_f64().expect("a number");
    assert!((-0.3..=-0.03).contains(&needed_rad), "{needed_rad}");
    assert!(cause["b_s_low"].as_f64() >= Some(0.8), "{cause}");
    assert!(cause["change"].as_str().expect("words").ends_with("° to the right"), "{cause}");
    // The mended robot, as a laboratory would write it down.
    let mended = [-0.11, 0.39].map(|edge_rad: f64| edge_rad + needed_rad);
    let after = Robot { edges_rad: Some(mended), ..WEDGE }.diagnosis();
    assert_eq!(after["viable"], true, "{after:#}");
}

#[test]
fn with_sound_robots_nothing_is_wrong_and_what_could_be_worse_is_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    FLOCKBOT.write(folder.path());

    let output = done(folder.path(), &["diagnose", "sweep.yaml", "--confirm", "500"]);
    let text = output;
    assert!(text.starts_with("robot: these robots mill; nothing is wrong\n"), "{text}");
    assert!(text.contains("false positive rate 0.05, "), "{text}");
}

#[test]
fn what_cannot_be_diagnosed_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    FLOCKBOT.write(folder.path());
    let robot = text_in(folder.path(), "robot.yaml");
    let contradictory = robot.replace("limits_m_s: [0.02, 0.3]", "limits_m_s: [0.3, 0.1]");
    std::fs::write(folder.path().join("contradictory.yaml"), contradictory).expect("writable");
    let slow = robot.replace("limits_m_s: [0.02, 0.3]", "limits_m_s: [0.02, 0.05]");
    std::fs::write(folder.path().join("slow.yaml"), slow).expect("writable");

    for (arguments, expected) in [
        (&["missing.yaml"][..], "missing.yaml"),
        (&["contradictory.yaml"], "expected limits with 0 <= least < most"),
        (&["slow.yaml", "--sweep", "sweep.yaml"], "beyond the robots' limits"),
    ] {
        let output = rsrs(folder.path(), &[&["diagnose"], arguments].concat());

        assert_eq!(code(&output), 1, "{}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
    for wrong in ["--cost=range=5", "--cost=range_m", "--b-s=1"] {
        let output = rsrs(folder.path(), &["diagnose", "robot.yaml", wrong]);

        assert_eq!(code(&output), 2, "{wrong}: {}", stderr(&output));
    }
}

#[test]
fn defects_that_are_planted_in_sound_robots_are_named() {
    let n_robots: usize = number("RSRS_DEFECTS").unwrap_or(2);
    let mut generator = ChaCha8Rng::seed_from_u64(17);
    let mut others = Vec::new();

    for number in 0..n_robots {
        let sound = Robot::random(&mut generator);
        // A defect that takes nothing away from this robot is planted deeper.
        let defect = DEFECTS[(number + 4) % DEFECTS.len()];
        let planted = [1.0, 1.4, 2.0, 2.8].into_iter().find_map(|severity| {
            let mut robot = sound.clone();
            let axis = robot.plant(defect, severity);
            let diagnosis = robot.diagnosis();
            (diagnosis["viable"] == false).then_some((axis, diagnosis))
        });
        let (axis, diagnosis) = planted.unwrap_or_else(|| panic!("{defect} does no harm"));
        let found = first_set(&diagnosis);
        if found != [axis] {
            others.push(format!("{number}: {defect}, found {found:?}"));
        }
    }

    assert!(10 * others.len() <= n_robots, "of {n_robots} not named: {others:#?}");
}

#[test]
fn two_planted_defects_are_named_together_in_most_robots() {
    let n_robots = or_if_long(1, 20);
    let mut generator = ChaCha8Rng::seed_from_u64(23);
    let mut others = Vec::new();

    for number in 0..n_robots {
        let mut robot = Robot::random(&mut generator);
        let pairs = [
            ("lean", "false_positive"),
            ("heterogeneity", "gust_m_s"),
            ("true_positive", "lean"),
            ("heading_noise_rad", "false_positive"),
        ];
        let (one, other) = pairs[number % pairs.len()];
        let mut planted = [robot.plant(one, 1.4), robot.plant(other, 1.4)];
        planted.sort_unstable();
        let found = sets(&robot.diagnosis());
        if !found.iter().any(|set| *set == planted) {
            others.push(format!("{number}: {planted:?}, found {found:?}"));
        }
    }

    assert!(2 * others.len() < n_robots, "of {n_robots} not named: {others:#?}");
}

/// The profiles of the repository in the built-in settings; what is needed is written into them.
#[test]
fn the_repositorys_robots_are_diagnosed_and_mill_when_mended() {
    let profiles = repository().join("launch_configs/profiles");
    let diagnose = |path: &Path, more: &[&str]| {
        let path = path.to_str().expect("a path in UTF-8");
        json(&rsrs(&profiles, &[&["diagnose", path, "--format", "json"], more].concat()))
    };

    // With any number of robots it takes longer, and all three take minutes.
    let flockbot = profiles.join("flockbot.yaml");
    if !is_long() {
        let seven = diagnose(&flockbot, &["--robots", "7", "--confirm", "400"]);
        assert_eq!(seven["viable"], true, "{seven:#}");
        return;
    }
    let flockbot = diagnose(&flockbot, &[]);
    assert_eq!(flockbot["viable"], true, "{flockbot:#}");

    let folder = tempfile::tempdir().expect("a temporary folder");
    let lta = diagnose(&profiles.join("lta.yaml"), &[]);
    let smars = diagnose(&profiles.join("smars.yaml"), &[]);

    assert!(first_set(&lta).contains(&"gust_m_s".to_owned()), "{lta:#}");
    // Made up with a bad sensor, and yet what keeps it from milling is how much its gains differ, too.
    assert_eq!(first_set(&smars), ["heterogeneity", "range_m"], "{smars:#}");
    let number = |cause: usize, key: &str| smars["causes"][cause][key].as_f64().expect("a number");
    let (gains, farther) = (number(0, "needed"), number(1, "needed") / number(1, "now"));
    let text = text_in(&profiles, "smars.yaml")
        .replace("robot_sd: 0.0545272", &format!("robot_sd: {gains}"))
        .replace("robot_sd: 0.0262843", &format!("robot_sd: {gains}"));
    let (before, rest) = text.split_once("  polygon_m:\n").expect("its sensor has corners");
    let (corners, after) = rest.split_once("  true_positive:").expect("and rates behind them");
    let corners: Vec<String> = corners
        .lines()
        .map(|line| {
            let (list, number) = line.rsplit_once(' ').expect("a number is in a list");
            let number: f64 = number.parse().expect("a corner has numbers");
            format!("{list} {:.4}", number * farther)
        })
        .collect();
    let corners = corners.join("\n");
    let mended = format!("{before}  polygon_m:\n{corners}\n  true_positive:{after}");
    let path = folder.path().join("mended.yaml");
    std::fs::write(&path, mended).expect("the folder is writable");
    // From the disc that was searched: that of the mended robots by themselves is wider.
    let (start_m, at) = (&smars["denser_start"]["now_m"], &smars["causes"][0]["cell"]);
    let sweep = folder.path().join("sweep.yaml");
    let lines = format!(
        "profile: mended.yaml\ncells: [{at}]\nfixed: {{placement_radius_m: {start_m}, arena_m: 15}}\n\
         duration_s: 300\nseed: 1\n"
    );
    std::fs::write(&sweep, lines).expect("the folder is writable");
    let sweep = sweep.to_str().expect("a path in UTF-8");
    let with_sweep = ["diagnose", "mended.yaml", "--sweep", sweep, "--format", "json"];
    let mended = json(&rsrs(folder.path(), &with_sweep));
    assert_eq!(mended["viable"], true, "with {gains} and {farther} times the range: {mended:#}");
    assert!(gains < 0.05 && farther > 1.5);
}
