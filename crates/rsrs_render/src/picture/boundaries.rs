//! The boundaries of a mill by geometry, as lines in the plane of a diagram.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::theory::Condition;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_pipeline::swarm::Swarm;
use rsrs_view::diagram::{Boundary, Side};

/// The plane of a diagram: its axes, and the least and greatest swept value on each.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Horizontal axis.
    pub x: (Axis, f64, f64),
    /// Vertical axis, if there is one.
    pub y: Option<(Axis, f64, f64)>,
}

/// The line of each condition for an ideal ring that begins or ceases to hold in the plane, where
/// simulated robots do not contradict it: most runs of the cells in `mills` mill.
///
/// Each condition holds on one side of a line, as each depends on every axis in one direction only.
/// What is no axis of the plane is taken from `conditions`, one of its cells. There are no lines if
/// the theory does not hold for these robots, see [`Ring::new`], nor where their sensor is turned
/// along an axis.
pub fn boundaries(conditions: &Conditions, plane: Plane, mills: &[&Cell]) -> Vec<Boundary> {
    if plane.x.0 == Axis::SensorBearing || plane.y.is_some_and(|y| y.0 == Axis::SensorBearing) {
        return Vec::new();
    }
    let Some(swarm) = Swarm::new(conditions) else {
        return Vec::new();
    };
    let line = |condition: Condition| {
        let (points, holds) = match plane.y {
            Some(y) => curve(condition, swarm, (plane.x, y))?,
            None => upright(condition, swarm, plane.x)?,
        };
        let label = label(condition);
        (points.len() >= 2).then_some(Boundary { label, points, holds })
    };
    let stands = |condition: &Condition| !is_contradicted(*condition, swarm, mills);
    Condition::ALL.into_iter().filter(stands).filter_map(line).collect()
}

fn label(condition: Condition) -> String {
    format!("ideal ring: {}", condition.title())
}

/// More than this share of the cells that mill beyond a line is no scatter.
const SCATTER: f64 = 0.1;

/// Whether robots mill where a condition does not hold: on a ring of another kind.
fn is_contradicted(condition: Condition, swarm: Swarm, mills: &[&Cell]) -> bool {
    let is_beyond = |cell: &&&Cell| {
        let there = cell.iter().fold(swarm, |swarm, (axis, value)| swarm.with(axis, value));
        there.meets(condition) == Some(false)
    };
    mills.iter().filter(is_beyond).count() as f64 > SCATTER * mills.len() as f64
}

type Span = (Axis, f64, f64);
type Points = Vec<(f64, f64)>;

/// Points of a line, taken along the axis on which it has more of them.
fn curve(condition: Condition, swarm: Swarm, (x, y): (Span, Span)) -> Option<(Points, Side)> {
    let along = |along: Span, across: Span| -> Vec<(f64, Crossing)> {
        let point = |value: f64| {
            crossing(condition, swarm.with(along.0, value), across).map(|found| (value, found))
        };
        values(along).filter_map(point).collect()
    };
    let along_x = along(x, y);
    let along_y = along(y, x);
    if along_x.len() >= along_y.len() {
        let holds = if along_x.first()?.1.holds_above { Side::Above } else { Side::Below };
        Some((along_x.into_iter().map(|(x, found)| (x, found.value)).collect(), holds))
    } else {
        let holds = if along_y.first()?.1.holds_above { Side::Right } else { Side::Left };
        Some((along_y.into_iter().map(|(y, found)| (found.value, y)).collect(), holds))
    }
}

/// The line across a diagram of one axis.
fn upright(condition: Condition, swarm: Swarm, x: Span) -> Option<(Points, Side)> {
    let Crossing { value, holds_above } = crossing(condition, swarm, x)?;
    let holds = if holds_above { Side::Right } else { Side::Left };
    Some((vec![(value, -0.5), (value, 0.5)], holds))
}

/// Where along an axis a condition begins or ceases to hold.
#[derive(Clone, Copy)]
struct Crossing {
    value: f64,
    /// Whether it holds at higher values.
    holds_above: bool,
}

/// The first crossing along an axis.
fn crossing(condition: Condition, swarm: Swarm, (axis, low, high): Span) -> Option<Crossing> {
    let meets = |value: f64| swarm.with(axis, value).meets(condition);
    let values: Vec<f64> = values((axis, low, high)).collect();
    let pair = values.windows(2).find(|pair| {
        let (before, after) = (meets(pair[0]), meets(pair[1]));
        before.is_some() && after.is_some() && before != after
    })?;
    let (mut from, mut to) = (pair[0], pair[1]);
    let before = meets(from);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (from + to);
        if meets(middle) == before { from = middle } else { to = middle }
    }
    Some(Crossing { value: 0.5 * (from + to), holds_above: before == Some(false) })
}

/// Values along an axis, evenly spaced; they reach beyond the outermost cells' centres, as the
/// plot does.
fn values((_, low, high): Span) -> impl Iterator<Item = f64> {
    let beyond = if high > low { 0.5 * (high - low) } else { 0.5 * high };
    let (from, to) = ((low - beyond).max(LEAST), high + beyond);
    (0..=SEGMENTS).map(move |segment| from + (to - from) * f64::from(segment) / f64::from(SEGMENTS))
}

const SEGMENTS: u32 = 200;
const BISECTIONS: u32 = 40;

