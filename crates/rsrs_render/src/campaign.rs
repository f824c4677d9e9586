//! What a campaign has come to, in words.

use rsrs_core::numerals::{count, counted};
use rsrs_fleet::record::EndingKind;
use rsrs_pipeline::attempt::{BROKEN_OFF, NOT_JUDGED};
use rsrs_pipeline::campaign::{Replaced, Row, Summary};

use crate::columns::toned_columns;
use crate::gaps;
use crate::label::marked;
use crate::words::{Tone, Words};

/// The experiments as a table, and what comes next.
pub fn text(summary: &Summary) -> Words {
    let [first, second] = if summary.experiments.iter().any(|row| row.speed_m_s.is_some()) {
        ["m/s", "rad/s"]
    } else {
        ["controller", ""]
    };
    let head =
        ["experiment", first, second, "robots", "lost", "seed", "ended", "label", "messages"];
    let mut rows = vec![head.map(Words::from)];
    rows.extend(summary.experiments.iter().map(cells));
    let mut lines: Vec<String> = summary.experiments.iter().flat_map(notes).collect();
    lines.extend(replaced(&summary.experiments));
    lines.push(format!(
        "{} of {} experiments are finished, in {}",
        summary.n_finished,
        summary.experiments.len(),
        summary.folder.display()
    ));
    lines.push(format!("next: {}", summary.next));
    lines.into_iter().fold(toned_columns(&rows), Words::below)
}

fn cells(row: &Row) -> [Words; 9] {
    let phase = row.phase.map(|phase| marked(phase.to_string(), row.settledness));
    let seed = match row.replicate {
        0 => row.seed.to_string(),
        replicate => format!("{} #{replicate}", row.seed),
    };
    let n_messages = row.bag.as_ref().map_or_else(|| "-".to_owned(), |_| count(row.n_messages));
    [
        (&row.experiment).into(),
        row.speed_m_s.map_or_else(|| numbers(row), |speed| speed.to_string()).into(),
        row.turn_rate_rad_s.map_or_else(String::new, |turn| turn.to_string()).into(),
        row.n_robots.to_string().into(),
        row.lost_robots.len().to_string().into(),
        seed.into(),
        ended(row),
        phase.unwrap_or_else(|| "-".into()),
        n_messages.into(),
    ]
}

/// `leave 0.02, stay 0.05`.
fn numbers(row: &Row) -> String {
    let numbers = row.numbers.iter().map(|(name, value)| format!("{name} {value}"));
    let numbers: Vec<String> = numbers.collect();
    if numbers.is_empty() { "a table".to_owned() } else { numbers.join(", ") }
}

/// How its last run ended, in a word or two.
fn ended(row: &Row) -> Words {
    let ending = match row.ending.as_deref() {
        None => "not run",
        Some("completed") if !row.is_finished => "not judged",
        Some(BROKEN_OFF) => "broken off",
        Some(ending) => ending,
    };
    let tone = match EndingKind::from_key(ending) {
        Some(EndingKind::Completed) => Tone::Good,
        Some(_) => Tone::Bad,
        None => Tone::Unclear,
    };
    Words::toned(tone, ending)
}

/// What there is to state of it under the table.
fn notes(row: &Row) -> Vec<String> {
    let mut notes = Vec::new();
    for (attempt, number) in row.attempts.iter().zip(1..) {
        let kept = attempt.bag.as_ref().map(|bag| format!("; kept as {bag}"));
        notes.push(format!("attempt {number}: {attempt}{}", kept.unwrap_or_default()));
    }
    let is_told = row.attempts.last().is_some_and(|last| last.reason == row.reason);
    if !row.reason.is_empty() && !is_told {
        notes.push(row.reason.clone());
    }
    if !row.not_judged.is_empty() {
        notes.push(format!("{NOT_JUDGED}{}", row.not_judged));
    }
    if let Some(n_lost @ 1..) = row.n_lost {
        notes.push(format!("{} lost on the way to the bag", counted(n_lost, "message")));
    }
    let counts = if row.counts { "; it counts" } else { "; it does not count" };
    notes.extend(row.lost_robots.iter().map(|lost| format!("{lost}{counts}")));
    notes.extend(gaps::lines(&row.gaps));
    notes.iter().map(|note| format!("{}: {note}", row.experiment)).collect()
}

