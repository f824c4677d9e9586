//! Arenas that are no squares, and obstacles, as they are in files.

use serde::{Deserialize, Serialize};

use super::WorldFile;
use super::free_space::{FreeSpace, Outline, Wall, side_around_m};
use super::problem::{WorldProblem, within};
use crate::plane::sides;
use crate::quantity::Bounds;

/// The border of an arena that is no square of side `arena_m`; give one of the three.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArenaShape {
    /// Width along x and height along y of a rectangle around the origin, in metres; shape `[2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rectangle_m: Option<[f64; 2]>,
    /// Radius of a disc around the origin, in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc_m: Option<f64>,
    /// Corners of a polygon in order, in metres; its sides meet nowhere else, and it may have corners that point inward.
    /// Shape `[n_corners][2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon_m: Option<Vec<[f64; 2]>>,
}

/// What stands fixed in the arena, and bodies cannot enter; give `place_m` and `radius_m` of a disc, or `polygon_m`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// The centre of a disc, in metres from the middle of the arena; shape `[2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_m: Option<[f64; 2]>,
    /// Its radius, in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Corners of a polygon, as those of an arena.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon_m: Option<Vec<[f64; 2]>>,
}

/// Width, height or radius of an arena or an obstacle, in metres.
const LENGTH: Bounds = Bounds { least: 1e-3, most: 1e6 };
/// Corners of a polygon; more are a mistake.
const CORNERS: Bounds = Bounds { least: 3.0, most: 1000.0 };
/// Sides of a polygon that do not meet are at least so far apart, in metres.
const LEAST_APART_M: f64 = 1e-3;
/// Cosine between a side and the next one, turned back: of a corner that is sharper than 1°.
const FOLDED: f64 = 0.99985;

impl ArenaShape {
    /// Its border; it was checked.
    pub fn outline(&self) -> Outline {
        match self {
            Self { rectangle_m: Some(sides_m), .. } => Outline::rectangle(*sides_m),
            Self { disc_m: Some(radius_m), .. } => {
                Outline::Disc { centre_m: [0.0; 2], radius_m: *radius_m }
            }
            Self { polygon_m, .. } => {
                Outline::Polygon { corners_m: polygon_m.clone().unwrap_or_default() }
            }
        }
    }

    /// What it is, in words: `a disc of radius 2 m`.
    pub fn in_words(&self) -> String {
        match self {
            Self { rectangle_m: Some([width_m, height_m]), .. } => {
                format!("a rectangle of {width_m} m by {height_m} m")
            }
            Self { disc_m: Some(radius_m), .. } => format!("a disc of radius {radius_m} m"),
            Self { polygon_m, .. } => {
                format!("a polygon of {} corners", polygon_m.as_ref().map_or(0, Vec::len))
            }
        }
    }

    pub(super) fn check(&self) -> Result<(), WorldProblem> {
        match (self.rectangle_m, self.disc_m, &self.polygon_m) {
            (Some(sides_m), None, None) => {
                sides_m.into_iter().try_for_each(|side_m| within("rectangle_m", side_m, LENGTH))
            }
            (None, Some(radius_m), None) => within("disc_m", radius_m, LENGTH),
            (None, None, Some(corners_m)) => check_polygon(corners_m),
            _ => Err(WorldProblem::ArenaKind),
        }
    }
}

impl Obstacle {
    /// Its outline; it was checked.
    pub fn outline(&self) -> Outline {
        match (self.place_m, self.radius_m) {
            (Some(centre_m), Some(radius_m)) => Outline::Disc { centre_m, radius_m },
            _ => Outline::Polygon { corners_m: self.polygon_m.clone().unwrap_or_default() },
        }
    }

    pub(super) fn check(&self) -> Result<(), WorldProblem> {
        match (self.place_m, self.radius_m, &self.polygon_m) {
            (Some(place_m), Some(radius_m), None) => {
                within("radius_m", radius_m, LENGTH)?;
                place_m.into_iter().try_for_each(|at_m| within("place_m", at_m, Bounds::COORDINATE))
            }
            (None, None, Some(corners_m)) => check_polygon(corners_m),
            _ => Err(WorldProblem::ObstacleKind),
        }
    }
}

