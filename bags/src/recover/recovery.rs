//! The record of a recovery in the bag that it made.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::Bag;

/// The record in a recovered bag of where it came from.
pub const RECORD: &str = "rsrs.recovered";

/// Whether everything that was recorded is in it.
pub const IS_COMPLETE: &str = "is_complete";

/// Messages that are not, as far as can be determined.
pub const N_MESSAGES_LOST: &str = "n_messages_lost";

/// Whether these are all of them.
pub const IS_EXACT: &str = "is_exact";

/// Whether the end of a file is missing.
pub const LACKS_END: &str = "lacks_end";

/// What the name of a loss starts with.
pub const LOSS: &str = "loss_";

/// What a recovered bag lacks of the one that was damaged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// Whether everything that was recorded is in it.
    pub is_complete: bool,
    /// Messages that are not, as far as can be determined.
    pub n_messages_lost: u64,
    /// Whether these are all of them; else there may be more.
    pub is_exact: bool,
    /// Whether the end of a file is missing, and with it perhaps that of the run.
    pub lacks_end: bool,
    /// What could not be saved, in words.
    pub losses: Vec<String>,
}

impl Bag {
    /// What the bag lacks, if it was recovered from a damaged one; `None` for any other bag.
    ///
    /// A bag that was recovered twice lacks what was lost either time.
    pub fn recovery(&self) -> Option<Recovery> {
        let records = self.files().iter().flat_map(|file| &file.metadata);
        let recoveries = records.filter(|record| record.name == RECORD);
        recoveries.map(|record| read(&record.metadata)).reduce(|mut all, another| {
            all.is_complete &= another.is_complete;
            all.n_messages_lost += another.n_messages_lost;
            all.is_exact &= another.is_exact;
            all.lacks_end |= another.lacks_end;
            all.losses.extend(another.losses);
            all
        })
    }
}

/// Reads a record back; what is not in it counts as lost.
fn read(pairs: &BTreeMap<String, String>) -> Recovery {
    let is = |key: &str| pairs.get(key).is_some_and(|text| text == "true");
    let losses = pairs.iter().filter(|(key, _)| key.starts_with(LOSS));
    Recovery {
        is_complete: is(IS_COMPLETE),
        n_messages_lost: pairs.get(N_MESSAGES_LOST).and_then(|n| n.parse().ok()).unwrap_or(0),
        is_exact: is(IS_EXACT),
        lacks_end: is(LACKS_END),
        losses: losses.map(|(_, text)| text.clone()).collect(),
    }
}
