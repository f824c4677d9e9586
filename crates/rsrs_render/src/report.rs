//! A sweep and the runs that were compared with it, as one HTML file.

mod cells;
mod runs;
mod tables;

use std::path::Path;

use rsrs_core::comparison;
use rsrs_core::diagram::choice::Choice;
use rsrs_core::natural_order::natural_key;
use rsrs_core::numerals::{counted, percent, size};
use rsrs_pipeline::compare::{CompareOptions, compare};
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_view::report::{ReportPage, Slice, Verdict, VerdictMark, html as write};
use rsrs_view::simulator::source;

use crate::comparison::{self as comparing, ComparedBag, Report as Comparison, verdict_name};
use crate::picture::{self, DiagramOptions};
use crate::wording::{capitalised, quantity, robot_names};

/// What was written into a file: a page of so many runs.
pub fn written(file: &Path, n_runs: u64, n_bytes: u64) -> String {
    let runs = if n_runs > 0 { counted(n_runs, "run") } else { "no runs".to_owned() };
    format!("{}: {runs}, {}", file.display(), size(n_bytes))
}

/// Compares runs with the sweep of a folder, if there are some, and shows both on a page that needs
/// no other file: a diagram whose cells respond with their numbers and one of their runs in motion,
/// and every real run in motion beside its order parameters.
pub fn html(
    folder: &Path,
    runs: Option<&CompareOptions>,
) -> anyhow::Result<(String, Option<Comparison>)> {
    let result = folder::read(folder)?;
    let choice = folder::read_choice(folder)?;
    let mut comparison = runs.map(|runs| compare(folder, runs).map(Comparison::new)).transpose()?;
    if let Some(comparison) = &mut comparison {
        let path = |run: &ComparedBag| natural_key(&run.labelled.bag.to_string_lossy());
        comparison.bags.sort_by_cached_key(path);
    }
    let of = Reported {
        folder,
        result: &result,
        choice: choice.as_ref(),
        comparison: comparison.as_ref(),
    };
    Ok((write(&of.page()?), comparison))
}

/// What a report is about.
struct Reported<'a> {
    folder: &'a Path,
    result: &'a SweepResult,
    choice: Option<&'a Choice>,
    comparison: Option<&'a Comparison>,
}

impl Reported<'_> {
    fn page(&self) -> anyhow::Result<ReportPage> {
        let Self { result, comparison, .. } = self;
        let cells = cells::facts(self)?;
        let sweep = result.source.to_yaml();
        let mut details = vec![("The sweep with its profile".to_owned(), sweep)];
        if let Some(comparison) = comparison {
            details.insert(
                0,
                ("The comparison as text".to_owned(), comparing::text(comparison).to_string()),
            );
        }
        let robots = robot_names(&result.source);
        Ok(ReportPage {
            title: if comparison.is_some() {
                format!("Simulated runs and experiments: {robots}")
            } else {
                format!("Simulated runs: {robots}")
            },
            verdict: comparison.map(|comparison| Verdict {
                words: verdict_name(comparison.verdict).to_owned(),
                mark: mark(comparison.verdict),
            }),
            summary: comparison.map_or_else(Vec::new, summary),
            diagrams: self.diagrams()?,
            source: source(&result.source.sweep, &result.source.profile),
            first_cell: cells.iter().position(|cell| cell.is_chosen).unwrap_or(0),
            cells,
            chosen: self.choice.map(chosen),
            comparison: comparison.map_or_else(Vec::new, tables::comparison),
            runs: comparison.map(runs::facts).transpose()?.unwrap_or_default(),
            not_counted: comparison.and_then(tables::not_counted),
            profiles: tables::profiles(&result.source.profile, result.source.sweep.world())?,
            provenance: tables::provenance(self),
            details,
        })
    }

    /// One picture for each slice.
    fn diagrams(&self) -> anyhow::Result<Vec<Slice>> {
        let options = DiagramOptions {
            chosen: self.choice.cloned(),
            experiments: self.comparison.map(Comparison::marks).unwrap_or_default(),
            validation: picture::validation(self.folder, &self.result.source)?,
            ..DiagramOptions::default()
        };
        let slices = picture::slices(&self.result.diagram);
        let draw = |at: Vec<_>| {
            let words: Vec<String> =
                at.iter().map(|(axis, value)| quantity::named(*axis, *value)).collect();
            let options = DiagramOptions { at, ..options.clone() };
            let drawn = picture::drawn(self.result, &options)?;
            Ok(Slice { heading: words.join(", "), drawn })
        };
        slices.into_iter().map(draw).collect()
    }
}

fn summary(comparison: &Comparison) -> Vec<String> {
    let mill = comparison.behaviour().verb().plain;
    let next = comparing::next_in_words(comparison).join(": ");
    let mut sentences = vec![
        format!("Claim: real robots {mill} at least as often as simulated ones."),
        format!("{}.", capitalised(&comparing::reason_in_words(comparison))),
        format!("Next: {next}."),
    ];
    sentences.extend(comparison.notes.iter().map(|note| format!("Note: {note}.")));
    sentences
}

fn mark(verdict: comparison::Verdict) -> VerdictMark {
    match verdict {
        comparison::Verdict::Supported => VerdictMark::Supported,
        comparison::Verdict::Violated => VerdictMark::Violated,
        comparison::Verdict::Undecided | comparison::Verdict::NoClaim => VerdictMark::Open,
    }
}

/// How many samples take at least so long; 1 or more.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and casts from floats saturate"
)]
fn samples_at_least(duration_s: f64, period_s: f64) -> usize {
    ((duration_s / period_s - 1e-9).ceil() as usize).max(1)
}

fn chosen(choice: &Choice) -> String {
    format!(
        "Chosen cell: {}; {} of {} {} (95 % interval {} to {}).",
        quantity::of_cell(&choice.cell),
        percent(choice.b_s),
        counted(choice.n_replicates, "fresh simulated run"),
        choice.behaviour().verb().did,
        percent(choice.b_s_low),
        percent(choice.b_s_high)
    )
}
