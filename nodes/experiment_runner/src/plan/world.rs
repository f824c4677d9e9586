//! What is in the arena besides the robots: the file that an experiment names, or that of the sweep that its cell is from.

use std::path::Path;

use rsrs_core::conditions::{ARENA_M, Conditions};
use rsrs_core::help::{Help, Helpful};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::world::{WorldFile, WorldSource};
use rsrs_fleet::experiment::ExperimentFile;
use rsrs_fleet::record::Backend;

use super::read as read_file;
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

/// Puts the world in the place of its path.
///
/// # Returns
///
/// The text of a file that was read, which goes into the bag.
///
/// # Errors
///
/// If the file cannot be read, or describes no world of this arena, or there is a sweep, too.
pub fn read(
    experiment: &mut ExperimentFile,
    (cell, swept): (&Cell, Option<&SweptCell>),
    beside: &Path,
) -> anyhow::Result<Option<String>> {
    let Some(WorldSource::File(path)) = &experiment.world else { return Ok(None) };
    if swept.is_some() {
        return Err(Helpful::from(WorldTwice).into());
    }
    let (name, text) = read_file(&beside.join(path))?;
    let arena_m = cell.get(Axis::Arena).unwrap_or(ARENA_M);
    let world = WorldFile::parse(&name, &text, &[arena_m]).map_err(Helpful::from)?;
    experiment.world = Some(WorldSource::Read(world));
    Ok(Some(text))
}

/// Objects whose poses nobody publishes.
#[derive(Debug, thiserror::Error)]
#[error(
    "there are {found} in this world, and their poses are known where the simulator is all of the fleet"
)]
struct Objects {
    found: String,
}

impl Help for Objects {
    fn help(&self) -> Option<String> {
        Some(
            "run it with `--backend simulator`, or leave the objects out of the `world`".to_owned(),
        )
    }
}

/// Refuses a world with objects in which robots are real: nothing records where their objects are.
///
/// # Errors
///
/// If there are some.
pub fn refuse_objects(backend: Backend, conditions: &Conditions) -> anyhow::Result<()> {
    if backend == Backend::Simulator || conditions.world.n_objects() == 0 {
        return Ok(());
    }
    let found = conditions.world.in_words();
    Err(Helpful::from(Objects { found }).into())
}
