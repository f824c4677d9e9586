//! `rsrs choose`: the most robust milling cell, confirmed.

use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::{Choice, VIABLE_B_S_LOW};
use rsrs_core::quantity::Cell;
use serde::Serialize;

use crate::commands::{Format, print_text, report, report_written};
use crate::failure::Outcome;
use crate::progress::execution;
use crate::setting_arguments::SettingArguments;
use crate::words::{Tone, Words};
use rsrs_pipeline::choose::extension::{Extension, extensions};
use rsrs_pipeline::choose::text::{NO_VIABLE_CELL, VIABLE, none_viable, viable};
use rsrs_pipeline::choose::{Chosen, choose, write};
use rsrs_pipeline::sweep::ablation::{Ablation, REPLICATES, ablate};
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::wording::shell::{experiment_beside, free_beside, quoted, sweep_beside};

/// Choose the milling cell that may drift furthest, and confirm it on fresh seeds.
///
/// What counts is the smaller share of mills of both worlds (robots made worse, and as measured), smoothed
/// over neighbouring cells. Cells without a surely failing neighbour come first, and then those deepest
/// inside the region where this share is viable. In this order, cells are confirmed in both worlds until
/// one is viable; only these fresh runs count for its `B_s`, because the best of many swept cells looks
/// better than it is. The output also states what a denser start and other numbers of robots would give.
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
            let printed = viable(&choice, arguments.viable) + &wider.unwrap_or_default();
            let words = Words::from(printed).tone(Tone::Good, VIABLE);
            report_with_factors(arguments, &choice, &choice.cell, words)?;
            report_next(arguments)?;
            Ok(Outcome::Done)
        }
        Chosen::NoViableCell(none) => {
            let words =
                Words::from(none_viable(&none, arguments.viable)).tone(Tone::Bad, NO_VIABLE_CELL);
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
