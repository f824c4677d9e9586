//! What is in the arena besides the robots, and of which classes these are: the file that an experiment names, or that of the sweep that its cell is from.

use std::path::Path;

use rsrs_core::conditions::{ARENA_M, Conditions};
use rsrs_core::help::{Help, Helpful};
use rsrs_core::natural_order::natural_key;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::world::{WorldFile, WorldSource};
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::record::Backend;

use super::profiles::Measured;
use super::read_named;
use super::swept::SweptCell;

/// A world beside a sweep, which has its own.
#[derive(Debug, thiserror::Error)]
#[error("the experiment names a `world`, and its cell is from a sweep, which has its own")]
struct WorldTwice;

impl Help for WorldTwice {
    fn help(&self) -> Option<String> {
        Some("leave `world` out, or give the cell without the sweep".to_owned())
    }
}

/// Puts the world in the place of its path, and refuses one beside a sweep. The text of a file that was
/// read goes into the bag.
pub fn read(
    experiment: &mut ExperimentFile,
    (cell, swept): (&Cell, Option<&SweptCell>),
    experiment_file: &Path,
) -> anyhow::Result<Option<String>> {
    let Some(WorldSource::File(path)) = &experiment.world else { return Ok(None) };
    if swept.is_some() {
        return Err(Helpful::from(WorldTwice).into());
    }
    let beside = experiment_file.parent().unwrap_or(Path::new(""));
    let file = experiment_file.display().to_string();
    let path = beside.join(path);
    let (name, text) = read_named("world", &path, &file)?;
    let arena_m = cell.get(Axis::Arena).unwrap_or(ARENA_M);
    let robots: Vec<usize> = cell.robots().into_iter().collect();
    let mut world = WorldFile::parse(&name, &text, &[arena_m], &robots).map_err(Helpful::from)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    world.read_profiles(|of_class| {
        Ok::<_, anyhow::Error>(Measured::of_class(&beside.join(of_class), &name)?.profile)
    })?;
    experiment.world = Some(WorldSource::Read(world));
    Ok(Some(text))
}

/// Robots that bags have in another order than the fleet, in which they are dealt to their classes.
#[derive(Debug, thiserror::Error)]
#[error(
    "robots are dealt to {found} in the order of the fleet, and {robot} is listed after {before}"
)]
struct Unordered {
    found: String,
    robot: String,
    before: String,
}

impl Help for Unordered {
    fn help(&self) -> Option<String> {
        Some(
            "list the robots in the order of their names, `robot_2` before `robot_10`: so anybody who knows the names \
             knows the classes"
                .to_owned(),
        )
    }
}

/// Refuses robots of several classes that are not in the order of their names.
pub fn refuse_unordered(robots: &[String], conditions: &Conditions) -> anyhow::Result<()> {
    if conditions.world.classes.is_empty() {
        return Ok(());
    }
    match robots.windows(2).find(|pair| natural_key(&pair[0]) > natural_key(&pair[1])) {
        None => Ok(()),
        Some(pair) => {
            let found = conditions.world.in_words();
            let (before, robot) = (pair[0].clone(), pair[1].clone());
            Err(Helpful::from(Unordered { found, robot, before }).into())
        }
    }
}

/// Objects that only some of the robots could push.
#[derive(Debug, thiserror::Error)]
#[error(
    "there are {found} in this world, and real and virtual robots in this fleet, which cannot push the same objects"
)]
struct Objects {
    found: String,
}

impl Help for Objects {
    fn help(&self) -> Option<String> {
        Some(
            "run it with real robots alone, with `--backend sim`, or leave the objects out of the `world`"
                .to_owned(),
        )
    }
}

/// Robots that nobody can have fail.
#[derive(Debug, thiserror::Error)]
#[error("robots of this world fail, and they do so where the simulator is all of the fleet")]
struct Failing;

impl Help for Failing {
    fn help(&self) -> Option<String> {
        Some("run it with `--backend sim`, or leave `failures` out of the `world`".to_owned())
    }
}

/// Refuses a world in which robots fail where robots are real, and one with objects where some are.
pub fn refuse_objects(backend: Backend, conditions: &Conditions) -> anyhow::Result<()> {
    if backend == Backend::Simulator {
        return Ok(());
    }
    if !conditions.world.failures.is_empty() {
        return Err(Helpful::from(Failing).into());
    }
    if backend == Backend::Fleet || conditions.world.n_objects() == 0 {
        return Ok(());
    }
    let found = conditions.world.in_words();
    Err(Helpful::from(Objects { found }).into())
}
