//! The label of one bag: by the one judge, or by a person.

pub mod agreement;
pub mod human_labels;
pub mod implausible;

pub use human_labels::Labeller;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rsrs_bags::trajectory::{Finding, Needed, RecordedTrajectory, TrajectoryError};
use rsrs_bags::{Bag, Recovery};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{JudgeError, Phase, label_with};
use rsrs_core::judge::reason::Reason;
use rsrs_core::judge::trajectory::Bodies;
use rsrs_core::judge::window::Window;
use rsrs_core::robot::controller::Controller;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_files::quoted;
use rsrs_fleet::record::{
    Backend, Ending, EndingKind, ExperimentRecord, LostRobot, OwnProfile, PausedRobot,
};
use serde::{Deserialize, Serialize};

use self::human_labels::{HumanLabel, JUDGE};
use self::implausible::ImplausibleMotion;
use crate::error::{helped, with_help};
use crate::recorded_run::{self, LossyRecovery, PosesBy, PosesOfRun};

/// The label beside a bag, as a campaign leaves it.
pub const LABEL: &str = "label.json";

/// A run is a part of one if it is shorter than it was set to be by more than this share of it ...
const SHORT_SHARE: f64 = 0.02;

/// ... and by more than this, in seconds: the lease takes a moment to be received.
const SHORT_S: f64 = 2.0;

/// What to label a bag by.
#[derive(Clone, Copy, Debug, Default)]
pub struct LabelOptions {
    /// Body and reach of the robots; `None` takes that of the bag's own record.
    pub bodies: Option<GivenBodies>,
    /// Where poses come from; `None` takes the source by which the run went, as its record states it.
    pub poses: Option<PoseSource>,
    /// What to do about a run whose end was not recorded.
    pub cut: CutRun,
    /// What to judge it for; `None` takes what the bag's own record has, or milling.
    pub behaviour: Option<Behaviour>,
}

/// What somebody gives for what a record has of the robots and their arena.
#[derive(Clone, Copy, Debug, Default)]
pub struct GivenBodies {
    /// Radius of one robot's body, in metres.
    pub radius_m: Option<f64>,
    /// How far from a robot's centre the centre of another can be seen, in metres.
    pub reach_m: Option<f64>,
    /// Side of the arena, in metres; that of the record where none is given.
    pub arena_m: Option<f64>,
}

/// What to do about a run whose end was not recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutRun {
    /// What there is of it is not taken for the whole.
    #[default]
    Refused,
    /// What there is of it is judged, and marked as a part.
    Judged,
}

/// A bag with its label.
#[derive(Clone, Debug, Serialize)]
pub struct Labelled {
    /// The bag.
    pub bag: PathBuf,
    /// What its swarm settled into.
    pub phase: Phase,
    /// The order parameters behind it; `None` for a person's label.
    pub evidence: Option<OrderParameters>,
    /// How sure it is; not there for a person's label.
    #[serde(flatten)]
    pub certainty: Option<Certainty>,
    /// Why it is this phase, a sentence each; empty for a stable mill, and for a person's label.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub why: Vec<String>,
    /// Number of robots; `None` for a person's label.
    pub n_robots: Option<usize>,
    /// Time that was recorded while the swarm was running, in seconds; `None` for a person's label.
    pub duration_s: Option<f64>,
    /// What moved the robots, by the bag's record; not there for a bag without one, and for a person's
    /// label.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backend: Option<Backend>,
    /// Who labelled it: the judge, or a person's name.
    pub by: String,
    /// Where the poses came from; not there for a person's label.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<String>,
    /// By what that is known; not there for a person's label.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses_by: Option<PosesBy>,
    /// What was mended on the way from the bag to the judge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    /// Labels by people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<HumanLabel>,
    /// What a bag lacks that was recovered from a damaged one; not there for any other bag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damage: Option<String>,
    /// The same in numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recovery: Option<Recovery>,
    /// How much of the run was judged, where its end was not recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<RunPart>,
    /// How the run ended, if it was not completed: `void`, `aborted` or `failed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ending: Option<&'static str>,
    /// Why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Robots that did not take part to the end, by the bag.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost_robots: Vec<LostRobot>,
    /// Whether the run counts in a comparison without those, by the rule of its experiment; not there
    /// where none was lost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counts_without_lost: Option<bool>,
    /// When robots stood in the run because leases did not reach them, and went on, by the bag.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub paused_robots: Vec<PausedRobot>,
    /// What its poses and commands show that cannot be, or that a robot did not move: look again.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub implausible: Vec<ImplausibleMotion>,
    /// Robots whose first poses are not where its record places them, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub misplaced: Vec<String>,
    /// Robots that had no gate of ours in front of their wheels, by the bag's record.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub controller_only: Vec<String>,
    /// Robots with a profile of their own, and in what it differs from the fleet's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub own_profiles: BTreeMap<String, OwnProfile>,
}

