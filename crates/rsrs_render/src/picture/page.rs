//! A diagram on a page of its own.

use rsrs_core::diagram::DiagramCell;
use rsrs_core::numerals::{percent, percents};
use rsrs_core::statistics::interval_kind::IntervalKind;
use rsrs_core::statistics::share::Share;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_view::page::{Page, Table};

use super::{Worlds, robots};
use crate::wording::robot_names;

/// The picture on a page, with the numbers behind it and how they were made.
pub fn page(result: &SweepResult, worlds: Worlds, svg: &str) -> anyhow::Result<String> {
    let source = &result.source;
    let mut page = Page::new(&format!("Phase diagram: {}", robot_names(source)));
    page.figure(svg);
    page.heading("Cells");
    let kind = source.sweep.interval_kind();
    for world in worlds.all() {
        let rows = result.of_world(*world)?.cells.iter().map(|entry| row(entry, kind)).collect();
        let does = source.sweep.behaviour.known().verb().does;
        let head = ["cell", "most frequent phase", does, "95 % interval", "runs"];
        let caption = format!("Every cell of the sweep: {}", robots(result, *world));
        page.table(&Table { caption, head: head.map(str::to_owned).into(), rows });
    }
    page.heading("How it was made");
    page.paragraph(&format!(
        "Swept by rsrs {}, commit {}, seed {}.",
        source.provenance.version, source.provenance.commit, source.sweep.seed
    ));
    page.details("The sweep with its profile", &source.to_yaml());
    Ok(page.finish())
}

/// How the runs of a cell ended.
fn row(entry: &DiagramCell, kind: IntervalKind) -> Vec<String> {
    let DiagramCell { cell, counts } = entry;
    let milling = Share::milling(counts);
    let interval = kind.interval(milling.hits, milling.n);
    vec![
        cell.to_string(),
        counts.majority().map_or_else(String::new, |phase| phase.to_string()),
        percent(milling.value()),
        percents(interval.low, interval.high),
        milling.n.to_string(),
    ]
}
