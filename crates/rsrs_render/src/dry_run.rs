//! What a dry run has come to, arrow by arrow.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::Choice;
use rsrs_core::numerals::{counted, percent};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_files::quoted;
use rsrs_pipeline::attempt::Attempt;
use rsrs_pipeline::choose::NoViableCell;
use rsrs_pipeline::label::Labelled;
use rsrs_pipeline::run_summary::RunSummary;
use rsrs_pipeline::sweep::result::SweepResult;
use serde::{Serialize, Serializer};

use crate::choice::{NoViableCellJson, as_measured, in_fresh_runs, reason};
use crate::comparison::{self, Report};
use crate::label::toned_phase_of;
use crate::own_network::{self, Isolation};
use crate::run_summary::pace;
use crate::settling;
use crate::sweep::in_words;
use crate::words::Words;

/// What a dry run leaves, as JSON.
#[derive(Serialize)]
#[serde(untagged)]
pub enum DryRunResult {
    /// Experiments were run.
    Compared(Box<Compared>),
    /// No cell is viable.
    NothingToRun(Box<NothingToRun>),
}

/// What a dry run leaves whose experiments were run.
#[derive(Serialize)]
pub struct Compared {
    /// Where all of it is.
    pub folder: PathBuf,
    /// Where the files behind it are.
    pub launch_configs: PathBuf,
    /// Folder of the sweep.
    pub sweep: PathBuf,
    /// The phase diagram.
    pub diagram: PathBuf,
    /// The page of the report.
    pub report: PathBuf,
    /// The chosen cell.
    pub choice: Choice,
    /// Every run, those that did not count before those that did.
    pub experiments: Vec<RunSummary>,
    /// What came of them.
    pub comparison: Report,
}

/// What a dry run leaves where no cell is viable.
#[derive(Serialize)]
pub struct NothingToRun {
    /// Where all of it is.
    pub folder: PathBuf,
    /// Where the files behind it are.
    pub launch_configs: PathBuf,
    /// Folder of the sweep.
    pub sweep: PathBuf,
    /// Why there is none.
    #[serde(serialize_with = "as_json")]
    pub choice: NoViableCell,
}

fn as_json<S: Serializer>(none: &NoViableCell, serializer: S) -> Result<S::Ok, S::Error> {
    NoViableCellJson::from(none).serialize(serializer)
}

/// One of the experiments of a dry run.
#[derive(Clone, Copy, Debug)]
pub struct NumberedExperiment {
    /// Its number, from 1.
    pub number: u64,
    /// How many there are.
    pub n_experiments: NumberOfExperiments,
    /// Its seed.
    pub seed: u64,
}

/// How many experiments a dry run has.
#[derive(Clone, Copy, Debug)]
pub enum NumberOfExperiments {
    /// So many.
    Fixed(u64),
    /// As many as decide, and no more than these.
    AtMost(u64),
}

