//! Which bags may be held against a sweep: those of the experiment that was simulated, each run
//! once.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_bags::Bag;
use rsrs_core::conditions::operator::OperatorConditions;
use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::other_profile::{OtherProfile, ProfilesDiffer};
use rsrs_files::quoted;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{Backend, Ending, EndingKind, ExperimentRecord, LostRobot, PausedRobot};
use rsrs_sim::sweep::confirmation_seed;

use crate::attempt::number_aside;
use crate::compare::not_counted::{LeftOutRun, NotCounted, NotCountedCause};
use crate::error::{help_of, in_one_line, with_help};
use crate::files::folder_of;
use crate::recorded_run::{self, BrokenRecording, LossyRecovery};
use crate::sweep::result::SweepResult;

/// A bag of a run that a swept cell stands for.
#[derive(Clone, Debug)]
pub struct Admitted {
    /// The bag.
    pub bag: PathBuf,
    /// Index of its cell in the diagram.
    pub cell: usize,
    /// How the run was set up.
    pub record: ExperimentRecord,
    /// How it ended; `None` if that is unknown. Only a completed run counts.
    pub ending: Option<Ending>,
    /// Why it is unknown what the whole run was, where it is.
    pub incomplete: Option<String>,
    /// Whether its robots were ever allowed to move.
    pub has_started: bool,
    /// Where it is kept, if another run was made in its place.
    pub made_again: Option<String>,
    /// That its robots have another profile than those of the sweep, where somebody insists.
    pub other_profile: Option<ProfilesDiffer>,
}

impl Admitted {
    /// Robots that did not take part to the end.
    pub fn lost(&self) -> &[LostRobot] {
        self.ending.as_ref().map_or(&[], |ending| &ending.lost)
    }

    /// When robots stood because leases did not reach them, and went on.
    pub fn paused(&self) -> &[PausedRobot] {
        self.ending.as_ref().map_or(&[], |ending| &ending.paused)
    }

    /// The run as one of this cell that does not count, and why.
    pub fn left_out(self, cell: &Cell, (cause, reason): (NotCountedCause, String)) -> LeftOutRun {
        let not_counted = NotCounted {
            cell: cell.clone(),
            cause,
            ending: self.ending.as_ref().map_or("unknown", |ending| ending.kind.key()),
            reason,
            lost_robots: self.lost().to_vec(),
            after_start: self.has_started,
            bag: self.bag,
        };
        let number = self.record.fixed.map(|fixed| fixed.number);
        LeftOutRun { cell: self.cell, number, not_counted }
    }

    /// Why it does not count, whatever its label, with the cause in full; `None` if it does.
    pub fn cause(&self) -> Option<(NotCountedCause, String)> {
        if let Some(reason) = &self.incomplete {
            return Some((NotCountedCause::Incomplete, reason.clone()));
        }
        let Some(ending) = &self.ending else {
            return Some((
                NotCountedCause::Incomplete,
                "does not state how its run ended".to_owned(),
            ));
        };
        let lost = ending.lost.iter().map(ToString::to_string);
        let reason = Some(ending.reason.clone()).filter(|reason| !reason.is_empty());
        let reasons: Vec<String> = reason.into_iter().chain(lost).collect();
        let counts = self.record.counts_without(&ending.lost);
        let without_robots = (!counts).then_some(NotCountedCause::RobotLost);
        let made_again = self.made_again.is_some().then_some(NotCountedCause::MadeAgain);
        let cause = NotCountedCause::of_ending(ending.kind).or(without_robots).or(made_again)?;
        let reasons = reasons.into_iter().chain(self.made_again.clone());
        Some((cause, reasons.collect::<Vec<_>>().join("; ")))
    }
}

/// Reads the records of bags, and refuses those that no swept cell stands for, all in one error.
/// Attempts that a campaign has made again are kept beside their bags and come along.
///
/// A sweep that varies what is unknown of a real robot is refused first.
pub fn admit(
    result: &SweepResult,
    bags: &[PathBuf],
    other_profile: OtherProfile,
) -> anyhow::Result<Vec<Admitted>> {
    let matcher = RunMatcher::to(result, other_profile)?;
    let mut admitted = bags_alone(&matcher, bags)?;
    for bag in kept_beside(bags) {
        // What does not state its experiment is no attempt at one of the sweep's.
        match matcher.admit(&bag) {
            Ok(run) if admitted.iter().all(|other| other.record.run_id != run.record.run_id) => {
                let kept = "kept beside the run that was made in its place";
                admitted.push(Admitted { made_again: Some(kept.to_owned()), ..run });
            }
            Ok(_) => {}
            Err(error) => log::warn!("{}", in_one_line(&error)),
        }
    }
    Ok(admitted)
}