/// All quantities of the theory are positive.
const LEAST: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::{Placement, Settings};
    use rsrs_core::diagram::theory::Ring;
    use rsrs_core::robot::profile::Sees;
    use rsrs_core::robot::region::Region;

    use super::*;

    fn conditions() -> Conditions {
        let profile = rsrs_testing::conditions::flockbot();
        let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
        let mut conditions =
            Conditions::resolve(&profile, &Settings { values, ..Settings::default() }).unwrap();
        conditions.placement = Placement::DiscFacingOut { radius_m: 0.8 };
        conditions
    }

    fn lines(x: Span, y: Option<Span>) -> Vec<Boundary> {
        boundaries(&conditions(), Plane { x, y }, &[])
    }

    /// The only line with this label.
    fn line(lines: &[Boundary], condition: Condition) -> &Boundary {
        let label = label(condition);
        lines.iter().find(|line| line.label == label).expect("the line is there")
    }

    #[test]
    fn speed_against_turning_rate_shows_the_greatest_speed_and_nothing_else() {
        let lines = lines((Axis::Speed, 0.05, 0.5), Some((Axis::TurnRate, 0.25, 2.0)));

        assert_eq!(lines.len(), 1, "{lines:?}");
        let ring = Ring::new(&conditions()).unwrap();
        let gains = conditions().robot;
        assert_eq!(line(&lines, Condition::FastTurnBalance).holds, Side::Above);
        for (speed_m_s, turn_rate_rad_s) in &line(&lines, Condition::FastTurnBalance).points {
            let delivered_rad_s = turn_rate_rad_s * gains.turn_gain.mean;
            let greatest_m_s = speed_m_s * gains.speed_gain.mean;
            assert!(ring.holds(greatest_m_s - 1e-6, delivered_rad_s));
            assert!(!ring.holds(greatest_m_s + 1e-6, delivered_rad_s));
        }
    }

    #[test]
    fn robots_against_half_angle_shows_where_rings_exist_reach_and_have_room() {
        let lines = lines((Axis::Robots, 3.0, 20.0), Some((Axis::HalfAngle, 0.05, 0.6)));

        for (robots, half_angle_rad) in &line(&lines, Condition::Existence).points {
            assert!((half_angle_rad - std::f64::consts::PI / robots).abs() < 1e-9);
        }
        for (robots, half_angle_rad) in &line(&lines, Condition::Reach).points {
            // The chord is r / sin(pi/N - a), and a body's side touches the end of an edge of 0.75 m.
            let seen_rad = std::f64::consts::PI / robots - half_angle_rad;
            assert!((0.075 / libm::sin(seen_rad) - libm::hypot(0.75, 0.075)).abs() < 1e-6);
        }
        for (robots, half_angle_rad) in &line(&lines, Condition::Room).points {
            let seen_rad = std::f64::consts::PI / robots - half_angle_rad;
            assert!((libm::sin(seen_rad) - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn a_limit_that_does_not_depend_on_an_axis_is_a_straight_line() {
        let lines = lines((Axis::Range, 0.3, 1.0), Some((Axis::Gust, 0.0, 0.1)));

        let reach = line(&lines, Condition::Reach);
        assert!(reach.points.len() > 100);
        // The chord of nine Flockbots is 0.505 m: with their radius across it, the hypotenuse.
        assert!(reach.points.iter().all(|(range_m, _)| (range_m - 0.499).abs() < 1e-3));
    }

    #[test]
    fn a_sweep_of_one_axis_has_upright_lines() {
        let lines = lines((Axis::FalsePositive, 0.0, 0.5), None);

        let balance = line(&lines, Condition::FastTurnBalance);
        assert_eq!(balance.holds, Side::Left);
        let balance = &balance.points;
        assert_eq!(balance.len(), 2);
        assert!((balance[0].0 - 0.364).abs() < 2e-3, "{balance:?}");
        assert_eq!((balance[0].1, balance[1].1), (-0.5, 0.5));
    }

    #[test]
    fn a_line_beyond_which_robots_mill_is_not_drawn() {
        let plane = Plane { x: (Axis::Robots, 3.0, 12.0), y: Some((Axis::Range, 0.3, 1.0)) };
        let cell = |robots| Cell::new([(Axis::Robots, robots), (Axis::Range, 0.4)]).unwrap();
        let (fits, beyond) = (cell(7.0), cell(9.0));
        let has_reach = |mills: &[&Cell]| {
            let lines = boundaries(&conditions(), plane, mills);
            lines.iter().any(|line| line.label == label(Condition::Reach))
        };

        assert!(has_reach(&[&fits]));
        assert!(!has_reach(&[&fits, &beyond]));
    }

    #[test]
    fn robots_for_which_the_theory_does_not_hold_have_no_lines() {
        let mut centres = conditions();
        centres.robot.sees = Sees::Centre;
        let mut polygon = conditions();
        polygon.robot.region =
            Region::Polygon { corners_m: vec![[0.0, -0.1], [0.7, 0.0], [0.0, 0.1]] };
        let plane = Plane { x: (Axis::Speed, 0.05, 0.5), y: Some((Axis::TurnRate, 0.25, 2.0)) };

        assert_eq!(boundaries(&centres, plane, &[]), []);
        assert_eq!(boundaries(&polygon, plane, &[]), []);
    }
}
