//! The folder of a campaign: what was asked for, and which experiments are finished.
//!
//! Nothing in it marks an experiment that is under way: it is finished when its manifest is there, and
//! not before. So a campaign may be killed at any moment.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_bags::{Bag, METADATA};
use rsrs_fleet::record::{Ending, EndingKind, ExperimentRecord};
use serde::{Deserialize, Serialize};

use super::manifest::{self, MANIFEST, Manifest, write_whole};
use super::{Item, is_same};
use crate::attempt::{Attempt, keep_aside, number_aside};
use crate::error::{in_one_line, with_help};
use crate::files::lock_file::try_lock;
use crate::files::{make_folder, read_json_if_there, write_file, write_json};
use crate::label::{LABEL, LabelOptions, Settledness, label_bag};
use crate::recorded_run::{self, gaps};

const LOCK: &str = "campaign.lock";
const STATE: &str = "campaign.json";
const FILE: &str = "campaign.yaml";
/// The bag in the folder of an experiment.
pub const BAG: &str = "bag";

/// What a campaign is, whatever has been run of it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    schema_version: u32,
    experiments: Vec<Asked>,
}

/// One experiment that was asked for.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    folder: String,
    record: ExperimentRecord,
}

impl Asked {
    fn is_same(&self, other: &Self) -> bool {
        self.folder == other.folder && is_same(&self.record, &other.record)
    }
}

/// What has become of a run that was completed.
pub enum Finished {
    /// It is the experiment's result.
    Result(Box<Manifest>),
    /// The judge cannot judge it, for this reason, and might judge another one.
    NotJudged(String),
}

/// The folder of a campaign, locked for this process.
pub struct CampaignFolder {
    path: PathBuf,
    /// Held to the end of this process, however it ends.
    _lock: File,
}

