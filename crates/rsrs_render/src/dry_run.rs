//! What a dry run has come to, arrow by arrow.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::Choice;
use rsrs_core::numerals::percent;
use rsrs_files::quoted;
use rsrs_pipeline::choose::NoViableCell;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::source::ResolvedSweep;

use crate::choice::{as_measured, in_fresh_runs, reason};
use crate::settling;
use crate::sweep::in_words;

/// How much worse than measured the simulated robots are.
pub fn measured_and_harsher(source: &ResolvedSweep) -> anyhow::Result<String> {
    let measured = &source.profile;
    let simulated = source.sweep.factors(measured).apply(measured)?;
    Ok(format!(
        "profile: {}, as measured; simulated worse: spread of the gains {} to {}, missed detections \
         {} to {}, false ones {} to {}",
        measured.name,
        percent(measured.actuation.speed.robot_sd),
        percent(simulated.actuation.speed.robot_sd),
        percent(1.0 - measured.sensing.true_positive),
        percent(1.0 - simulated.sensing.true_positive),
        percent(measured.sensing.false_positive),
        percent(simulated.sensing.false_positive),
    ))
}

/// What the sweep found.
pub fn swept(result: &SweepResult) -> String {
    format!(
        "sweep: {} cells, {} runs of {} s each in both worlds: {}",
        result.diagram.cells.len(),
        result.source.sweep.replicates,
        result.source.sweep.duration_s,
        in_words(&result.diagram.majorities())
    )
}

/// Which cell was chosen, and how sure that is.
pub fn chosen(choice: &Choice) -> String {
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
pub fn left(left: &Left<'_>) -> String {
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
