//! Controllers on trial: simulated, judged, and described.

use rsrs_core::conditions::{ClassChanges, Conditions, ConditionsError, Placement, Settings};
use rsrs_core::document::source::Source;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::condition::Needs;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::order::Parameter;
use rsrs_core::quantity::Axis;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::wheels::Wheels;
use rsrs_core::statistics::share::Share;
use rsrs_core::world::WorldFile;
use rsrs_sim::exploration::niche::{Clusters, Extent, Motion, Niche, Rotation};
use rsrs_sim::exploration::space::{ControllerSpace, Point};
use rsrs_sim::sweep::{ReplicateOutcome, Runs, Swept, Watch, check, sweep_measuring};
use serde::{Deserialize, Serialize};

use super::space::Space;
use super::{CONFIRM, ExploreOptions};
use crate::best_setting::grid::PLACEMENT_OVER_ARENA;
use crate::error::{helped, with_help};

/// What a controller came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Its number, from 0.
    pub number: usize,
    /// Where it was proposed.
    pub point: Point,
    /// The controller.
    pub controller: Controller,
    /// The niche of most of its runs.
    pub niche: Niche,
    /// Share of its runs in this niche.
    pub share: f64,
    /// What most of its runs are called.
    pub name: Name,
    /// How near it is to the behaviour that is searched for, from 0 to 1; 0 for none.
    pub fitness: f64,
}

/// What people call what a swarm does. The first of these that most runs show counts, but that who goes along
/// the walls is called so before anything else.
///
/// # Source
///
/// The classes of D. S. Brown et al., DARS 2018, who call cyclic pursuit what is [`Behaviour::MILLING`] here;
/// the bounds are ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Name {
    /// The wanted phase of a behaviour.
    Behaviour(Behaviour),
    /// Robots go along the walls.
    WallFollowing,
    /// Headings circle the centroid of a crowd that is no ring.
    RotatingCrowd,
    /// Robots are about, alone and free.
    NoOrder,
    /// Nothing that has a name.
    Other,
}

impl Name {
    /// Those of runs by their niche, which no behaviour's file is needed for.
    pub const OF_NICHES: [Self; 3] = [Self::WallFollowing, Self::RotatingCrowd, Self::NoOrder];

    /// In files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Behaviour(behaviour) => behaviour.key(),
            Self::WallFollowing => "wall_following",
            Self::RotatingCrowd => "rotating_crowd",
            Self::NoOrder => "no_order",
            Self::Other => "other",
        }
    }

    /// The class of Brown et al. that it is, under their name.
    pub fn brown_class(self) -> Option<&'static str> {
        match self {
            Self::Behaviour(Behaviour::MILLING) => Some("cyclic_pursuit"),
            Self::Behaviour(Behaviour::AGGREGATION) => Some("aggregation"),
            Self::Behaviour(Behaviour::DISPERSAL) => Some("dispersal"),
            Self::Behaviour(_) | Self::Other => None,
            Self::WallFollowing => Some("wall_following"),
            Self::RotatingCrowd => Some("milling"),
            Self::NoOrder => Some("random"),
        }
    }

    /// Whether a run shows it, by its niche; never behaviours, which judge for themselves.
    pub fn is_shown_in(self, niche: Niche, evidence: &OrderParameters) -> bool {
        self.shown_in(niche, evidence) == Some(true)
    }

    /// Whether a run shows it; `None` for behaviours, which judge for themselves.
    fn shown_in(self, niche: Niche, evidence: &OrderParameters) -> Option<bool> {
        let is_away_and_free = niche.motion == Motion::Free && niche.extent != Extent::AtWalls;
        match self {
            Self::Behaviour(_) | Self::Other => None,
            Self::WallFollowing => Some(
                niche.extent == Extent::AtWalls
                    && niche.rotation == Rotation::Full
                    && niche.motion == Motion::Free,
            ),
            Self::RotatingCrowd => Some(
                is_away_and_free
                    && evidence.rotation >= CROWD_ROTATES
                    && evidence.circliness < RING,
            ),
            Self::NoOrder => Some(
                is_away_and_free
                    && niche.rotation == Rotation::None
                    && niche.clusters == Clusters::Loose,
            ),
        }
    }
}

/// A crowd rotates from this rotation on, ...
const CROWD_ROTATES: f64 = 0.6;
/// ... unless it is a ring, which is from this circliness on.
const RING: f64 = 0.5;

