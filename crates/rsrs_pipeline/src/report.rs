//! A sweep and the runs that were compared with it, as one HTML file.

use std::path::Path;

use anyhow::Context;
use rsrs_core::diagram::choice::Choice;
use rsrs_core::judge::certainty::Certainty;
use rsrs_core::judge::phase::WINDOW_S;
use rsrs_core::statistics::comparison::SIGNIFICANCE;
use rsrs_view::page::Page;
use rsrs_view::trajectory::{TrajectoryPicture, svg};

use crate::compare::report::{ComparedBag, ComparedCell, Report as Comparison};
use crate::compare::{Options, compare};
use crate::error::in_one_line;
use crate::label::{LabelOptions, Labelled, judge};
use crate::picture::{self, DiagramOptions};
use crate::provenance;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::wording::counted;

/// Compares runs with a sweep, and shows both with every run from above.
///
/// # Arguments
///
/// * `folder` — that of the sweep.
///
/// # Returns
///
/// The page, which needs no other file, and the comparison.
///
/// # Errors
///
/// As [`compare()`].
pub fn html(folder: &Path, runs: &Options) -> anyhow::Result<(String, Comparison)> {
    let result = folder::read(folder)?;
    let choice = folder::read_choice(folder)?;
    let comparison = compare(folder, runs)?;
    let html = page(folder, &result, choice.as_ref(), &comparison)?;
    Ok((html, comparison))
}

fn page(
    folder: &Path,
    result: &SweepResult,
    choice: Option<&Choice>,
    comparison: &Comparison,
) -> anyhow::Result<String> {
    let mut page = Page::new(&format!("Simulated and real runs: {}", result.source.profile.name));
    page.paragraph(&comparison.verdict_in_words());
    page.paragraph(&format!("Next: {}.", comparison.next_in_words()));
    for note in &comparison.notes {
        page.paragraph(&format!("Note: {note}."));
    }

    page.heading("Phase diagram");
    let options = DiagramOptions {
        chosen: choice.cloned(),
        experiments: comparison.marks(),
        ..DiagramOptions::default()
    };
    page.figure(&picture::of_sweep(result, &options)?, &[]);
    if let Some(choice) = choice {
        page.paragraph(&chosen(choice));
    }

    page.heading("Comparison, all cells together");
    page.table(["all runs", "found"], &rows_of_all(comparison));
    page.heading("Comparison, cell by cell");
    let rows: Vec<[String; 6]> = comparison.cells.iter().map(row_of_cell).collect();
    page.table(
        ["cell", "real runs", "simulated runs", "p, exact", "p at any time", "by itself"],
        &rows,
    );

    page.heading("Runs");
    page.figures(&comparison.bags.iter().map(figure).collect::<anyhow::Result<Vec<_>>>()?);
    if !comparison.not_counted.is_empty() {
        page.heading("Runs that do not count");
        let rows: Vec<[String; 3]> = comparison
            .not_counted
            .iter()
            .map(|run| [run.bag.display().to_string(), run.ending.to_owned(), run.reason.clone()])
            .collect();
        page.table(["bag", "ending", "cause"], &rows);
    }

    page.heading("How it was made");
    page.paragraph(&format!(
        "rsrs {}, commit {}; sweep in {} by rsrs {}, commit {}, seed {}.",
        env!("CARGO_PKG_VERSION"),
        provenance::COMMIT,
        folder.display(),
        result.source.provenance.version,
        result.source.provenance.commit,
        result.source.sweep.seed
    ));
    page.details("The comparison as text", &comparison.to_string());
    let sweep = serde_saphyr::to_string(&result.source).context("the sweep as YAML")?;
    page.details("The sweep with its profile", &sweep);
    Ok(page.finish())
}

fn chosen(choice: &Choice) -> String {
    format!(
        "Chosen cell: {}; {:.1} % of {} milled (95 % interval {:.1} to {:.1} %).",
        choice.cell,
        100.0 * choice.b_s,
        counted(choice.n_replicates, "fresh simulated run"),
        100.0 * choice.b_s_low,
        100.0 * choice.b_s_high
    )
}

