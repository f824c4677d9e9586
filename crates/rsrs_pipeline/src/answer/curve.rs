//! How often robots mill as one quantity changes.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::choice::Margin;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::tidy;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::ReplicateOutcome;

use super::reason::{Edge, Why};
use super::tried_value::TriedValue;
use super::{AnswerOptions, Point, Quantity, Range};
use crate::best_setting::search::{Changes, Search};

/// Numbers of robots that are tried.
const ROBOTS: std::ops::RangeInclusive<u32> = 2..=20;
/// Each value of a command, a range or an angle over the one before.
const FACTOR: f64 = 1.1;
/// So many values below and above what is recommended, or what the robot has.
const FACTORS: std::ops::RangeInclusive<i32> = -12..=12;
/// A sensor does not open farther, in radians.
const WIDEST_RAD: f64 = 1.5;
/// Steps between two values of the rates of true and false positives, and of
/// the spread of the gains, and how far the latter two go.
const SHARE_STEP: f64 = 0.05;
const FALSE_STEP: f64 = 0.02;
const MOST_FALSE: f64 = 0.5;
const GAIN_STEP: f64 = 0.0125;
const MOST_GAIN: f64 = 0.3;
/// Steps between the bounds of a controller's number.
const NUMBER_STEPS: u32 = 24;
/// Steps of latency that are tried.
const LATENCIES: std::ops::RangeInclusive<u32> = 0..=12;

/// Moves one quantity from the recommended cell; `None` if robots have no such quantity.
pub fn quantity(
    search: &Search<'_>,
    cell: &Cell,
    axis: Axis,
    options: AnswerOptions<'_>,
) -> anyhow::Result<Option<Quantity>> {
    let settings = search.settings.with_cell(cell);
    let named = settings.controller.as_ref().and_then(|table| table.number(axis));
    let set = || settings.values.iter().rev().find(|(other, _)| *other == axis);
    let now = if axis.is_capability() {
        search.source.profile.capability(axis)
    } else {
        set().map(|(_, value)| *value).or(named.map(|number| number.value))
    };
    let Some(now) = now else { return Ok(None) };
    let values = match named {
        Some(number) => with(now, between([number.from, number.to])),
        None => with(now, values(&search.source.profile, axis, now)),
    };
    let swept = swept(search, cell, (axis, &values), options)?;
    let curve: Vec<Point> =
        swept.iter().map(|swept| Point::new(swept.value, Share::milling(&swept.phases))).collect();
    let around = around(&curve, now, options.best.wanted);
    let range = around.map(|(first, last)| Range::new(&curve, (first, last), now));
    let at = swept.iter().position(|swept| same(swept.value, now));
    let why = match (around, at) {
        (Some((first, last)), Some(at)) => {
            let edge = |outward: Vec<_>, n_inside| {
                (n_inside < outward.len()).then(|| Box::new(Edge::new(&outward, n_inside)))
            };
            let below = edge(swept[..=at].iter().rev().collect(), at - first + 1);
            Why::Ends { below, above: edge(swept[at..].iter().collect(), last - at + 1) }
        }
        (_, at) => Why::nowhere(&swept, at.map(|at| &swept[at])),
    };
    Ok(Some(Quantity { axis, recommended: now, range, curve, why }))
}

/// Runs with each value that is possible, in both worlds.
fn swept(
    search: &Search<'_>,
    cell: &Cell,
    (axis, values): (Axis, &[f64]),
    options: AnswerOptions<'_>,
) -> anyhow::Result<Vec<TriedValue>> {
    let mut possible = Vec::new();
    for value in values {
        let (changes, cell) = if axis.is_capability() {
            (vec![(axis, *value)], cell.clone())
        } else {
            let others = cell.iter().filter(|(other, _)| *other != axis);
            (Changes::new(), Cell::new(others.chain([(axis, *value)]))?)
        };
        possible.extend(search.in_both_worlds(&changes, &cell).map(|worlds| (*value, worlds)));
    }
    let conditions: Vec<Conditions> =
        possible.iter().flat_map(|(_, worlds)| worlds.iter().cloned()).collect();
    let doing = axis.key();
    let ran =
        search.simulate(&conditions, (search.source.sweep.seed, options.replicates), doing)?;
    let rarer = |counts: &[PhaseCounts]| {
        let milling = |counts: &PhaseCounts| Share::milling(counts).hits;
        if milling(&counts[1]) < milling(&counts[0]) { counts[1] } else { counts[0] }
    };
    let counts = ran.counts(conditions.len());
    let swept = possible.into_iter().enumerate().zip(counts.chunks(2)).map(
        |((index, (value, [harsher, _])), counts)| {
            let ring_m = ring_m(&ran.outcomes, 2 * index);
            TriedValue { value, phases: rarer(counts), harsher, ring_m }
        },
    );
    Ok(swept.collect())
}

