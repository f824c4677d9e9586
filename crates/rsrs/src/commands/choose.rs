//! `rsrs choose`: the most robust milling cell, confirmed.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::{Choice, Margin, VIABLE_B_S_LOW};
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::tidy;
use serde::Serialize;

use crate::commands::{Format, print_text, report, report_written};
use crate::failure::Outcome;
use crate::progress::execution;
use crate::setting_arguments::SettingArguments;
use crate::words::{Tone, Words};
use rsrs_pipeline::choose::extension::{Extension, extensions};
use rsrs_pipeline::choose::{Chosen, alternatives_text, as_measured, choose, write};
use rsrs_pipeline::sweep::ablation::{Ablation, REPLICATES, ablate};
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::settling;
use rsrs_pipeline::wording::counted;
use rsrs_pipeline::wording::shell::{experiment_beside, free_beside, quoted, sweep_beside};

/// Choose the milling cell that may drift furthest, and confirm it on fresh seeds.
///
/// The share of mills that counts is the smaller of both worlds': robots made worse, and as measured.
/// It is smoothed over neighbouring cells; cells of which no neighbour surely fails come first, and then
/// they are ranked by their depth inside the region where it is viable. From the first on, cells are
/// confirmed in both worlds until one is viable: what was swept flatters a cell, so only fresh runs feed
/// its `B_s`. It is also reported what a denser start and other numbers of robots would give.
/// The last lines show which of the factors that make robots worse matters in that cell: each
/// alone, and all but each. Exit code 3 means that no cell is viable; `rsrs diagnose FOLDER` finds what
/// would have to be changed about the robots.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Least confirmed lower bound of `B_s` of a viable cell, in both worlds (default: 0.8).
    #[arg(long, value_name = "SHARE", default_value_t = VIABLE_B_S_LOW, hide_default_value = true,
          value_parser = share)]
    viable: f64,
    /// Write the choice into this file too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    setting: SettingArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// A share from 0 to 1, from the command line.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err("expected a share from 0 to 1".into())
    }
}

/// Runs the command.
///
/// # Errors
///
/// If the folder is not a sweep's or the choice cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = arguments.setting.options(arguments.viable)?;
    match choose(&arguments.folder, options)? {
        Chosen::Viable(choice) => {
            if let Some(path) = &arguments.output {
                write(path, &choice)?;
            }
            let wider = wider(&arguments.folder, &choice)?.map(|wider| format!("\n{wider}"));
            let printed = text(&choice, arguments.viable) + &wider.unwrap_or_default();
            let words = Words::from(printed).tone(Tone::Good, VIABLE);
            report_with_factors(arguments, &choice, &choice.cell, words)?;
            report_next(arguments)?;
            Ok(Outcome::Done)
        }
        Chosen::NoViableCell(none) => {
            let mut lines = vec![format!("{NO_VIABLE_CELL}: {}", none.reason)];
            lines.extend(alternatives(&none.best, arguments.viable));
            let printed = lines.join("\n");
            let words = Words::from(printed).tone(Tone::Bad, NO_VIABLE_CELL);
            report_with_factors(arguments, &none, &none.best.cell, words)?;
            if arguments.format == Format::Text {
                let next = format!("next: rsrs diagnose {}", quoted(&arguments.folder));
                print_text(next + "   # what would have to be changed")?;
            }
            Ok(Outcome::NegativeAnswer)
        }
    }
}

/// An answer, and which factors make the robots of its cell worse.
#[derive(Serialize)]
struct WithFactors<'a, T> {
    #[serde(flatten)]
    answer: &'a T,
    /// What every factor does in that cell; `null` if none changes this robot.
    factors: Option<Ablation>,
}

fn report_with_factors<T: Serialize>(
    arguments: &Arguments,
    answer: &T,
    cell: &Cell,
    words: Words,
) -> anyhow::Result<()> {
    let result = folder::read(&arguments.folder)?;
    let replicates = REPLICATES.min(arguments.setting.confirm);
    let factors = ablate(&result.source, cell, replicates, execution(arguments.setting.threads)?)?;
    let words = match &factors {
        Some(factors) => words.below(factors.in_words()),
        None => words,
    };
    report(arguments.format, &WithFactors { answer, factors }, words)
}

/// Where the choice was written, and what follows from it.
fn report_next(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.format == Format::Json {
        return Ok(());
    }
    let folder = quoted(&arguments.folder);
    let Some(path) = &arguments.output else {
        let kept = quoted(arguments.folder.join("choice.json"));
        let next =
            format!("next: rsrs choose {folder} -o {kept}   # keeps it, for run and diagram");
        return print_text(next);
    };
    report_written(Format::Text, path)?;
    let experiment = experiment_beside(&arguments.folder);
    let next = format!(
        "next: rsrs plan-experiments {folder}\nthen: rsrs run {experiment} --from {folder}"
    );
    print_text(next)
}

/// What a chosen cell is called, and how a person reads it.
const VIABLE: &str = "viable";
const NO_VIABLE_CELL: &str = "no viable cell";

