//! The simulated polygon: convex, with few edges, and inside the measured one.

use crate::plane::{Point, area, between, cross, left_of, minus, sides};
use crate::robot::sensor::MAX_CORNERS;

/// A large convex polygon inside a simple one, both counterclockwise, in metres; `None` if nothing
/// is left.
///
/// The convex hull is cut until nothing of the measured border is left inside: always at the
/// deepest point, along the line that leaves the most area. Then corners are dropped, the least
/// missed first, until few enough are left: 3 to [`MAX_CORNERS`], to a tenth of a millimetre. What
/// remains claims less than what was measured, which is the point (`fig:sim_sensing`, red inside
/// blue).
pub fn inscribed(measured_m: &[Point]) -> Option<Vec<Point>> {
    let mut convex = hull(measured_m);
    // Every cut frees a corner or an edge of the border for good.
    for _ in 0..4 * measured_m.len() {
        let Some((point, directions)) = deepest(measured_m, &convex) else { break };
        convex = directions
            .iter()
            .flat_map(|direction| {
                let [x, y] = *direction;
                [[x, y], [-x, -y]].map(|direction| cut(&convex, point, direction))
            })
            .max_by(|left, right| area(left).total_cmp(&area(right)))
            .expect("there are directions");
    }
    while convex.len() > MAX_CORNERS {
        let least = (0..convex.len())
            .min_by(|left, right| ear_m2(&convex, *left).total_cmp(&ear_m2(&convex, *right)))
            .expect("there are corners");
        convex.remove(least);
    }
    for corner in &mut convex {
        *corner = corner.map(|number| (number * 1e4).round() / 1e4);
    }
    // Rounding can leave corners that are none, or that point inwards by a hair.
    while let Some(flat) = (0..convex.len()).find(|corner| ear_m2(&convex, *corner) <= 1e-7) {
        convex.remove(flat);
    }
    (convex.len() >= 3).then_some(convex)
}

/// Where the measured border reaches deepest into a convex polygon, and along which lines a cut
/// there may run.
fn deepest(measured: &[Point], convex: &[Point]) -> Option<(Point, Vec<Point>)> {
    let n = measured.len();
    let along = |from: usize| minus(measured[(from + 1) % n], measured[from % n]);
    let corners =
        (0..n).map(|corner| (measured[corner], vec![along(corner), along(corner + n - 1)], true));
    let edges = (0..n).filter_map(|edge| {
        let middle = middle_inside(convex, measured[edge], measured[(edge + 1) % n])?;
        Some((middle, vec![along(edge)], false))
    });
    let (point, mut directions, is_corner) = corners
        .chain(edges)
        .max_by(|left, right| depth_m(convex, left.0).total_cmp(&depth_m(convex, right.0)))?;
    if depth_m(convex, point) < 1e-5 {
        return None;
    }
    if is_corner {
        directions.extend((0..180_u32).map(|degree| {
            let (sine, cosine) = libm::sincos(f64::from(degree).to_radians());
            [cosine, sine]
        }));
    }
    Some((point, directions))
}

/// Distance of a point from the border of a convex polygon; negative outside.
fn depth_m(convex: &[Point], point: Point) -> f64 {
    let depth_m = |[from, to]: [Point; 2]| {
        let along = minus(to, from);
        left_of([from, to], point) / libm::hypot(along[0], along[1])
    };
    sides(convex).map(depth_m).fold(f64::INFINITY, f64::min)
}

/// The middle of what a convex polygon contains of a segment.
fn middle_inside(convex: &[Point], from: Point, to: Point) -> Option<Point> {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for side in sides(convex) {
        let (start, end) = (left_of(side, from), left_of(side, to));
        if start < 0.0 && end < 0.0 {
            return None;
        }
        if start < 0.0 {
            low = low.max(start / (start - end));
        } else if end < 0.0 {
            high = high.min(start / (start - end));
        }
    }
    let share = f64::midpoint(low, high);
    (low < high).then(|| between(from, to, share))
}

/// What is left of a line through a point with a direction.
fn cut(convex: &[Point], point: Point, direction: Point) -> Vec<Point> {
    let side = |corner: Point| cross(direction, minus(corner, point));
    let mut left = Vec::with_capacity(convex.len() + 1);
    for [from, to] in sides(convex) {
        let (start, end) = (side(from), side(to));
        if start >= 0.0 {
            left.push(from);
        }
        if (start > 0.0 && end < 0.0) || (start < 0.0 && end > 0.0) {
            left.push(between(from, to, start / (start - end)));
        }
    }
    left.dedup_by(|one, other| (one[0] - other[0]).abs() + (one[1] - other[1]).abs() < 1e-9);
    left
}

/// Area that is lost with a corner.
fn ear_m2(convex: &[Point], corner: usize) -> f64 {
    let n = convex.len();
    let (before, after) = (convex[(corner + n - 1) % n], convex[(corner + 1) % n]);
    left_of([before, convex[corner]], after) / 2.0
}

/// The convex hull, counterclockwise.
///
/// # Source
///
/// A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979.
fn hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|left, right| left[0].total_cmp(&right[0]).then(left[1].total_cmp(&right[1])));
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., before, last] = chain.as_slice()
                && left_of([*before, *last], point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = chain(&mut sorted.iter().copied());
    lower.extend(chain(&mut sorted.iter().rev().copied()));
    lower
}

/// Whether a point lies in a convex, counterclockwise polygon, or on its border.
pub(crate) fn contains(polygon_m: &[Point], place_m: Point) -> bool {
    sides(polygon_m).all(|side| left_of(side, place_m) >= -1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_convex_polygon_is_its_own_inside() {
        let square = [[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]];

        let found = inscribed(&square).unwrap();

        assert!((area(&found) - 1.0).abs() < 1e-3 && found.len() == 4, "{found:?}");
    }

    #[test]
    fn a_notch_is_left_out_at_the_least_loss() {
        // A unit square with a thin notch in its left side that reaches 0.2 m in.
        let notched =
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.55], [0.2, 0.5], [0.0, 0.45]];

        let found = inscribed(&notched).unwrap();

        // The best cut through the notch's tip is upright and leaves 0.8 of the area.
        assert!((area(&found) - 0.8).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_round_region_gets_few_corners_inside_it() {
        let round: Vec<Point> = (0..60)
            .map(|corner| {
                let (sine, cosine) = libm::sincos(f64::from(corner) * 0.1047);
                [cosine, sine]
            })
            .collect();

        let found = inscribed(&round).unwrap();

        assert_eq!(found.len(), MAX_CORNERS);
        assert!(found.iter().all(|corner| libm::hypot(corner[0], corner[1]) <= 1.0001));
        // An inscribed octagon covers 2.83 of 3.14; dropping corners one by one loses some of that.
        assert!(area(&found) > 2.6, "{}", area(&found));
    }
}
