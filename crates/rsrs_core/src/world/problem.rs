//! What is wrong with a world, and where.

use std::fmt;

use crate::document::file_error::FileError;
use crate::help::Help;
use crate::numerals::counted;
use crate::quantity::Bounds;
use crate::robot::profile::ProfileError;

/// Where in a world something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nowhere in it: it is all of it.
    Whole,
    /// At the border of the arena.
    Arena,
    /// At an obstacle, from 0.
    Obstacle(usize),
    /// In a group of objects, from 0.
    Objects(usize),
    /// At a goal, from 0.
    Goal(usize),
    /// At a class of robots, from 0.
    Class(usize),
    /// At a failure, from 0.
    Failure(usize),
}

/// What is wrong with a world, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct WorldFlaw {
    /// Where.
    pub place: Place,
    /// What.
    pub problem: WorldProblem,
}

/// What is wrong with a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldProblem {
    /// It is as none.
    #[error("there is nothing in it")]
    Nothing,
    /// More than one border of the arena, or none.
    #[error("an arena needs exactly one of `rectangle_m`, `disc_m` and `polygon_m`")]
    ArenaKind,
    /// Neither a disc nor a polygon, or both.
    #[error("an obstacle needs both `place_m` and `radius_m`, or `polygon_m` alone")]
    ObstacleKind,
    /// Too few or too many corners.
    #[error("`polygon_m` has {0} corners, expected 3 to 1000")]
    Corners(usize),
    /// Sides of a polygon that cross or touch.
    #[error(
        "the sides of `polygon_m` from ({}, {}) m and from ({}, {}) m meet beside its corners, or one turns back on \
         the other: expected sides that are {least_m} m or more apart",
        corners_m[0][0], corners_m[0][1], corners_m[1][0], corners_m[1][1]
    )]
    SidesMeet {
        /// Where the two begin, in metres.
        corners_m: [[f64; 2]; 2],
        /// In metres.
        least_m: f64,
    },
    /// An obstacle of which nothing is in the arena.
    #[error("an obstacle at ({}, {}) m is beyond {arena}", place_m[0], place_m[1])]
    Beyond {
        /// Its centre, or its first corner, in metres.
        place_m: [f64; 2],
        /// In words.
        arena: String,
    },
    /// An object in an obstacle.
    #[error("an object of radius {radius_m} m at ({}, {}) m overlaps with an obstacle", place_m[0], place_m[1])]
    InObstacle {
        /// In metres.
        radius_m: f64,
        /// In metres.
        place_m: [f64; 2],
    },
    /// Both a number and places, or neither.
    #[error("objects need exactly one of `count` and `places_m`")]
    CountOrPlaces,
    /// A number outside what it can mean.
    #[error("`{key}` is {found}, expected a number {bounds}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// The number.
        found: f64,
        /// What it may be.
        bounds: Bounds,
    },
    /// A disc that is not in the arena.
    #[error(
        "{what} of radius {radius_m} m at ({}, {}) m is not within {arena}",
        place_m[0], place_m[1]
    )]
    Outside {
        /// `an object` or `a goal`.
        what: &'static str,
        /// In metres.
        radius_m: f64,
        /// In metres.
        place_m: [f64; 2],
        /// In words.
        arena: String,
    },
    /// Two objects in one place.
    #[error(
        "objects at ({}, {}) m and ({}, {}) m overlap: they are {found_m:.3} m apart, expected {least_m:.3} m or more",
        places_m[0][0], places_m[0][1], places_m[1][0], places_m[1][1]
    )]
    Overlap {
        /// In metres.
        places_m: [[f64; 2]; 2],
        /// Distance of their centres, in metres.
        found_m: f64,
        /// Both radii, in metres.
        least_m: f64,
    },
    /// More than there is room for.
    #[error(
        "{} of radius {radius_m} m do not fit into {arena}: at most {at_most} ever do",
        counted(*count as u64, "object")
    )]
    TooMany {
        /// Asked for.
        count: usize,
        /// In metres.
        radius_m: f64,
        /// The arena, in words.
        arena: String,
        /// By the density of the closest packing.
        at_most: usize,
    },
    /// A class whose name cannot be one.
    #[error("`{0}` is no name of a class: expected small letters, digits and `_`, a letter first")]
    ClassName(String),
    /// Two classes of one name.
    #[error("`{0}` is the name of two classes")]
    SameClass(String),
    /// Neither one robot nor a number of them, or both.
    #[error("a failure needs exactly one of `robot` and `count`")]
    WhoFails,
    /// Nothing fails.
    #[error("a failure needs `stops: true` or `sensors_stick: true`")]
    WhatFails,
    /// A robot that is none of the swarm.
    #[error("robot {robot} fails, and there are {robots} robots, counted from 1")]
    NoSuchRobot {
        /// Its number, from 1.
        robot: usize,
        /// Robots of the swarm.
        robots: usize,
    },
    /// More robots than there are.
    #[error("{count} robots fail, and there are {robots}")]
    TooManyFail {
        /// How many fail.
        count: usize,
        /// Robots of the swarm.
        robots: usize,
    },
    /// A profile of a class that describes no robot.
    #[error("its profile describes no robot: {0}")]
    Profile(#[source] Box<ProfileError>),
    /// A class for which no robot is left.
    #[error("{classes} classes of robots are more than the {}", counted(*robots as u64, "robot"))]
    TooManyClasses {
        /// Classes.
        classes: usize,
        /// Robots of the swarm.
        robots: usize,
    },
    /// Counts of all classes that are not those of all robots.
    #[error("the classes have {counted} robots together, and there are {robots}")]
    ClassCounts {
        /// Robots of all classes.
        counted: usize,
        /// Robots of the swarm.
        robots: usize,
    },
    /// Counts of some classes that leave none for each of the others.
    #[error(
        "classes with a `count` have {counted} of the {robots} robots, which leaves too few for {sharing} without one"
    )]
    TooFewLeft {
        /// Robots of classes with a count.
        counted: usize,
        /// Classes without one.
        sharing: usize,
        /// Robots of the swarm.
        robots: usize,
    },
}

