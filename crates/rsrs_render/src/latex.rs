//! Tables for a paper, in LaTeX with `booktabs`.

use std::path::Path;

use rsrs_core::numerals::percent;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::share::Share;

use rsrs_pipeline::error::with_help;
use rsrs_pipeline::sweep::result::{SweepResult, World};

use crate::comparison::{Report, evidence, verdict_name};
use crate::picture::robots;
use crate::wording::quantity::{as_on_an_axis, without_unit};
use crate::wording::{capitalised, robot_names};

/// A table of more rows goes on over pages.
const PAGE_ROWS: usize = 40;

/// Whether a file is one of LaTeX, by its ending.
pub fn is_tex(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "tex")
}

/// Refuses a file that does not end in `.tex`.
pub fn check(path: &Path) -> anyhow::Result<()> {
    if is_tex(path) {
        return Ok(());
    }
    Err(with_help(
        format!("{} does not end in .tex", path.display()),
        format!("name the table `-o {}`", path.with_extension("tex").display()),
    ))
}

/// Every cell of a sweep: its values, the most frequent phase, the share of the wanted one with its 95 %
/// interval, and the number of runs.
pub fn cells(result: &SweepResult, world: World) -> anyhow::Result<String> {
    let diagram = result.of_world(world)?;
    let source = &result.source;
    let kind = source.sweep.interval_kind();
    let mut head: Vec<String> = diagram.axes.iter().map(|axis| escaped(&axis.label())).collect();
    head.extend(["most frequent phase", "$B_s$", "95\\,\\% interval", "runs"].map(str::to_owned));
    let rows = diagram.cells.iter().map(|entry| {
        let milling = Share::milling(&entry.counts);
        let interval = kind.interval(milling.hits, milling.n);
        let mut row = values(&diagram.axes, &entry.cell);
        let phase = entry.counts.majority();
        row.push(phase.map_or_else(String::new, |phase| phase.title().to_owned()));
        row.extend(share(milling.value(), interval.low, interval.high));
        row.push(milling.n.to_string());
        row
    });
    let comment = format!(
        "{} of {}, {}, {} s each, seed {}; rsrs {}, commit {}",
        capitalised(source.sweep.behaviour.known().noun()),
        robot_names(source),
        robots(result, world),
        source.sweep.duration_s,
        source.sweep.seed,
        source.provenance.version,
        source.provenance.commit
    );
    Ok(tabular(&comment, &head, &rows.collect::<Vec<_>>(), &[]))
}

/// What was compared, cell by cell, and what follows from all of it.
pub fn verdict(comparison: &Report) -> String {
    let axes: Vec<Axis> = comparison
        .cells
        .first()
        .map_or_else(Vec::new, |first| first.cell.iter().map(|(axis, _)| axis).collect());
    let mut head: Vec<String> = axes.iter().map(|axis| escaped(&axis.label())).collect();
    let rest =
        ["$B_s$", "95\\,\\% interval", "$n_s$", "$B_r$", "95\\,\\% interval", "$n_r$", "verdict"];
    head.extend(rest.map(str::to_owned));
    let rows = comparison.cells.iter().map(|cell| {
        let mut row = values(&axes, &cell.cell);
        row.extend(share(cell.b_s, cell.b_s_low, cell.b_s_high));
        row.push(cell.n_simulated.to_string());
        row.extend(share(cell.b_r, cell.b_r_low, cell.b_r_high));
        row.extend([cell.n_real.to_string(), escaped(verdict_name(cell.verdict))]);
        row
    });
    let pooled = &comparison.pooled;
    let supported = pooled.e_supported.map_or_else(|| "none".to_owned(), evidence);
    let mut all = vec![
        format!(
            "All runs: {} of {} {}, {:.1} expected.",
            pooled.n_milled,
            pooled.n_real,
            comparison.behaviour().verb().did,
            pooled.n_expected
        ),
        format!(
            "Evidence for $B_r < B_s$: {}; for $B_r \\ge B_s - {}$: {supported}.",
            evidence(pooled.e_violated),
            pooled.margin
        ),
        format!(
            "Verdict: {}. {}",
            escaped(verdict_name(comparison.verdict)),
            capitalised(&escaped(&comparison.summary))
        ),
    ];
    all.extend(comparison.notes.iter().map(|note| format!("Note: {}.", escaped(note))));
    tabular(&format!("labels: {}", comparison.labels), &head, &rows.collect::<Vec<_>>(), &all)
}

fn values(axes: &[Axis], cell: &Cell) -> Vec<String> {
    let value = |axis: &Axis| {
        let value = cell.get(*axis).map(|value| as_on_an_axis(*axis, value));
        value.map_or_else(String::new, |value| {
            format!("${}$", without_unit(&value).replace('−', "-"))
        })
    };
    axes.iter().map(value).collect()
}

fn share(value: f64, low: f64, high: f64) -> [String; 2] {
    let number = |share: f64| percent(share).replace(" %", "");
    [format!("{}\\,\\%", number(value)), format!("{} to {}", number(low), number(high))]
}

fn tabular(comment: &str, head: &[String], rows: &[Vec<String>], below: &[String]) -> String {
    let comment = comment.replace(char::is_control, " ");
    let columns = "r".repeat(head.len());
    let is_long = rows.len() > PAGE_ROWS;
    let (environment, packages) =
        if is_long { ("longtable", "booktabs,longtable") } else { ("tabular", "booktabs") };
    let mut lines = vec![
        format!("% {comment}"),
        format!("% needs \\usepackage{{{packages}}}"),
        format!("\\begin{{{environment}}}{{@{{}}{columns}@{{}}}}"),
        "\\toprule".to_owned(),
        format!("{} \\\\", head.join(" & ")),
        "\\midrule".to_owned(),
    ];
    if is_long {
        lines.push("\\endhead".to_owned());
    }
    lines.extend(rows.iter().map(|row| format!("{} \\\\", row.join(" & "))));
    if !below.is_empty() {
        lines.push("\\midrule".to_owned());
    }
    let n_columns = head.len();
    let across = |line: &String| {
        format!("\\multicolumn{{{n_columns}}}{{@{{}}p{{\\linewidth}}@{{}}}}{{{line}}} \\\\")
    };
    lines.extend(below.iter().map(across));
    lines.extend(["\\bottomrule".to_owned(), format!("\\end{{{environment}}}\n")]);
    lines.join("\n")
}

fn escaped(text: &str) -> String {
    let mut all = String::new();
    for character in text.chars() {
        match character {
            '%' | '_' | '&' | '#' | '$' | '{' | '}' => all.extend(['\\', character]),
            '≥' => all.push_str("$\\ge$"),
            '−' => all.push_str("$-$"),
            '×' => all.push_str("$\\times$"),
            '→' => all.push_str("$\\to$"),
            '~' => all.push_str("\\textasciitilde{}"),
            '^' => all.push_str("\\textasciicircum{}"),
            '°' => all.push_str("$^\\circ$"),
            '\\' => all.push_str("\\textbackslash{}"),
            _ => all.push(character),
        }
    }
    all
}
