//! Milling fractions over one capability at a time, against an independent implementation: the
//! prototype of this world, written before it and in other code, in double precision, with another
//! generator, platform trigonometry and a judge of its own; how far a body is from a cone it finds by
//! cases, from bearing and distance. It is not kept in the repository, so its percentages stand here as
//! numbers. Its judge asks for stable milling over the whole window and not whether it lasts, so ours
//! is asked the same here; `neutral.rs` holds the whole judge against another one, which is kept. A robot
//! is blocked where it is held up, as here; were every touch counted, 49.8, 14.1, 3.0 and 57.2 % would mill
//! with gains that differ by 0.1, 0.15 and 0.2 and where centres are seen, and elsewhere as many as here.
//!
//! Its fractions come from 1,000 runs each, as ours. Both are counts, so a row agrees if the
//! exact intervals of both overlap; at a tail of 0.001 on each side, a row whose fractions are equal
//! fails with a probability far below one in a thousand.

use rsrs_core::conditions::{Arena, Conditions, Placement, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::statistics::interval::Interval;

use crate::support::count;
use rsrs_testing::conditions::flockbot_conditions;

const REPLICATES: u64 = 1000;
const THEIR_RUNS: u64 = 1000;
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
        let whole = Behaviour::MILLING.rules().phase(&judged.evidence);
        whole == Phase::STABLE_MILLING
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
        [(4.0, 16.6), (6.0, 84.2), (9.0, 85.6), (12.0, 2.2), (14.0, 0.0)],
        |conditions, robots| conditions.robots = robots as usize,
    );
    let far = rows(
        "robots, range 1.5 m,",
        [(6.0, 61.3), (9.0, 71.3), (12.0, 80.5), (15.0, 56.8), (20.0, 1.6), (30.0, 0.0)],
        |conditions, robots| {
            conditions.robots = robots as usize;
            set_range(conditions, 1.5);
            place_within(conditions, 1.65);
        },
    );
    let narrow = rows("robots, half-angle 5 degrees,", [(20.0, 63.4)], |conditions, robots| {
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
        [(0.0, 86.9), (0.02, 86.0), (0.05, 88.0), (0.1, 53.9), (0.15, 22.4), (0.2, 8.4)],
        |conditions, sd| {
            conditions.robot.speed_gain.robot_sd = sd;
            conditions.robot.turn_gain.robot_sd = sd;
        },
    );
    let detection = rows(
        "true positive",
        [(1.0, 85.4), (0.95, 87.4), (0.8, 86.3), (0.6, 81.1), (0.5, 60.9), (0.4, 0.1)],
        |conditions, probability| conditions.robot.true_positive = probability,
    );
    let false_positives = rows(
        "false positive",
        [(0.0, 73.6), (0.05, 85.4), (0.12, 83.0), (0.16, 62.5), (0.2, 13.6), (0.3, 0.0)],
        |conditions, probability| conditions.robot.false_positive = probability,
    );
    let range = rows(
        "range",
        [(0.7, 81.9), (0.6, 63.4), (0.55, 47.5), (0.5, 23.4), (0.45, 6.4), (0.4, 0.7), (0.3, 0.0)],
        set_range,
    );
    let latency = rows(
        "latency",
        [(1.0, 87.6), (2.0, 79.8), (4.0, 13.0), (8.0, 0.0)],
        |conditions, steps| conditions.robot.latency_steps = steps as u32,
    );
    let wide = rows("half-angle", [(30_f64.to_radians(), 0.0)], set_half_angle);
    let centre = rows("centres only", [(0.0, 63.0)], |conditions, _| {
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
        [(0.01, 82.6), (0.02, 22.4), (0.03, 0.4), (0.05, 0.0)],
        |conditions, sd_m_s| conditions.robot.gust_sd_m_s = sd_m_s,
    );
    let lag = rows(
        "yaw lag",
        [(0.25, 83.5), (0.5, 72.4), (1.0, 55.1), (2.0, 0.7), (4.0, 0.0)],
        |conditions, lag_s| conditions.robot.yaw_lag_s = lag_s,
    );
    let placement = rows(
        "placement radius",
        [(0.4, 99.6), (0.6, 98.5), (1.2, 41.0), (1.6, 11.1), (2.5, 0.2)],
        place_within,
    );
    let period = rows("period", [(0.065, 86.5), (0.26, 28.9)], |conditions, period_s| {
        conditions.period_s = period_s;
    });
    let walls = |walls: Walls| {
        move |conditions: &mut Conditions, side_m: f64| conditions.arena = Arena { side_m, walls }
    };
    let stop = rows("side, stop", [(3.0, 49.4), (2.0, 0.5), (1.5, 0.0)], walls(Walls::Stop));
    let clamp = rows("side, clamp", [(3.0, 84.2), (2.0, 98.7), (1.5, 99.9)], walls(Walls::Clamp));
    let frozen = rows("frozen while blocked", [(0.0, 84.7)], |conditions, _| {
        conditions.robot.rotates_while_blocked = false;
    });

    let all: Vec<Row> =
        [gusts, lag, placement, period, stop, clamp, frozen].into_iter().flatten().collect();

    assert_eq!(disagreements(&all, 300.0), Vec::<String>::new());
}

#[test]
fn how_often_robots_mill_after_so_long() {
    for (duration_s, percent) in [(120.0, 78.5), (900.0, 89.4)] {
        let base = rows("seconds", [(duration_s, percent)], |_, _| {});

        assert_eq!(disagreements(&base, duration_s), Vec::<String>::new());
    }
}

#[test]
fn a_wrong_world_disagrees() {
    let wrong = rows("false positive", [(0.12, 83.0)], |conditions, _| {
        conditions.robot.false_positive = 0.16;
    });

    assert_eq!(disagreements(&wrong, 300.0).len(), 1);
}