/// What the label of a bag, as it is written, has on whether it is near another one.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub struct Settledness {
    /// Not there in a person's label.
    is_settled: Option<bool>,
    /// Whether poses or motions are found that cannot be; not there in a label without them.
    #[serde(default, rename = "implausible", deserialize_with = "is_there")]
    pub is_implausible: bool,
}

/// That something is there, whatever it is.
fn is_there<'a, D: serde::Deserializer<'a>>(deserializer: D) -> Result<bool, D::Error> {
    serde::de::IgnoredAny::deserialize(deserializer).map(|_| true)
}

impl Settledness {
    /// Whether a person should look at the run.
    pub fn is_borderline(self) -> bool {
        self.is_settled == Some(false)
    }
}

/// How much there is of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunPart {
    /// So much was recorded, in seconds.
    pub recorded_s: f64,
    /// So long the run was set to last, in seconds; `None` if it is not in the bag.
    pub set_s: Option<f64>,
}

impl Labelled {
    /// Whether the label is near another one, so that a person should look at the run.
    pub fn is_borderline(&self) -> bool {
        self.certainty.as_ref().is_some_and(|certainty| !certainty.is_settled)
    }

    /// Whether a person should look at the run, and why.
    pub fn settledness(&self) -> Settledness {
        let is_settled = Some(!self.is_borderline());
        Settledness { is_settled, is_implausible: !self.implausible.is_empty() }
    }

    /// A bag with the label of a person, which is one of `labels`.
    pub fn by_hand(bag: &Path, label: &HumanLabel, labels: Vec<HumanLabel>) -> Self {
        Self {
            bag: bag.to_path_buf(),
            phase: label.phase,
            evidence: None,
            certainty: None,
            why: Vec::new(),
            n_robots: None,
            duration_s: None,
            backend: None,
            by: label.by.clone(),
            poses: None,
            poses_by: None,
            findings: Vec::new(),
            labels,
            damage: None,
            recovery: None,
            part: None,
            ending: None,
            reason: None,
            lost_robots: Vec::new(),
            counts_without_lost: None,
            paused_robots: Vec::new(),
            implausible: Vec::new(),
            misplaced: Vec::new(),
            controller_only: Vec::new(),
            own_profiles: BTreeMap::new(),
        }
    }
}

/// Labels one bag with the phase that its swarm settled into.
///
/// What the judge needs of the robots comes from the options, else from the record that the bag
/// holds, else it is unknown. A bag that has no poses, no commands, or too little time has no
/// label.
pub fn label_bag(path: &Path, options: LabelOptions) -> anyhow::Result<Labelled> {
    Ok(judge(path, options)?.0)
}

/// As [`label_bag`], with what was judged.
pub fn judge(
    path: &Path,
    options: LabelOptions,
) -> anyhow::Result<(Labelled, RecordedTrajectory, Bodies)> {
    let run = read_run(path, options)?;
    Ok((run.labelled(path)?, run.recorded, run.bodies))
}