/// Where controllers are tried: the robots, made worse, in their arena.
pub struct TestBed {
    /// What the robots are called.
    pub robot: String,
    /// What is searched.
    pub space: Space,
    /// Side of the arena, in metres.
    pub arena_m: f64,
    /// Radius of the disc in which robots start, in metres; of a table's, of the one that holds all of them.
    pub placement_m: f64,
    measured: RobotProfile,
    factors: HarsherFactors,
    simulated: RobotProfile,
    settings: Settings,
    runs: Runs,
    /// Of an arena that is no plain square ([`Niche::new`]).
    inradius_m: Option<f64>,
}

/// The robot that may be commanded what each of a swarm may.
fn slowest(measured: &RobotProfile, world: Option<&WorldFile>) -> RobotProfile {
    let mut slowest = measured.clone();
    let actuation = &mut slowest.actuation;
    for (_, other) in world.iter().flat_map(|world| world.profiles()) {
        let other = &other.actuation;
        let both = |[low, high]: [f64; 2], [other_low, other_high]: [f64; 2]| {
            [low.max(other_low), high.min(other_high)]
        };
        actuation.speed.limits_m_s = both(actuation.speed.limits_m_s, other.speed.limits_m_s);
        actuation.turn.limits_rad_s = both(actuation.turn.limits_rad_s, other.turn.limits_rad_s);
        actuation.wheels = match (actuation.wheels, other.wheels) {
            (Some(wheels), Some(others)) => Some(Wheels {
                base_m: wheels.base_m.max(others.base_m),
                speed_max_m_s: wheels.speed_max_m_s.min(others.speed_max_m_s),
            }),
            (wheels, others) => wheels.or(others),
        };
    }
    slowest
}

/// Robots in their world.
struct Robots<'a> {
    /// Those without a profile of their own, simulated by this one.
    profile: &'a RobotProfile,
    /// What made them worse, with which those of classes are, too.
    factors: Option<HarsherFactors>,
    settings: &'a Settings,
}

/// Has robots do this when they touch; those that do it keep their friction.
fn touching(robots: &mut RobotProfile, contact: ContactModel) {
    if robots.body.contact != contact {
        (robots.body.contact, robots.body.contact_friction) = (contact, None);
    }
}

/// Area of the arena for each robot, in squares of its radius: with room to disperse, and walls to meet, between
/// the 333 of D. S. Brown et al. (DARS 2018) and the 730 of M. Gauci et al. (IJRR 2014).
const ARENA_OVER_RADIUS_2: f64 = 500.0;

/// Radius of the disc in which robots start, for the root of their number, over their own: the paper's Flockbots
/// (`sec:micromacro`) start in a disc of 0.825 m.
const PLACEMENT_OVER_RADIUS: f64 = 11.0 / 3.0;

/// Fresh runs of robots that do something else when they touch, which are simulated one at a time.
const CONFIRM_CONTACT: u64 = 40;

/// How often a controller shows in other worlds what it was found for.
#[derive(Clone, Copy, Debug)]
pub struct Elsewhere {
    /// The robots as measured.
    pub as_measured: Share,
    /// What the others do when they touch.
    pub contact: ContactModel,
    /// The robots made worse, all of them with that contact.
    pub with_contact: Share,
}

/// Which of a controller's runs show what it was found for.
pub struct Shown {
    /// How many.
    pub share: Share,
    /// The number of the first of them.
    pub first: Option<u64>,
    /// The mean over them of each order parameter that all of them have.
    pub means: Vec<(Parameter, f64)>,
}

/// A share of runs from which on a controller is called by what they show.
pub const MOST: f64 = 0.5;