/// The recordings of attempts that were made again, as they are kept beside their bags, without those that
/// are among the bags.
fn kept_beside(bags: &[PathBuf]) -> Vec<PathBuf> {
    let mut kept = BTreeSet::new();
    for bag in bags {
        let Some(name) = bag.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            continue;
        };
        let entries = folder_of(bag).read_dir().into_iter().flatten().flatten();
        let numbered = entries.filter_map(|entry| {
            let aside = entry.file_name().to_string_lossy().into_owned();
            number_aside(&name, &aside)
                .map(|number| (bag.clone(), number, bag.with_file_name(aside)))
        });
        kept.extend(numbered);
    }
    let paths = kept.into_iter().map(|(_, _, path)| path);
    paths.filter(|path| !bags.contains(path)).collect()
}

fn bags_alone(matcher: &RunMatcher, bags: &[PathBuf]) -> anyhow::Result<Vec<Admitted>> {
    let mut admitted: Vec<Admitted> = Vec::new();
    let mut refusals = Vec::new();
    for bag in bags {
        let run = matcher.admit(bag).and_then(|run| {
            refuse_repeated(&run, &admitted)?;
            Ok(run)
        });
        match run {
            Ok(run) => admitted.push(run),
            Err(refusal) => refusals.push(refusal),
        }
    }
    refuse(COMPARE, &refusals, bags.len())?;
    Ok(admitted)
}

/// What cannot be done with bags, and what to do instead.
#[derive(Clone, Copy, Debug)]
pub struct Refusal {
    what: &'static str,
    help: &'static str,
}

/// Bags of other experiments.
const COMPARE: Refusal = Refusal {
    what: "compared with this sweep",
    help: "leave such bags out, or compare them with the sweep that simulates their experiment",
};

/// Bags that the judge cannot label.
pub const LABEL: Refusal = Refusal { what: "labelled", help: "leave such bags out" };

/// Turns the reasons for which some of `n_bags` bags are refused, one each, into one error that has
/// them all; without a reason there is none.
pub fn refuse(refusal: Refusal, reasons: &[anyhow::Error], n_bags: usize) -> anyhow::Result<()> {
    let Refusal { what, help } = refusal;
    let Some((first, others)) = reasons.split_first() else { return Ok(()) };
    // What mends one of them mends the others only if it is the same.
    let own_help = help_of(first)
        .filter(|own| others.iter().all(|other| help_of(other).as_ref() == Some(own)));
    let lines: Vec<String> = reasons.iter().map(in_one_line).collect();
    let which = match others {
        [] => "a bag".to_owned(),
        _ => format!("{} of {n_bags} bags", lines.len()),
    };
    let message = format!("{which} cannot be {what}\n  {}", lines.join("\n  "));
    Err(with_help(message, own_help.unwrap_or_else(|| help.to_owned())))
}

/// What a sweep asks of a bag.
struct RunMatcher<'a> {
    diagram: &'a PhaseDiagram,
    /// What each cell stands for, in the order of the diagram.
    operator_conditions: Vec<OperatorConditions>,
    /// Digests of the worlds that were simulated, in the order of the diagram.
    worlds: Vec<u64>,
    seed: u64,
    /// Digest of the profile of its robots, and what to do about others.
    profile_digest: String,
    other_profile: OtherProfile,
    /// The value of each capability that the sweep has one value of.
    capabilities: Vec<(Axis, f64)>,
}

impl<'a> RunMatcher<'a> {
    fn to(result: &'a SweepResult, other_profile: OtherProfile) -> anyhow::Result<Self> {
        let diagram = &result.diagram;
        let duration_s = result.source.sweep.duration_s;
        let cells = result.source.cells("sweep.yaml")?;
        let operator_conditions =
            cells.iter().map(|(_, conditions)| OperatorConditions::new(conditions, duration_s));
        let capabilities = diagram
            .axes
            .iter()
            .filter(|axis| axis.is_capability())
            .map(|axis| Ok((*axis, single_value(diagram, *axis)?)));
        Ok(Self {
            diagram,
            operator_conditions: operator_conditions.collect(),
            worlds: cells.iter().map(|(_, conditions)| conditions.digest()).collect(),
            seed: result.source.sweep.seed,
            profile_digest: result.source.profile.digest(),
            other_profile,
            capabilities: capabilities.collect::<anyhow::Result<_>>()?,
        })
    }

