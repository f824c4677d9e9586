//! A track of thousands of poses as a short path that looks the same.

use crate::svg::number;

/// A point on the page, in pixels.
pub type Point = (f64, f64);

/// Drops points of a track without moving it by more than a tolerance, in pixels.
///
/// # Source
///
/// D. Douglas and T. Peucker, "Algorithms for the reduction of the number of points required to
/// represent a digitized line", 1973.
pub fn simplified(points: &[Point], tolerance_px: f64) -> Vec<Point> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut is_kept = vec![false; points.len()];
    is_kept[0] = true;
    is_kept[last] = true;
    let mut sections = vec![(0, last)];
    while let Some((from, to)) = sections.pop() {
        let inner = (from + 1..to).map(|index| (index, distance_px(points, index, from, to)));
        let farthest = inner.max_by(|left, right| left.1.total_cmp(&right.1));
        if let Some((index, away_px)) = farthest
            && away_px > tolerance_px
        {
            is_kept[index] = true;
            sections.extend([(from, index), (index, to)]);
        }
    }
    points.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

/// How far a point is from the segment between two others.
fn distance_px(points: &[Point], index: usize, from: usize, to: usize) -> f64 {
    let ((x, y), (from_x, from_y), (to_x, to_y)) = (points[index], points[from], points[to]);
    let (dx, dy) = (to_x - from_x, to_y - from_y);
    let squared_length = dx * dx + dy * dy;
    let share = if squared_length > 0.0 {
        (((x - from_x) * dx + (y - from_y) * dy) / squared_length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(x - from_x - share * dx, y - from_y - share * dy)
}

/// The points as an SVG path, to a tenth of a pixel; empty for no point.
///
/// Steps are shorter to write than places. They are those between rounded places, so that they do
/// not drift.
pub fn path(points: &[Point]) -> String {
    let tenth = |(x, y): &Point| ((x * 10.0).round() / 10.0, (y * 10.0).round() / 10.0);
    let places: Vec<Point> = points.iter().map(tenth).collect();
    let Some((x, y)) = places.first() else { return String::new() };
    let steps: Vec<String> = places
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1))
        .map(|(dx, dy)| format!("{} {}", number(dx), number(dy)))
        .collect();
    let start = format!("M{} {}", number(*x), number(*y));
    if steps.is_empty() { start } else { format!("{start}l{}", steps.join(" ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(n_points: u32) -> Vec<Point> {
        let angle = |index: u32| f64::from(index) * std::f64::consts::TAU / f64::from(n_points);
        (0..=n_points)
            .map(|index| libm::sincos(angle(index)))
            .map(|(sine, cosine)| (200.0 * cosine, 200.0 * sine))
            .collect()
    }

    #[test]
    fn a_circle_of_thousands_of_points_needs_a_few_dozen() {
        let points = circle(5000);

        let simple = simplified(&points, 0.25);

        assert!((30..100).contains(&simple.len()), "{}", simple.len());
        assert_eq!((simple[0], simple[simple.len() - 1]), (points[0], points[5000]));
        for pair in simple.windows(2) {
            let middle = libm::hypot(
                f64::midpoint(pair[0].0, pair[1].0),
                f64::midpoint(pair[0].1, pair[1].1),
            );
            assert!(200.0 - middle <= 0.25);
        }
    }

    #[test]
    fn straight_and_standing_robots_keep_their_ends() {
        let straight = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)];

        assert_eq!(simplified(&straight, 0.25), [(0.0, 0.0), (2.0, 0.0)]);
        assert_eq!(simplified(&[(3.0, 3.0); 4], 0.25), [(3.0, 3.0); 2]);
        assert!(simplified(&[], 0.25).is_empty() && path(&[]).is_empty());
        assert_eq!(path(&[(0.0, 0.04), (1.26, 2.0)]), "M0 0l1.3 2");
    }
}