impl WorldFile {
    /// Side of the square around the origin that holds all of the arena, in metres; `None` where the world has no arena
    /// of its own.
    pub fn side_m(&self) -> Option<f64> {
        Some(side_around_m(&self.arena.as_ref()?.outline()))
    }

    /// Where bodies may be in an arena of this side, in metres, which counts where the world has none of its own; `None`
    /// for a square without obstacles, which whoever asks knows by its side.
    pub fn free_space(&self, side_m: f64) -> Option<FreeSpace> {
        if self.arena.is_none() && self.obstacles.is_empty() {
            return None;
        }
        let border = self.arena.as_ref().map(ArenaShape::outline);
        let border = border.unwrap_or_else(|| Outline::rectangle([side_m; 2]));
        let obstacles = self.obstacles.iter().map(Obstacle::outline).collect();
        Some(FreeSpace::new(border, obstacles))
    }
}

/// Whether corners are those of a polygon whose sides meet at its corners only.
fn check_polygon(corners_m: &[[f64; 2]]) -> Result<(), WorldProblem> {
    let n = corners_m.len();
    let all = corners_m.iter().flatten();
    all.into_iter().try_for_each(|at_m| within("polygon_m", *at_m, Bounds::COORDINATE))?;
    if !CORNERS.contains(n as f64) {
        return Err(WorldProblem::Corners(n));
    }
    let all: Vec<[[f64; 2]; 2]> = sides(corners_m).collect();
    let meet = |one: usize, other: usize| WorldProblem::SidesMeet {
        corners_m: [all[one][0], all[other][0]],
        least_m: LEAST_APART_M,
    };
    for (one, [from, to]) in all.iter().enumerate() {
        let next = (one + 1) % n;
        let is_short = libm::hypot(to[0] - from[0], to[1] - from[1]) < LEAST_APART_M;
        if is_short || is_folded(all[one], all[next]) {
            return Err(meet(one, next));
        }
    }
    for (one, side) in all.iter().enumerate() {
        for (other, further) in all.iter().enumerate().skip(one + 2) {
            // The last side is beside the first one.
            let is_beside = one == 0 && other == n - 1;
            if !is_beside && (cross(*side, *further) || apart_m(*side, *further) < LEAST_APART_M) {
                return Err(meet(one, other));
            }
        }
    }
    Ok(())
}

/// Whether a side turns back upon the one before it.
fn is_folded([from, corner]: [[f64; 2]; 2], [_, to]: [[f64; 2]; 2]) -> bool {
    let back = [from[0] - corner[0], from[1] - corner[1]];
    let on = [to[0] - corner[0], to[1] - corner[1]];
    let lengths = libm::hypot(back[0], back[1]) * libm::hypot(on[0], on[1]);
    back[0] * on[0] + back[1] * on[1] > FOLDED * lengths
}

/// Whether two segments cross, each having its ends on both sides of the other.
fn cross(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> bool {
    let side = |[from, to]: [[f64; 2]; 2], at: [f64; 2]| {
        (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])
    };
    let parts = |line, ends: [[f64; 2]; 2]| side(line, ends[0]) * side(line, ends[1]) < 0.0;
    parts(one, other) && parts(other, one)
}

/// How far two segments that do not cross are apart, in metres: an end of one of them is nearest.
fn apart_m(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> f64 {
    let from_m = |line, ends: [[f64; 2]; 2]| {
        ends.map(|end| {
            let nearest = Wall::Straight(line).nearest_m(end);
            libm::hypot(end[0] - nearest[0], end[1] - nearest[1])
        })
    };
    [from_m(one, other), from_m(other, one)].into_iter().flatten().fold(f64::INFINITY, f64::min)
}
