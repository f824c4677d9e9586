//! What did not get into the bag, by topic.

use std::collections::BTreeMap;

use rsrs_msgs::topics::Reliability;

use crate::recorded_topics::RecordedTopic;

/// What did not get into the bag.
pub struct Account {
    recorded_topics: Vec<RecordedTopic>,
    /// The last count of each publisher, by topic and publisher.
    last: BTreeMap<(usize, [u8; 16]), u64>,
    /// Samples missing between two of one publisher, by topic.
    gaps: BTreeMap<usize, u64>,
}

impl Account {
    /// Starts to count; what was let go on these topics is read at the end.
    pub fn new(recorded_topics: &[RecordedTopic]) -> Self {
        Self {
            recorded_topics: recorded_topics.to_vec(),
            last: BTreeMap::new(),
            gaps: BTreeMap::new(),
        }
    }

    /// Takes a publisher's count of a sample that was recorded; its source is the index of the
    /// topic, and the publisher.
    pub fn add(&mut self, source: (usize, [u8; 16]), sequence: u64) {
        let Some(last) = self.last.insert(source, sequence) else { return };
        let n_missing = sequence.saturating_sub(last.saturating_add(1));
        if n_missing > 0 {
            *self.gaps.entry(source.0).or_default() += n_missing;
        }
    }

    /// Samples missing on reliable topics.
    pub fn n_missing_of_reliable(&self) -> u64 {
        let is_reliable = |index: usize| {
            self.recorded_topics.get(index).is_some_and(|recorded_topic| {
                recorded_topic.qos.reliability == Reliability::Reliable
            })
        };
        self.gaps.iter().filter(|(index, _)| is_reliable(**index)).map(|(_, missing)| missing).sum()
    }

    /// Pairs for the bag: sums, and each topic of which something is missing.
    ///
    /// `n_missing` counts samples that publishers sent between two that were recorded, for whatever
    /// reason; `n_overflowed` those of them that came and found the queue to the bag full, with those
    /// before the first and after the last that was recorded.
    pub fn to_pairs(&self) -> BTreeMap<String, String> {
        let n_missing: u64 = self.gaps.values().sum();
        let n_overflowed: u64 = self.recorded_topics.iter().map(RecordedTopic::n_overflowed).sum();
        let mut pairs = BTreeMap::from([
            ("n_missing".to_owned(), n_missing.to_string()),
            ("n_overflowed".to_owned(), n_overflowed.to_string()),
        ]);
        for (index, recorded_topic) in self.recorded_topics.iter().enumerate() {
            if let Some(n_missing) = self.gaps.get(&index) {
                pairs.insert(format!("n_missing {}", recorded_topic.name), n_missing.to_string());
            }
            if recorded_topic.n_overflowed() > 0 {
                let n_overflowed = recorded_topic.n_overflowed().to_string();
                pairs.insert(format!("n_overflowed {}", recorded_topic.name), n_overflowed);
            }
        }
        pairs
    }
}
