//! What did not get into a bag, by topic, as its recorder counted it.

use rsrs_bags::Bag;
use rsrs_fleet::record::RECORDING;
use serde::{Deserialize, Serialize};

/// What is missing of one topic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// The topic.
    pub topic: String,
    /// Samples that its publishers sent between two that were recorded.
    pub n_missing: u64,
    /// Samples that came and found the queue to the bag full.
    pub n_overflowed: u64,
}

/// What is missing in a bag; nothing in one whose recorder was killed before its end.
pub fn in_bag(bag: &Bag) -> Vec<Gap> {
    let Some(pairs) = bag.metadata(RECORDING) else { return Vec::new() };
    let mut gaps: Vec<Gap> = Vec::new();
    for (key, text) in pairs {
        let Some((what, topic)) = key.split_once(' ') else { continue };
        let Ok(n) = text.parse::<u64>() else { continue };
        let index = gaps.iter().position(|gap| gap.topic == topic).unwrap_or_else(|| {
            gaps.push(Gap { topic: topic.to_owned(), n_missing: 0, n_overflowed: 0 });
            gaps.len() - 1
        });
        match what {
            "n_missing" => gaps[index].n_missing = n,
            "n_overflowed" => gaps[index].n_overflowed = n,
            _ => {}
        }
    }
    gaps
}
