//! The judge on recordings that are worse than the simulator's: a tracker that misses, is late, and
//! is never quite right.

mod tracker;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use rsrs_bags::Bag;
use rsrs_bags::trajectory::{TrajectoryOptions, read_trajectory};
use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::environment::{is_long, or_if_long};

use crate::cells::{CELLS, conditions};
use tracker::Tracker;

/// Long enough to settle.
const DURATION_S: f64 = 180.0;

/// What the tracker sees of it: the judge looks at the last 60 s.
const SEEN_S: f64 = 62.0;

/// What became of the episodes that one tracker saw.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    n: usize,
    n_settled: usize,
    n_changed: usize,
}

impl Tally {
    fn add(&mut self, (is_settled, is_same): (bool, bool)) {
        self.n += 1;
        self.n_settled += usize::from(is_settled);
        self.n_changed += usize::from(is_settled && !is_same);
    }

    fn plus(self, other: Self) -> Self {
        Self {
            n: self.n + other.n,
            n_settled: self.n_settled + other.n_settled,
            n_changed: self.n_changed + other.n_changed,
        }
    }

    fn share_kept(self) -> f64 {
        1.0 - self.n_changed as f64 / self.n_settled.max(1) as f64
    }
}

/// The end of an episode.
fn episode(conditions: &Conditions, replicate: u64) -> Trajectory {
    let seed = Seed { seed: 23, replicate };
    let mut episode = run_episode(conditions, seed, DURATION_S).expect("the robots fit");
    let n_seen = tracker::whole(SEEN_S / episode.period_s) * episode.n_robots;
    let n_before = episode.poses.len() - n_seen;
    episode.poses.drain(..n_before);
    episode.commands.drain(..n_before);
    episode
}

/// The phase of an episode, whether it is settled, and whether the tracker leaves its label as it is.
fn seen_by(tracker: Tracker, folder: &Path, index: usize) -> (Phase, bool, bool) {
    let conditions = conditions(CELLS[index % CELLS.len()]);
    let episode = episode(&conditions, (index / CELLS.len()) as u64);
    let bodies = conditions.bodies();
    let verdict = label(&episode, &bodies).expect("it is long enough");
    let certainty = Certainty::new(&verdict, &Behaviour::MILLING.rules());
    let bag = folder.join(index.to_string());
    tracker.record(&bag, &episode, index as u64);
    let opened = Bag::open(&bag).expect("it is a bag");
    let recorded = read_trajectory(&opened, &TrajectoryOptions::default())
        .unwrap_or_else(|error| panic!("{tracker:?}, {}: {error}", bag.display()));
    std::fs::remove_dir_all(&bag).expect("it is ours");
    let found = label(&recorded.trajectory, &bodies).expect("it is long enough");
    (verdict.phase, certainty.is_settled, found.phase == verdict.phase)
}

#[test]
#[expect(clippy::print_stdout, reason = "the rates are what this is about")]
fn a_tracker_leaves_at_least_98_of_100_settled_labels_as_they_are() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let n_episodes = or_if_long(200, 2000);
    let next = Mutex::new(0..n_episodes);
    let tallies = Mutex::new(BTreeMap::<Tracker, Tally>::new());
    let phases = Mutex::new(BTreeMap::<Phase, usize>::new());

    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(index) = next.lock().expect("no panic").next() else { return };
                    // Trackers and cells must not go round in step.
                    let tracker = Tracker::ALL[index / CELLS.len() % Tracker::ALL.len()];
                    let (phase, is_settled, is_same) = seen_by(tracker, folder.path(), index);
                    *phases.lock().expect("no panic").entry(phase).or_default() += 1;
                    let mut tallies = tallies.lock().expect("no panic");
                    tallies.entry(tracker).or_default().add((is_settled, is_same));
                }
            });
        }
    });

    let tallies = tallies.into_inner().expect("no panic");
    for (tracker, tally) in &tallies {
        println!("{tracker:?}: {tally:?}, {:.3} kept", tally.share_kept());
    }
    let all = tallies.values().fold(Tally::default(), |sum, tally| sum.plus(*tally));
    let unsettled = 1.0 - all.n_settled as f64 / all.n as f64;
    println!("all: {all:?}, {:.3} kept, {unsettled:.3} unsettled", all.share_kept());
    let phases = phases.into_inner().expect("no panic");
    println!("{phases:?}");
    assert_eq!(
        phases.len(),
        Behaviour::MILLING.phases().len(),
        "every phase should occur: {phases:?}"
    );
    assert!(all.share_kept() >= 0.98, "{:.3} of settled labels are kept", all.share_kept());
    assert!(unsettled <= 0.2, "{unsettled:.3} of the episodes are unsettled");
    if is_long() {
        for (tracker, tally) in tallies {
            assert!(tally.share_kept() >= 0.98, "{tracker:?}: {:.3} are kept", tally.share_kept());
        }
    }
}

/// Rows of the table of `docs/judge_by_eye.md` about the labels of others, from the phases of their runs.
#[test]
fn what_the_judges_say_of_the_labels_of_others_is_counted() {
    let page = crate::pages::text_of("docs/judge_by_eye.md");
    let found = crate::pages::text_of("docs/judge_by_others.csv");
    let rows: Vec<Vec<&str>> =
        found.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(rows.len() > 1000, "{} rows", rows.len());

    for label in ["aggregation", "dispersal", "cyclic", "milling", "wall-following", "random"] {
        let count = |ticks: &str, behaviour: &str, reach_m: &str, phase: Option<&str>| {
            let is_one = |row: &&Vec<&str>| {
                (row[0], row[3], row[4], row[5]) == (label, ticks, behaviour, reach_m)
                    && phase.is_none_or(|phase| row[6] == phase)
            };
            rows.iter().filter(is_one).count()
        };
        let gathered = |ticks| count(ticks, "aggregation", "0.75", Some("aggregated"));
        let runs = count("1200", "aggregation", "0.75", None);
        let mut cells = vec![label.to_owned(), runs.to_string(), gathered("1200").to_string()];
        let long = count("3600", "aggregation", "0.75", None);
        cells.push(if long == 0 { String::new() } else { gathered("3600").to_string() });
        for reach_m in ["0.2", "0.3", "0.4", "0.5", "0.75"] {
            cells.push(count("1200", "dispersal", reach_m, Some("spread_out")).to_string());
        }
        let row = format!("| {} |", cells.join(" | ")).replace("|  |", "| |");
        assert!(page.contains(&row), "the page lacks {row}");
    }
}
