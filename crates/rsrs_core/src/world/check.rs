//! Whether a world can be, and be in an arena: each refusal with its line.

use std::fmt;

use serde::Deserialize;
use serde_saphyr::Spanned;

use super::{
    ArenaShape, Failure, FreeSpace, Goal, Object, ObjectGroup, Obstacle, Outline, ROUNDING,
    RobotClass, WorldFile,
};
use crate::document;
use crate::document::file_error::FileError;
use crate::document::source::Source;
use crate::help::Help;
use crate::numerals::counted;
use crate::quantity::Bounds;
use crate::robot::profile::{ProfileError, RobotProfile};

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

/// Most objects of a group or robots of a class; more are a mistake.
const MOST_OBJECTS: Bounds = Bounds { least: 1.0, most: 1e4 };
/// Weight over that of a robot; dimensionless. What is heavier is an obstacle.
const WEIGHT: Bounds = Bounds { least: 0.1, most: 1e3 };
/// The radius of a disc, in metres: that of an object that robots could push, and of a goal on a floor.
const RADIUS: Bounds = Bounds { least: 1e-3, most: 1e3 };

/// Where the parts of a world are in its file; of their types, because what is no number is refused elsewhere.
#[derive(Deserialize)]
struct Lines {
    arena: Option<Spanned<ArenaShape>>,
    #[serde(default)]
    obstacles: Vec<Spanned<Obstacle>>,
    #[serde(default)]
    objects: Vec<Spanned<ObjectGroup>>,
    #[serde(default)]
    goals: Vec<Spanned<Goal>>,
    #[serde(default)]
    classes: Vec<Spanned<RobotClass>>,
    #[serde(default)]
    failures: Vec<Spanned<Failure>>,
}

impl WorldFile {
    /// Reads a world for arenas with these sides, in metres, and for these numbers of robots;
    /// errors call it `file`. The sides are nothing to a world with an arena of its own.
    pub fn parse(
        file: &str,
        text: &str,
        arenas_m: &[f64],
        robots: &[usize],
    ) -> Result<Self, WorldError> {
        let world: Self = document::parse(file, text)?;
        let refuse = |flaw: WorldFlaw| {
            let WorldFlaw { place, problem } = flaw;
            FileError::flaw((file, text), problem, |lines: &Lines| {
                Some(match place {
                    Place::Whole => 1,
                    Place::Arena => lines.arena.as_ref()?.defined.line(),
                    Place::Obstacle(obstacle) => lines.obstacles.get(obstacle)?.defined.line(),
                    Place::Objects(group) => lines.objects.get(group)?.defined.line(),
                    Place::Goal(goal) => lines.goals.get(goal)?.defined.line(),
                    Place::Class(class) => lines.classes.get(class)?.defined.line(),
                    Place::Failure(failure) => lines.failures.get(failure)?.defined.line(),
                })
            })
        };
        if world.is_empty() {
            let problem = WorldProblem::Nothing;
            return Err(refuse(WorldFlaw { place: Place::Whole, problem }));
        }
        world.check().map_err(refuse)?;
        match world.side_m() {
            Some(own_m) => world.check_in(own_m),
            None => arenas_m.iter().try_for_each(|side_m| world.check_in(*side_m)),
        }
        .map_err(refuse)?;
        robots.iter().try_for_each(|robots| world.check_classes_of(*robots)).map_err(refuse)?;
        robots.iter().try_for_each(|robots| world.check_failures_of(*robots)).map_err(refuse)?;
        Ok(world)
    }

    /// The world as a YAML document.
    pub fn to_yaml(&self) -> String {
        document::to_yaml(self)
    }