/// Mean radius of the mills of a cell, in metres; `None` if there are none.
fn ring_m(outcomes: &[ReplicateOutcome], cell: usize) -> Option<f64> {
    let is_mill = |it: &&ReplicateOutcome| it.cell == cell && it.phase == Phase::STABLE_MILLING;
    let radii_m: Vec<f64> =
        outcomes.iter().filter(is_mill).map(|it| it.evidence.mean_radius_m).collect();
    (!radii_m.is_empty()).then(|| radii_m.iter().sum::<f64>() / radii_m.len() as f64)
}

/// The values of a controller's number that are tried: all that its table allows, in even steps.
fn between([from, to]: [f64; 2]) -> Vec<f64> {
    let share = |step: u32| f64::from(step) / f64::from(NUMBER_STEPS);
    (0..=NUMBER_STEPS).map(|step| tidy(from + share(step) * (to - from))).collect()
}

/// These values, ascending and each once, and what there is now among them.
fn with(now: f64, mut values: Vec<f64>) -> Vec<f64> {
    if !values.iter().any(|value| same(*value, now)) {
        values.push(now);
    }
    values.sort_by(f64::total_cmp);
    values.dedup_by(|one, other| same(*one, *other));
    values
}

/// The values of a quantity that are tried.
fn values(robot: &RobotProfile, axis: Axis, now: f64) -> Vec<f64> {
    let steps = |step: f64, most: f64| -> Vec<f64> {
        let numbers = (0..).map(|number| tidy(f64::from(number) * step));
        numbers.take_while(|value| *value <= most + 1e-9).collect()
    };
    let around = || -> Vec<f64> {
        FACTORS.map(|power| tidy(now * libm::pow(FACTOR, f64::from(power)))).collect()
    };
    // Up to the limits, as far as they are near; those of a robot are of both directions.
    let within = |limits: [f64; 2]| -> Vec<f64> {
        let near = around();
        let (first, last) = (near[0].abs(), near[near.len() - 1].abs());
        let ends = limits.into_iter().filter(|end| (first..=last).contains(end));
        let inside = |value: &f64| (limits[0]..=limits[1]).contains(&value.abs());
        ends.map(|end| end.copysign(now)).chain(near.iter().copied().filter(inside)).collect()
    };
    let mut values = match axis {
        Axis::Robots => ROBOTS.map(f64::from).collect(),
        Axis::Speed | Axis::UndetectedSpeed => within(robot.actuation.speed.limits_m_s),
        Axis::TurnRate | Axis::UndetectedTurnRate => within(robot.actuation.turn.limits_rad_s),
        Axis::TruePositive => steps(SHARE_STEP, 1.0),
        Axis::FalsePositive => steps(FALSE_STEP, MOST_FALSE),
        Axis::Heterogeneity => steps(GAIN_STEP, MOST_GAIN),
        Axis::LatencySteps => LATENCIES.map(f64::from).collect(),
        _ => around(),
    };
    if axis == Axis::HalfAngle {
        values.retain(|value| *value <= WIDEST_RAD.max(now));
    }
    values
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= 1e-9 * one.abs().max(1.0)
}

