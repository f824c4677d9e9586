//! Whether a world can be, and be in an arena: each refusal with its line.

use serde::Deserialize;
use serde_saphyr::Spanned;

use super::problem::{Place, WorldError, WorldFlaw, WorldProblem, within};
use super::{
    ArenaShape, Failure, FreeSpace, Goal, Object, ObjectGroup, Obstacle, Outline, ROUNDING,
    RobotClass, WorldFile,
};
use crate::document;
use crate::document::file_error::FileError;
use crate::document::source::Source;
use crate::quantity::Bounds;
use crate::robot::profile::RobotProfile;

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