    /// Whether each part of it can be; that of no part can.
    pub fn check(&self) -> Result<(), WorldFlaw> {
        if let Some(arena) = &self.arena {
            arena.check().map_err(|problem| WorldFlaw { place: Place::Arena, problem })?;
        }
        for (place, obstacle) in self.obstacles.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Obstacle(place), problem };
            obstacle.check().map_err(flaw)?;
        }
        for (place, group) in self.objects.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Objects(place), problem };
            check_group(group).map_err(flaw)?;
        }
        for (place, goal) in self.goals.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Goal(place), problem };
            within("radius_m", goal.radius_m, RADIUS).map_err(flaw)?;
            check_place("place_m", goal.place_m).map_err(flaw)?;
        }
        for (place, RobotClass { name, count, profile, .. }) in self.classes.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Class(place), problem };
            let found = name.clone();
            if !document::is_name(name) {
                return Err(flaw(WorldProblem::ClassName(found)));
            }
            if self.classes[..place].iter().any(|other| other.name == *name) {
                return Err(flaw(WorldProblem::SameClass(found)));
            }
            let count = count.map_or(Ok(()), |count| within("count", count as f64, MOST_OBJECTS));
            count.map_err(flaw)?;
            let profile =
                profile.as_ref().and_then(Source::read).map_or(Ok(()), RobotProfile::check);
            profile.map_err(|source| flaw(WorldProblem::Profile(Box::new(source))))?;
        }
        for (place, failure) in self.failures.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Failure(place), problem };
            failure.check().map_err(flaw)?;
        }
        self.check_apart()
    }

    /// Whether the classes of a checked world are those of so many robots, each with one or more of them.
    pub fn check_classes_of(&self, robots: usize) -> Result<(), WorldFlaw> {
        let classes = self.classes.len();
        if classes > robots {
            let problem = WorldProblem::TooManyClasses { classes, robots };
            return Err(WorldFlaw { place: Place::Class(robots), problem });
        }
        let (counted, sharing) = (self.counted_robots(), self.n_sharing_classes());
        let problem = if sharing == 0 {
            if classes == 0 || counted == robots {
                return Ok(());
            }
            WorldProblem::ClassCounts { counted, robots }
        } else {
            if counted.saturating_add(sharing) <= robots {
                return Ok(());
            }
            WorldProblem::TooFewLeft { counted, sharing, robots }
        };
        let last = self.classes.iter().rposition(|class| class.count.is_some()).unwrap_or_default();
        Err(WorldFlaw { place: Place::Class(last), problem })
    }

    /// Whether a checked world can be in a square arena of this side, in metres, which counts where the world has no
    /// arena of its own.
    pub fn check_in(&self, side_m: f64) -> Result<(), WorldFlaw> {
        let arena = || match &self.arena {
            None => format!("the arena of {side_m} m"),
            Some(arena) => format!("the arena, {}", arena.in_words()),
        };
        let inside = Inside { side_m, space: self.free_space(side_m) };
        for (place, obstacle) in self.obstacles.iter().enumerate() {
            if let Some(place_m) = inside.beyond_border(&obstacle.outline()) {
                let problem = WorldProblem::Beyond { place_m, arena: arena() };
                return Err(WorldFlaw { place: Place::Obstacle(place), problem });
            }
        }
        for (place, group) in self.objects.iter().enumerate() {
            let flaw = |problem| WorldFlaw { place: Place::Objects(place), problem };
            let (count, radius_m) = (group.n_objects(), group.radius_m);
            for place_m in group.places_m.iter().flatten().copied() {
                if !inside.borders_hold(place_m, radius_m) {
                    let what = "an object";
                    let arena = arena();
                    return Err(flaw(WorldProblem::Outside { what, radius_m, place_m, arena }));
                }
                if !inside.is_clear_of_obstacles(place_m, radius_m) {
                    return Err(flaw(WorldProblem::InObstacle { radius_m, place_m }));
                }
            }
            let at_most = inside.most_that_fit(radius_m);
            if count > at_most {
                let arena = arena();
                return Err(flaw(WorldProblem::TooMany { count, radius_m, arena, at_most }));
            }
        }
        for (place, Goal { place_m, radius_m }) in self.goals.iter().enumerate() {
            if !inside.borders_hold(*place_m, *radius_m) {
                let (what, radius_m, place_m, arena) = ("a goal", *radius_m, *place_m, arena());
                let problem = WorldProblem::Outside { what, radius_m, place_m, arena };
                return Err(WorldFlaw { place: Place::Goal(place), problem });
            }
        }
        Ok(())
    }

    /// Whether objects that have places are apart.
    fn check_apart(&self) -> Result<(), WorldFlaw> {
        let of_group = |(group, objects): (usize, &ObjectGroup)| {
            objects.each().map(move |object| (group, object)).collect::<Vec<(usize, Object)>>()
        };
        let placed = self.objects.iter().enumerate().flat_map(of_group);
        let placed: Vec<(usize, f64, [f64; 2])> = placed
            .filter_map(|(group, object)| Some((group, object.radius_m, object.place_m?)))
            .collect();
        for (position, (group, radius_m, place_m)) in placed.iter().enumerate() {
            for (_, other_radius_m, other_m) in &placed[..position] {
                let found_m = libm::hypot(place_m[0] - other_m[0], place_m[1] - other_m[1]);
                let least_m = radius_m + other_radius_m;
                if found_m < least_m * (1.0 - ROUNDING) {
                    let places_m = [*other_m, *place_m];
                    let problem = WorldProblem::Overlap { places_m, found_m, least_m };
                    return Err(WorldFlaw { place: Place::Objects(*group), problem });
                }
            }
        }
        Ok(())
    }
}

