//! The label of one bag: by the one judge, or by a person.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_bags::Bag;
use rsrs_bags::trajectory::{
    Finding, Keep, PoseSource, RecordedTrajectory, TrajectoryOptions, read_trajectory,
};
use rsrs_core::certainty::Certainty;
use rsrs_core::order::Evidence;
use rsrs_core::phase::{Phase, Thresholds, label};
use rsrs_core::trajectory::Bodies;
use rsrs_fleet::record::ExperimentRecord;
use rsrs_msgs::topics::{self, Topic};
use serde::Serialize;

use crate::failure::{explained, with_help};
use crate::human_labels::{self, HumanLabel, JUDGE};
use crate::recorded_run;

/// What to label a bag by.
#[derive(Clone, Copy, Debug, Default)]
pub struct LabelOptions {
    /// Body and sensing range of the robots; `None` takes what the bag's own record says.
    pub bodies: Option<Bodies>,
    /// Where poses come from; `None` takes the first source that the bag has of all robots.
    pub poses: Option<PoseSource>,
}

/// A bag with its label.
#[derive(Clone, Debug, Serialize)]
pub struct Labelled {
    /// The bag.
    pub bag: PathBuf,
    /// What its swarm settled into.
    pub phase: Phase,
    /// The order parameters behind it; `None` for a person's label.
    pub evidence: Option<Evidence>,
    /// How sure it is; not there for a person's label.
    #[serde(flatten)]
    pub certainty: Option<Certainty>,
    /// Number of robots; `None` for a person's label.
    pub n_robots: Option<usize>,
    /// Time that was recorded while the swarm was running, in seconds; `None` for a person's label.
    pub duration_s: Option<f64>,
    /// Who labelled it: the judge, or a person's name.
    pub by: String,
    /// Where the poses came from; not there for a person's label.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<String>,
    /// What was mended on the way from the bag to the judge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    /// What people said of the bag.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<HumanLabel>,
    /// Where the recording breaks off; the judge has seen what came before. Not there for a whole
    /// bag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
    /// Robots that had no gate of ours in front of their wheels, as the bag's record says.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub controller_only: Vec<String>,
}

impl Labelled {
    /// A bag with the label of a person, which is one of `labels`.
    pub fn by_hand(bag: &Path, label: &HumanLabel, labels: Vec<HumanLabel>) -> Self {
        Self {
            bag: bag.to_path_buf(),
            phase: label.phase,
            evidence: None,
            certainty: None,
            n_robots: None,
            duration_s: None,
            by: label.by.clone(),
            poses: None,
            findings: Vec::new(),
            labels,
            damage: None,
            controller_only: Vec::new(),
        }
    }
}

/// Labels one bag with the phase that its swarm settled into.
///
/// What the judge must know of the robots comes from the options, else from the record that the
/// bag holds, else it is unknown.
///
/// # Errors
///
/// If the bag or its record cannot be read, or it has no poses, no commands, or too little time;
/// the error names the bag.
pub fn label_bag(path: &Path, options: LabelOptions) -> anyhow::Result<Labelled> {
    Ok(judge_what_is_kept(path, options, Keep::JUDGED)?.0)
}

/// As [`label_bag`], with the whole run.
///
/// # Errors
///
/// As [`label_bag`].
pub fn judge(
    path: &Path,
    options: LabelOptions,
) -> anyhow::Result<(Labelled, RecordedTrajectory, Bodies)> {
    judge_what_is_kept(path, options, Keep::All)
}

fn judge_what_is_kept(
    path: &Path,
    options: LabelOptions,
    keep: Keep,
) -> anyhow::Result<(Labelled, RecordedTrajectory, Bodies)> {
    let labels = human_labels::read(path)?;
    let bag = recorded_run::open(path)?;
    let record = recorded_run::record_in(&bag)?;
    let bodies = options.bodies.unwrap_or_else(|| recorded_bodies(record.as_ref()));
    let poses = options.poses.or_else(|| source_of_all(&bag, record.as_ref()?));
    let recorded = read_trajectory(&bag, &TrajectoryOptions { poses, keep }).map_err(|error| {
        let (message, help) = (format!("{}: {error}", path.display()), error.help());
        explained(error, message, help)
    })?;
    let trajectory = &recorded.trajectory;
    let verdict = label(trajectory, &bodies).with_context(|| path.display().to_string())?;
    let certainty = Certainty::of((trajectory, &bodies), &verdict, &Thresholds::default());
    let labelled = Labelled {
        bag: path.to_path_buf(),
        phase: verdict.phase,
        evidence: Some(verdict.evidence),
        certainty: Some(certainty),
        n_robots: Some(verdict.n_robots),
        duration_s: Some(recorded.duration_s()),
        by: JUDGE.to_owned(),
        poses: Some(recorded.poses.to_string()),
        findings: recorded.findings.clone(),
        labels,
        damage: recorded_run::break_in(&bag),
        controller_only: record.map(|record| record.controller_only).unwrap_or_default(),
    };
    Ok((labelled, recorded, bodies))
}

/// Takes the label that a person has given to a bag.
///
/// # Errors
///
/// If the file with the labels does not read, or has none of this person.
pub fn label_by(path: &Path, who: &str) -> anyhow::Result<Labelled> {
    let labels = human_labels::read(path)?;
    let name = path.display();
    match human_labels::by(&labels, who) {
        Some(label) => Ok(Labelled::by_hand(path, label, labels.clone())),
        None => Err(with_help(
            format!("{name}: has no label by {who}"),
            format!("watch it and say what it shows: `rsrs label {name} --as PHASE --by {who}`"),
        )),
    }
}

/// The first source that has poses of all robots of the record: in a mixed fleet, what the simulator
/// says of its own may come on more topics than what a tracker says of the real ones.
///
/// # Returns
///
/// `None` if there is none such; then it is for the reader of trajectories to choose.
fn source_of_all(bag: &Bag, record: &ExperimentRecord) -> Option<PoseSource> {
    let recorded = bag.topics();
    let has_all = |topic: &Topic| {
        record.robots.iter().all(|robot| {
            let name = topic.for_robot(robot);
            recorded.iter().any(|found| found.name == name && found.n_messages > 0)
        })
    };
    let sources = [(PoseSource::Odom, topics::ODOM), (PoseSource::Pose, topics::POSE)];
    sources.into_iter().find_map(|(source, topic)| has_all(&topic).then_some(source))
}

fn recorded_bodies(record: Option<&ExperimentRecord>) -> Bodies {
    let unknown = Bodies { radius_m: None, range_m: None };
    record.map_or(unknown, |record| record.conditions.bodies())
}
