//! What stays of the runs of an experiment that gave no result, in its folder.

use std::path::Path;

use super::folder::{BAG, names_in};
use super::manifest::write_whole;
use crate::attempt::{Attempt, keep_aside, number_aside};
use crate::files::read_json_if_there;

/// Their list, in the folder of the experiment.
pub const ATTEMPTS: &str = "attempts.json";

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
pub fn keep(folder: &Path, attempt: Option<Attempt>) -> anyhow::Result<Option<Attempt>> {
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