fn text(choice: &Choice, viable: f64) -> String {
    let margins = choice.margin.iter().map(|(axis, margin)| drift(choice, *axis, *margin));
    let mut lines = vec![
        format!(
            "{VIABLE}: {} (surely {:.0} % of its runs or more {}, made worse and as measured)",
            choice.cell,
            100.0 * viable,
            choice.behaviour().verb().plain
        ),
        format!(
            "  made worse, it {} in {:.1} % of {} fresh runs (95 % interval {:.1} to {:.1} %)",
            choice.behaviour().verb().does,
            100.0 * choice.b_s,
            choice.n_replicates,
            100.0 * choice.b_s_low,
            100.0 * choice.b_s_high
        ),
    ];
    lines.extend(tried(choice));
    lines.extend(as_measured(choice).map(|text| format!("  {text}")));
    lines.extend(choice.settling.map(|settling| format!("  {}", settling::text(&settling))));
    let did = choice.behaviour().verb().did;
    let converged =
        |time_s: f64| format!("  half of the runs that {did} had come to it by {time_s:.0} s");
    lines.extend(choice.converged_s.map(converged));
    lines.extend(alternatives(choice, viable));
    lines.extend(by_circliness(choice));
    lines.extend(margins);
    if choice.margin.values().any(|margin| margin.low > 0.0 || margin.high > 0.0) {
        lines.push(
            "  (by the runs of the sweep, from swept value to swept value; the margins of `rsrs answer` \
             are of finer values and runs of their own, and may be wider or narrower)"
                .to_owned(),
        );
    }
    lines.join("\n")
}

/// How far a value may drift, and what is known beyond.
fn drift(choice: &Choice, axis: Axis, margin: Margin) -> String {
    let Margin { low, high } = margin;
    let edge = choice.edge.get(&axis).copied().unwrap_or_default();
    let value = choice.cell.get(axis).unwrap_or_default();
    let unit = axis.unit();
    let edges = match (edge.low, edge.high) {
        (false, false) => String::new(),
        (true, false) => {
            format!("edge of the sweep: nothing was swept below {}", tidy(value - low))
        }
        (false, true) => {
            format!("edge of the sweep: nothing was swept above {}", tidy(value + high))
        }
        (true, true) => format!(
            "edge of the sweep: nothing was swept below {} and above {}",
            tidy(value - low),
            tidy(value + high)
        ),
    };
    let behind = |edges: String| if edges.is_empty() { edges } else { format!("; {edges}") };
    if low == 0.0 && high == 0.0 {
        return match (edge.low, edge.high) {
            (false, false) => {
                format!("  {axis} may not drift: the next values that were swept are not viable")
            }
            (true, true) => {
                format!("  how far {axis} may drift is unknown: no value beside {value} was swept")
            }
            (true, false) => {
                format!("  {axis} may not drift upward: the next value is not viable; {edges}")
            }
            (false, true) => {
                format!("  {axis} may not drift downward: the next value is not viable; {edges}")
            }
        };
    }
    let low = if low == 0.0 { low.to_string() } else { format!("-{low}") };
    format!("  {axis} may drift by {low} to +{high} {unit}{}", behind(edges))
}

/// The sweep that would have the chosen cell inside, if it lies at the edge of this one.
fn wider(folder: &Path, choice: &Choice) -> anyhow::Result<Option<String>> {
    let found = extensions(&folder::read(folder)?, choice);
    let (possible, ends): (Vec<_>, Vec<_>) =
        found.into_iter().partition(|extension| !extension.values.is_empty());
    let mut lines: Vec<String> = Vec::new();
    for Extension { axis, end, .. } in &ends {
        lines.push(format!("  {axis} {end} is as far as these robots can go"));
    }
    if possible.is_empty() {
        return Ok((!lines.is_empty()).then(|| lines.join("\n")));
    }
    let (sweep, next) = (sweep_beside(folder), quoted(free_beside(folder)));
    lines.push(format!(
        "the cell lies at the edge of the sweep; to see beyond it, put into {sweep}"
    ));
    for Extension { axis, values, .. } in &possible {
        let values: Vec<String> = values.iter().map(ToString::to_string).collect();
        lines.push(format!("  {axis}: [{}]", values.join(", ")));
    }
    lines.push(format!("and run: rsrs sweep {sweep} -o {next}"));
    Ok(Some(lines.join("\n")))
}

/// How many cells came before this one and did not hold.
fn tried(choice: &Choice) -> Option<String> {
    let n_before = choice.candidates_tried?.checked_sub(1).filter(|n| *n > 0)?;
    Some(format!("  {} ranked before it did not hold", counted(n_before, "cell")))
}

/// What other starts and numbers would give.
fn alternatives(choice: &Choice, viable: f64) -> Vec<String> {
    alternatives_text(choice, viable).into_iter().map(|line| format!("  {line}")).collect()
}

/// How `B_s` moves with the circliness from which a mill is called stable.
fn by_circliness(choice: &Choice) -> Option<String> {
    let [lower, stable, higher] = choice.by_circliness.as_slice() else { return None };
    Some(format!(
        "  a mill is stable from a circliness of {} on (0: a filled disc, 1: a thin ring); from {} on it \
         would be {:.1} %, from {} on {:.1} %",
        stable.stable_circliness,
        lower.stable_circliness,
        100.0 * lower.b_s,
        higher.stable_circliness,
        100.0 * higher.b_s
    ))
}
