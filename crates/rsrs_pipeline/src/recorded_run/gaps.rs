//! What did not get into a bag, by topic, as its recorder counted it.

use rsrs_bags::Bag;
use rsrs_fleet::record::RECORDING;
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

/// The same for a person: a line for all topics that lack the same, and what that means.
pub fn lines(gaps: &[Gap]) -> Vec<String> {
    let mut groups: Vec<Vec<&Gap>> = Vec::new();
    for gap in gaps {
        let same = groups.iter_mut().find(|group| {
            (group[0].n_missing, group[0].n_overflowed) == (gap.n_missing, gap.n_overflowed)
        });
        match same {
            Some(group) => group.push(gap),
            None => groups.push(vec![gap]),
        }
    }
    let is_missing = gaps.iter().any(|gap| gap.n_missing > 0);
    let meaning = is_missing.then(|| HARMLESS.to_owned());
    groups.iter().map(|group| line(group)).chain(meaning).collect()
}

/// What samples that were lost on their way mean.
const HARMLESS: &str =
    "samples that are missing are harmless, unless `rsrs label` refuses the run for them";

/// What topics lack, each as much as the first one.
fn line(group: &[&Gap]) -> String {
    let Gap { topic, n_missing, n_overflowed } = group[0];
    let each = if group.len() > 1 { " on each" } else { "" };
    let mut parts = Vec::new();
    if *n_missing > 0 {
        let samples = counted(*n_missing, "sample");
        parts.push(format!("{samples} missing between recorded ones{each}"));
    }
    if *n_overflowed > 0 {
        let samples = counted(*n_overflowed, "sample");
        parts.push(format!("{samples} let go because the queue to the bag was full{each}"));
    }
    let topics = match group.len() - 1 {
        0 => topic.clone(),
        1 => format!("{topic} and {}", group[1].topic),
        n => format!("{topic} and {n} other topics"),
    };
    format!("{topics}: {}", parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_reported_by_topic() {
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
                HARMLESS,
            ]
        );
    }

    #[test]
    fn topics_that_lack_the_same_share_a_line() {
        let gap = |robot: u32| Gap {
            topic: format!("/robot_{robot}/robot_status"),
            n_missing: 1,
            n_overflowed: 0,
        };
        let nine: Vec<Gap> = (1..=9).map(gap).collect();
        let two = [gap(1), gap(2)];

        assert_eq!(
            lines(&nine),
            [
                "/robot_1/robot_status and 8 other topics: 1 sample missing between recorded ones on each",
                HARMLESS,
            ]
        );
        assert_eq!(
            lines(&two),
            [
                "/robot_1/robot_status and /robot_2/robot_status: 1 sample missing between recorded \
              ones on each",
                HARMLESS
            ]
        );
    }
}