/// Why a file is no world.
pub type WorldError = FileError<WorldProblem>;

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => write!(out, "the world"),
            Self::Arena => write!(out, "the arena of the world"),
            Self::Obstacle(obstacle) => write!(out, "obstacles[{obstacle}] of the world"),
            Self::Objects(group) => write!(out, "objects[{group}] of the world"),
            Self::Goal(goal) => write!(out, "goals[{goal}] of the world"),
            Self::Class(class) => write!(out, "classes[{class}] of the world"),
            Self::Failure(failure) => write!(out, "failures[{failure}] of the world"),
        }
    }
}

impl Help for WorldProblem {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Nothing => {
                "give `objects: [{count: 20, radius_m: 0.05}]`, `goals: [{place_m: [1, 0], radius_m: 0.3}]`, \
                 `classes: [{name: a}, {name: b}]`, `arena: {disc_m: 2}` or `obstacles: [{place_m: [1, 0], \
                 radius_m: 0.3}]`, or leave `world:` out where it is named"
                    .to_owned()
            }
            Self::ArenaKind => {
                "give `rectangle_m: [4, 2]`, `disc_m: 2`, or `polygon_m: [[x, y], …]`".to_owned()
            }
            Self::ObstacleKind => {
                "give `place_m: [1, 0], radius_m: 0.3` of a disc, or `polygon_m: [[x, y], …]`".to_owned()
            }
            Self::Corners { .. } => "give the corners in order, each once".to_owned(),
            Self::SidesMeet { .. } => {
                "give the corners in order, one way round, and each once".to_owned()
            }
            Self::Beyond { .. } => {
                "move it, or leave it out; the origin is the middle of the arena".to_owned()
            }
            Self::InObstacle { .. } => "move the object, or the obstacle".to_owned(),
            Self::CountOrPlaces => {
                "give `count: 20` to have them placed at random, or `places_m: [[x, y], …]`".to_owned()
            }
            Self::OutOfRange { key: "radius_m" | "disc_m" | "rectangle_m", .. } => "give a length in metres".to_owned(),
            Self::OutOfRange { key: "count", found, .. } if *found < 1.0 => {
                "leave out what there is none of".to_owned()
            }
            Self::OutOfRange { .. } => return None,
            Self::Outside { .. } => {
                "move it, or widen `arena_m`, or the world's `arena`; the origin is the middle of the arena".to_owned()
            }
            Self::Overlap { .. } => "move one of them".to_owned(),
            Self::TooMany { .. } => "take fewer or smaller ones, or widen `arena_m`, or the world's `arena`".to_owned(),
            Self::WhoFails => {
                "give `robot: 3`, or `count: 2` to have them drawn for each replicate".to_owned()
            }
            Self::WhatFails => "have the robot stop, or its sensors stick, or leave it out".to_owned(),
            Self::NoSuchRobot { .. } | Self::TooManyFail { .. } => {
                "lower it, or take more `robots`".to_owned()
            }
            Self::ClassName { .. } => "call it `sheep`, or `a`".to_owned(),
            Self::SameClass { .. } => "give one of them another name".to_owned(),
            Self::Profile(source) => return source.help(),
            Self::TooManyClasses { .. } => {
                "take fewer classes, or more `robots`: each class has one or more".to_owned()
            }
            Self::ClassCounts { .. } => {
                "leave `count` out of one class, which then has the others".to_owned()
            }
            Self::TooFewLeft { .. } => {
                "lower a `count`, or take more `robots`: each class has one or more".to_owned()
            }
        })
    }
}

impl Help for WorldFlaw {
    fn help(&self) -> Option<String> {
        self.problem.help()
    }
}

/// Refuses a number outside what its key can mean.
pub(super) fn within(key: &'static str, found: f64, bounds: Bounds) -> Result<(), WorldProblem> {
    if bounds.contains(found) {
        return Ok(());
    }
    Err(WorldProblem::OutOfRange { key, found, bounds })
}
