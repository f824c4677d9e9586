//! What a bag says of its run: how it was set up, where it breaks off, and how it ended.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use rsrs_bags::trajectory::{Keep, PoseSource, TrajectoryOptions};
use rsrs_bags::{Bag, Damage};
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord};

use crate::failure::{explained, with_help};
use crate::wording::{count, counted};

/// Recorders hand over what they have every second; a file that did not grow for this long is not
/// recorded any more.
const STILL_GROWING: Duration = Duration::from_secs(5);

/// Opens a bag whose bytes are those that were written.
///
/// # Errors
///
/// If it cannot be read, is no bag, breaks off, or is damaged; the error names it.
pub fn open(path: &Path) -> anyhow::Result<Bag> {
    let bag = open_damaged(path)?;
    let Some(damage) = break_in(&bag) else { return Ok(bag) };
    let name = path.display();
    let recover = format!("save what can be saved: `rsrs bag recover {name}`");
    let help = if is_growing(&bag) {
        format!("wait until it is recorded; if nobody records it any more, {recover}")
    } else {
        recover
    };
    Err(with_help(format!("{name}: {damage}"), help))
}

/// Opens a bag, damaged or not.
///
/// # Errors
///
/// If it cannot be read or is no bag; the error names it.
pub fn open_damaged(path: &Path) -> anyhow::Result<Bag> {
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

/// Where the recording breaks off or is damaged, in words; `None` for a whole bag.
pub fn break_in(bag: &Bag) -> Option<String> {
    let damage = bag.damage();
    let Damage { path, n_messages, last_log_time_ns, at_byte, is_end, reason } = damage.first()?;
    let messages = counted(*n_messages, "message");
    let at = last_log_time_ns.map(|time_ns| format!(", at {:.1} s", time_ns as f64 / 1e9));
    let what = if *is_end { "breaks off" } else { "is damaged" };
    let doubt = if is_growing(bag) { " (or goes on: the file has just grown)" } else { "" };
    let place = if *is_end {
        String::new()
    } else {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        format!(": {file}, byte {}: {reason}", count(*at_byte))
    };
    Some(format!("the recording {what} after {messages}{}{doubt}{place}", at.unwrap_or_default()))
}

/// Whether the file that breaks off may still be recorded.
fn is_growing(bag: &Bag) -> bool {
    let damage = bag.damage();
    let Some(Damage { path, is_end: true, .. }) = damage.first() else { return false };
    let age = path.metadata().ok().and_then(|it| it.modified().ok()?.elapsed().ok());
    age.is_some_and(|age| age < STILL_GROWING)
}

/// What a recovered bag lacks, in words; `None` for any other bag, and for one that lacks nothing.
pub fn lack_in(bag: &Bag) -> Option<String> {
    let recovery = bag.recovery().filter(|recovery| !recovery.is_complete)?;
    let n_lost = recovery.n_messages_lost;
    let lost = match (recovery.is_exact, n_lost) {
        (true, 0) => "no message is missing, but something else".to_owned(),
        (true, n) => format!("{} missing", counted(n, "message")),
        (false, 0) => "nobody knows how many messages are missing".to_owned(),
        (false, n) => format!("at least {} missing", counted(n, "message")),
    };
    Some(format!("recovered from a damaged bag: {lost}"))
}

/// How the trajectory of a run is read.
pub fn trajectory_options(
    record: Option<&ExperimentRecord>,
    poses: Option<PoseSource>,
    keep: Keep,
) -> TrajectoryOptions {
    TrajectoryOptions { poses, keep, run_id: record.map(|record| record.run_id.clone()) }
}