/// A step of a dry run that has come to something.
#[derive(Clone, Copy)]
pub enum Step<'a> {
    /// It is known how much worse than measured the simulated robots are.
    Profiles {
        /// Robots as measured.
        measured: &'a RobotProfile,
        /// The simulated ones.
        simulated: &'a RobotProfile,
    },
    /// The sweep is made.
    Swept(&'a SweepResult),
    /// A cell is chosen.
    Chosen(&'a Choice),
    /// Experiments begin, in this network.
    NetworkEntered(&'a Isolation),
    /// A run gave no result, and is made again.
    TriedAgain {
        /// The experiment.
        experiment: NumberedExperiment,
        /// The run.
        attempt: &'a Attempt,
    },
    /// An experiment was completed, and labelled.
    Ran {
        /// The experiment.
        experiment: NumberedExperiment,
        /// The run.
        summary: &'a RunSummary,
        /// Its label.
        label: &'a Labelled,
    },
    /// The experiments are compared with the sweep.
    Compared(&'a Report),
    /// Everything is written.
    Left(Left<'a>),
}

/// What a step has come to.
pub fn text(step: &Step<'_>) -> Words {
    match *step {
        Step::Profiles { measured, simulated } => measured_and_harsher(measured, simulated).into(),
        Step::Swept(result) => swept(result).into(),
        Step::Chosen(choice) => chosen(choice).into(),
        Step::NetworkEntered(isolation) => own_network::text(isolation).into(),
        Step::TriedAgain { experiment, attempt } => {
            let name = name(experiment);
            format!("{name}: {attempt}; it does not count, and is tried again").into()
        }
        Step::Ran { experiment, summary, label } => {
            let run = format!(
                "{}, {} s over DDS{}, {} recorded: ",
                name(experiment),
                summary.duration_s,
                pace(summary),
                counted(summary.n_messages, "message")
            );
            Words::from(run).then(toned_phase_of(label))
        }
        Step::Compared(comparison) => Words::from("").below(comparison::text(comparison)),
        Step::Left(left) => lines_of(&left).into(),
    }
}

/// `experiment 3 of at most 60: seed 3`.
fn name(experiment: NumberedExperiment) -> String {
    let of = match experiment.n_experiments {
        NumberOfExperiments::Fixed(n) => format!("of {n}"),
        NumberOfExperiments::AtMost(most) => format!("of at most {most}"),
    };
    format!("experiment {} {of}: seed {}", experiment.number, experiment.seed)
}

/// How much worse than measured the simulated robots are.
fn measured_and_harsher(measured: &RobotProfile, simulated: &RobotProfile) -> String {
    format!(
        "profile: {}, as measured; simulated worse: spread of the gains {} to {}, missed detections \
         {} to {}, false ones {} to {}",
        measured.name,
        percent(measured.actuation.speed.robot_sd),
        percent(simulated.actuation.speed.robot_sd),
        percent(1.0 - measured.sensing.true_positive),
        percent(1.0 - simulated.sensing.true_positive),
        percent(measured.sensing.false_positive),
        percent(simulated.sensing.false_positive),
    )
}

/// What the sweep found.
fn swept(result: &SweepResult) -> String {
    format!(
        "sweep: {} cells, {} runs of {} s each in both worlds: {}",
        result.diagram.cells.len(),
        result.source.sweep.replicates,
        result.source.sweep.duration_s,
        in_words(&result.diagram.majorities())
    )
}

/// Which cell was chosen, and how sure that is.
fn chosen(choice: &Choice) -> String {
    let chosen = format!("chosen: {}, which {}", choice.cell, in_fresh_runs(choice));
    let measured = as_measured(choice);
    let settling = choice.settling.map(|settling| settling::text(&settling));
    [Some(chosen), measured, settling].into_iter().flatten().collect::<Vec<_>>().join("\n  ")
}

/// Why nothing is run, and what comes next.
pub fn no_viable_cell(none: &NoViableCell, sweep: &Path) -> String {
    format!("no viable cell: {}\nnext: rsrs diagnose {}", reason(none), quoted(sweep))
}

/// What a dry run leaves.
#[derive(Clone, Copy, Debug)]
pub struct Left<'a> {
    /// Where all of it is.
    pub folder: &'a Path,
    /// Whether the files behind it were made for it, and lie there, too.
    pub has_starter_files: bool,
    /// The experiment file.
    pub experiment: &'a Path,
    /// Of the experiments that were completed.
    pub bags: &'a [PathBuf],
}

/// What is in which file, and how to go on.
fn lines_of(left: &Left<'_>) -> String {
    let Left { experiment, bags, .. } = left;
    let folder = left.folder.display();
    let mut lines = vec![String::new()];
    if left.has_starter_files {
        lines.push(format!(
            "{folder}/launch_configs   the files behind it: change them and run again"
        ));
    }
    lines.extend([
        format!("{folder}/sweep            cells.csv, replicates.parquet, choice.json"),
        format!("{folder}/diagram.png      the phase diagram (also as .svg)"),
        format!("{folder}/comparison.json"),
    ]);
    lines.push(match bags {
        [] => format!("{folder}/bags             no experiment was completed"),
        [bag] => format!("{}   its recording", bag.display()),
        [.., last] => {
            format!("{folder}/bags             experiment_1 and on, to {}", last.display())
        }
    });
    lines.push(format!(
        "one experiment again: rsrs run {} --from {}",
        quoted(experiment),
        quoted(left.folder.join("sweep"))
    ));
    lines.push(format!("all of it to look at: {folder}/report.html"));
    lines.join("\n")
}