impl TestBed {
    /// Robots in an arena.
    pub fn new(measured: &RobotProfile, options: &ExploreOptions) -> anyhow::Result<Self> {
        let factors = Harsher::default().factors(measured);
        let simulated = factors.apply(measured)?;
        let across_m = simulated.body.radius_m * (options.robots.max(1) as f64).sqrt();
        let own_m = options.world.and_then(WorldFile::side_m);
        let arena_m = own_m.or(options.arena_m).unwrap_or_else(|| {
            // A side that a person would write, and in which there is room for the least of robots.
            ((ARENA_OVER_RADIUS_2.sqrt() * across_m * 10.0).round() / 10.0).max(0.1)
        });
        let in_disc_m = (PLACEMENT_OVER_RADIUS * across_m).min(PLACEMENT_OVER_ARENA * arena_m);
        let placement = options.starts.map(|table| table.placement.clone());
        let placement_m = placement.as_ref().map_or(in_disc_m, Placement::radius_m);
        let placement_m = (placement_m * 1e3).round() / 1e3;
        let mut values = vec![(Axis::Robots, options.robots as f64)];
        // Beside an arena of the world's own, that of the options is refused.
        let side_m = if own_m.is_some() { options.arena_m } else { Some(arena_m) };
        values.extend(side_m.map(|side_m| (Axis::Arena, side_m)));
        if placement.is_none() {
            values.push((Axis::PlacementRadius, placement_m));
        }
        let settings = Settings {
            values,
            walls: options.walls,
            behaviour: options.wanted.unwrap_or_default(),
            placement,
            controller: options.controller.cloned(),
            world: options.world.cloned().unwrap_or_default(),
            class_changes: ClassChanges::default(),
        };
        let runs = Runs {
            seed: options.seed,
            replicates: options.replicates,
            duration_s: options.duration_s,
            n_threads: options.execution.n_threads,
        };
        let space = match options.controller {
            Some(table) if table.numbers.is_empty() => {
                return Err(with_help(
                    "the controller has no numbers, so there is nothing to search",
                    "name some under `numbers`, and use them in its rows",
                ));
            }
            Some(table) => Space::Table(table.clone()),
            None => {
                let commanded = slowest(measured, options.world);
                Space::Commands(ControllerSpace::new(&commanded, options.directions))
            }
        };
        let space_m = settings.world.free_space(arena_m);
        let test_bed = Self {
            robot: settings.world.robot_names(measured),
            space,
            arena_m,
            placement_m,
            measured: measured.clone(),
            factors,
            simulated,
            settings,
            runs,
            inradius_m: space_m.map(|space| space.inradius_m()),
        };
        let conditions = test_bed.conditions(&vec![1.0; test_bed.space.n_numbers()]);
        let conditions = conditions.map_err(helped)?;
        check(&[conditions], runs)?;
        Ok(test_bed)
    }

    /// The robots, made worse.
    pub fn robots(&self) -> &RobotProfile {
        &self.simulated
    }