/// A recorded run, with its label if it has one.
#[derive(Clone, Debug)]
pub struct ReadRun {
    /// The label.
    pub label: Result<Labelled, NoLabel>,
    /// What the robots did.
    pub recorded: RecordedTrajectory,
    /// What is known of them.
    pub bodies: Bodies,
    /// What the run is judged for.
    pub behaviour: Behaviour,
    /// Distance of simulated walls from the origin, in metres, where there are some.
    pub walls_m: Option<f64>,
    /// What moved the robots, by the bag's record.
    pub backend: Option<Backend>,
    /// What they decided by, by the bag's record.
    pub controller: Option<Controller>,
    /// Robots that did not take part to the end.
    pub lost_robots: Vec<LostRobot>,
    /// Labels by people.
    pub labels: Vec<HumanLabel>,
}

impl ReadRun {
    /// The label, or why it has none; the error names the bag.
    pub fn labelled(&self, path: &Path) -> anyhow::Result<Labelled> {
        self.label.clone().map_err(|none| none.refused(path))
    }

    /// The rows of robots that did not take part to the end.
    pub fn lost_rows(&self) -> Vec<usize> {
        let is_lost = |robot: &String| self.lost_robots.iter().any(|lost| lost.robot == *robot);
        let rows = self.recorded.robots.iter().enumerate().filter(|(_, robot)| is_lost(robot));
        rows.map(|(row, _)| row).collect()
    }
}

/// Why a run that can be read has no label.
#[derive(Clone, Debug, PartialEq)]
pub enum NoLabel {
    /// Its end was not recorded.
    Part(RunPart),
    /// It was stopped before there was enough to judge.
    Stopped {
        /// How long it went on, in seconds.
        duration_s: f64,
        /// How it ended.
        ending: &'static str,
        /// Why.
        reason: String,
        /// Which time of it would be judged.
        window: Window,
    },
    /// It is judged by where objects were, of which nothing is known.
    Objects(Finding),
    /// The judge cannot decide.
    Judge(JudgeError),
}

impl NoLabel {
    fn from_error(error: JudgeError, ending: Option<&Ending>, findings: &[Finding]) -> Self {
        let of_objects = || findings.iter().find(|finding| finding.is_of_objects()).cloned();
        match (error, ending) {
            (error @ JudgeError::UnknownObjects { .. }, _) => {
                of_objects().map_or(Self::Judge(error), Self::Objects)
            }
            (JudgeError::TooShort { duration_s, window }, Some(Ending { kind, reason, .. }))
                if *kind != EndingKind::Completed =>
            {
                let (ending, reason) = (kind.key(), reason.clone());
                Self::Stopped { duration_s, ending, reason, window }
            }
            (error, _) => Self::Judge(error),
        }
    }

    fn refused(self, path: &Path) -> anyhow::Error {
        match self {
            Self::Part(part) => only_a_part(path, part),
            Self::Stopped { duration_s, ending, reason, window } => anyhow!(
                "{}: the run was {ending} after {duration_s:.1} s ({reason}), and {} s or more would be \
                 judged",
                path.display(),
                window.least_s()
            ),
            Self::Objects(finding) => with_help(
                format!("{}: it is judged by objects, and {finding}", path.display()),
                "look at what the tracker sees of them, and run it again".to_owned(),
            ),
            Self::Judge(error) => not_judged(path, error),
        }
    }
}

