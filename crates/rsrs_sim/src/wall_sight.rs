//! Where a sensor's region reaches a wall of an arena of any shape, and whether walls lie across a way.
//!
//! In the sensor's frame. A region is convex, and along a wall the distance from the sensor has one minimum. So the point of
//! a wall in the region that is nearest to the sensor is the nearest of all of its points, if the region holds that, and else
//! the nearest of those in which the wall crosses the region's edges.
//!
//! In double precision, of `+ - * /`, the square root and comparisons.

use rsrs_core::plane::{between, cross, dot, left_of, minus, sides};
use rsrs_core::robot::region::Region;
use rsrs_core::world::Wall;

/// A region, ready for walls of any shape.
pub struct WallSight {
    /// From where to where each of its edges goes, in metres; of a cone those that begin at the sensor.
    edges: Vec<[[f64; 2]; 2]>,
    shape: Shape,
}

enum Shape {
    /// A cone, by the tangent of its half-angle and its squared range in square metres.
    Cone { slope: f64, range_m2: f64 },
    /// A polygon, which is what lies to the left of each edge.
    Polygon,
}

/// What ends on a wall ends within this share of its length; dimensionless.
const ENDS: f64 = 1e-9;

/// A wall that lies across a way lies at no more than this share of it, because the way may end on a wall; dimensionless.
const ACROSS: f64 = 1.0 - 1e-4;

impl WallSight {
    /// The region of a sensor.
    pub fn new(region: &Region) -> Self {
        match region {
            Region::Cone { half_angle_rad, range_m } => {
                let (sine, cosine) = libm::sincos(*half_angle_rad);
                let edge = |side: f64| [[0.0; 2], [range_m * cosine, side * range_m * sine]];
                let shape = Shape::Cone { slope: sine / cosine, range_m2: range_m * range_m };
                Self { edges: vec![edge(-1.0), edge(1.0)], shape }
            }
            Region::Polygon { corners_m } => {
                Self { edges: sides(corners_m).collect(), shape: Shape::Polygon }
            }
        }
    }

