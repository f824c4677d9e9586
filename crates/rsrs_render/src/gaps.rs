//! What did not get into a bag, in words.

use rsrs_core::numerals::counted;
use rsrs_pipeline::recorded_run::gaps::Gap;

/// A line for all topics that lack the same, and what that means.
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
