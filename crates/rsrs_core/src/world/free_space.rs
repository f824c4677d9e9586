//! Where bodies may be: within the border of the arena and outside its obstacles.
//!
//! In double precision, of `+ - * /`, the square root and comparisons alone, because the simulator's bits depend on it.

use super::ROUNDING;
use crate::plane::{area, dot, minus, sides};

/// A closed curve on the floor.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A circle.
    Disc {
        /// In metres.
        centre_m: [f64; 2],
        /// In metres.
        radius_m: f64,
    },
    /// A polygon whose sides meet at its corners only.
    Polygon {
        /// In order, one way round or the other, in metres; shape `[n_corners][2]`.
        corners_m: Vec<[f64; 2]>,
    },
}

/// A part of an outline: a wall that bodies run into and sensors see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wall {
    /// A side of a polygon, from one corner to the next, in metres.
    Straight([[f64; 2]; 2]),
    /// A circle.
    Round {
        /// In metres.
        centre_m: [f64; 2],
        /// In metres.
        radius_m: f64,
    },
}

/// Steps across an arena in which room is looked for; even, so that its middle is among the places.
const GRID_STEPS: u32 = 100;

/// Corners of the polygon by which a disc is drawn.
const DRAWN_CORNERS: u32 = 96;

impl Outline {
    /// A square or a rectangle around the origin; width and height in metres.
    pub fn rectangle([width_m, height_m]: [f64; 2]) -> Self {
        let (x_m, y_m) = (width_m / 2.0, height_m / 2.0);
        Self::Polygon { corners_m: vec![[-x_m, -y_m], [x_m, -y_m], [x_m, y_m], [-x_m, y_m]] }
    }

    /// Whether a place in metres lies in it.
    pub fn contains(&self, [x_m, y_m]: [f64; 2]) -> bool {
        match self {
            Self::Disc { centre_m, radius_m } => {
                squared(minus([x_m, y_m], *centre_m)) < radius_m * radius_m
            }
            Self::Polygon { corners_m } => {
                // A ray along x leaves it once more often than it enters it.
                let crosses = |[from, to]: [[f64; 2]; 2]| {
                    (from[1] > y_m) != (to[1] > y_m)
                        && x_m < from[0] + (to[0] - from[0]) * (y_m - from[1]) / (to[1] - from[1])
                };
                sides(corners_m).filter(|side| crosses(*side)).count() % 2 == 1
            }
        }
    }

    /// Its walls.
    pub fn walls(&self) -> Vec<Wall> {
        match self {
            Self::Disc { centre_m, radius_m } => {
                vec![Wall::Round { centre_m: *centre_m, radius_m: *radius_m }]
            }
            Self::Polygon { corners_m } => sides(corners_m).map(Wall::Straight).collect(),
        }
    }

    /// Area within it, in square metres.
    pub fn area_m2(&self) -> f64 {
        match self {
            Self::Disc { radius_m, .. } => std::f64::consts::PI * radius_m * radius_m,
            Self::Polygon { corners_m } => area(corners_m).abs(),
        }
    }

    /// The corners by which it is drawn, in metres; a disc as a polygon that differs from it by half a thousandth of its
    /// radius.
    pub fn drawn_m(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Polygon { corners_m } => corners_m.clone(),
            Self::Disc { centre_m, radius_m } => {
                let corner = |corner: u32| {
                    let turn_rad =
                        std::f64::consts::TAU * f64::from(corner) / f64::from(DRAWN_CORNERS);
                    let (sine, cosine) = libm::sincos(turn_rad);
                    [centre_m[0] + radius_m * cosine, centre_m[1] + radius_m * sine]
                };
                (0..DRAWN_CORNERS).map(corner).collect()
            }
        }
    }

    /// The least and the greatest x and y in it, in metres.
    pub fn bounds_m(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Disc { centre_m: [x_m, y_m], radius_m } => {
                [[x_m - radius_m, y_m - radius_m], [x_m + radius_m, y_m + radius_m]]
            }
            Self::Polygon { corners_m } => {
                let none = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
                corners_m.iter().fold(none, |[low, high], [x_m, y_m]| {
                    [[low[0].min(*x_m), low[1].min(*y_m)], [high[0].max(*x_m), high[1].max(*y_m)]]
                })
            }
        }
    }
}

impl Wall {
    /// Its point nearest to a place, in metres.
    pub fn nearest_m(&self, place_m: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::Straight([from, to]) => {
                let (along, beyond) = (minus(to, from), minus(place_m, from));
                let share = dot(beyond, along) / squared(along);
                let share = share.clamp(0.0, 1.0);
                [from[0] + share * along[0], from[1] + share * along[1]]
            }
            Self::Round { centre_m, radius_m } => {
                let out_m = minus(place_m, centre_m);
                let distance_m = squared(out_m).sqrt();
                // From the centre all of it is as near.
                let out = if distance_m > 0.0 {
                    out_m.map(|along_m| along_m / distance_m)
                } else {
                    [1.0, 0.0]
                };
                [centre_m[0] + radius_m * out[0], centre_m[1] + radius_m * out[1]]
            }
        }
    }
}

/// Where bodies may be.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpace {
    border: Outline,
    obstacles: Vec<Outline>,
    walls: Vec<Wall>,
}

impl FreeSpace {
    /// The space within a border and outside obstacles.
    pub fn new(border: Outline, obstacles: Vec<Outline>) -> Self {
        let walls = std::iter::once(&border).chain(&obstacles).flat_map(Outline::walls).collect();
        Self { border, obstacles, walls }
    }

