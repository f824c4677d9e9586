//! What comes before the bag is open, and belongs to its beginning.

use std::collections::VecDeque;

use rsrs_ros::session::ReceivedRaw;

use super::Sample;
use crate::recorded_topics::{RecordedTopic, Role};

/// Messages of each kind that are kept, at most. Latched transforms are fewer; of logs the last ones
/// are of more use than the first.
const MOST_MESSAGES: usize = 10_000;
/// Bytes of each kind that are kept, at most.
const MOST_BYTES: usize = 32 << 20;

/// Messages of these kinds, in the order in which they came.
///
/// They give their places in the queue to the bag back: a node that logs thousands of lines a second
/// while robots are looked for starves no status.
#[derive(Default)]
pub(super) struct Early {
    transforms: Kept,
    preparation: Kept,
}

impl Early {
    /// Keeps a message, if it is of these kinds; what is let go for it is counted with its topic.
    pub(super) fn keep(&mut self, sample: Sample, recorded_topics: &[RecordedTopic]) {
        let kept = match recorded_topics[sample.topic_index].role {
            Role::StaticTransforms => &mut self.transforms,
            Role::Preparation => &mut self.preparation,
            _ => return,
        };
        for let_go in kept.push(sample.topic_index, sample.received) {
            recorded_topics[let_go].count_overflow();
        }
    }

    /// All that was kept.
    pub(super) fn take(&mut self) -> impl Iterator<Item = (usize, ReceivedRaw)> + use<> {
        let Self { transforms, preparation } = std::mem::take(self);
        transforms.messages.into_iter().chain(preparation.messages)
    }
}

#[derive(Default)]
struct Kept {
    messages: VecDeque<(usize, ReceivedRaw)>,
    n_bytes: usize,
}

impl Kept {
    /// Keeps a message, and lists the topics of messages that were let go for it.
    fn push(&mut self, topic: usize, received: ReceivedRaw) -> Vec<usize> {
        self.n_bytes += received.message.len();
        self.messages.push_back((topic, received));
        let mut let_go = Vec::new();
        while self.messages.len() > MOST_MESSAGES || self.n_bytes > MOST_BYTES {
            let Some((topic, received)) = self.messages.pop_front() else { break };
            self.n_bytes -= received.message.len();
            let_go.push(topic);
        }
        let_go
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(sequence: u64, n_bytes: usize) -> ReceivedRaw {
        let (source_time_ns, received_time_ns, writer) = (None, 0, [1; 16]);
        let message = vec![0; n_bytes];
        ReceivedRaw { message, source_time_ns, received_time_ns, sequence, writer }
    }

    #[test]
    fn the_newest_are_kept_and_the_others_are_named() {
        let mut kept = Kept::default();

        let let_go: usize =
            (0..MOST_MESSAGES as u64 + 5).map(|count| kept.push(3, message(count, 10)).len()).sum();
        assert_eq!((let_go, kept.messages[0].1.sequence), (5, 5));

        let let_go = kept.push(4, message(0, MOST_BYTES));
        assert_eq!(let_go.len(), MOST_MESSAGES);
        assert_eq!((kept.messages.len(), kept.n_bytes), (1, MOST_BYTES));
    }
}
