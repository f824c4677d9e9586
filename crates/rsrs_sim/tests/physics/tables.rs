//! Milling fractions over one capability at a time, against an independent implementation: the
//! prototype of this world, written before it and in other code, in double precision, with another
//! generator, platform trigonometry and a judge of its own. It is not kept in the repository, so its
//! percentages stand here as numbers. Its judge asks for stable milling over the whole window and not
//! whether it lasts, so ours is asked the same here; `neutral.rs` holds the whole judge against another
//! one, which is kept.
//!
//! Its fractions come from 200 runs each, ours from 1,000. Both are counts, so a row agrees if the
//! exact intervals of both overlap; at a tail of 0.001 on each side, a row whose fractions are equal
//! fails with a probability far below one in a thousand.

use rsrs_core::conditions::{Arena, Conditions, Placement, Region, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::profile::Sees;
use rsrs_core::statistics::interval::Interval;

use crate::support::count;
use rsrs_testing::conditions::flockbot_conditions;

const REPLICATES: u64 = 1000;
const THEIR_RUNS: u64 = 200;
const TAIL: f64 = 0.001;

/// What is changed, to which value, and the percentage of mills that was found.
struct Row {
    name: String,
    milling_percent: f64,
    conditions: Conditions,
}

/// Rows of one table: the base with one thing changed, for each value.
fn rows<const N: usize>(
    name: &str,
    table: [(f64, f64); N],
    change: impl Fn(&mut Conditions, f64),
) -> Vec<Row> {
    let row = |(value, milling_percent): (f64, f64)| {
        let mut conditions = flockbot_conditions();
        change(&mut conditions, value);
        Row { name: format!("{name} {value}"), milling_percent, conditions }
    };
    table.into_iter().map(row).collect()
}

/// The rows of which the intervals do not overlap.
fn disagreements(rows: &[Row], duration_s: f64) -> Vec<String> {
    let cells: Vec<Conditions> = rows.iter().map(|row| row.conditions.clone()).collect();
    let ours = count(&cells, REPLICATES, duration_s, |judged| {
        let whole = Behaviour::Milling.rules().phase(&judged.evidence);
        whole == Phase::StableMilling
    });
    let disagrees = |(row, hits): (&Row, &u64)| {
        let their_hits = (row.milling_percent / 100.0 * THEIR_RUNS as f64).round() as u64;
        let theirs = Interval::with_tails(their_hits, THEIR_RUNS, TAIL);
        let found = Interval::with_tails(*hits, REPLICATES, TAIL);
        let text =
            format!("{}: {} % expected, {hits} of {REPLICATES}", row.name, row.milling_percent);
        (found.low > theirs.high || found.high < theirs.low).then_some(text)
    };
    rows.iter().zip(&ours).filter_map(disagrees).collect()
}

fn set_range(conditions: &mut Conditions, new_range_m: f64) {
    let Region::Cone { range_m, .. } = &mut conditions.robot.region else {
        unreachable!("Flockbots have cones")
    };
    *range_m = new_range_m;
}

fn set_half_angle(conditions: &mut Conditions, new_half_angle_rad: f64) {
    let Region::Cone { half_angle_rad, .. } = &mut conditions.robot.region else {
        unreachable!("Flockbots have cones")
    };
    *half_angle_rad = new_half_angle_rad;
}

fn place_within(conditions: &mut Conditions, radius_m: f64) {
    conditions.placement = Placement::DiscFacingOut { radius_m };
}

#[test]
fn how_often_so_many_robots_mill() {
    let near = rows(
        "robots, range 0.75 m,",
        [(4.0, 14.0), (6.0, 88.5), (9.0, 84.5), (12.0, 0.5), (14.0, 0.0)],
        |conditions, robots| conditions.robots = robots as usize,
    );
    let far = rows(
        "robots, range 1.5 m,",
        [(6.0, 62.0), (9.0, 71.0), (12.0, 85.0), (15.0, 53.5), (20.0, 2.5), (30.0, 0.0)],
        |conditions, robots| {
            conditions.robots = robots as usize;
            set_range(conditions, 1.5);
            place_within(conditions, 1.65);
        },
    );
    let narrow = rows("robots, half-angle 5 degrees,", [(20.0, 63.5)], |conditions, robots| {
        conditions.robots = robots as usize;
        set_range(conditions, 1.5);
        set_half_angle(conditions, 5_f64.to_radians());
        place_within(conditions, 1.65);
    });

    let all: Vec<Row> = near.into_iter().chain(far).chain(narrow).collect();

    assert_eq!(disagreements(&all, 300.0), Vec::<String>::new());
}

#[test]
fn how_often_robots_mill_that_differ_or_sense_badly() {
    let spread = rows(
        "gain sd",
        [(0.0, 87.0), (0.02, 88.0), (0.05, 84.5), (0.1, 48.5), (0.15, 18.0), (0.2, 3.5)],
        |conditions, sd| {
            conditions.robot.speed_gain.robot_sd = sd;
            conditions.robot.turn_gain.robot_sd = sd;
        },
    );
    let detection = rows(
        "true positive",
        [(1.0, 82.0), (0.95, 86.0), (0.8, 84.5), (0.6, 81.5), (0.5, 64.0), (0.4, 0.0)],
        |conditions, probability| conditions.robot.true_positive = probability,
    );
    let false_positives = rows(
        "false positive",
        [(0.0, 74.5), (0.05, 87.0), (0.12, 85.0), (0.16, 56.0), (0.2, 11.0), (0.3, 0.0)],
        |conditions, probability| conditions.robot.false_positive = probability,
    );
    let range = rows(
        "range",
        [(0.7, 81.0), (0.6, 49.5), (0.55, 26.5), (0.5, 5.5), (0.45, 0.5), (0.4, 0.0), (0.3, 0.0)],
        set_range,
    );
    let latency = rows(
        "latency",
        [(1.0, 88.5), (2.0, 80.0), (4.0, 10.0), (8.0, 0.0)],
        |conditions, steps| conditions.robot.latency_steps = steps as u32,
    );
    let wide = rows("half-angle", [(30_f64.to_radians(), 0.0)], set_half_angle);
    let centre = rows("centres only", [(0.0, 58.5)], |conditions, _| {
        conditions.robot.sees = Sees::Centre;
    });

    let all: Vec<Row> = [spread, detection, false_positives, range, latency, wide, centre]
        .into_iter()
        .flatten()
        .collect();

    assert_eq!(disagreements(&all, 300.0), Vec::<String>::new());
}

#[test]
fn how_often_disturbed_or_confined_robots_mill() {
    let gusts = rows(
        "gust",
        [(0.01, 83.0), (0.02, 22.5), (0.03, 0.0), (0.05, 0.0)],
        |conditions, sd_m_s| conditions.robot.gust_sd_m_s = sd_m_s,
    );
    let lag = rows(
        "yaw lag",
        [(0.25, 87.5), (0.5, 75.5), (1.0, 61.5), (2.0, 1.5), (4.0, 0.0)],
        |conditions, lag_s| conditions.robot.yaw_lag_s = lag_s,
    );
    let placement = rows(
        "placement radius",
        [(0.4, 99.5), (0.6, 97.5), (1.2, 38.0), (1.6, 13.0), (2.5, 0.0)],
        place_within,
    );
    let period = rows("period", [(0.065, 88.0), (0.26, 33.5)], |conditions, period_s| {
        conditions.period_s = period_s;
    });
    let walls = |walls: Walls| {
        move |conditions: &mut Conditions, side_m: f64| conditions.arena = Arena { side_m, walls }
    };
    let stop = rows("side, stop", [(3.0, 51.0), (2.0, 0.5), (1.5, 0.0)], walls(Walls::Stop));
    let clamp = rows("side, clamp", [(3.0, 85.0), (2.0, 98.0), (1.5, 100.0)], walls(Walls::Clamp));
    let frozen = rows("frozen while blocked", [(0.0, 78.0)], |conditions, _| {
        conditions.robot.rotates_while_blocked = false;
    });

    let all: Vec<Row> =
        [gusts, lag, placement, period, stop, clamp, frozen].into_iter().flatten().collect();

    assert_eq!(disagreements(&all, 300.0), Vec::<String>::new());
}

#[test]
fn how_often_robots_mill_after_so_long() {
    for (duration_s, percent) in [(120.0, 79.0), (900.0, 88.0)] {
        let base = rows("seconds", [(duration_s, percent)], |_, _| {});

        assert_eq!(disagreements(&base, duration_s), Vec::<String>::new());
    }
}

#[test]
fn a_wrong_world_disagrees() {
    let wrong = rows("false positive", [(0.12, 85.0)], |conditions, _| {
        conditions.robot.false_positive = 0.16;
    });

    assert_eq!(disagreements(&wrong, 300.0).len(), 1);
}
