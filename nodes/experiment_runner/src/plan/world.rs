//! What is in the arena besides the robots, and of which classes these are: the file that an experiment names, or that of the sweep that its cell is from.

use std::path::Path;

use rsrs_core::conditions::{ARENA_M, Conditions};
use rsrs_core::help::Helpful;
use rsrs_core::natural_order::natural_key;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::world::{WorldFile, WorldSource};
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::record::Backend;

use super::profiles::Measured;
use super::read_named;
use super::swept::SweptCell;

/// Puts the world in the place of its path, and refuses one beside a sweep. The text of a file that was
/// read goes into the bag.
pub fn read(
    experiment: &mut ExperimentFile,
    (cell, swept): (&Cell, Option<&SweptCell>),
    experiment_file: &Path,
) -> anyhow::Result<Option<String>> {
    let Some(WorldSource::File(path)) = &experiment.world else { return Ok(None) };
    if swept.is_some() {
        let twice =
            "the experiment names a `world`, and its cell is from a sweep, which has its own";
        let help = "leave `world` out, or give the cell without the sweep";
        return Err(Helpful::new(twice, help).into());
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

/// Refuses robots of several classes that are not in the order of their names, which is that of bags.
pub fn refuse_unordered(robots: &[String], conditions: &Conditions) -> anyhow::Result<()> {
    if conditions.world.classes.is_empty() {
        return Ok(());
    }
    let mut pairs = robots.windows(2);
    let Some(pair) = pairs.find(|pair| natural_key(&pair[0]) > natural_key(&pair[1])) else {
        return Ok(());
    };
    let (found, before, robot) = (conditions.world.in_words(), &pair[0], &pair[1]);
    let unordered = format!(
        "robots are dealt to {found} in the order of the fleet, and {robot} is listed after {before}"
    );
    let help = "list the robots in the order of their names, `robot_2` before `robot_10`: so anybody \
                who knows the names knows the classes";
    Err(Helpful::new(unordered, help).into())
}

/// Refuses a world in which robots fail where robots are real, and one with objects where some are.
pub fn refuse_objects(backend: Backend, conditions: &Conditions) -> anyhow::Result<()> {
    if backend == Backend::Simulator {
        return Ok(());
    }
    if !conditions.world.failures.is_empty() {
        let failing =
            "robots of this world fail, and they do so where the simulator is all of the fleet";
        let help = "run it with `--backend sim`, or leave `failures` out of the `world`";
        return Err(Helpful::new(failing, help).into());
    }
    if backend == Backend::Fleet || conditions.world.n_objects() == 0 {
        return Ok(());
    }
    let objects = format!(
        "there are {} in this world, and real and virtual robots in this fleet, which cannot push the \
         same objects",
        conditions.world.in_words()
    );
    let help = "run it with real robots alone, with `--backend sim`, or leave the objects out of the \
                `world`";
    Err(Helpful::new(objects, help).into())
}