/// The first and the last point around a value before the share is less than wanted: by itself
/// surely, or pooled with its neighbours. `None` if it is surely less at the value itself.
fn around(curve: &[Point], now: f64, wanted: f64) -> Option<(usize, usize)> {
    let at = curve.iter().position(|point| same(point.value, now))?;
    if curve[at].b_s_high < wanted {
        return None;
    }
    let below: Vec<&Point> = curve[..=at].iter().rev().collect();
    let above: Vec<&Point> = curve[at..].iter().collect();
    Some((at - n_beyond(&below, wanted), at + n_beyond(&above, wanted)))
}

/// How many values beyond the first belong to the range.
fn n_beyond(outward: &[&Point], wanted: f64) -> usize {
    let pooled = falling(outward);
    let holds = |index: &usize| pooled[*index] >= wanted && outward[*index].b_s_high >= wanted;
    (1..outward.len()).take_while(holds).count()
}

/// The shares of mills as they would be if they only fell from the first value on: those that chance has
/// put out of order are pooled (isotonic regression by pooling adjacent violators).
fn falling(outward: &[&Point]) -> Vec<f64> {
    let mut pools: Vec<(Share, usize)> = Vec::new();
    for point in outward {
        let mut pool = (point.milling(), 1);
        while let Some((before, n_before)) = pools.last().copied() {
            if before.value() > pool.0.value() {
                break;
            }
            pools.pop();
            let (hits, n) = (pool.0.hits + before.hits, pool.0.n + before.n);
            pool = (Share { hits, n }, pool.1 + n_before);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(share, n)| std::iter::repeat_n(share.value(), n)).collect()
}

impl Range {
    fn new(curve: &[Point], (first, last): (usize, usize), now: f64) -> Self {
        let (low, high) = (curve[first].value, curve[last].value);
        Self {
            low,
            high,
            ends_below: first > 0,
            ends_above: last + 1 < curve.len(),
            margin: Margin { low: tidy(now - low), high: tidy(high - now) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many mills of 1000 runs at each value.
    fn curve(mills: &[u64]) -> Vec<Point> {
        let point =
            |(index, hits): (usize, &u64)| Point::new(index as f64, Share { hits: *hits, n: 1000 });
        mills.iter().enumerate().map(point).collect()
    }

    #[test]
    fn values_that_mill_less_often_than_wanted_together_are_not_in_the_range() {
        // As in 250 runs: none of them is surely below 0.8, and all nine together are.
        let mills = [240, 230, 194, 196, 192, 190, 189, 198, 187, 194, 194, 60];
        let point =
            |(index, hits): (usize, &u64)| Point::new(index as f64, Share { hits: *hits, n: 250 });
        let curve: Vec<Point> = mills.iter().enumerate().map(point).collect();
        assert!(curve[2..11].iter().all(|point| point.b_s_high >= 0.8), "{curve:?}");

        assert_eq!(around(&curve, 1.0, 0.8), Some((0, 1)));
    }

    #[test]
    fn a_value_that_chance_has_put_below_its_neighbours_ends_no_range() {
        assert_eq!(around(&curve(&[950, 900, 790, 880, 860, 300]), 1.0, 0.8), Some((0, 4)));
        // What is surely below ends it, whatever comes behind.
        assert_eq!(around(&curve(&[950, 900, 500, 950, 950, 950]), 1.0, 0.8), Some((0, 1)));
    }

    #[test]
    fn a_range_ends_before_the_first_value_that_fails() {
        let curve = curve(&[900, 100, 850, 950, 900, 700, 900]);

        let (first, last) = around(&curve, 3.0, 0.8).unwrap();
        let range = Range::new(&curve, (first, last), 3.0);

        assert_eq!((first, last), (2, 4));
        assert!(range.ends_below && range.ends_above);
        assert_eq!(range.margin, Margin { low: 1.0, high: 1.0 });
        assert_eq!(around(&curve, 5.0, 0.8), None);
    }

    #[test]
    fn a_range_may_go_as_far_as_was_tried() {
        let curve = curve(&[900, 950, 900]);

        let range = Range::new(&curve, around(&curve, 1.0, 0.8).unwrap(), 1.0);

        assert!(!range.ends_below && !range.ends_above);
    }
}
