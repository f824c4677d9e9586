//! What a bag says of its run: how it was set up, where it breaks off, and how it ended.

use std::path::Path;

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord};

use crate::failure::explained;

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
    let n_messages = first.n_messages;
    Some(match first.last_log_time_ns {
        Some(time_ns) => {
            let time_s = time_ns as f64 / 1e9;
            format!("the recording breaks off after {n_messages} messages, at {time_s:.1} s")
        }
        None => format!("the recording breaks off after {n_messages} messages"),
    })
}