impl CampaignFolder {
    /// Makes the folder for the text of a campaign file and its experiments, or goes on with the
    /// one that is there.
    ///
    /// # Errors
    ///
    /// If it is not this campaign's, or another process is at work in it.
    pub fn open(path: &Path, text: &str, items: &[Item]) -> anyhow::Result<Self> {
        refuse_foreign(path)?;
        make_folder(path)?;
        let Some(lock) = try_lock(&path.join(LOCK))? else {
            bail!("another `rsrs campaign` is at work in {}", path.display());
        };
        let folder = Self { path: path.to_owned(), _lock: lock };
        let asked = |item: &Item| Asked {
            folder: item.experiment.folder.clone(),
            record: item.record.clone(),
        };
        let asked: Vec<Asked> = items.iter().map(asked).collect();
        let before = folder.asked_before()?;
        folder.refuse_other(&before, &asked)?;
        if before.len() < asked.len() {
            write_file(&path.join(FILE), text.as_bytes())?;
            let state = State { schema_version: Manifest::schema_version(), experiments: asked };
            write_whole(&path.join(STATE), &state)?;
        }
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn asked_before(&self) -> anyhow::Result<Vec<Asked>> {
        let path = self.path.join(STATE);
        let state: Option<State> = read_json_if_there(&path, "not what a campaign leaves")?;
        Ok(state.map_or_else(Vec::new, |state| state.experiments))
    }

    /// A campaign may get more experiments at its end; nothing else of it may change.
    fn refuse_other(&self, before: &[Asked], now: &[Asked]) -> anyhow::Result<()> {
        let differs = before
            .iter()
            .enumerate()
            .find(|(index, asked)| !now.get(*index).is_some_and(|now| asked.is_same(now)))
            .map(|(_, asked)| asked.folder.as_str());
        match differs {
            None => Ok(()),
            Some(folder) => Err(with_help(
                format!("{} holds another campaign: {folder} is not the same", self.path.display()),
                format!(
                    "its file is {}; experiments may be added at its end, and other ones need \
                     another folder",
                    self.path.join(FILE).display()
                ),
            )),
        }
    }

    /// The folder of an experiment.
    pub fn of(&self, item: &Item) -> PathBuf {
        self.path.join(&item.experiment.folder)
    }

    /// Whether an experiment has its result, and all of it is as it was: a file that is gone or
    /// changed is an error that names it.
    ///
    /// One whose run was void or could not be judged has none, even if an earlier version, which did
    /// not run it again, took it for finished.
    pub fn is_finished(&self, item: &Item) -> anyhow::Result<bool> {
        let Some(manifest) = self.manifest(item)? else { return Ok(false) };
        manifest.verify(&self.of(item))?;
        Ok(manifest.is_result())
    }

    /// The manifest of an experiment, without a look at its files; `None` if it was never finished.
    pub fn manifest(&self, item: &Item) -> anyhow::Result<Option<Manifest>> {
        let folder = self.of(item);
        let Some(manifest) = Manifest::read(&folder)? else { return Ok(None) };
        if !is_same(&manifest.record, &item.record) {
            bail!("{} is of another experiment", folder.join(MANIFEST).display());
        }
        Ok(Some(manifest))
    }

    /// Finishes an experiment whose bag was closed, though its runner was killed before the end;
    /// `None` if there is none. A recording that broke off is no closed bag.
    pub fn adopt(&self, item: &Item) -> anyhow::Result<Option<Manifest>> {
        let path = self.of(item).join(BAG);
        if !path.join(METADATA).is_file() {
            return Ok(None);
        }
        let Ok(bag) = Bag::open(&path) else { return Ok(None) };
        let (Ok(Some(record)), Ok(Some(ending))) =
            (recorded_run::record_in(&bag), recorded_run::ending_in(&bag))
        else {
            return Ok(None);
        };
        let is_same = is_same(&record, &item.record) && bag.damage().is_empty();
        if !is_same || ending.kind != EndingKind::Completed {
            return Ok(None);
        }
        // One that could not be judged before may be judged now.
        let n_lost = self.manifest(item)?.and_then(|manifest| manifest.n_lost);
        match self.finish(item, record, &ending, n_lost)? {
            Finished::Result(manifest) => Ok(Some(*manifest)),
            Finished::NotJudged(_) => Ok(None),
        }
    }

    /// Labels the bag of a run that was completed, and writes the experiment's manifest if that is its
    /// result.
    pub fn finish(
        &self,
        item: &Item,
        record: ExperimentRecord,
        ending: &Ending,
        n_lost: Option<u64>,
    ) -> anyhow::Result<Finished> {
        let folder = self.of(item);
        let path = folder.join(BAG);
        let bag = recorded_run::open(&path)?;
        let mut parts = vec![BAG];
        let (phase, not_judged) = match label_bag(&path, LabelOptions::default()) {
            Ok(mut labelled) => {
                // The folder may be moved.
                labelled.bag = PathBuf::from(BAG);
                write_json(&folder.join(LABEL), &labelled)?;
                parts.push(LABEL);
                (Some(labelled.phase), String::new())
            }
            Err(error) if record.duration_s >= record.conditions.behaviour.window().least_s() => {
                return Ok(Finished::NotJudged(in_one_line(&error)));
            }
            // Another run would be as short.
            Err(error) => (None, in_one_line(&error)),
        };
        if folder.join(ATTEMPTS).exists() {
            parts.push(ATTEMPTS);
        }
        let attempts = attempts_in(&folder)?;
        let copies: Vec<String> = item_files(&folder)?;
        parts.extend(copies.iter().map(String::as_str));
        let manifest = Manifest {
            schema_version: Manifest::schema_version(),
            name: item.experiment.name.clone(),
            record,
            ending: ending.kind.key().to_owned(),
            reason: ending.reason.clone(),
            phase,
            not_judged,
            n_messages: bag.info().n_messages,
            n_lost,
            gaps: gaps::in_bag(&bag),
            lost_robots: ending.lost.clone(),
            kept_aside: attempts.iter().filter_map(|attempt| attempt.bag.clone()).collect(),
            attempts,
            files: manifest::entries(&folder, &parts)?,
        };
        manifest.write(&folder)?;
        Ok(Finished::Result(Box::new(manifest)))
    }

    /// The runs of an experiment that gave no result.
    pub fn attempts(&self, item: &Item) -> anyhow::Result<Vec<Attempt>> {
        attempts_in(&self.of(item))
    }

    /// Whether the label of a finished experiment is near another one.
    pub fn settledness(&self, item: &Item) -> anyhow::Result<Settledness> {
        let settledness = read_json_if_there(&self.of(item).join(LABEL), "no label")?;
        Ok(settledness.unwrap_or_default())
    }

    /// Keeps what there is of a run that gave no result, returns it, and makes the experiment an
    /// open one. Without an `attempt`, its recording is all that is known of it; `None` if there is
    /// nothing to keep.
    pub fn keep(&self, item: &Item, attempt: Option<Attempt>) -> anyhow::Result<Option<Attempt>> {
        let folder = self.of(item);
        if !folder.exists() {
            return Ok(None);
        }
        // First: with it the experiment is finished, and its bag has to be there.
        let mut attempt = attempt;
        if let Some(manifest) = Manifest::read(&folder)? {
            attempt = attempt.or_else(|| {
                let recorded = Attempt::of_recording(&folder.join(BAG));
                Some(Attempt { reason: manifest.why_no_result(), ..recorded })
            });
            std::fs::remove_file(folder.join(MANIFEST))
                .with_context(|| format!("cannot remove {}", folder.join(MANIFEST).display()))?;
        }
        let label = folder.join(LABEL);
        if label.exists() {
            std::fs::remove_file(&label)
                .with_context(|| format!("cannot remove {}", label.display()))?;
        }
        keep(&folder, attempt)
    }
}

/// The copies of the files behind an experiment.
fn item_files(folder: &Path) -> anyhow::Result<Vec<String>> {
    let mut names = names_in(folder)?;
    names.retain(|name| Path::new(name).extension().is_some_and(|end| end == "yaml"));
    Ok(names)
}

/// Names of what is in a folder, sorted.
pub fn names_in(folder: &Path) -> anyhow::Result<Vec<String>> {
    let list = || -> std::io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in folder.read_dir()? {
            names.push(entry?.file_name().to_string_lossy().into_owned());
        }
        names.sort();
        Ok(names)
    };
    list().with_context(|| format!("cannot list {}", folder.display()))
}