    /// The border of the arena.
    pub fn border(&self) -> &Outline {
        &self.border
    }

    /// What stands in it.
    pub fn obstacles(&self) -> &[Outline] {
        &self.obstacles
    }

    /// All walls: those of the border, and those of each obstacle.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The point of a wall that is nearest to a place, and its distance from it, in metres.
    pub fn nearest_wall_m(&self, place_m: [f64; 2]) -> ([f64; 2], f64) {
        let none = ([f64::NAN; 2], f64::INFINITY);
        let (point_m, distance_m2) = self.walls.iter().fold(none, |nearest, wall| {
            let point_m = wall.nearest_m(place_m);
            let distance_m2 = squared(minus(place_m, point_m));
            if distance_m2 < nearest.1 { (point_m, distance_m2) } else { nearest }
        });
        (point_m, distance_m2.sqrt())
    }

    /// Whether a place is free: within the border, and in no obstacle.
    pub fn is_free(&self, place_m: [f64; 2]) -> bool {
        self.border.contains(place_m)
            && !self.obstacles.iter().any(|obstacle| obstacle.contains(place_m))
    }

    /// How far the nearest wall is from a place, in metres; negative where it is not free. A body is within the walls
    /// where this is its radius or more.
    pub fn clearance_m(&self, place_m: [f64; 2]) -> f64 {
        let (_, distance_m) = self.nearest_wall_m(place_m);
        if self.is_free(place_m) { distance_m } else { -distance_m }
    }

    /// Radius of the largest disc that fits, in metres: by the best of a grid of places, a hundredth of the arena apart.
    pub fn inradius_m(&self) -> f64 {
        let [low, high] = self.border.bounds_m();
        let at = |axis: usize, step: u32| {
            low[axis] + (high[axis] - low[axis]) * f64::from(step) / f64::from(GRID_STEPS)
        };
        (0..=GRID_STEPS)
            .flat_map(|along| (0..=GRID_STEPS).map(move |up| [at(0, along), at(1, up)]))
            .map(|place_m| self.clearance_m(place_m))
            .fold(0.0, f64::max)
    }

    /// By how much a body may be in a wall, in metres: lengths were the same before they were rounded.
    pub fn slack_m(&self) -> f64 {
        ROUNDING * side_around_m(&self.border)
    }
}

/// Side of the square around the origin that holds all of an outline, in metres.
pub(super) fn side_around_m(outline: &Outline) -> f64 {
    let most_m = outline.bounds_m().into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
    2.0 * most_m
}

fn squared(vector: [f64; 2]) -> f64 {
    dot(vector, vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L: a square of 2 m without its upper right quarter.
    fn l_shape() -> Outline {
        let corners_m =
            vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
        Outline::Polygon { corners_m }
    }

    #[test]
    fn a_place_is_as_far_from_walls_as_from_the_nearest_of_them() {
        let disc = Outline::Disc { centre_m: [-0.5, -0.5], radius_m: 0.2 };
        let space = FreeSpace::new(l_shape(), vec![disc]);

        for (place_m, expected_m) in [
            ([0.5, -0.5], 0.5),
            ([-0.5, 0.6], 0.4),
            // The corner that points inward is a point.
            ([-0.03, -0.04], 0.05),
            ([0.3, 0.2], -0.2),
            ([-0.5, -0.9], 0.1),
            ([-0.5, -0.6], -0.1),
            ([1.5, -0.5], -0.5),
        ] {
            let found_m = space.clearance_m(place_m);
            assert!((found_m - expected_m).abs() < 1e-12, "{place_m:?}: {found_m}");
        }
        assert!((l_shape().area_m2() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_largest_disc_that_fits_touches_walls_and_obstacles() {
        let disc = Outline::Disc { centre_m: [0.3, 0.1], radius_m: 2.0 };
        let around = Outline::Disc { centre_m: [0.3, 0.1], radius_m: 0.4 };
        let inradius_m = |border: &Outline, obstacles: &[Outline]| {
            FreeSpace::new(border.clone(), obstacles.to_vec()).inradius_m()
        };

        for (found_m, expected_m) in [
            (inradius_m(&disc, &[]), 2.0),
            (inradius_m(&Outline::rectangle([3.0, 1.4]), &[]), 0.7),
            // Halfway between the obstacle and the border.
            (inradius_m(&disc, &[around]), 0.8),
            // It touches two sides and the corner that points inward: r + r / √2 = 1 / √2 from there.
            (inradius_m(&l_shape(), &[]), 2.0 - std::f64::consts::SQRT_2),
        ] {
            assert!((found_m - expected_m).abs() < 0.02 * expected_m, "{found_m}: {expected_m}");
        }
    }

    #[test]
    fn a_polygon_is_the_same_one_way_round_and_the_other() {
        let Outline::Polygon { mut corners_m } = l_shape() else { panic!("it is a polygon") };
        corners_m.reverse();
        let reversed = Outline::Polygon { corners_m };

        for step in 0..400 {
            let place_m = [f64::from(step % 20) * 0.13 - 1.2, f64::from(step / 20) * 0.13 - 1.2];
            assert_eq!(reversed.contains(place_m), l_shape().contains(place_m), "{place_m:?}");
        }
        assert!((reversed.area_m2() - 3.0).abs() < 1e-12);
    }
}
