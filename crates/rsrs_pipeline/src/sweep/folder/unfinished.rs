//! A sweep at work in its folder, so that it may be killed at any moment and resumed.
//!
//! In the folder there are `sweep.yaml` and the folder `unfinished`, which holds the finished blocks,
//! one file each. A file is written beside its place and renamed, so none is half-written, and one
//! that is damaged all the same is seen by its digest and made again. At the end the results are
//! written from the blocks, in their order, and take their places one by one; then `unfinished` is
//! renamed and removed. Nothing of this depends on who did which block when, so the finished folder
//! is the same byte for byte.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use rsrs_core::diagram::folder::{self, CELLS, REPLICATES, SWEEP, UNFINISHED};
use rsrs_core::digest::Digest;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_files::quoted;
use rsrs_sim::sweep::{Block, ReplicateOutcome};

use super::block_file::{BlockId, decode, encode};
use super::difference::first_difference;
use super::{cells, read_source};
use crate::error::with_help;
use crate::files::lock_file::try_lock;
use crate::files::{ANOTHER_FOLDER, make_folder, write_draft, wrote};
use crate::sweep::Draw;
use crate::sweep::replicate_table::ReplicateTable;
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;

/// What it is called once its blocks are in the results.
const DISCARDED: &str = "discarded";
/// Locked by the process that is at work.
const LOCK: &str = "lock";
/// Where pictures are drawn.
const PICTURES: &str = "pictures";
/// The results, in the order in which they take their places; then come pictures.
const TABLES: [&str; 2] = [REPLICATES, CELLS];

/// Whether a sweep has begun in a folder and not ended.
pub fn is_unfinished(folder: &Path) -> bool {
    folder.join(UNFINISHED).exists()
}

/// The command that finishes the sweep of a folder.
pub fn command(folder: &Path) -> String {
    folder::finish(&quoted(folder.join(SWEEP)), &quoted(folder))
}

/// What there is to do in an output folder.
pub enum FolderState {
    /// The results of this very sweep are there.
    Finished,
    /// A sweep that was begun now or before.
    Unfinished(Unfinished),
}

/// A sweep at work in its folder; no other process is at work in it.
pub struct Unfinished {
    folder: PathBuf,
    sweep: u64,
    behaviour: Behaviour,
    /// Held open, for it is the lock.
    _lock: File,
}

/// Opens an output folder, and makes it if it is not there.
///
/// # Errors
///
/// If the folder holds anything else than this very sweep, or another process is at work in it.
pub fn open(folder: &Path, source: &ResolvedSweep) -> anyhow::Result<FolderState> {
    let sweep = source.to_yaml();
    let made = make(folder, &sweep)?;
    let is_begun = is_unfinished(folder);
    let lock = match made {
        Some(lock) => Some(lock),
        None if is_begun => Some(lock(folder)?),
        None => None,
    };
    let there = refuse_another_sweep(folder, source)?;
    let discarded = folder.join(DISCARDED);
    if discarded.exists() {
        remove_folder(&discarded)?;
    }
    // It may have been finished by another process before it was locked by this one.
    let Some(lock) = lock.filter(|_| is_unfinished(folder)) else {
        return Ok(FolderState::Finished);
    };
    refuse_another_program(folder, &there, source)?;
    let mut digest = Digest::new("sweep");
    digest.text(&sweep);
    let unfinished = Unfinished {
        folder: folder.to_path_buf(),
        sweep: digest.value(),
        behaviour: source.sweep.behaviour.known(),
        _lock: lock,
    };
    Ok(FolderState::Unfinished(unfinished))
}