/// Which experiments were run with robots that have been replaced since; those in a row together.
fn replaced(rows: &[Row]) -> Vec<String> {
    let runs = rows.chunk_by(|row, next| row.replaced == next.replaced);
    let line = |run: &[Row]| {
        let [first, ..] = run else { return None };
        let Replaced { gone, new } = first.replaced.as_ref()?;
        let last = &run[run.len() - 1].experiment;
        let first = &first.experiment;
        let which = if first == last { first.clone() } else { format!("{first} to {last}") };
        let (gone, new) = (gone.join(", "), new.join(", "));
        Some(format!("{which}: run with {gone}, in whose place the fleet file has {new} now"))
    };
    runs.filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use rsrs_core::judge::phase::Phase;
    use rsrs_fleet::record::LostRobot;
    use rsrs_pipeline::attempt::Attempt;

    use super::*;

    fn row(experiment: &str, label: &str) -> Row {
        Row {
            experiment: experiment.to_owned(),
            speed_m_s: Some(0.15),
            turn_rate_rad_s: Some(0.75),
            numbers: std::collections::BTreeMap::new(),
            n_robots: 9,
            seed: 1,
            replicate: 0,
            robots: vec!["robot_1".to_owned(), "robot_3".to_owned()],
            is_finished: true,
            ending: Some("completed".to_owned()),
            reason: String::new(),
            phase: Some(Phase::STABLE_MILLING),
            settledness: serde_json::from_str(label).expect("it is a label"),
            not_judged: String::new(),
            n_messages: 1234,
            n_lost: Some(0),
            gaps: Vec::new(),
            lost_robots: Vec::new(),
            counts: true,
            attempts: Vec::new(),
            replaced: None,
            bag: Some(PathBuf::from("bag")),
        }
    }

    fn summary(experiments: Vec<Row>) -> Summary {
        let n_finished = experiments.iter().filter(|row| row.is_finished).count();
        let next = "rsrs compare sweep --bags results/*/bag".to_owned();
        Summary { folder: PathBuf::from("results"), n_finished, experiments, next }
    }

    const SURE: &str = r#"{"phase": "stable_milling", "is_settled": true}"#;

    fn lost() -> Vec<LostRobot> {
        let (robot, reason) = ("robot_1".to_owned(), "silent for more than 1 s".to_owned());
        vec![LostRobot { robot, after_s: 61.2, reason }]
    }

    #[test]
    fn a_robot_that_was_lost_is_in_the_table_and_such_a_campaign_is_not_whole() {
        let without = Row { lost_robots: lost(), counts: false, ..row("001_lost", SURE) };
        let short_handed = summary(vec![without, row("002_whole", SURE)]);

        let table = text(&short_handed).to_string();
        let rows: Vec<&str> = table.lines().collect();
        assert!(rows[0].contains(" robots  lost  seed "), "{table}");
        let columns: Vec<&str> = rows[1].split_whitespace().collect();
        assert_eq!(columns[..6], ["001_lost", "0.15", "0.75", "9", "1", "1"], "{table}");
        let note =
            "001_lost: robot_1 lost after 61.2 s: silent for more than 1 s; it does not count";
        assert!(rows.contains(&note), "{table}");
        assert!(!short_handed.is_whole());

        let counts = Row { lost_robots: lost(), ..row("001_lost", SURE) };
        assert!(summary(vec![counts]).is_whole(), "its rule was fixed beforehand");
    }

    #[test]
    fn every_attempt_stays_in_the_summary_with_its_cause_and_its_recording() {
        let attempt = |ending: &str, reason: &str, bag: Option<&str>| Attempt {
            run_id: "run".to_owned(),
            robots: Vec::new(),
            ending: ending.to_owned(),
            reason: reason.to_owned(),
            has_started: bag.is_some(),
            lost_robots: Vec::new(),
            bag: bag.map(str::to_owned),
        };
        let open = Row {
            attempts: vec![
                attempt("failed", "robot_3: did not arm: silent", None),
                attempt("void", "frozen for 5 s", Some("bag.unfinished_1")),
            ],
            is_finished: false,
            ending: Some("void".to_owned()),
            reason: "frozen for 5 s".to_owned(),
            phase: None,
            bag: None,
            ..row("001_open", "{}")
        };
        let summary = summary(vec![open]);

        let table = text(&summary).to_string();
        for line in [
            "001_open: attempt 1: failed: robot_3: did not arm: silent",
            "001_open: attempt 2: void: frozen for 5 s; kept as bag.unfinished_1",
            "0 of 1 experiments are finished, in results",
        ] {
            assert!(table.lines().any(|it| it == line), "{line}: {table}");
        }
        assert_eq!(table.matches("frozen").count(), 1, "{table}");
        assert!(!summary.is_whole());
    }

    #[test]
    fn robots_that_were_replaced_are_named_with_the_experiments_that_they_took_part_in() {
        let all = |names: [&str; 2]| names.map(str::to_owned);
        let replaced =
            Replaced::between(&all(["robot_1", "robot_3"]), &all(["robot_8", "robot_1"]));
        assert_eq!(Replaced::between(&all(["a", "b"]), &all(["b", "a"])), None, "another order");
        let before = |name: &str| Row {
            replaced: Replaced::between(&all(["robot_1", "robot_3"]), &all(["robot_8", "robot_1"])),
            ..row(name, SURE)
        };
        assert!(replaced.is_some());

        let summary = summary(vec![before("001_a"), before("002_a"), row("003_a", SURE)]);
        let table = text(&summary).to_string();

        let line =
            "001_a to 002_a: run with robot_3, in whose place the fleet file has robot_8 now";
        assert!(table.lines().any(|it| it == line), "{table}");
    }

    #[test]
    fn a_label_near_another_one_is_marked_in_the_table() {
        let summary = summary(vec![
            row("001_sure", SURE),
            row("002_near", r#"{"phase": "stable_milling", "is_settled": false}"#),
            row("003_by_ana", r#"{"phase": "stable_milling"}"#),
        ]);

        let table = text(&summary).to_string();
        let rows: Vec<&str> = table.lines().skip(1).take(3).collect();
        assert!(rows[1].contains(" stable milling (not settled: look again)  1,234"), "{table}");
        assert!(!rows[0].contains("look again") && !rows[2].contains("look again"), "{table}");
    }
}