    fn made_worse(&self) -> Robots<'_> {
        let Self { simulated, factors, settings, .. } = self;
        Robots { profile: simulated, factors: Some(*factors), settings }
    }

    fn measured(&self) -> Robots<'_> {
        Robots { profile: &self.measured, factors: None, settings: &self.settings }
    }

    /// Radius of a robot's body, in metres.
    pub fn radius_m(&self) -> f64 {
        self.simulated.body.radius_m
    }

    /// The robots as measured, with some controller.
    pub fn as_measured(&self) -> Result<Conditions, ConditionsError> {
        self.conditions_of(self.measured(), &vec![1.0; self.space.n_numbers()])
    }

    /// The world of the controller at a point.
    pub fn conditions(&self, point: &[f64]) -> Result<Conditions, ConditionsError> {
        self.conditions_of(self.made_worse(), point)
    }

    /// What is set at a point.
    pub fn values(&self, point: &[f64]) -> Vec<(Axis, f64)> {
        self.space.values(point, (&self.measured, &self.settings))
    }

    fn conditions_of(
        &self,
        Robots { profile, factors, settings }: Robots<'_>,
        point: &[f64],
    ) -> Result<Conditions, ConditionsError> {
        let mut settings = settings.clone();
        if let Some(factors) = factors {
            settings.class_changes = ClassChanges::as_of(&self.measured, factors);
        }
        settings.values.extend(self.values(point));
        Conditions::resolve(profile, &settings)
    }

    /// Tries some controllers, which are numbered from `first`.
    pub fn try_out(
        &self,
        first: usize,
        points: &[Point],
        options: &ExploreOptions,
    ) -> anyhow::Result<Vec<Trial>> {
        let conditions =
            points.iter().map(|point| self.conditions(point)).collect::<Result<Vec<_>, _>>()?;
        let swept = run_to_end(&conditions, self.runs, options)?;
        let replicates = usize::try_from(self.runs.replicates).expect("runs fit into memory");
        let trial = |index: usize| {
            let outcomes = &swept.outcomes[index * replicates..(index + 1) * replicates];
            let conditions = &conditions[index];
            let niche_of = |outcome: &ReplicateOutcome| {
                Niche::new(conditions, &outcome.evidence, self.inradius_m)
            };
            let (niche, share) = most_frequent(outcomes, niche_of);
            Trial {
                number: first + index,
                point: points[index].clone(),
                controller: conditions.controller.clone(),
                niche,
                share,
                name: name(outcomes, niche_of),
                fitness: options.wanted.map_or(0.0, |wanted| fitness(&wanted.rules(), outcomes)),
            }
        };
        Ok((0..points.len()).map(trial).collect())
    }

    /// How often fresh runs of a controller show what it was found for, by name or by niche, and
    /// what those that do look like.
    pub fn confirm(
        &self,
        trial: &Trial,
        fresh: (u64, u64),
        options: &ExploreOptions,
    ) -> anyhow::Result<Shown> {
        self.shown_by(self.made_worse(), trial, fresh, options)
    }

    /// How often fresh runs show the same as measured, and where the robots do something else when they
    /// touch: push where they stop or pass, and stop where they push.
    pub fn elsewhere(
        &self,
        trial: &Trial,
        seed: u64,
        options: &ExploreOptions,
    ) -> anyhow::Result<Elsewhere> {
        let contact = self.other_contact();
        let (profile, settings) = self.touching_otherwise(contact);
        let others = Robots { profile: &profile, settings: &settings, ..self.made_worse() };
        let shown_by = |robots, replicates| {
            self.shown_by(robots, trial, (seed, replicates), options).map(|shown| shown.share)
        };
        Ok(Elsewhere {
            as_measured: shown_by(self.measured(), CONFIRM)?,
            contact,
            with_contact: shown_by(others, CONFIRM_CONTACT)?,
        })
    }

    /// What robots do when they touch in the world in which they do something else; where they differ in it, something
    /// else than those of the first class.
    fn other_contact(&self) -> ContactModel {
        let first = self.settings.world.classes.first();
        let first = first.map_or(&self.simulated, |class| class.profile_or(&self.simulated));
        match first.body.contact {
            ContactModel::Stop | ContactModel::None => ContactModel::Push,
            ContactModel::Push => ContactModel::Stop,
        }
    }

    /// The robots made worse, and their settings, where all of them do this when they touch.
    fn touching_otherwise(&self, contact: ContactModel) -> (RobotProfile, Settings) {
        let (mut profile, mut settings) = (self.simulated.clone(), self.settings.clone());
        touching(&mut profile, contact);
        for class in &mut settings.world.classes {
            if let Some(Source::Read(own)) = &mut class.profile {
                touching(own, contact);
            }
        }
        (profile, settings)
    }

    fn shown_by(
        &self,
        robots: Robots<'_>,
        trial: &Trial,
        (seed, replicates): (u64, u64),
        options: &ExploreOptions,
    ) -> anyhow::Result<Shown> {
        let conditions = self.judged_of(robots, trial)?;
        let runs = Runs { seed, replicates, ..self.runs };
        let swept = run_to_end(std::slice::from_ref(&conditions), runs, options)?;
        let shows = |outcome: &&ReplicateOutcome| {
            let niche = Niche::new(&conditions, &outcome.evidence, self.inradius_m);
            match trial.name {
                Name::Behaviour(behaviour) => outcome.phase == behaviour.wanted(),
                name => name.shown_in(niche, &outcome.evidence).unwrap_or(niche == trial.niche),
            }
        };
        let showing: Vec<&ReplicateOutcome> = swept.outcomes.iter().filter(shows).collect();
        Ok(Shown {
            share: Share { hits: showing.len() as u64, n: replicates },
            first: showing.first().map(|outcome| outcome.replicate),
            means: means(&showing),
        })
    }

    /// The world of a controller, judged for what it was found to do.
    pub fn judged_for(&self, trial: &Trial) -> Result<Conditions, ConditionsError> {
        self.judged_of(self.made_worse(), trial)
    }

    fn judged_of(&self, robots: Robots<'_>, trial: &Trial) -> Result<Conditions, ConditionsError> {
        let mut conditions = self.conditions_of(robots, &trial.point)?;
        if let Name::Behaviour(behaviour) = trial.name {
            conditions.behaviour = behaviour;
        }
        Ok(conditions)
    }
}