/// Reads a recorded run, and labels it if that can be done.
pub fn read_run(path: &Path, options: LabelOptions) -> anyhow::Result<ReadRun> {
    let bag = recorded_run::open(path)?;
    let record = recorded_run::record_in(&bag)?;
    // Their phases may be those of a behaviour that the record has.
    let labels = human_labels::read(path)?;
    let recorded = record.as_ref().map_or(Bodies::UNKNOWN, |record| record.conditions.bodies());
    let bodies = match options.bodies {
        None => recorded,
        Some(GivenBodies { radius_m, reach_m, arena_m }) => {
            Bodies { radius_m, reach_m, arena_m: arena_m.or(recorded.arena_m), ..recorded }
        }
    };
    let ending = recorded_run::ending_in(&bag)?;
    let behaviour = behaviour_of(record.as_ref(), options);
    let poses = PosesOfRun::new(&bag, record.as_ref(), options.poses)?;
    let recorded = poses
        .read(&bag, record.as_ref(), Needed::Judged(behaviour.window()))
        .map_err(|error| refused(path, error, ending.as_ref()))?;
    let part = part_of_run(&bag, &recorded, record.as_ref(), ending.as_ref());
    // A floor of real robots has its own frame and its own walls.
    let simulated = record.as_ref().filter(|record| record.backend == Backend::Simulator);
    let walls_m = simulated.and_then(|record| record.conditions.arena.walls_m());
    let backend = record.as_ref().map(|record| record.backend);
    let lost_robots = ending.as_ref().map(|ending| ending.lost.clone()).unwrap_or_default();
    let label = || -> Result<Labelled, NoLabel> {
        if let (Some(part), CutRun::Refused) = (part, options.cut) {
            return Err(NoLabel::Part(part));
        }
        let trajectory = &recorded.trajectory;
        let rules = behaviour.rules();
        let verdict = label_with(trajectory, &bodies, &rules)
            .map_err(|error| NoLabel::from_error(error, ending.as_ref(), &recorded.findings))?;
        let certainty = Certainty::new(&verdict, &rules);
        let reason = Reason::new(trajectory, &bodies, &verdict, &rules);
        let counts_without_lost =
            record.as_ref().zip(ending.as_ref()).and_then(|(record, ending)| {
                let is_asked = ending.kind == EndingKind::Completed && !ending.lost.is_empty();
                is_asked.then(|| record.counts_without(&ending.lost))
            });
        let stopped = ending.as_ref().filter(|ending| ending.kind != EndingKind::Completed);
        let lost = ending.as_ref().map_or(&[][..], |ending| &ending.lost);
        let lossy = LossyRecovery::in_bag(&bag);
        let implausible = implausible::find(&recorded, &bodies, record.as_ref(), lost);
        let misplaced = record.as_ref().map(|record| implausible::misplaced(&recorded, record));
        Ok(Labelled {
            bag: path.to_path_buf(),
            phase: verdict.phase,
            evidence: Some(verdict.evidence),
            certainty: Some(certainty),
            why: reason.sentences(rules.wanted, &recorded.robots),
            n_robots: Some(verdict.n_robots),
            duration_s: Some(recorded.trajectory.duration_s()),
            backend,
            by: JUDGE.to_owned(),
            poses: Some(recorded.poses.to_string()),
            poses_by: Some(poses.by),
            findings: recorded.findings.clone(),
            labels: labels.clone(),
            damage: lossy.as_ref().map(ToString::to_string),
            recovery: lossy.map(|LossyRecovery(recovery)| recovery),
            part,
            ending: stopped.map(|ending| ending.kind.key()),
            reason: stopped.map(|ending| ending.reason.clone()),
            paused_robots: ending.as_ref().map(|ending| ending.paused.clone()).unwrap_or_default(),
            lost_robots: lost_robots.clone(),
            counts_without_lost,
            implausible,
            misplaced: misplaced.unwrap_or_default(),
            own_profiles: record.as_ref().map(|it| it.own_profiles.clone()).unwrap_or_default(),
            controller_only: record
                .as_ref()
                .map(|it| it.controller_only.clone())
                .unwrap_or_default(),
        })
    };
    let label = label();
    Ok(ReadRun {
        label,
        recorded,
        bodies,
        behaviour,
        walls_m,
        backend,
        controller: record.map(|record| record.conditions.controller),
        lost_robots,
        labels,
    })
}

/// What a run is judged for: what was asked for, else what its record has.
fn behaviour_of(record: Option<&ExperimentRecord>, options: LabelOptions) -> Behaviour {
    let recorded = || record.map(|record| record.conditions.behaviour);
    options.behaviour.or_else(recorded).unwrap_or_default()
}

