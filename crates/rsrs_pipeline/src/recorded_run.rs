//! The record of a run in its bag: how it was set up, where it breaks off, and how it ended.

mod damage;
pub mod gaps;
mod poses;

use std::path::Path;

use anyhow::Context;
use rsrs_bags::{Bag, BagError, TopicInfo};
use rsrs_core::numerals::{counted, size};
use rsrs_files::quoted;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord};
use rsrs_msgs::cdr;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs;
use rsrs_msgs::topics::{self, Topic};

pub use self::damage::{BrokenRecording, DamagedPlace, LossyRecovery};
pub use self::poses::{PosesBy, PosesOfRun};
use crate::error::{helped, with_help};

/// Opens a bag whose bytes are those that were written: one that breaks off or is damaged is
/// refused, by name.
pub fn open(path: &Path) -> anyhow::Result<Bag> {
    let bag = open_damaged(path)?;
    let Some(broken) = BrokenRecording::in_bag(&bag) else { return Ok(bag) };
    let name = path.display();
    let recover = format!("save what can be saved: `rsrs bag recover {}`", quoted(path));
    let help = if broken.is_growing {
        format!("wait until it is recorded; if nobody records it any more, {recover}")
    } else {
        recover
    };
    Err(with_help(format!("{name}: {broken}"), help))
}

/// Opens a bag, damaged or not.
pub fn open_damaged(path: &Path) -> anyhow::Result<Bag> {
    let bag = Bag::open(path).map_err(helped)?;
    let info = bag.info();
    let n_messages = counted(info.n_messages, "message");
    log::info!("opened {}: {n_messages}, {}", path.display(), size(info.n_bytes));
    Ok(bag)
}

/// The record of the run: `None` in a bag that no runner of ours has made.
pub fn record_in(bag: &Bag) -> anyhow::Result<Option<ExperimentRecord>> {
    let Some(attachment) = bag.attachment(ATTACHMENT) else {
        return record_on_topic(bag);
    };
    let what = || format!("{}: its record, {ATTACHMENT}, does not read", bag.path().display());
    let text = std::str::from_utf8(&attachment.data).with_context(what)?;
    Ok(Some(ExperimentRecord::from_json(text).with_context(what)?))
}

/// The record of the first run that is in a bag without attachments, as converters leave it.
fn record_on_topic(bag: &Bag) -> anyhow::Result<Option<ExperimentRecord>> {
    let what = || format!("{}: {} does not read", bag.path().display(), topics::EXPERIMENT.name);
    let text = texts_on(bag, &topics::EXPERIMENT)?.into_iter().next();
    let record = text.map(|text| ExperimentRecord::from_json(&text).with_context(what));
    record.transpose()
}

/// The ending of a run, by id, in a bag without metadata.
fn ending_on_topic(bag: &Bag) -> anyhow::Result<Option<Ending>> {
    let what = || format!("{}: {}", bag.path().display(), topics::ENDING.name);
    let run_id = record_in(bag)?.map(|record| record.run_id);
    for text in texts_on(bag, &topics::ENDING)? {
        let (ending, of) = Ending::from_json(&text).with_context(what)?;
        if run_id.as_ref().is_none_or(|run_id| *run_id == of) {
            return Ok(Some(ending));
        }
    }
    Ok(None)
}

/// The texts on a topic, up to where the recording breaks off.
fn texts_on(bag: &Bag, topic: &Topic) -> anyhow::Result<Vec<String>> {
    let is_there = |found: &TopicInfo| found.name == topic.name && found.n_messages > 0;
    if !bag.topics().iter().any(is_there) {
        return Ok(Vec::new());
    }
    let mut texts = Vec::new();
    for message in bag.messages_on([topic.name]) {
        let message = match message {
            Err(BagError::Incomplete { .. }) => break,
            message => message?,
        };
        let what = || format!("{}: {} is no text", bag.path().display(), topic.name);
        texts.push(cdr::decode::<std_msgs::String>(&message.bytes).with_context(what)?.data);
    }
    Ok(texts)
}

/// How the run ended: `None` if the recorder was killed before its end.
pub fn ending_in(bag: &Bag) -> anyhow::Result<Option<Ending>> {
    let Some(pairs) = bag.metadata(ENDING) else {
        return ending_on_topic(bag);
    };
    let ending = Ending::from_pairs(pairs).with_context(|| {
        format!("{}: its metadata {ENDING} has {pairs:?}, which is no ending", bag.path().display())
    })?;
    Ok(Some(ending))
}

/// Whether the robots were allowed to move, as far as it was recorded.
pub fn has_started(bag: &Bag) -> bool {
    let leases = bag.messages_on([topics::LEASE.name]).map_while(Result::ok);
    let mut leases = leases.filter_map(|message| cdr::decode::<RunLease>(&message.bytes).ok());
    leases.any(|lease| lease.state == LeaseState::Running)
}