/// Makes the folder, and returns its lock; `None` if there is a folder already, or another process
/// has made it. It is made beside its place, so that there is never one without its `sweep.yaml`.
fn make(folder: &Path, sweep: &str) -> anyhow::Result<Option<File>> {
    let name = folder.file_name().context("the output folder needs a name")?;
    let draft = folder.with_file_name(format!(".{}.new", name.to_string_lossy()));
    while !folder.exists() {
        let unfinished = draft.join(UNFINISHED);
        match std::fs::create_dir_all(&unfinished) {
            // Another process has moved or removed the draft between the making of its two folders.
            Err(error) if error.kind() == ErrorKind::NotFound && folder.exists() => continue,
            Err(error) if error.kind() == ErrorKind::AlreadyExists && !draft.is_file() => continue,
            made => made.with_context(|| format!("cannot make {}", draft.display()))?,
        }
        match try_lock(&unfinished.join(LOCK)) {
            // Another process has made the folder, and this draft is one too many.
            Ok(Some(_lock)) if folder.exists() => remove_folder(&draft)?,
            Ok(Some(lock)) => {
                let made = write_draft(&draft.join(SWEEP), sweep.as_bytes())
                    .and_then(|()| move_to(&draft, folder));
                if made.is_err() {
                    // The first error is the one to report; a draft that cannot be removed is named
                    // by it.
                    drop(std::fs::remove_dir_all(&draft));
                }
                return made.map(|()| Some(lock));
            }
            // Another process makes this very folder, which takes it a moment.
            Ok(None) => std::thread::sleep(Duration::from_millis(10)),
            // It has done so between the two lines above.
            Err(_) if folder.exists() || !unfinished.exists() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

fn lock(folder: &Path) -> anyhow::Result<File> {
    try_lock(&folder.join(UNFINISHED).join(LOCK))?.ok_or_else(|| {
        with_help(
            format!("another process is sweeping into {}", folder.display()),
            "wait until it ends, or stop it and run this command again",
        )
    })
}

fn refuse_another_sweep(folder: &Path, source: &ResolvedSweep) -> anyhow::Result<ResolvedSweep> {
    let refuse =
        |what: String| with_help(format!("{} exists and {what}", folder.display()), ANOTHER_FOLDER);
    if !folder.join(SWEEP).exists() {
        return Err(refuse("is not the folder of a sweep".to_owned()));
    }
    let there = read_source(folder)?;
    match first_difference(&there, source) {
        Some(difference) => Err(refuse(format!("holds another sweep: {difference}"))),
        None => Ok(there),
    }
}

/// Half of the results from one program and half from another would be the results of neither.
fn refuse_another_program(
    folder: &Path,
    there: &ResolvedSweep,
    source: &ResolvedSweep,
) -> anyhow::Result<()> {
    let (before, now) = (&there.provenance, &source.provenance);
    if before == now {
        return Ok(());
    }
    Err(with_help(
        format!(
            "the sweep in {} was begun by another program: rsrs {} of commit {}, and this is {} of \
             commit {}",
            folder.display(),
            before.version,
            before.commit,
            now.version,
            now.commit
        ),
        "finish it with that program, or give another folder with `-o`",
    ))
}

impl Unfinished {
    fn place(&self, number: u64) -> (BlockId, PathBuf) {
        let name = format!("block_{number:06}");
        (
            BlockId { sweep: self.sweep, number, behaviour: self.behaviour },
            self.folder.join(UNFINISHED).join(name),
        )
    }

    /// Whether there is a file for a block.
    pub fn has(&self, number: u64) -> bool {
        self.place(number).1.exists()
    }

    /// Reads a block that is there and whole; nothing is changed.
    pub fn peek(
        &self,
        number: u64,
        block: &Block,
    ) -> anyhow::Result<Option<Vec<ReplicateOutcome>>> {
        let (place, path) = self.place(number);
        match std::fs::read(&path) {
            Ok(bytes) => Ok(decode(place, block, &bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
        }
    }

    /// Reads a block that is there; what is there and damaged is removed.
    pub fn read(
        &self,
        number: u64,
        block: &Block,
    ) -> anyhow::Result<Option<Vec<ReplicateOutcome>>> {
        let outcomes = self.peek(number, block)?;
        if outcomes.is_none() && self.has(number) {
            let (_, path) = self.place(number);
            std::fs::remove_file(&path)
                .with_context(|| format!("cannot remove {}, which is damaged", path.display()))?;
        }
        Ok(outcomes)
    }

    /// Keeps a finished block; if that fails, the blocks that are kept are not touched.
    pub fn keep(
        &self,
        number: u64,
        block: &Block,
        outcomes: &[ReplicateOutcome],
    ) -> anyhow::Result<()> {
        let (place, path) = self.place(number);
        let draft = path.with_extension("new");
        let kept = write_draft(&draft, &encode(place, block, outcomes))
            .and_then(|()| move_to(&draft, &path));
        if kept.is_err() {
            // It may be what fills the disk. The first error is the one to report.
            drop(std::fs::remove_file(&draft));
        }
        kept
    }

    /// Writes the results from all blocks, which come with their numbers, in order, and ends the
    /// work. With two threads, the pictures are drawn beside the tables.
    ///
    /// # Errors
    ///
    /// If a result cannot be written, or a block was damaged since it was kept; the folder can then
    /// still be resumed.
    pub fn finish(
        self,
        result: &SweepResult,
        blocks: impl Iterator<Item = (u64, Block)>,
        (n_threads, draw): (usize, Draw),
    ) -> anyhow::Result<()> {
        let unfinished = self.folder.join(UNFINISHED);
        let tabulate = || {
            self.write_replicates(&unfinished.join(REPLICATES), result, blocks)?;
            write_draft(&unfinished.join(CELLS), &cells::to_csv(result))?;
            // The disk takes its time too, while the picture is being drawn.
            TABLES.iter().try_for_each(|name| save(&unfinished.join(name)))
        };
        let pictures = unfinished.join(PICTURES);
        make_folder(&pictures)?;
        if n_threads > 1 {
            std::thread::scope(|scope| {
                let drawing = scope.spawn(|| draw(&pictures, result));
                tabulate()?;
                drawing.join().expect("drawing does not panic")
            })?;
        } else {
            tabulate()?;
            draw(&pictures, result)?;
        }
        let mut results = TABLES.map(|name| unfinished.join(name)).to_vec();
        for picture in files_in(&pictures)? {
            save(&picture)?;
            results.push(picture);
        }
        for file in results {
            let path = self.folder.join(file.file_name().expect("a file has a name"));
            move_to(&file, &path)?;
            wrote(&path);
        }
        let discarded = self.folder.join(DISCARDED);
        move_to(&unfinished, &discarded)?;
        remove_folder(&discarded)
    }

    fn write_replicates(
        &self,
        path: &Path,
        result: &SweepResult,
        blocks: impl Iterator<Item = (u64, Block)>,
    ) -> anyhow::Result<()> {
        let mut table = ReplicateTable::create(path, result)?;
        for (number, block) in blocks {
            let outcomes = self.read(number, &block)?.with_context(|| {
                format!("block {number} in {} was changed meanwhile", self.folder.display())
            })?;
            table.append(&outcomes)?;
        }
        table.finish()
    }

    /// Removes a folder in which nothing was kept.
    pub fn abandon(self) -> anyhow::Result<()> {
        remove_folder(&self.folder)
    }
}

fn files_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let listed = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>());
    let mut files = listed.with_context(|| format!("cannot list {}", folder.display()))?;
    files.sort();
    Ok(files)
}

/// Waits until a file is on the disk, so that its blocks may be removed.
fn save(path: &Path) -> anyhow::Result<()> {
    let saved = File::open(path).and_then(|file| file.sync_all());
    saved.with_context(|| format!("cannot save {}", path.display()))
}

fn move_to(from: &Path, to: &Path) -> anyhow::Result<()> {
    std::fs::rename(from, to).with_context(|| format!("cannot make {}", to.display()))
}

/// Removes a folder, unless another process has just done so.
fn remove_folder(folder: &Path) -> anyhow::Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed.with_context(|| format!("cannot remove {}", folder.display())),
    }
}