fn rows_of_all(comparison: &Comparison) -> Vec<[String; 2]> {
    let pooled = &comparison.pooled;
    let short = pooled.shortfall_at_most.map_or_else(
        || "not bounded".to_owned(),
        |short| format!("at most {:.0} percentage points", 100.0 * short),
    );
    [
        ("milled", format!("{} of {}", pooled.n_milled, pooled.n_real)),
        ("expected if both mill equally often", format!("{:.1}", pooled.n_expected)),
        ("evidence that real robots mill less often", format!("{:.3e}", pooled.e_violated)),
        (
            "evidence that they mill as often, but for the margin",
            format!("{:.3e}", pooled.e_supported),
        ),
        ("margin", format!("{:.0} percentage points", 100.0 * pooled.margin)),
        ("evidence that decides", format!("{}", 1.0 / SIGNIFICANCE)),
        ("less often, as far as these runs say, by", short),
        ("p, exact if the number of runs was fixed before", format!("{:.3}", pooled.p_value)),
    ]
    .map(|(what, found)| [what.to_owned(), found])
    .into()
}

fn row_of_cell(cell: &ComparedCell) -> [String; 6] {
    let share = |share: f64, low: f64, high: f64, n: u64| {
        let [share, low, high] = [share, low, high].map(|share| 100.0 * share);
        format!("{share:.1} % of {n} milled ({low:.1} to {high:.1} %)")
    };
    [
        cell.cell.to_string(),
        share(cell.b_r, cell.b_r_low, cell.b_r_high, cell.n_real),
        share(cell.b_s, cell.b_s_low, cell.b_s_high, cell.n_simulated),
        format!("{:.3}", cell.p_corrected),
        format!("{:.3}", cell.p_violated),
        cell.verdict_in_a_word().to_owned(),
    ]
}

/// A run from above, with its label; without poses, its label alone.
fn figure(run: &ComparedBag) -> anyhow::Result<(String, Vec<String>)> {
    let labelled = &run.labelled;
    let mut caption = vec![format!("{} by {}", labelled.phase_in_words(), labelled.by)];
    caption.push(run.cell.to_string());
    let drawn = match judge(&labelled.bag, LabelOptions::default()) {
        Err(error) => {
            caption.push(format!("not drawn: {}", in_one_line(&error)));
            String::new()
        }
        Ok((judged, recorded, bodies)) => {
            let radius_m = bodies.radius_m.context("the record of a run has its robots")?;
            caption.extend(evidence(&judged));
            let name = labelled.bag.file_name().unwrap_or_default().to_string_lossy();
            svg(&TrajectoryPicture {
                trajectory: &recorded.trajectory,
                radius_m,
                tail_s: WINDOW_S,
                phase: Some(labelled.phase),
                lost: &judged.lost_rows(&recorded.robots),
                title: name.into_owned(),
                subtitle: labelled.phase.to_string(),
            })
            .with_context(|| labelled.bag.display().to_string())?
        }
    };
    Ok((drawn, caption))
}

/// What the judge's label rests on, and labels by people.
fn evidence(judged: &Labelled) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(evidence) = &judged.evidence {
        lines.push(format!(
            "rotation {:.2}, orbit {:.2}, circliness {:.2} of {:.2}, blocked {:.2}, lost {}",
            evidence.rotation,
            evidence.orbit,
            evidence.circliness,
            evidence.circliness_ceiling,
            evidence.blocked,
            evidence.lost.map_or_else(|| "unknown".to_owned(), |lost| format!("{lost:.2}"))
        ));
    }
    if let Some(Certainty { nearest: Some(nearest), confidence, .. }) = &judged.certainty {
        lines.push(format!(
            "judge: {}; {} is {:.2} away; {:.0} % of the window's 10 s blocks show the same phase",
            judged.phase,
            nearest.becomes,
            nearest.distance,
            100.0 * confidence
        ));
    }
    lines.extend(judged.findings.iter().map(|finding| format!("mended: {finding}")));
    lines.extend(judged.labels.iter().map(|label| format!("by hand: {label}")));
    lines
}