fn check_group(group: &ObjectGroup) -> Result<(), WorldProblem> {
    within("radius_m", group.radius_m, RADIUS)?;
    within("friction", group.friction, Bounds::FRICTION)?;
    within("weight", group.weight, WEIGHT)?;
    match (group.count, &group.places_m) {
        (Some(count), None) => within("count", count as f64, MOST_OBJECTS),
        (None, Some(places_m)) => {
            within("count", places_m.len() as f64, MOST_OBJECTS)?;
            places_m.iter().try_for_each(|place_m| check_place("places_m", *place_m))
        }
        _ => Err(WorldProblem::CountOrPlaces),
    }
}

fn check_place(key: &'static str, place_m: [f64; 2]) -> Result<(), WorldProblem> {
    place_m.into_iter().try_for_each(|coordinate_m| within(key, coordinate_m, Bounds::COORDINATE))
}

/// Where things of a world must be.
struct Inside {
    /// Of the square that counts where there is no other space, in metres.
    side_m: f64,
    space: Option<FreeSpace>,
}

impl Inside {
    /// Whether all of a disc is within the border of the arena.
    fn borders_hold(&self, place_m: [f64; 2], radius_m: f64) -> bool {
        match &self.space {
            None => {
                let most_m = (self.side_m / 2.0 - radius_m) + ROUNDING * self.side_m;
                place_m.iter().all(|coordinate_m| coordinate_m.abs() <= most_m)
            }
            Some(space) => {
                let within = FreeSpace::new(space.border().clone(), Vec::new());
                within.clearance_m(place_m) >= radius_m - space.slack_m()
            }
        }
    }

    fn is_clear_of_obstacles(&self, place_m: [f64; 2], radius_m: f64) -> bool {
        let space = self.space.as_ref();
        space.is_none_or(|space| space.clearance_m(place_m) >= radius_m - space.slack_m())
    }

    /// The centre or the first corner of an obstacle of which neither the centre nor a corner is in the arena.
    fn beyond_border(&self, obstacle: &Outline) -> Option<[f64; 2]> {
        let places_m = match obstacle {
            Outline::Disc { centre_m, .. } => std::slice::from_ref(centre_m),
            Outline::Polygon { corners_m } => corners_m,
        };
        let border = self.space.as_ref()?.border();
        let is_beyond = !places_m.iter().any(|place_m| border.contains(*place_m));
        is_beyond.then(|| places_m[0])
    }

    /// No packing of discs within the arena is denser than the hexagonal one.
    fn most_that_fit(&self, radius_m: f64) -> usize {
        let area_m2 = match &self.space {
            None if 2.0 * radius_m > self.side_m => return 0,
            None => self.side_m * self.side_m,
            Some(space) => space.border().area_m2(),
        };
        let each_m2 = radius_m * radius_m * 12_f64.sqrt();
        (area_m2 / each_m2).floor() as usize
    }
}

pub(super) fn within(key: &'static str, found: f64, bounds: Bounds) -> Result<(), WorldProblem> {
    if bounds.contains(found) {
        return Ok(());
    }
    Err(WorldProblem::OutOfRange { key, found, bounds })
}