/// Nothing is mixed into a folder that holds something else.
fn refuse_foreign(path: &Path) -> anyhow::Result<()> {
    if !path.exists() || path.join(STATE).exists() {
        return Ok(());
    }
    let ours = |name: &String| name.starts_with("campaign.");
    match names_in(path)?.into_iter().find(|name| !ours(name)) {
        None => Ok(()),
        Some(name) => Err(with_help(
            format!("{} is not the folder of a campaign: it holds {name}", path.display()),
            "give another folder with `-o`",
        )),
    }
}

/// Their list, in the folder of the experiment.
const ATTEMPTS: &str = "attempts.json";

/// The runs of an experiment that gave no result, in the order in which they were made; its bag is
/// in `folder`.
///
/// A recording that was kept aside before its entry was written, or by a version that wrote none,
/// is among them.
pub fn attempts_in(folder: &Path) -> anyhow::Result<Vec<Attempt>> {
    let list = read_json_if_there(&folder.join(ATTEMPTS), "no list of attempts")?;
    let mut attempts: Vec<Attempt> = list.unwrap_or_default();
    if !folder.exists() {
        return Ok(attempts);
    }
    let mut aside: Vec<(u64, String)> = names_in(folder)?
        .into_iter()
        .filter_map(|name| Some((number_aside(BAG, &name)?, name)))
        .filter(|(_, name)| attempts.iter().all(|it| it.bag.as_ref() != Some(name)))
        .collect();
    aside.sort();
    let unlisted = aside.iter().map(|(_, name)| Attempt::of_recording(&folder.join(name)));
    attempts.extend(unlisted);
    Ok(attempts)
}

/// Keeps what there is of a run that gave no result, and returns it: its recording under another
/// name, and what it was in the list. Without an `attempt`, its recording is all that is known of
/// it; `None` if there is nothing to keep.
fn keep(folder: &Path, attempt: Option<Attempt>) -> anyhow::Result<Option<Attempt>> {
    let aside = keep_aside(&folder.join(BAG))?;
    let kept = match (attempt, &aside) {
        (Some(attempt), _) => {
            let name = aside.as_ref().and_then(|aside| aside.file_name());
            Some(Attempt { bag: name.map(|name| name.to_string_lossy().into_owned()), ..attempt })
        }
        (None, Some(aside)) => Some(Attempt::of_recording(aside)),
        (None, None) => None,
    };
    let mut attempts = attempts_in(folder)?;
    if let Some(kept) = &kept {
        attempts.retain(|it| it.bag.is_none() || it.bag != kept.bag);
        attempts.push(kept.clone());
    }
    if !attempts.is_empty() {
        write_whole(&folder.join(ATTEMPTS), &attempts)?;
    }
    Ok(kept)
}
