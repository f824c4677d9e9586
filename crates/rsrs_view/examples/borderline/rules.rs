//! The rules of stable milling that are held against the labels.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::behaviour::condition::{Condition, Needs};
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{Phase, label};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::{WINDOW_S, samples_in};

use crate::{Episode, WORLDS};

/// Parts of the window of which each is asked: the whole, halves, thirds, sixths.
const PARTS: [usize; 4] = [1, 2, 3, 6];

/// Where an episode is to the line between stable milling and the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Stable by the whole window, and not by each third.
    Disputed,
    /// Stable by both.
    Stable,
    /// Semi-stable.
    Other,
}

/// An episode with the order parameters of its window and its parts.
#[derive(Clone, Debug)]
pub struct Judged {
    pub episode: Episode,
    phase: Phase,
    /// As `PARTS`, one after the other.
    evidence: Vec<OrderParameters>,
}

impl Judged {
    /// Judges an episode.
    pub fn new(episode: Episode, trajectory: &Trajectory, bodies: &Bodies) -> Self {
        let verdict = label(trajectory, bodies).expect("it is long enough");
        let end = trajectory.n_samples();
        let start = end - samples_in(WINDOW_S, trajectory.period_s);
        let evidence = PARTS
            .iter()
            .flat_map(|n| (0..*n).map(|part| part_of(start..end, (part, *n))))
            .map(|samples| OrderParameters::new(trajectory, samples, bodies))
            .collect();
        Self { episode, phase: whole_phase(&verdict.evidence), evidence }
    }

    fn parts(&self, n: usize) -> &[OrderParameters] {
        let first: usize = PARTS.iter().take_while(|parts| **parts < n).sum();
        &self.evidence[first..first + n]
    }

    /// On which side of the line it is; `None` if it is far from being a mill.
    pub fn side(&self) -> Option<Side> {
        let rules = Behaviour::MILLING.rules();
        let is_steady = self.parts(3).iter().all(|part| rules.is_wanted(part));
        match (self.phase, is_steady) {
            (Phase::STABLE_MILLING, true) => Some(Side::Stable),
            (Phase::STABLE_MILLING, false) => Some(Side::Disputed),
            (Phase::SEMI_STABLE_MILLING, _) => Some(Side::Other),
            _ => None,
        }
    }

    /// How far it is from the line, by the whole window or its worst third, whichever is nearer.
    pub fn off_line(&self) -> f64 {
        let thirds = self.parts(3).iter().map(margin).fold(f64::INFINITY, f64::min);
        margin(&self.evidence[0]).abs().min(thirds.abs())
    }
}

/// The phase by the whole window alone.
fn whole_phase(evidence: &OrderParameters) -> Phase {
    Behaviour::MILLING.rules().phase(evidence)
}

/// The samples of one of so many parts of a window.
fn part_of(window: Range<usize>, (part, n): (usize, usize)) -> Range<usize> {
    window.start + window.len() * part / n..window.start + window.len() * (part + 1) / n
}