/// Runs of controllers to their end, with all measured that niches are made of; progress is that of controllers, and shown
/// elsewhere.
fn run_to_end(
    conditions: &[Conditions],
    runs: Runs,
    options: &ExploreOptions,
) -> anyhow::Result<Swept> {
    let also = conditions.first().map_or(&[][..], Niche::looks_also_at);
    let watch = Watch { progress: &|_| {}, cancel: options.execution.observer.cancel() };
    let swept = sweep_measuring(conditions, runs, watch, also)?;
    if swept.is_cancelled {
        return Err(with_help(
            "interrupted; what was tried is kept",
            "go on with the same command",
        ));
    }
    Ok(swept)
}

/// The niche of most runs, and their share.
fn most_frequent(
    outcomes: &[ReplicateOutcome],
    niche_of: impl Fn(&ReplicateOutcome) -> Niche,
) -> (Niche, f64) {
    let mut counts = std::collections::BTreeMap::new();
    for outcome in outcomes {
        *counts.entry(niche_of(outcome)).or_insert(0_u64) += 1;
    }
    let most = counts.into_iter().max_by_key(|(niche, n)| (*n, std::cmp::Reverse(*niche)));
    let (niche, n) = most.expect("a controller has runs");
    (niche, n as f64 / outcomes.len() as f64)
}

/// What most runs show: a behaviour, whatever they were judged for.
fn name(outcomes: &[ReplicateOutcome], niche_of: impl Fn(&ReplicateOutcome) -> Niche) -> Name {
    let share = |rules: &Rules| {
        let shows = |outcome: &&ReplicateOutcome| rules.phase(&outcome.evidence) == rules.wanted;
        outcomes.iter().filter(shows).count() as f64 / outcomes.len() as f64
    };
    let is_called = |name: &Name| {
        let shows =
            |outcome: &&ReplicateOutcome| name.is_shown_in(niche_of(outcome), &outcome.evidence);
        outcomes.iter().filter(shows).count() as f64 / outcomes.len() as f64 > MOST
    };
    // Robots that go along the walls have no neighbours for most of the time, but they do more.
    if is_called(&Name::WallFollowing) {
        return Name::WallFollowing;
    }
    let behaviour = Behaviour::all().find(|behaviour| share(&behaviour.rules()) > MOST);
    let other = || [Name::RotatingCrowd, Name::NoOrder].into_iter().find(is_called);
    behaviour.map(Name::Behaviour).or_else(other).unwrap_or(Name::Other)
}

/// The mean over some runs of each order parameter that all of them have.
fn means(outcomes: &[&ReplicateOutcome]) -> Vec<(Parameter, f64)> {
    if outcomes.is_empty() {
        return Vec::new();
    }
    let mean = |parameter: Parameter| {
        let values: Option<Vec<f64>> =
            outcomes.iter().map(|outcome| parameter.value(&outcome.evidence)).collect();
        Some((parameter, values?.iter().sum::<f64>() / outcomes.len() as f64))
    };
    Parameter::all().filter_map(mean).collect()
}

/// How near runs are to a behaviour, from 0 to 1: half for the share of them that are in its wanted
/// phase, half for how far its conditions are met on average, which leads there.
fn fitness(rules: &Rules, outcomes: &[ReplicateOutcome]) -> f64 {
    let n = outcomes.len() as f64;
    let hits = outcomes.iter().filter(|outcome| outcome.phase == rules.wanted).count() as f64;
    let met: f64 = outcomes.iter().map(|outcome| met(rules, &outcome.evidence)).sum();
    f64::midpoint(hits / n, met / n)
}

/// How far the conditions of the wanted phase are met, from 0 to 1.
fn met(rules: &Rules, evidence: &OrderParameters) -> f64 {
    let conditions: Vec<_> = rules.of(rules.wanted).flat_map(|rule| &rule.conditions).collect();
    let sum: f64 = conditions
        .iter()
        .map(|condition| {
            let found = condition.parameter.of(evidence);
            match condition.needs {
                _ if condition.holds(evidence) => 1.0,
                Needs::AtLeast => (found / condition.bound).clamp(0.0, 1.0),
                Needs::Below | Needs::AtMost => (1.0 - (found - condition.bound)).clamp(0.0, 1.0),
            }
        })
        .sum();
    sum / conditions.len() as f64
}

