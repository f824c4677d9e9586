//! `rsrs label`: what a bag shows, by the one judge and by people.

use std::collections::BTreeSet;
use std::path::PathBuf;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::{Phase, unknown};
use rsrs_core::robot::pose_source::PoseSource;

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments};
use crate::notes::print_note;
use rsrs_pipeline::compare::run_matching::{LABEL, refuse};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::label::agreement::agreement;
use rsrs_pipeline::label::human_labels::{self, HumanLabel};
use rsrs_pipeline::label::{CutRun, GivenBodies, LabelOptions, Labelled, label_bag};
use rsrs_pipeline::recorded_run;
use rsrs_pipeline::sweep::source::{behaviour, read_profile};
use rsrs_render::agreement::text as agreed;
use rsrs_render::label::{added, explained, text};
use rsrs_render::words::Words;

/// Label bags with the phase that their swarm settled into.
///
/// The judge looks at the last 60 s in which the run's lease was RUNNING, or else in which robots
/// were commanded to move. It needs poses. The robots' body and sensing range come from
/// `--profile`, their reach alone from `--reach`, or else both from the record of the experiment that
/// bags of `rsrs` hold. Without them nothing is labelled, and the output shows which reach gives
/// which phase.
///
/// Bags that cannot be labelled are named, each with its reason, when the others are labelled; the
/// exit code is 1 then. A damaged bag is refused; `rsrs bag recover` saves what is left of it, and of
/// a run whose end is lost `--part` labels what there is.
///
/// With `--as` the label is yours: it is added to a file in the bag's folder, and changes nothing
/// that is there. With `--agreement` nothing is labelled: it shows how far the judge and people agree,
/// and which bags to look at again.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs label results/run_*
  rsrs label results/run_1 --as semi_stable_milling --by ana --note 'two robots outside'
  rsrs label --agreement results/run_*")]
pub struct Arguments {
    /// Bags: rosbag2 folders or single .mcap files.
    #[arg(required = true, value_name = "BAG")]
    bags: Vec<PathBuf>,
    /// Add a label of your own.
    #[arg(long = "as", value_name = "PHASE", requires = "by",
          conflicts_with_all = ["agreement", "profile", "reach", "poses", "part"])]
    phase: Option<String>,
    /// Your name, for your own label.
    #[arg(long, value_name = "WHO", requires = "phase")]
    by: Option<String>,
    /// A note on your own label.
    #[arg(long, value_name = "TEXT", requires = "phase")]
    note: Option<String>,
    /// Report how far the judge and people agree, instead of labelling.
    #[arg(long)]
    agreement: bool,
    /// The robots' profile, for the radius of their body and their sensing range (default: from each
    /// bag's record).
    #[arg(long, value_name = "PROFILE")]
    profile: Option<PathBuf>,
    /// How far from the centre of a robot it senses the centre of another, in metres (default: from
    /// each bag's record).
    #[arg(long, value_name = "M", conflicts_with = "profile",
          value_parser = crate::numbers::number("a positive number of metres", |reach_m| reach_m > 0.0))]
    reach: Option<f64>,
    /// What to judge it for: milling, aggregation, dispersal, or the path of a file (default: what the
    /// bag's record has, else milling).
    #[arg(long, value_parser = behaviour)]
    behaviour: Option<Behaviour>,
    /// Where poses come from (default: what the run went by; where nothing in the bag states it, the
    /// first of these that has poses of all robots).
    #[arg(long, value_parser = crate::pose_arguments::pose_sources())]
    poses: Option<PoseSource>,
    /// Label what there is of a run whose end was not recorded; `rsrs compare` does not count such a
    /// label.
    #[arg(long)]
    part: bool,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// The phase of a name: of what is built in, of the file that `--behaviour` names, or of what the runs of
