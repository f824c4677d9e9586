//! What a bag says of its run: how it was set up, where it breaks off, and how it ended.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord};

use crate::failure::explained;
use crate::wording::counted;

/// Recorders hand over what they have every second; a file that did not grow for this long is not
/// recorded any more.
const STILL_GROWING: Duration = Duration::from_secs(5);

/// Opens a bag.
///
/// # Errors
///
/// If it cannot be read or is no bag; the error names it.
pub fn open(path: &Path) -> anyhow::Result<Bag> {
    Bag::open(path).map_err(|error| {
        let (message, help) = (error.to_string(), error.help());
        explained(error, message, help)
    })
}

/// The record of the run: `None` in a bag that no runner of ours has made.
///
/// # Errors
///
/// If there is one that does not read; the error names the bag.
pub fn record_in(bag: &Bag) -> anyhow::Result<Option<ExperimentRecord>> {
    let Some(attachment) = bag.attachment(ATTACHMENT) else {
        return Ok(None);
    };
    let what = || format!("{}: its record, {ATTACHMENT}, does not read", bag.path().display());
    let text = std::str::from_utf8(&attachment.data).with_context(what)?;
    Ok(Some(ExperimentRecord::from_json(text).with_context(what)?))
}

/// How the run ended: `None` if the recorder did not live to say it.
///
/// # Errors
///
/// If what it says is no ending; the error names the bag.
pub fn ending_in(bag: &Bag) -> anyhow::Result<Option<Ending>> {
    let Some(pairs) = bag.metadata(ENDING) else {
        return Ok(None);
    };
    let ending = Ending::from_pairs(pairs).with_context(|| {
        format!(
            "{}: its metadata {ENDING} says {pairs:?}, which is no ending",
            bag.path().display()
        )
    })?;
    Ok(Some(ending))
}

/// Where the recording breaks off, in words; `None` for a whole bag.
pub fn break_in(bag: &Bag) -> Option<String> {
    let damage = bag.damage();
    let first = damage.first()?;
    let messages = counted(first.n_messages, "message");
    let at = first.last_log_time_ns.map(|time_ns| format!(", at {:.1} s", time_ns as f64 / 1e9));
    let age = first.path.metadata().ok().and_then(|it| it.modified().ok()?.elapsed().ok());
    let is_fresh = age.is_some_and(|age| age < STILL_GROWING);
    let doubt = if is_fresh { " (or goes on: the file has just grown)" } else { "" };
    Some(format!("the recording breaks off after {messages}{}{doubt}", at.unwrap_or_default()))
}
