//! What one run over ROS 2 came to, in words.

use std::path::Path;

use rsrs_core::judge::window::Window;
use rsrs_core::numerals::counted;
use rsrs_files::quoted;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{Backend, EndingKind, ExperimentRecord};
use rsrs_pipeline::run_summary::RunSummary;

use crate::gaps;
use crate::words::{Tone, Words};

/// What came of a run that was completed or is void, and what comes next; of its `record`, and with the
/// seed that was `given` for it.
pub fn text(summary: &RunSummary, record: &ExperimentRecord, given: Option<u64>) -> Words {
    let bag = summary.bag.as_ref().map_or_else(String::new, |bag| bag.display().to_string());
    let messages = counted(summary.n_messages, "message");
    let mut words =
        Words::from(format!("{bag}: {} s, {messages}{}", summary.duration_s, pace(summary)));
    if summary.ending != EndingKind::Completed {
        let ending = Words::toned(Tone::Bad, summary.ending.key());
        words = words.below(ending.then(format!(": {}", summary.reason)));
    }
    let mut lines: Vec<String> = Vec::new();
    lines.extend(summary.other_profile.iter().map(|differ| format!("note: {differ}")));
    lines.extend(summary.own_profiles.iter().map(|(robot, own)| format!("{robot}: {own}")));
    lines.extend(summary.lost_robots.iter().map(ToString::to_string));
    lines.extend(summary.paused_robots.iter().map(ToString::to_string));
    if summary.n_lost > 0 {
        let lost = counted(summary.n_lost, "message");
        lines.push(format!("{lost} lost on the way to the bag"));
    }
    lines.extend(gaps::lines(&summary.gaps));
    lines.extend(same_again(record, given));
    let judged = record.conditions.behaviour.window();
    lines.extend(summary.bag.as_ref().map(|bag| next(bag, summary.duration_s, judged)));
    lines.into_iter().fold(words, Words::below)
}

/// How fast a run in lockstep went, behind how long it was: `, 31 times real time`; nothing in real time.
pub(crate) fn pace(summary: &RunSummary) -> String {
    let factor = summary.real_time_factor;
    factor.map_or_else(String::new, |factor| format!(", {factor:.0} times real time"))
}

/// Robots that did not report that they stand: `not confirmed to stand, go and look: robot_3`.
pub fn unconfirmed(robots: &[String]) -> Words {
    Words::toned(Tone::Bad, "not confirmed to stand, go and look")
        .then(format!(": {}", robots.join(", ")))
}

/// That another such run is the same one again: in lockstep, of one seed.
fn same_again(record: &ExperimentRecord, given: Option<u64>) -> Option<String> {
    let is_same = record.backend == Backend::Simulator && record.time == Time::Lockstep;
    let seed = record.seed;
    (is_same && given.is_none()).then(|| {
        format!(
            "note: without `--seed` such a run is always this one, of seed {seed}; the next one is \
             another with `--seed {}`",
            seed + 1
        )
    })
}

/// What to look at: a run that is too short for a label can be drawn.
fn next(bag: &Path, duration_s: f64, judged: Window) -> String {
    let least_s = judged.least_s();
    if duration_s >= least_s {
        return format!("next: rsrs label {}", quoted(bag));
    }
    let picture = quoted(bag.with_extension("svg"));
    let why = format!("a label takes {least_s:.0} s or more");
    format!("next: rsrs draw {} -o {picture}   # {why}", quoted(bag))
}

#[cfg(test)]
mod tests {
    use rsrs_fleet::experiment::RobotLost;
    use rsrs_testing::conditions::flockbot_conditions;
    use rsrs_testing::record::fleet_record;

    use super::*;

    #[test]
    fn that_a_run_without_a_seed_would_be_the_same_again_is_said_in_the_simulator() {
        let fleet = ExperimentRecord {
            robot_lost: RobotLost::Note,
            ..fleet_record("0", flockbot_conditions())
        };
        let simulated = ExperimentRecord {
            backend: Backend::Simulator,
            time: Time::Lockstep,
            seed: 4,
            ..fleet.clone()
        };

        let said = same_again(&simulated, None).expect("it would be the same");
        assert!(said.ends_with("`--seed 5`"), "{said}");
        assert_eq!(same_again(&simulated, Some(4)), None);
        assert_eq!(same_again(&fleet, None), None);
    }

    #[test]
    fn messages_are_counted_as_those_of_a_bag_are() {
        let record = fleet_record("0", flockbot_conditions());
        let printed = |n_messages| {
            let summary = RunSummary { n_messages, ..RunSummary::new(&record) };
            text(&summary, &record, None).to_string()
        };

        assert_eq!(printed(71_384), ": 300 s, 71,384 messages");
        assert_eq!(printed(1), ": 300 s, 1 message");
    }
}