#[cfg(test)]
mod tests {
    use rsrs_core::conditions::Walls;
    use rsrs_core::world::RobotClass;
    use rsrs_sim::exploration::space::Directions;
    use rsrs_testing::conditions::flockbot;

    use super::*;
    use crate::execution::Execution;

    /// Four robots in a world; in a square of 3 m, unless it has an arena of its own.
    fn options(world: &WorldFile) -> ExploreOptions<'_> {
        ExploreOptions {
            wanted: None,
            controller: None,
            world: Some(world),
            starts: None,
            robots: 4,
            arena_m: world.arena.is_none().then_some(3.0),
            walls: Walls::Stop,
            directions: Directions::Both,
            controllers: 1,
            replicates: 1,
            duration_s: 100.0,
            seed: 1,
            execution: Execution::unobserved(),
        }
    }

    /// Flockbots, of which every other one was changed.
    fn mixed(change: impl Fn(&mut RobotProfile)) -> TestBed {
        let measured = flockbot();
        let mut own = measured.clone();
        change(&mut own);
        let class = |name: &str, profile: Option<RobotProfile>| RobotClass {
            name: name.to_owned(),
            profile: profile.map(Source::Read),
            ..RobotClass::default()
        };
        let classes = vec![class("a", None), class("b", Some(own))];
        let world = WorldFile { classes, ..WorldFile::NOTHING };
        TestBed::new(&measured, &options(&world)).unwrap()
    }

    #[test]
    fn of_an_arena_that_is_no_plain_square_the_distance_of_its_walls_is_measured() {
        for (text, is_measured) in [
            ("arena: {disc_m: 1.5}", true),
            ("obstacles: [{place_m: [0, 1], radius_m: 0.2}]", true),
            ("goals: [{place_m: [0, 1], radius_m: 0.2}]", false),
        ] {
            let world = WorldFile::parse("world.yaml", text, &[3.0], &[4]).unwrap();
            let options = options(&world);
            let test_bed = TestBed::new(&flockbot(), &options).unwrap();
            let point = vec![0.5; test_bed.space.n_numbers()];

            let trial = test_bed.try_out(0, &[point], &options).unwrap().remove(0);
            let shown = test_bed.confirm(&trial, (2, 8), &options).unwrap();

            let found = shown.means.iter().find(|(it, _)| *it == Parameter::WALL_DISTANCE);
            assert_eq!(found.is_some(), is_measured, "{text}: {:?}", shown.means);
        }
    }

    #[test]
    fn with_another_contact_the_robots_of_all_classes_do_something_else_when_they_touch() {
        for own in [ContactModel::Stop, ContactModel::Push] {
            let test_bed = mixed(|robot| {
                robot.body.contact = own;
                robot.body.contact_friction = (own == ContactModel::Push).then_some(0.3);
            });
            let contacts = |conditions: Conditions| {
                [0, 1].map(|robot| {
                    let robot = conditions.robot_at(robot);
                    (robot.contact, robot.contact_friction.to_bits())
                })
            };
            let point = vec![1.0; test_bed.space.n_numbers()];

            let contact = test_bed.other_contact();
            let (profile, settings) = test_bed.touching_otherwise(contact);
            let others = Robots { profile: &profile, settings: &settings, ..test_bed.made_worse() };

            assert_eq!(contact, ContactModel::Push);
            let friction = if own == ContactModel::Push { 0.3_f64 } else { 0.0 };
            assert_eq!(
                contacts(test_bed.conditions(&point).unwrap()),
                [(ContactModel::Stop, 0), (own, friction.to_bits())]
            );
            assert_eq!(
                contacts(test_bed.conditions_of(others, &point).unwrap()),
                [(ContactModel::Push, 0), (ContactModel::Push, friction.to_bits())]
            );
        }
    }

    #[test]
    fn the_wheels_of_one_class_bound_what_the_swarm_is_commanded() {
        let on_wheels = mixed(|robot| {
            robot.actuation.wheels = Some(Wheels { base_m: 0.12, speed_max_m_s: 0.05 });
        });
        let fastest = |test_bed: &TestBed| {
            let point = vec![1.0; test_bed.space.n_numbers()];
            test_bed.conditions(&point).unwrap().controller.fastest().speed_m_s
        };

        assert!(fastest(&on_wheels) <= 0.05, "{}", fastest(&on_wheels));
        assert!(fastest(&mixed(|_| {})) > 0.05);
    }
}
