//! A controller of other authors, with their numbers, does here what it does in a simulator that shares
//! nothing with this one.
//!
//! M. Gauci, J. Chen, W. Li, T. J. Dodd and R. Groß, "Self-organized aggregation without computation",
//! IJRR 33(8), 2014: e-pucks with a line of sight, backward on a circle while nothing is seen, and turning in
//! place while something is.

use std::path::{Path, PathBuf};
use std::process::Command as Process;
use std::sync::OnceLock;

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;

use crate::support::{count, perfect_flockbots};
use crate::ternary::Wheels;
use rsrs_testing::environment::or_if_long;

const WHEELS: Wheels = Wheels { most_m_s: 0.128, axle_m: 0.051 };
/// Radius of the body in metres, and control period in seconds.
const RADIUS_M: f64 = 0.037;
const PERIOD_S: f64 = 0.1;
/// Farther than the swarm is wide, in metres.
const FAR_M: f64 = 100.0;
/// When robots are looked at, in seconds.
const TIMES_S: [f64; 4] = [60.0, 120.0, 180.0, 300.0];
/// By how much two shares may differ: what chance does comes on top.
const POINTS: f64 = 0.05;

/// E-pucks on a square metre each, heading anywhere.
fn e_pucks(robots: usize, range_m: f64, contact: ContactModel) -> Conditions {
    let side_m = (robots as f64).sqrt();
    let mut conditions = perfect_flockbots();
    conditions.robots = robots;
    conditions.controller =
        ControllerParameters::new(WHEELS.command(1.0, -1.0), WHEELS.command(-0.7, -1.0)).into();
    conditions.behaviour = Behaviour::AGGREGATION;
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: side_m, height_m: side_m });
    conditions.arena = Arena { side_m: 2.0 * FAR_M, walls: Walls::None };
    conditions.robot.radius_m = RADIUS_M;
    conditions.robot.contact = contact;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.0, range_m };
    conditions.period_s = PERIOD_S;
    conditions.check().expect("they make a world");
    conditions
}

/// Whether nine tenths of the robots or more are in one cluster, of which no two neighbours are further apart
/// than four radii.
fn are_gathered(poses: &[Pose]) -> bool {
    let mut left: Vec<Pose> = poses.to_vec();
    let mut largest = 0;
    while let Some(first) = left.pop() {
        let mut cluster = vec![first];
        let mut next = 0;
        while next < cluster.len() {
            let Pose { x_m, y_m, .. } = cluster[next];
            let is_near =
                |other: &Pose| libm::hypot(other.x_m - x_m, other.y_m - y_m) < 4.0 * RADIUS_M;
            let (near, apart): (Vec<Pose>, Vec<Pose>) = left.into_iter().partition(is_near);
            left = apart;
            cluster.extend(near);
            next += 1;
        }
        largest = largest.max(cluster.len());
    }
    10 * largest >= 9 * poses.len()
}

/// In how many runs of ours the robots are gathered at each time.
fn ours(conditions: &Conditions, runs: u64, times_s: &[f64]) -> Vec<u64> {
    let last_s = times_s[times_s.len() - 1] + PERIOD_S;
    let gathered = |replicate: u64| -> Vec<bool> {
        let run = run_episode(conditions, Seed { seed: 1, replicate }, last_s).expect("they fit");
        let at = |time_s: &f64| are_gathered(run.poses_at((time_s / PERIOD_S).round() as usize));
        times_s.iter().map(at).collect()
    };
    let half = |odd: u64| -> Vec<u64> {
        let mut counts = vec![0; times_s.len()];
        for replicate in (odd..runs).step_by(2) {
            for (count, is_gathered) in counts.iter_mut().zip(gathered(replicate)) {
                *count += u64::from(is_gathered);
            }
        }
        counts
    };
    let (one, other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| half(1));
        (half(0), other.join().expect("it did not panic"))
    });
    one.iter().zip(other).map(|(one, other)| one + other).collect()
}

/// The other simulator, compiled once.
fn compiled() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics/gathering.c");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gathering");
        let mut compiler = Process::new("cc");
        let compiler = compiler.args(["-O2", "-o"]).arg(&program).arg(&source).arg("-lm");
        let status = compiler.status().expect("the linker of Rust is a compiler of C");
        assert!(status.success(), "{status}");
        program
    })
}

/// The same of the other simulator.
fn theirs(robots: usize, range_m: f64, runs: u64, times_s: &[f64]) -> Vec<u64> {
    let numbers = [robots as f64, runs as f64, 1.0, range_m];
    let arguments = numbers.iter().chain(times_s).map(ToString::to_string);
    let output = Process::new(compiled()).args(arguments).output().expect("it was compiled");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("numbers");
    text.split_whitespace().map(|count| count.parse().expect("a count")).collect()
}

/// Asserts that shares are within five points of each other, and what four standard errors of runs so few
/// allow.
fn assert_agree(what: &str, ours: &[u64], theirs: &[u64], runs: u64) {
    let mut lines = Vec::new();
    for (here, there) in ours.iter().zip(theirs) {
        let both = (here + there) as f64 / (2 * runs) as f64;
        let error = (2.0 * both * (1.0 - both) / runs as f64).sqrt();
        let difference = (*here as f64 - *there as f64).abs() / runs as f64;
        lines.push(format!("{here} {there} of {runs}: {difference:.3} +- {error:.3}"));
        assert!(difference <= POINTS + 4.0 * error, "{what}: {lines:#?}");
    }
}

#[test]
fn published_aggregation_is_that_of_an_independent_simulator() {
    // So many in the long test that 5 points are no chance; of 50 robots, fewer would show nothing.
    for (robots, runs, long_runs) in [(10, 60, 2000), (20, 16, 1000), (50, 0, 200)] {
        let runs = or_if_long(runs, long_runs);
        if runs == 0 {
            continue;
        }
        let conditions = e_pucks(robots, FAR_M, ContactModel::Push);

        let ours = ours(&conditions, runs, &TIMES_S);
        let theirs = theirs(robots, FAR_M, runs, &TIMES_S);

        assert_agree(&format!("{robots} robots"), &ours, &theirs, runs);
        assert!(5 * ours[3] >= 4 * runs, "all but a few have gathered: {ours:?} of {runs}");
    }
}

#[test]
fn the_range_from_which_robots_gather_is_that_of_an_independent_simulator() {
    let runs = or_if_long(20, 1000);
    let ranges_m = [0.5, 1.0, 2.0, 0.75, 1.5, 3.0];
    for range_m in ranges_m.into_iter().take(or_if_long(3, 6)) {
        let conditions = e_pucks(10, range_m, ContactModel::Push);

        let ours = ours(&conditions, runs, &[1200.0]);
        let theirs = theirs(10, range_m, runs, &[1200.0]);

        assert_agree(&format!("a range of {range_m} m"), &ours, &theirs, runs);
    }
}

#[test]
fn robots_that_stop_each_other_freeze_before_they_have_gathered() {
    let cells = [ContactModel::Push, ContactModel::Stop].map(|it| e_pucks(20, FAR_M, it));

    let aggregated = count(&cells, 16, 300.0, |judged| judged.phase == Phase::AGGREGATED);

    assert!(aggregated[0] >= 14 && aggregated[1] <= 4, "{aggregated:?} of 16");
}