/// How far the nearest boundary of stable milling is, in parts of what there is beyond it.
fn margin(evidence: &OrderParameters) -> f64 {
    let rules = Behaviour::MILLING.rules();
    let conditions = rules.of(rules.wanted).flat_map(|rule| &rule.conditions);
    let margin = |condition: &Condition| {
        let found = condition.parameter.of(evidence);
        match condition.needs {
            Needs::AtLeast => (found - condition.bound) / (1.0 - condition.bound),
            // Where nobody may be lost there is no share of it.
            Needs::AtMost if condition.bound == 0.0 => {
                if found > 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Needs::Below | Needs::AtMost => (condition.bound - found) / condition.bound,
        }
    };
    conditions.map(margin).fold(f64::INFINITY, f64::min)
}

/// The order parameters of all episodes and parts.
pub fn table(judged: &[Judged]) -> String {
    let mut table = "episode,world,cell,replicate,parts,part,rotation,orbit,circliness,blocked,\
                     stuck,lost,mean_radius_m\n"
        .to_owned();
    for (number, judged) in judged.iter().enumerate() {
        let Episode { world, cell, replicate } = judged.episode;
        for n in PARTS {
            for (part, evidence) in judged.parts(n).iter().enumerate() {
                let OrderParameters { rotation, orbit, circliness, blocked, stuck, .. } = evidence;
                writeln!(
                    table,
                    "{number},{},{cell},{replicate},{n},{part},{rotation:.4},{orbit:.4},\
                     {circliness:.4},{blocked:.4},{stuck:.4},{:.4},{:.4}",
                    WORLDS[world],
                    evidence.lost.expect("their reach is known"),
                    evidence.mean_radius_m
                )
                .expect("a string takes any text");
            }
        }
    }
    table
}

/// One part of an episode as its table has it.
#[derive(serde::Deserialize)]
struct Row {
    episode: usize,
    parts: usize,
    rotation: f64,
    orbit: f64,
    circliness: f64,
    blocked: f64,
    stuck: f64,
    lost: f64,
}

impl Row {
    fn is_stable(&self) -> bool {
        self.is_stable_from(0.5)
    }

    fn is_stable_from(&self, circliness: f64) -> bool {
        self.rotation >= 0.9
            && self.orbit >= 0.8
            && self.circliness >= circliness
            && self.blocked < 0.02
            && self.stuck < 0.2
            && self.lost == 0.0
    }

    fn is_semi_stable(&self) -> bool {
        self.rotation >= 0.6 && self.orbit >= 0.5
    }

    fn moves(&self) -> bool {
        self.rotation >= 0.9 && self.orbit >= 0.8
    }
}

type Parts = BTreeMap<usize, Vec<Row>>;
type Rule = (&'static str, fn(&Parts) -> bool);

/// Every rule asks the whole window; most ask its parts, too.
const RULES: [Rule; 9] = [
    ("the whole window", |parts| parts[&1][0].is_stable()),
    ("and each half", |parts| parts[&1][0].is_stable() && all(parts, 2, Row::is_stable)),
    ("and each third", |parts| parts[&1][0].is_stable() && all(parts, 3, Row::is_stable)),
    ("and each third, circliness 0.4", |parts| {
        parts[&1][0].is_stable() && all(parts, 3, |row| row.is_stable_from(0.4))
    }),
    ("and each third moves as a mill", |parts| {
        parts[&1][0].is_stable() && all(parts, 3, Row::moves)
    }),
    ("and each third is semi-stable", |parts| {
        parts[&1][0].is_stable() && all(parts, 3, Row::is_semi_stable)
    }),
    ("and the last third", |parts| parts[&1][0].is_stable() && parts[&3][2].is_stable()),
    ("and each sixth", |parts| parts[&1][0].is_stable() && all(parts, 6, Row::is_stable)),
    ("and five of six sixths", |parts| {
        parts[&1][0].is_stable() && parts[&6].iter().filter(|row| row.is_stable()).count() >= 5
    }),
];

fn all(parts: &Parts, n: usize, is_good: fn(&Row) -> bool) -> bool {
    parts[&n].iter().all(is_good)
}

/// What a person called an episode.
#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
enum Label {
    Stable,
    Other,
}

/// The labels of an episode, which a person gave twice.
#[derive(serde::Deserialize)]
struct Labels {
    episode: usize,
    first: Label,
    second: Label,
}

/// Prints how many labels each rule meets.
pub fn agree(folder: &Path, labels: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut episodes: BTreeMap<usize, Parts> = BTreeMap::new();
    for row in csv::Reader::from_path(folder.join("episodes.csv"))?.into_deserialize() {
        let row: Row = row?;
        episodes.entry(row.episode).or_default().entry(row.parts).or_default().push(row);
    }
    let rows: Vec<Labels> =
        csv::Reader::from_path(labels)?.into_deserialize().collect::<Result<_, _>>()?;
    let n_same = rows.iter().filter(|row| row.first == row.second).count();
    println!("{} episodes, labelled alike twice: {n_same}", rows.len());
    println!("| rule | first labels | second labels | where both agree |\n|---|---|---|---|");
    for (name, rule) in RULES {
        let n = |label: fn(&Labels) -> Option<Label>| {
            let is_met = |row: &&Labels| {
                let is_stable = rule(&episodes[&row.episode]);
                label(row) == Some(if is_stable { Label::Stable } else { Label::Other })
            };
            rows.iter().filter(is_met).count()
        };
        println!(
            "| {name} | {} | {} | {} of {n_same} |",
            n(|row| Some(row.first)),
            n(|row| Some(row.second)),
            n(|row| (row.first == row.second).then_some(row.first))
        );
    }
    Ok(())
}