/// the bags were made for.
fn phase_of(key: &str, bags: &[PathBuf]) -> anyhow::Result<Phase> {
    let of_record = |bag: &PathBuf| -> anyhow::Result<Option<Phase>> {
        let record = recorded_run::record_in(&recorded_run::open_damaged(bag)?)?;
        let Some(record) = record else { return Ok(None) };
        let mut phases = record.conditions.behaviour.phases().iter();
        Ok(phases.find(|phase| phase.key() == key).copied())
    };
    if let Some(phase) = Phase::from_key(key) {
        return Ok(phase);
    }
    for bag in bags {
        if let Some(phase) = of_record(bag)? {
            return Ok(phase);
        }
    }
    let keys: Vec<&str> = Phase::all().map(Phase::key).collect();
    let phases = keys.join(", ");
    Err(bad_arguments(with_help(
        unknown(key),
        format!("the phases are: {phases}; `--behaviour FILE` adds those of a file"),
    )))
}

/// Runs the command. Bags that cannot be labelled are reported, each with its reason, when the
/// others are.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some((phase, by)) = arguments.phase.as_deref().zip(arguments.by.as_deref()) {
        let phase = phase_of(phase, &arguments.bags)?;
        let label = HumanLabel::now(phase, by, arguments.note.as_deref())?;
        return add(arguments, &label);
    }
    let options = options(arguments)?;
    if arguments.agreement {
        return {
            let result = agreement(&arguments.bags, options)?;
            report(arguments.format, &result, agreed(&result))?;
            Ok(Outcome::Done)
        };
    }
    let mut labelled: Vec<Labelled> = Vec::new();
    let mut refusals = Vec::new();
    for bag in &arguments.bags {
        match label_bag(bag, options) {
            Ok(label) => labelled.push(label),
            Err(refusal) => refusals.push(refusal),
        }
    }
    if !labelled.is_empty() {
        report(arguments.format, &labelled, Words::lines(labelled.iter().map(text)))?;
        if arguments.format == Format::Text {
            let behaviours: BTreeSet<Behaviour> =
                labelled.iter().map(|label| label.phase.behaviour()).collect();
            for behaviour in behaviours {
                print_note(format!("note: {}", explained(behaviour)));
            }
        }
    }
    match <[anyhow::Error; 1]>::try_from(refusals) {
        // One bag alone has its whole story.
        Ok([refusal]) if labelled.is_empty() => Err(refusal),
        Ok(refusals) => refuse(LABEL, &refusals, arguments.bags.len()).map(|()| Outcome::Done),
        Err(refusals) => refuse(LABEL, &refusals, arguments.bags.len()).map(|()| Outcome::Done),
    }
}

/// Adds a person's label to every bag; to none if one of them is no bag or its labels do not read.
fn add(arguments: &Arguments, label: &HumanLabel) -> anyhow::Result<Outcome> {
    for bag in &arguments.bags {
        // Who has watched the run needs no recording of it.
        recorded_run::open_damaged(bag)?;
        human_labels::read(bag)?;
    }
    let mut labelled = Vec::new();
    let mut lines = Vec::new();
    for bag in &arguments.bags {
        let path = human_labels::add(bag, label)?;
        let labels = human_labels::read(bag)?;
        lines.push(added(label, bag, labels.len(), &path));
        labelled.push(Labelled::by_hand(bag, label, labels));
    }
    report(arguments.format, &labelled, lines.join("\n"))?;
    Ok(Outcome::Done)
}

fn options(arguments: &Arguments) -> anyhow::Result<LabelOptions> {
    let bodies = match &arguments.profile {
        None => (arguments.reach)
            .map(|reach_m| GivenBodies { reach_m: Some(reach_m), ..GivenBodies::default() }),
        Some(path) => {
            let profile = read_profile(path)?;
            let (radius_m, reach_m) = (profile.body.radius_m, profile.reach_m());
            let (radius_m, reach_m) = (Some(radius_m), Some(reach_m));
            Some(GivenBodies { radius_m, reach_m, arena_m: None })
        }
    };
    let cut = if arguments.part { CutRun::Judged } else { CutRun::Refused };
    Ok(LabelOptions { bodies, poses: arguments.poses, cut, behaviour: arguments.behaviour })
}