/// Why a bag gives no trajectory, with its record of the robot.
fn refused(path: &Path, error: TrajectoryError, ending: Option<&Ending>) -> anyhow::Error {
    let lost = match (&error, ending) {
        (TrajectoryError::EndsEarly { robot, .. }, Some(ending)) => {
            let lost = ending.lost.iter().find(|lost| lost.robot == *robot);
            lost.map_or_else(String::new, |lost| format!("; {lost}"))
        }
        _ => String::new(),
    };
    let message = format!("{}: {error}{lost}", path.display());
    helped(error).context(message)
}

/// Why a trajectory is not judged, and what to give the judge.
fn not_judged(path: &Path, error: JudgeError) -> anyhow::Error {
    let name = path.display();
    let help = format!(
        "state what the robots are: `rsrs label {} --profile PROFILE`, or how far one senses the centre of \
         another, in metres: `--reach M`",
        quoted(path)
    );
    match error {
        JudgeError::UnknownReach { .. } => {
            let message = format!("{name}: holds no record of its experiment; {error}");
            with_help(message, help)
        }
        error => anyhow::Error::from(error).context(name.to_string()),
    }
}

/// How much of a run there is, if its end was not recorded; one that was stopped has its end.
fn part_of_run(
    bag: &Bag,
    recorded: &RecordedTrajectory,
    record: Option<&ExperimentRecord>,
    ending: Option<&Ending>,
) -> Option<RunPart> {
    let is_stopped = ending.is_some_and(|ending| ending.kind != EndingKind::Completed);
    // The robot that was seen last begins the trajectory, not the run.
    let late_s = recorded.findings.iter().filter_map(|finding| match finding {
        Finding::LateStart { by_s, .. } => Some(*by_s),
        _ => None,
    });
    let recorded_s = recorded.trajectory.duration_s() + late_s.fold(0.0, f64::max);
    let set_s = record.map(|record| record.duration_s);
    let is_short = set_s.map(|set_s| recorded_s < set_s - (SHORT_SHARE * set_s).max(SHORT_S));
    // Without a record the duration of a run is unknown, but a file that was cut has lost its end.
    let is_cut = || bag.recovery().is_some_and(|recovery| recovery.lacks_end);
    let is_part = !is_stopped && is_short.unwrap_or_else(is_cut);
    is_part.then_some(RunPart { recorded_s, set_s })
}

fn only_a_part(path: &Path, part: RunPart) -> anyhow::Error {
    let RunPart { recorded_s, set_s } = part;
    let of = set_s.map_or_else(
        || "its end is lost".to_owned(),
        |set_s| format!("the run was set to last {set_s:.0} s"),
    );
    with_help(
        format!(
            "{}: {recorded_s:.1} s recorded, and {of}: a part is not judged as the whole",
            path.display()
        ),
        "run it again; or judge what there is with `rsrs label BAG --part`, which does not count",
    )
}

/// Takes the label that a person has given to a bag.
pub fn label_by(path: &Path, who: &str) -> anyhow::Result<Labelled> {
    let labels = human_labels::read(path)?;
    let name = path.display();
    match human_labels::by(&labels, who) {
        Some(label) => Ok(Labelled::by_hand(path, label, labels.clone())),
        None => Err(with_help(
            format!("{name}: has no label by {who}"),
            format!(
                "watch it and record what it shows: `rsrs label {} --as PHASE --by {}`",
                quoted(path),
                quoted(who)
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_was_stopped_early_is_not_just_too_short() {
        let lost = "lost robot_2: silent for more than 1 s".to_owned();
        let ending =
            |kind| Ending { kind, reason: lost.clone(), lost: Vec::new(), paused: Vec::new() };
        let short = || JudgeError::TooShort { duration_s: 34.0, window: Window::default() };

        let aborted = NoLabel::from_error(short(), Some(&ending(EndingKind::Aborted)), &[]);
        let completed = NoLabel::from_error(short(), Some(&ending(EndingKind::Completed)), &[]);

        let refused = aborted.refused(Path::new("bag")).to_string();
        assert!(refused.contains("aborted after 34.0 s (lost robot_2: silent"), "{refused}");
        assert_eq!(completed, NoLabel::Judge(short()));
    }
}
