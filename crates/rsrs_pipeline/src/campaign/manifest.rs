//! The manifest of one experiment: what is in its folder, and what it came to.
//!
//! It is written last and whole, so that an experiment with a manifest is a finished one.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use base16ct::HexDisplay;
use rsrs_core::judge::phase::Phase;
use rsrs_fleet::record::{EndingKind, ExperimentRecord, LostRobot};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::attempt::{Attempt, NOT_JUDGED};
use crate::error::with_help;
use crate::files::{cannot_write, read_if_there, write_durably};
use crate::recorded_run::gaps::Gap;

/// Its name in the folder of an experiment.
pub const MANIFEST: &str = "manifest.json";

/// Version of [`Manifest`]'s shape.
const SCHEMA_VERSION: u32 = 1;

/// What is in the folder of a finished experiment.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of this shape.
    pub schema_version: u32,
    /// The experiment's name.
    pub name: String,
    /// All that it takes to repeat the run: cell, seed, replicate, provenance.
    pub record: ExperimentRecord,
    /// How the run ended: completed (or void, where an earlier version has written it).
    pub ending: String,
    /// Why, if it is void; else empty.
    pub reason: String,
    /// The judge's label; `None` if it could not judge.
    pub phase: Option<Phase>,
    /// Why it could not; else empty.
    pub not_judged: String,
    /// Messages in the bag.
    pub n_messages: u64,
    /// Messages that the middleware lost on topics that are to lose none; `None` where the runner did
    /// was killed before its end.
    pub n_lost: Option<u64>,
    /// What did not get into the bag, by topic.
    pub gaps: Vec<Gap>,
    /// Robots that were lost on the way, and when.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lost_robots: Vec<LostRobot>,
    /// Recordings of this experiment that do not count and were kept aside.
    pub kept_aside: Vec<String>,
    /// Runs of this experiment that gave no result, with the cause of each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attempts: Vec<Attempt>,
    /// Every file that counts, by its path in this folder.
    pub files: Vec<Entry>,
}

/// A file of an experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Path in the experiment's folder.
    pub path: String,
    /// Size, in bytes.
    pub size_bytes: u64,
    /// SHA-256, as 64 hexadecimal digits.
    pub sha256: String,
}

impl Manifest {
    /// Version of the shape that is written.
    pub fn schema_version() -> u32 {
        SCHEMA_VERSION
    }

    /// Whether its run is the experiment's result. One that is void, or could not be judged though it was
    /// to last long enough, is none, and is run again.
    pub fn is_result(&self) -> bool {
        let least_s = self.record.conditions.behaviour.window().least_s();
        let is_judged = self.phase.is_some() || self.record.duration_s < least_s;
        self.ending == EndingKind::Completed.key() && is_judged
    }

    /// Why its run is no result, if it is none.
    pub fn why_no_result(&self) -> String {
        match self.not_judged.as_str() {
            "" => self.reason.clone(),
            not_judged => format!("{NOT_JUDGED}{not_judged}"),
        }
    }

    /// Reads the manifest of an experiment; `None` where there is none, because it is not finished.
    pub fn read(folder: &Path) -> anyhow::Result<Option<Self>> {
        let path = folder.join(MANIFEST);
        let Some(text) = read_if_there(&path)? else { return Ok(None) };
        let manifest = serde_json::from_str(&text)
            .with_context(|| format!("{} is no manifest", path.display()))?;
        Ok(Some(manifest))
    }

    /// Writes the manifest, whole or not at all, when all that it lists is on the disk.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        for entry in &self.files {
            let path = folder.join(&entry.path);
            File::open(&path)
                .and_then(|file| file.sync_all())
                .with_context(|| format!("cannot bring {} to the disk", path.display()))?;
        }
        write_whole(&folder.join(MANIFEST), self)
    }

    /// Looks whether every file is as it was when the experiment ended; the error names the first
    /// that is gone, or another one now.
    ///
    /// Files that came later, such as the labels of people, are no difference.
    pub fn verify(&self, folder: &Path) -> anyhow::Result<()> {
        for entry in &self.files {
            let path = folder.join(&entry.path);
            let changed = |how: String| {
                with_help(
                    format!("{} is not what was recorded: {how}", path.display()),
                    format!(
                        "bring the file back; or move {} elsewhere, and the experiment is run again",
                        folder.display()
                    ),
                )
            };
            let found = match Entry::new(folder, &entry.path) {
                Ok(found) => found,
                Err(error) => return Err(changed(format!("{error:#}"))),
            };
            if found.size_bytes != entry.size_bytes {
                let (found, expected) = (found.size_bytes, entry.size_bytes);
                return Err(changed(format!("it has {found} bytes, expected {expected}")));
            }
            if found.sha256 != entry.sha256 {
                let (found, expected) = (found.sha256, &entry.sha256);
                return Err(changed(format!("its SHA-256 is {found}, expected {expected}")));
            }
        }
        Ok(())
    }
}

impl Entry {
    fn new(folder: &Path, path: &str) -> anyhow::Result<Self> {
        let file = folder.join(path);
        let (size_bytes, sha256) = digest(&file).map_err(|error| anyhow!("{error}"))?;
        Ok(Self { path: path.to_owned(), size_bytes, sha256 })
    }
}

/// Every file below a folder's parts, which are files and folders in it, each with its checksum,
/// sorted by path.
pub fn entries(folder: &Path, parts: &[&str]) -> anyhow::Result<Vec<Entry>> {
    let mut paths = Vec::new();
    for part in parts {
        collect(folder, Path::new(part), &mut paths)
            .with_context(|| format!("cannot list {}", folder.join(part).display()))?;
    }
    paths.sort();
    let entry = |path: &PathBuf| {
        let name = path.to_str().context("names of our own files are text")?;
        Entry::new(folder, name).with_context(|| format!("cannot read {}", path.display()))
    };
    paths.iter().map(entry).collect()
}

fn collect(folder: &Path, part: &Path, paths: &mut Vec<PathBuf>) -> io::Result<()> {
    let path = folder.join(part);
    if !path.is_dir() {
        paths.push(part.to_owned());
        return Ok(());
    }
    for entry in path.read_dir()? {
        collect(folder, &part.join(entry?.file_name()), paths)?;
    }
    Ok(())
}

/// The size of a file and its SHA-256, read once in pieces.
fn digest(path: &Path) -> io::Result<(u64, String)> {
    let mut file = rsrs_files::open(path)?;
    let mut digest = Sha256::new();
    let mut size_bytes = 0;
    let mut piece = vec![0; 1 << 20];
    loop {
        let n = file.read(&mut piece)?;
        if n == 0 {
            break;
        }
        size_bytes += n as u64;
        digest.update(&piece[..n]);
    }
    Ok((size_bytes, format!("{:x}", HexDisplay(&digest.finalize()))))
}

/// Writes a value as JSON, so that a reader finds the old file or the new one, whenever this program
/// or the machine is killed.
pub fn write_whole(path: &Path, value: &impl Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(value).context("plain data as JSON")?;
    write_durably(path, format!("{text}\n").as_bytes()).with_context(|| cannot_write(path))
}
