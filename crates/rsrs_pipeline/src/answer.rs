//! The paper's five questions on a robot: how many, how fast, how sharply, how good the sensors, and
//! how alike.
//!
//! A recommendation is the most robust setting of a grid, confirmed on fresh seeds in both worlds. From
//! it one quantity at a time is moved, and the range over which robots mill as often as wanted is the
//! answer. Values of capabilities are measured ones: the robot that has them is made worse again.

mod curve;
mod reason;
mod tried_value;

use std::path::Path;

use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::diagram::choice::Margin;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_core::statistics::share::Share;
use serde::Serialize;

pub use crate::answer::reason::{Edge, Why};
pub use crate::best_setting::BestSetting;
use crate::best_setting::search::Search;
use crate::best_setting::{self, Subject};

/// What is asked.
#[derive(Clone, Copy)]
pub struct AnswerOptions<'a> {
    /// Sweep file, or the folder of a sweep, whose settings are tried; else a built-in grid is.
    pub sweep: Option<&'a Path>,
    /// What to do if that is of robots with another profile.
    pub other_profile: OtherProfile,
    /// Runs of each point of a curve, in each world; at least 1.
    pub replicates: u64,
    /// How the recommendation is looked for.
    pub best: best_setting::SearchOptions<'a>,
}

/// Runs of each point of a curve where nothing else is asked for.
pub const REPLICATES: u64 = 250;

/// The answers to the five questions.
///
/// # Source
///
/// `pr:main`.
#[derive(Clone, Debug, Serialize)]
pub struct Answers {
    /// The recommendation.
    #[serde(flatten)]
    pub best: BestSetting,
    /// What is the same in all settings.
    pub fixed: Cell,
    /// Simulated time of each run, in seconds.
    pub duration_s: f64,
    /// The factors that a sweep has other than those that follow from its robot, by their keys.
    #[serde(skip)]
    pub decided_factors: Vec<(&'static str, f64)>,
    /// That the settings are of a sweep of robots with another profile; not there if they are not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_profile: Option<ProfilesDiffer>,
    /// One of each of the five questions, in the paper's order, and one about the numbers of a controller; as
    /// JSON they are written with their reasons, by `rsrs_render`.
    #[serde(skip)]
    pub questions: Vec<Answer>,
}

/// The answer to one question.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The question, in the paper's words.
    pub question: &'static str,
    /// What it asks for, quantity by quantity.
    pub quantities: Vec<Quantity>,
}

/// Over which values of a quantity robots mill, all others as recommended.
#[derive(Clone, Debug, Serialize)]
pub struct Quantity {
    /// The quantity.
    pub axis: Axis,
    /// What is recommended; of a capability what the robot has.
    pub recommended: f64,
    /// The values around it up to the first of which the share of mills is less than wanted: surely by
    /// itself, or pooled with neighbours that chance has put out of order; `None` if it is surely less
    /// at the recommendation already.
    pub range: Option<Range>,
    /// The share of mills, value by value, ascending.
    pub curve: Vec<Point>,
    /// Why the range ends where it does.
    #[serde(skip)]
    pub why: Why,
}

/// A range of values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The least of them that was tried.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// Whether smaller values were tried.
    pub ends_below: bool,
    /// Whether greater ones were.
    pub ends_above: bool,
    /// From the recommendation to both ends.
    pub margin: Margin,
}

/// The share of mills at one value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The value.
    pub value: f64,
    /// Share of mills, in the world in which they are rarer.
    pub b_s: f64,
    /// Lower bound of its 95 % interval.
    pub b_s_low: f64,
    /// Upper bound.
    pub b_s_high: f64,
    /// Runs that milled there.
    pub n_mills: u64,
    /// Runs in each world.
    pub n_replicates: u64,
}

impl Point {
    fn new(value: f64, milling: Share) -> Self {
        let interval = milling.interval();
        Self {
            value,
            b_s: milling.value(),
            b_s_low: interval.low,
            b_s_high: interval.high,
            n_mills: milling.hits,
            n_replicates: milling.n,
        }
    }

    /// Runs that milled, of all.
    pub fn milling(&self) -> Share {
        Share { hits: self.n_mills, n: self.n_replicates }
    }
}

/// The five questions, and the quantities that each is about.
const QUESTIONS: [(&str, &[Axis]); 5] = [
    ("How many robots should be deployed?", &[Axis::Robots]),
    ("How fast should they be moving?", &[Axis::Speed, Axis::UndetectedSpeed]),
    ("How sharp should they be turning?", &[Axis::TurnRate, Axis::UndetectedTurnRate]),
    (
        "How good do the sensors need to be?",
        &[
            Axis::Range,
            Axis::HalfAngle,
            Axis::TruePositive,
            Axis::FalsePositive,
            Axis::LatencySteps,
        ],
    ),
    ("How homogeneous does the swarm need to be?", &[Axis::Heterogeneity]),
];

/// Of a controller with named numbers, what each of them may be.
const OF_ITS_NUMBERS: &str = "How exact do the numbers of the controller need to be?";

/// Answers the five questions, and of a controller with named numbers one about these.
///
/// The path is that of a profile, a sweep file, or the folder of a sweep; of the latter two the
/// robot, how it is made worse, and the settings are taken.
pub fn answer(path: &Path, options: AnswerOptions<'_>) -> anyhow::Result<Answers> {
    let robots = options.best.robots;
    let mut subject = Subject::read(path, (options.sweep, options.other_profile), robots)?;
    let other_profile = subject.other_profile.take();
    let result = subject.swept(path, options.best)?;
    let best = BestSetting::new(&result, options.best)?;
    let search = Search::new(&result, options.best)?;
    let numbers: Vec<Axis> =
        search.settings.controller.iter().flat_map(ControllerTable::axes).collect();
    let of_numbers = (!numbers.is_empty()).then_some((OF_ITS_NUMBERS, &numbers[..]));
    let mut questions = Vec::new();
    for (question, axes) in QUESTIONS.into_iter().chain(of_numbers) {
        let mut quantities = Vec::new();
        for axis in axes {
            quantities.extend(curve::quantity(&search, &best.cell, *axis, options)?);
        }
        questions.push(Answer { question, quantities });
    }
    let fixed = search.settings.values.iter().copied();
    Ok(Answers {
        fixed: Cell::new(fixed.filter(|(axis, _)| best.cell.get(*axis).is_none()))?,
        duration_s: result.source.sweep.duration_s,
        decided_factors: decided_factors(result.source.sweep.harsher),
        best,
        other_profile,
        questions,
    })
}

/// The factors that were decided; the others follow from the robot. Robots that are not made worse have
/// none.
fn decided_factors(harsher: Harsher) -> Vec<(&'static str, f64)> {
    if harsher == HarsherFactors::NONE.into() {
        return Vec::new();
    }
    harsher.given().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_that_were_decided_are_named_and_those_that_follow_from_the_robot_are_not() {
        let given = serde_json::from_str(r#"{"miss_factor": 5, "latency_extra_steps": 1}"#);
        let given: Harsher = given.expect("two factors");

        assert_eq!(decided_factors(given), [("miss_factor", 5.0), ("latency_extra_steps", 1.0)]);
        assert!(decided_factors(Harsher::default()).is_empty());
        assert!(decided_factors(HarsherFactors::NONE.into()).is_empty());
    }
}
