//! The folder of a search: what it follows from, and its journal.

use std::path::{Path, PathBuf};

use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::exploration::ExplorationSettings;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::world::WorldFile;

use super::StartTable;
use super::file_names::{CONTROLLER, PROFILE, SETTINGS, STARTS, WORLD};
use super::journal::Journal;
use crate::error::with_help;
use crate::files::lock_file::try_lock;
use crate::files::{make_folder, read_text, write_file};

const JOURNAL: &str = "trials.jsonl";
const LOCK: &str = ".lock";

/// A search at work in its folder; no other process is at work in it.
pub struct Folder {
    /// Where it is.
    pub path: PathBuf,
    /// What was tried.
    pub journal: Journal,
    /// Held open, for it is the lock.
    _lock: std::fs::File,
}

impl Folder {
    /// Opens a folder, and makes it if it is not there.
    ///
    /// # Errors
    ///
    /// If it holds another search or something else, or another process is at work in it.
    pub fn open(
        path: &Path,
        robot: &RobotProfile,
        settings: &ExplorationSettings,
        starts: Option<&StartTable>,
    ) -> anyhow::Result<Self> {
        let written = settings.to_yaml();
        let profile = robot.to_yaml();
        refuse_other_things(path)?;
        make_folder(path)?;
        let Some(lock) = try_lock(&path.join(LOCK))? else {
            return Err(with_help(
                format!("another search is at work in {}", path.display()),
                "wait for it, or give this one another folder",
            ));
        };
        let table = settings.controller.as_ref().map(ControllerTable::to_yaml);
        let world = settings.world.as_ref().map(WorldFile::to_yaml);
        let files = [
            (PROFILE, Some(&profile)),
            (SETTINGS, Some(&written)),
            (CONTROLLER, table.as_ref()),
            (WORLD, world.as_ref()),
            (STARTS, starts.map(|table| &table.text)),
        ];
        for (name, text) in files.into_iter().filter_map(|(name, text)| Some((name, text?))) {
            let file = path.join(name);
            if !file.exists() {
                write_file(&file, text.as_bytes())?;
            } else if read_text(&file)? != *text {
                return Err(with_help(
                    format!("{} is that of another search", file.display()),
                    "give this one another folder with `-o`",
                ));
            }
        }
        let journal = Journal::open(&path.join(JOURNAL))?;
        Ok(Self { path: path.to_owned(), journal, _lock: lock })
    }
}

/// A folder that holds something, and no search, is somebody's.
fn refuse_other_things(path: &Path) -> anyhow::Result<()> {
    let Ok(mut entries) = std::fs::read_dir(path) else { return Ok(()) };
    if path.join(LOCK).exists() || entries.next().is_none() {
        return Ok(());
    }
    Err(with_help(
        format!("{} is not the folder of a search, and not empty", path.display()),
        "name a new folder with `-o`",
    ))
}
