//! The shards of a sweep, put together.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_files::quoted;
use rsrs_sim::sweep::{Block, ReplicateOutcome};

use crate::error::with_help;
use crate::execution::Execution;
use crate::sweep::folder::unfinished::{self, FolderState, Unfinished};
use crate::sweep::folder::{self, difference};
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;
use crate::sweep::{Draw, Plan, sweep_into};

/// Puts shards together into the folder that one machine would have made, byte for byte.
///
/// The shards' folders are in any order and stay as they are; blocks may be in several of them. A
/// folder in which this was interrupted is gone on with. `draw` draws the results beside their
/// tables.
///
/// # Errors
///
/// If folders are not shards of one sweep, or one is still being swept into, or replicates are in
/// none of them.
pub fn merge(
    shards: &[PathBuf],
    folder: &Path,
    execution: Execution<'_>,
    draw: Draw,
) -> anyhow::Result<SweepResult> {
    refuse_one_of_them(shards, folder)?;
    refuse_twice(shards)?;
    let source = one_sweep(shards)?;
    let opened = shards.iter().map(|shard| open(shard)).collect::<anyhow::Result<Vec<_>>>()?;
    let name = shards[0].display().to_string();
    let plan = Plan::new(&name, &source, execution.n_threads)?;
    let mut n_missing = 0;
    for (number, block) in plan.blocks() {
        if whole_block(&opened, number, &block)?.is_none() {
            n_missing += block.n_rows();
        }
    }
    refuse_gaps(n_missing, shards)?;
    if let FolderState::Unfinished(whole) = unfinished::open(folder, &source)? {
        for (number, block) in plan.blocks() {
            let outcomes = whole_block(&opened, number, &block)?
                .with_context(|| format!("block {number} was changed meanwhile"))?;
            whole.keep(number, &block, &outcomes)?;
        }
    }
    sweep_into(folder, &name, source, execution, draw)
}

fn refuse_one_of_them(shards: &[PathBuf], folder: &Path) -> anyhow::Result<()> {
    let is_folder = |shard: &PathBuf| {
        shard == folder
            || shard
                .canonicalize()
                .is_ok_and(|shard| folder.canonicalize().is_ok_and(|it| it == shard))
    };
    if shards.iter().any(is_folder) {
        return Err(with_help(
            format!("{} is one of the shards", folder.display()),
            "give a new folder with `-o`",
        ));
    }
    Ok(())
}

/// A shard under two names is one, and half of a sweep.
fn refuse_twice(shards: &[PathBuf]) -> anyhow::Result<()> {
    let place = |shard: &PathBuf| shard.canonicalize().unwrap_or_else(|_| shard.clone());
    let twice = shards.iter().enumerate().find_map(|(position, shard)| {
        let before = shards[..position].iter().find(|other| place(other) == place(shard))?;
        Some((before, shard))
    });
    match twice {
        None => Ok(()),
        Some((before, shard)) if before == shard => {
            Err(with_help(format!("{} is given twice", shard.display()), "name every shard once"))
        }
        Some((before, shard)) => Err(with_help(
            format!("{} and {} are the same folder", before.display(), shard.display()),
            "name every shard once",
        )),
    }
}

/// What all shards are parts of.
fn one_sweep(shards: &[PathBuf]) -> anyhow::Result<ResolvedSweep> {
    let (first, others) = shards.split_first().expect("the command line asks for one");
    let source = folder::read_source(first)?;
    for other in others {
        let found = folder::read_source(other)?;
        let difference = difference::first_difference(&found, &source).or_else(|| {
            (found.provenance != source.provenance)
                .then(|| "it was begun by another program".into())
        });
        if let Some(difference) = difference {
            return Err(with_help(
                format!(
                    "{} and {} are shards of different sweeps: {difference}",
                    other.display(),
                    first.display()
                ),
                "sweep all shards with one sweep file and one program",
            ));
        }
    }
    Ok(source)
}

fn open(shard: &Path) -> anyhow::Result<Unfinished> {
    match unfinished::open(shard, &folder::read_source(shard)?)? {
        FolderState::Unfinished(unfinished) => Ok(unfinished),
        FolderState::Finished => Err(with_help(
            format!("{} holds a whole sweep, and no shard of one", shard.display()),
            format!("it needs no merging: `rsrs choose {}`", quoted(shard)),
        )),
    }
}

/// A block from the first shard that has it undamaged.
fn whole_block(
    opened: &[Unfinished],
    number: u64,
    block: &Block,
) -> anyhow::Result<Option<Vec<ReplicateOutcome>>> {
    for unfinished in opened {
        if let Some(outcomes) = unfinished.peek(number, block)? {
            return Ok(Some(outcomes));
        }
    }
    Ok(None)
}

fn refuse_gaps(n_missing: u64, shards: &[PathBuf]) -> anyhow::Result<()> {
    if n_missing == 0 {
        return Ok(());
    }
    let folders: Vec<String> = shards.iter().map(|shard| shard.display().to_string()).collect();
    Err(with_help(
        format!(
            "of this sweep {} missing in {}",
            if n_missing == 1 { "1 run is".to_owned() } else { format!("{n_missing} runs are") },
            folders.join(", ")
        ),
        "finish every shard with the command that began it, and name all of them",
    ))
}