    /// The nearest point of a wall in the region, and how far away it is, in metres.
    pub fn nearest(&self, wall: Wall) -> Option<([f64; 2], f64)> {
        let nearest_m = wall.nearest_m([0.0; 2]);
        if self.contains(nearest_m) {
            return Some((nearest_m, dot(nearest_m, nearest_m).sqrt()));
        }
        let crossed = self.edges.iter().flat_map(|edge| {
            let [from, to] = *edge;
            crossings(*edge, wall).map(move |share| between(from, to, share))
        });
        let crossed = crossed.map(|point_m| (point_m, dot(point_m, point_m).sqrt()));
        crossed.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn contains(&self, [x_m, y_m]: [f64; 2]) -> bool {
        match self.shape {
            Shape::Cone { slope, range_m2 } => {
                x_m > 0.0 && y_m.abs() <= x_m * slope && x_m * x_m + y_m * y_m <= range_m2
            }
            Shape::Polygon => self.edges.iter().all(|edge| left_of(*edge, [x_m, y_m]) >= 0.0),
        }
    }
}

/// Whether a wall lies across the way from the sensor to a point in metres.
pub fn lies_across(wall: Wall, to_m: [f64; 2]) -> bool {
    crossings([[0.0; 2], to_m], wall).any(|share| share < ACROSS)
}

/// At which shares of a segment a wall crosses it: at two of them at most.
fn crossings([from, to]: [[f64; 2]; 2], wall: Wall) -> impl Iterator<Item = f64> {
    let along = minus(to, from);
    let shares = match wall {
        Wall::Straight([start, end]) => {
            let (side, beyond) = (minus(end, start), minus(start, from));
            let across = cross(along, side);
            let on_side = cross(beyond, along) / across;
            let is_crossed = (-ENDS..=1.0 + ENDS).contains(&on_side);
            [is_crossed.then(|| cross(beyond, side) / across), None]
        }
        Wall::Round { centre_m, radius_m } => {
            let out = minus(from, centre_m);
            let (square, half) = (dot(along, along), dot(along, out));
            let root = half * half - square * (dot(out, out) - radius_m * radius_m);
            let at = |sign: f64| (sign * root.sqrt() - half) / square;
            if root < 0.0 { [None; 2] } else { [Some(at(-1.0)), Some(at(1.0))] }
        }
    };
    shares.into_iter().flatten().filter(|share| (0.0..=1.0).contains(share))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Points of a wall, a tenth of a millimetre apart or less.
    fn points(wall: Wall) -> Vec<[f64; 2]> {
        let shares = (0..=40_000).map(|step| f64::from(step) / 40_000.0);
        match wall {
            Wall::Straight([from, to]) => shares
                .map(|share| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])))
                .collect(),
            Wall::Round { centre_m: [x, y], radius_m } => shares
                .map(|share| {
                    let (sine, cosine) = libm::sincos(share * std::f64::consts::TAU);
                    [x + radius_m * cosine, y + radius_m * sine]
                })
                .collect(),
        }
    }

    /// Whether a point is in a region, by its definition.
    pub fn is_in(region: &Region, [x, y]: [f64; 2]) -> bool {
        match region {
            Region::Cone { half_angle_rad, range_m } => {
                libm::hypot(x, y) <= *range_m && libm::atan2(y, x).abs() <= *half_angle_rad + 1e-9
            }
            Region::Polygon { corners_m } => {
                let n = corners_m.len();
                (0..n).all(|side| {
                    let ([ax, ay], [bx, by]) = (corners_m[side], corners_m[(side + 1) % n]);
                    (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
                })
            }
        }
    }

    #[test]
    fn a_wall_of_any_shape_is_as_far_as_its_nearest_point_in_the_region() {
        let regions = [
            Region::Cone { half_angle_rad: 0.3, range_m: 0.9 },
            Region::Cone { half_angle_rad: 1.4, range_m: 0.6 },
            Region::Polygon { corners_m: vec![[0.1, -0.2], [0.9, -0.4], [0.9, 0.5], [0.1, 0.2]] },
            Region::Polygon { corners_m: vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] },
        ];
        let mut walls = vec![
            // Around the sensor, and around it alone.
            Wall::Round { centre_m: [0.1, 0.05], radius_m: 0.45 },
            Wall::Round { centre_m: [0.0, 0.0], radius_m: 0.3 },
        ];
        for turn in 0..30 {
            let (sine, cosine) = libm::sincos(f64::from(turn) * 0.209 + 0.01);
            let at = |along: f64, beside: f64| {
                [along * cosine - beside * sine, along * sine + beside * cosine]
            };
            walls.push(Wall::Straight([at(0.4, -0.1), at(0.5, 0.3)]));
            walls.push(Wall::Straight([at(0.2, -2.0), at(0.3, 2.0)]));
            walls.push(Wall::Round { centre_m: at(0.6, 0.0), radius_m: 0.2 });
        }
        let mut n_seen = 0;
        for (region, wall) in
            regions.iter().flat_map(|region| walls.iter().map(move |wall| (region, *wall)))
        {
            let there = points(wall).into_iter().filter(|point| is_in(region, *point));
            let expected = there.map(|[x, y]| libm::hypot(x, y)).min_by(f64::total_cmp);

            let found = WallSight::new(region).nearest(wall);

            let place = format!("{region:?} {wall:?}: {expected:?} {found:?}");
            assert_eq!(found.is_some(), expected.is_some(), "{place}");
            let (Some(([x, y], away_m)), Some(expected)) = (found, expected) else { continue };
            assert!((away_m - expected).abs() < 2e-3, "{place}");
            assert!((libm::hypot(x, y) - away_m).abs() < 1e-12, "{place}");
            n_seen += 1;
        }
        assert!(n_seen > 120, "{n_seen}");
    }

    #[test]
    fn a_line_of_sight_meets_the_walls_that_it_points_at() {
        let sight = WallSight::new(&Region::Cone { half_angle_rad: 0.0, range_m: 1.0 });
        let away_m = |wall| sight.nearest(wall).map(|(_, away_m)| away_m);

        let across = Wall::Straight([[0.3, -0.1], [0.5, 0.1]]);
        assert!(away_m(across).is_some_and(|away_m| (away_m - 0.4).abs() < 1e-12));
        let pillar = Wall::Round { centre_m: [0.6, 0.06], radius_m: 0.1 };
        assert!(away_m(pillar).is_some_and(|away_m| (away_m - 0.52).abs() < 1e-12));
        let around = Wall::Round { centre_m: [0.0, 0.0], radius_m: 0.8 };
        assert!(away_m(around).is_some_and(|away_m| (away_m - 0.8).abs() < 1e-12));
        assert_eq!(away_m(Wall::Round { centre_m: [0.6, 0.2], radius_m: 0.1 }), None);
        assert_eq!(away_m(Wall::Straight([[-0.3, -0.1], [-0.3, 0.1]])), None, "it is behind");
        assert_eq!(away_m(Wall::Straight([[1.1, -0.1], [1.1, 0.1]])), None, "it is too far");
    }

    #[test]
    fn a_wall_lies_across_a_way_if_it_lies_between_and_not_at_its_end() {
        let wall = Wall::Straight([[0.5, -0.2], [0.5, 0.2]]);

        assert!(lies_across(wall, [1.0, 0.1]));
        assert!(!lies_across(wall, [1.0, 0.5]), "it goes past the end");
        assert!(!lies_across(wall, [0.5, 0.1]) && !lies_across(wall, [0.4, 0.0]));
        assert!(lies_across(Wall::Round { centre_m: [0.5, 0.0], radius_m: 0.1 }, [1.0, 0.1]));
        assert!(!lies_across(Wall::Round { centre_m: [0.0, 0.0], radius_m: 2.0 }, [1.0, 0.1]));
    }
}
