//! What is in the arena besides robots, objects that they push and goals that they detect, the shape of the arena and
//! what stands in it, and of which classes robots are.
//!
//! In a file of its own, which sweeps and experiments name.

mod arena;
mod check;
mod classes;
mod failures;
mod free_space;
mod problem;

use serde::{Deserialize, Serialize};

use crate::document::source::{InFile, Source};
use crate::numerals::{self, is_zero};
use crate::robot::sensor::Detects;

pub use arena::{ArenaShape, Obstacle};
pub use classes::RobotClass;
pub use failures::Failure;
pub use free_space::{FreeSpace, Outline, Wall};
pub use problem::{Place, WorldError, WorldFlaw, WorldProblem};

/// What is in the arena besides robots, which shape it has, of which classes robots are, and which of them fail.
///
/// # Example
///
/// ```
/// use rsrs_core::world::WorldFile;
///
/// let text = "
/// objects: [{count: 20, radius_m: 0.05}]
/// goals: [{place_m: [1, 0], radius_m: 0.3}]
/// ";
/// let world = WorldFile::parse("world.yaml", text, &[3.0], &[5])?;
/// assert_eq!(world.n_objects(), 20);
/// # Ok::<(), rsrs_core::world::WorldError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldFile {
    /// The border of the arena, where that is no square of side `arena_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arena: Option<ArenaShape>,
    /// What stands fixed in the arena: sensors of `wall` detect it, and robots and objects run into it as into walls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// Discs that robots push, in groups that are alike.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectGroup>,
    /// Discs on the floor, which sensors detect and nothing collides with.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub goals: Vec<Goal>,
    /// Classes of robots, which sensors of `kin` and `other` tell from each other; robots are dealt to them in turn, in
    /// the order of their numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<RobotClass>,
    /// Robots that fail at a time, for good.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<Failure>,
}

/// The world of a sweep or an experiment.
pub type WorldSource = Source<WorldFile>;

impl InFile for WorldFile {
    const WHAT: &'static str = "world";
    const SOURCE: &'static str = "WorldSource";
}

/// Objects that are alike; give `count` or `places_m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectGroup {
    /// How many, anywhere in the arena: each replicate places them at random, clear of robots, walls and each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Where each of them is at the start, in metres from the middle of the arena; shape `[n_objects][2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub places_m: Option<Vec<[f64; 2]>>,
    /// Radius of each, in metres.
    pub radius_m: f64,
    /// Coulomb's coefficient of what slides along them, from 0 to 2 (default: 0); of two objects that of the smoother
    /// one counts.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub friction: f64,
    /// As how many robots each resists a push, from 0.1 to 1000 (default: 1); dimensionless. Of two bodies that push
    /// each other, the heavier one yields less.
    #[serde(default = "as_one_robot", skip_serializing_if = "is_as_one_robot")]
    pub weight: f64,
}

/// A disc on the floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// Its centre, in metres from the middle of the arena; shape `[2]`.
    pub place_m: [f64; 2],
    /// Its radius, in metres.
    pub radius_m: f64,
}

/// Lengths that differ by less than this share were the same before they were rounded; dimensionless.
pub(crate) const ROUNDING: f64 = 1e-6;

fn as_one_robot() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_as_one_robot(weight: &f64) -> bool {
    weight.to_bits() == as_one_robot().to_bits()
}

/// One object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// In metres.
    pub radius_m: f64,
    /// Dimensionless.
    pub friction: f64,
    /// Over that of a robot; dimensionless.
    pub weight: f64,
    /// Where it is at the start, in metres; `None` if that is drawn.
    pub place_m: Option<[f64; 2]>,
}

impl WorldFile {
    /// Nothing but robots.
    pub const NOTHING: Self = Self {
        arena: None,
        obstacles: Vec::new(),
        objects: Vec::new(),
        goals: Vec::new(),
        classes: Vec::new(),
        failures: Vec::new(),
    };

    /// Whether there is nothing but robots, of no classes.
    pub fn is_empty(&self) -> bool {
        *self == Self::NOTHING
    }

    /// Each object, group by group: the order of their numbers, poses and draws.
    pub fn each_object(&self) -> impl Iterator<Item = Object> + '_ {
        self.objects.iter().flat_map(ObjectGroup::each)
    }

    /// How many objects there are.
    pub fn n_objects(&self) -> usize {
        self.objects.iter().map(ObjectGroup::n_objects).sum()
    }

    /// The name of an object in topics, by its place among all, from 0: `object_1` is the first.
    pub fn object_name(object: usize) -> String {
        format!("object_{}", object + 1)
    }

    /// Whether a sensor can ever detect this kind of thing here, as far as it is among them.
    pub fn has(&self, kind: Detects) -> bool {
        match kind {
            Detects::Object => self.n_objects() > 0,
            Detects::Goal => !self.goals.is_empty(),
            Detects::Kin | Detects::Other => !self.classes.is_empty(),
            Detects::Robot | Detects::Wall => true,
        }
    }

    /// What it is, in words: `20 objects, 1 goal and 2 classes of robots`.
    pub fn in_words(&self) -> String {
        let counted = |n: usize, noun: &str| (n > 0).then(|| numerals::counted(n as u64, noun));
        let classes = match self.classes.len() {
            0 => None,
            1 => Some("1 class of robots".to_owned()),
            n => Some(format!("{n} classes of robots")),
        };
        let own: Vec<&str> = self.profiles().map(|(class, _)| class).collect();
        let classes = classes.map(|classes| match own.len() {
            0 => classes,
            1 => format!("{classes} ({} with a profile of its own)", own[0]),
            _ => format!("{classes} ({} with profiles of their own)", own.join(", ")),
        });
        let mut words: Vec<String> = [
            self.arena.as_ref().map(ArenaShape::in_words),
            counted(self.obstacles.len(), "obstacle"),
            counted(self.n_objects(), "object"),
            counted(self.goals.len(), "goal"),
            classes,
            counted(self.failures.len(), "failure"),
        ]
        .into_iter()
        .flatten()
        .collect();
        match words.pop() {
            None => "nothing but robots".to_owned(),
            Some(last) if words.is_empty() => last,
            Some(last) => format!("{} and {last}", words.join(", ")),
        }
    }
}

impl ObjectGroup {
    /// How many there are.
    pub fn n_objects(&self) -> usize {
        self.count.or_else(|| Some(self.places_m.as_ref()?.len())).unwrap_or(0)
    }

    fn each(&self) -> impl Iterator<Item = Object> + '_ {
        (0..self.n_objects()).map(|object| Object {
            radius_m: self.radius_m,
            friction: self.friction,
            weight: self.weight,
            place_m: self.places_m.as_ref().and_then(|places_m| places_m.get(object).copied()),
        })
    }
}
