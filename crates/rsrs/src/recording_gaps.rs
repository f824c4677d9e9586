//! What did not get into a bag, by topic, as its recorder counted it.

use rsrs_bags::Bag;
use rsrs_experiment_runner::RECORDING;
use serde::{Deserialize, Serialize};

use crate::wording::counted;

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

/// What is missing in a bag; nothing in one whose recorder did not live to say so.
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

/// The same for a person, a line for each topic.
pub fn lines(gaps: &[Gap]) -> Vec<String> {
    let line = |gap: &Gap| {
        let Gap { topic, n_missing, n_overflowed } = gap;
        let mut parts = Vec::new();
        if *n_missing > 0 {
            parts.push(format!("{} missing between recorded ones", counted(*n_missing, "sample")));
        }
        if *n_overflowed > 0 {
            let samples = counted(*n_overflowed, "sample");
            parts.push(format!("{samples} let go because the queue to the bag was full"));
        }
        format!("{topic}: {}", parts.join(", "))
    };
    gaps.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_by_topic() {
        let gaps = [
            Gap { topic: "/robot_1/odom".to_owned(), n_missing: 1, n_overflowed: 0 },
            Gap { topic: "/camera".to_owned(), n_missing: 2_000, n_overflowed: 7 },
        ];

        let lines = lines(&gaps);

        assert_eq!(
            lines,
            [
                "/robot_1/odom: 1 sample missing between recorded ones",
                "/camera: 2,000 samples missing between recorded ones, 7 samples let go because the \
                 queue to the bag was full",
            ]
        );
    }
}