    fn admit(&self, path: &Path) -> anyhow::Result<Admitted> {
        let bag = recorded_run::open_damaged(path)?;
        let name = path.display();
        let record = recorded_run::record_in(&bag)?.with_context(|| {
            format!("{name}: holds no record of its experiment, so what was run is unknown")
        })?;
        if record.backend == Backend::Mixed {
            bail!(
                "{name}: at least some of its robots were simulated, so it is no evidence of reality"
            );
        }
        let run = record.operator_conditions();
        let cell = self.diagram.locate(&self.cell(&run)).with_context(|| name.to_string())?;
        self.operator_conditions[cell].admit(&run).with_context(|| name.to_string())?;
        self.refuse_own(path, &record, cell)?;
        let found = &record.provenance.profile_digest;
        let other_profile =
            self.other_profile.admit(&self.profile_digest, found).map_err(|differ| {
                // Each bag has the profile of its robots.
                with_help(format!("{name}: {differ}"), ProfilesDiffer::help("PROFILE.yaml"))
            })?;
        let ending = recorded_run::ending_in(&bag)?;
        let incomplete = incomplete(&bag);
        let has_started = recorded_run::has_started(&bag);
        Ok(Admitted {
            bag: path.to_path_buf(),
            cell,
            record,
            ending,
            incomplete,
            has_started,
            made_again: None,
            other_profile,
        })
    }

    /// Refuses a replicate of the sweep itself: a prediction that is held against itself always holds.
    fn refuse_own(
        &self,
        path: &Path,
        record: &ExperimentRecord,
        cell: usize,
    ) -> anyhow::Result<()> {
        let is_its_world =
            record.backend == Backend::Simulator && record.conditions.digest() == self.worlds[cell];
        let seeds = [self.seed, confirmation_seed(self.seed)];
        if !(is_its_world && seeds.contains(&record.seed)) {
            return Ok(());
        }
        Err(with_help(
            format!(
                "{}: is a replicate of the sweep itself, with its robots and its seed, {}, so it is no \
                 evidence about reality",
                path.display(),
                record.seed
            ),
            "compare runs of the robots; where a simulator stands in for them, it moves the robots as \
             measured, and has a seed of its own (`--seed`)",
        ))
    }

    /// The values of a run on the swept axes.
    fn cell(&self, run: &OperatorConditions) -> Cell {
        // A table that is two commands is recorded as those, and its numbers are in the cell that has them.
        let is_its = |swept: &OperatorConditions| swept.controller == run.controller;
        let same = self.operator_conditions.iter().position(is_its);
        let number = |axis: Axis| match axis {
            Axis::Number(_) => self.diagram.cells[same?].cell.get(axis),
            _ => None,
        };
        let settings = (self.diagram.axes.iter())
            .filter_map(|axis| Some((*axis, run.setting(*axis).or_else(|| number(*axis))?)));
        Cell::new(settings.chain(self.capabilities.iter().copied()))
            .expect("the axes of a sweep are distinct, and numbers in JSON finite")
    }
}

/// Why it is unknown what a whole run was; `None` for a bag that is whole.
fn incomplete(bag: &Bag) -> Option<String> {
    let recover = || format!("`rsrs bag recover {}` saves what can be saved", quoted(bag.path()));
    let broken = BrokenRecording::in_bag(bag).map(|broken| format!("{broken}; {}", recover()));
    broken.or_else(|| LossyRecovery::in_bag(bag).map(|lossy| lossy.to_string()))
}

fn single_value(diagram: &PhaseDiagram, axis: Axis) -> anyhow::Result<f64> {
    let values = diagram.values(axis);
    if let [value] = values[..] {
        return Ok(value);
    }
    let values: Vec<String> = values.iter().map(f64::to_string).collect();
    Err(with_help(
        format!(
            "the sweep varies {axis} ({}), which is a property of the robots and not a setting: \
             no bag records which of these values its robots have, so none belongs to one cell",
            values.join(", ")
        ),
        format!("compare with a sweep that gives {axis} one value, under `fixed`"),
    ))
}

/// Refuses a run that is there already: it would count twice.
fn refuse_repeated(run: &Admitted, others: &[Admitted]) -> anyhow::Result<()> {
    let is_same_run = |other: &&Admitted| other.record.run_id == run.record.run_id;
    if let Some(other) = others.iter().find(is_same_run) {
        bail!("{} is the same run as {}", run.bag.display(), other.bag.display());
    }
    // In lockstep only the seed distinguishes one run from the next: their worlds are equal bit by bit.
    // A run that does not count does not forbid to make up for it.
    let world = |run: &Admitted| {
        let Admitted { record, ending, .. } = run;
        let is_completed =
            ending.as_ref().is_some_and(|ending| ending.kind == EndingKind::Completed);
        let counts = is_completed && record.time == Time::Lockstep;
        let conditions = &record.provenance.conditions_digest;
        counts.then(|| (record.seed, record.replicate, conditions.clone()))
    };
    let is_same_world = |other: &&Admitted| world(run).is_some() && world(other) == world(run);
    match others.iter().find(is_same_world) {
        None => Ok(()),
        Some(other) => Err(with_help(
            format!(
                "{}: repeats {}, a simulated run with the same seed, {}",
                run.bag.display(),
                other.bag.display(),
                run.record.seed
            ),
            "a simulated run is new evidence only with a seed of its own, and without `--seed` every one \
             has that of its experiment file: run it with another `--seed`",
        )),
    }
}
