//! The diagram whose cells respond, and what is known of each.

use maud::{Markup, html};

use super::{
    CellFacts, Replays, ReportPage, WorldFacts, bar, placed, player, symbol, with_interval,
};
use crate::diagram::{CellBox, DrawnDiagram};
use crate::page::{Table, picture, table};

/// The section of the diagram: pictures, and beside them the cell that is shown.
pub fn section(page: &ReportPage, replays: &Replays) -> Markup {
    html! {
        p.hint.scripted hidden {
            "Point at a cell, tap it, or reach it by Tab and the arrow keys: beside the diagram it shows how its runs ended, and one of them in motion. "
            "On any run, the key k plays and pauses, j and l go 5 s back and forth."
        }
        div.explorer {
            div.slices {
                @for slice in &page.diagrams {
                    @if !slice.heading.is_empty() { h3 { (slice.heading) } }
                    (diagram(page, &slice.drawn, &slice.heading))
                }
                (narrow_legend(page))
            }
            div.cell.scripted id="cell" hidden {
                (player("cell-player", "a simulated run of the cell", "loop"))
                @for (index, cell) in page.cells.iter().enumerate() {
                    (facts(page, (index, cell), replays.of_cells[index]))
                }
            }
        }
        @if let Some(chosen) = &page.chosen { p { (chosen) } }
        details {
            summary { "All cells as a table" }
            (table(&all_cells(&page.cells)))
        }
    }
}

/// The colours of the phases, where the legend of the picture is beyond the edge.
fn narrow_legend(page: &ReportPage) -> Markup {
    let worlds = page.cells.iter().flat_map(|cell| &cell.worlds);
    let phases = worlds.map(|world| world.counts.behaviour().phases()).next().unwrap_or_default();
    html! {
        p.legend aria-hidden="true" {
            @for phase in phases { span { (symbol(*phase)) " " (phase) } " " }
        }
    }
}

/// One picture, and over it a cell that responds for each one that it shows.
fn diagram(page: &ReportPage, drawn: &DrawnDiagram, heading: &str) -> Markup {
    let label = if heading.is_empty() { "cells" } else { heading };
    html! {
        div.scrolled.wide tabindex="0" role="region" aria-label=(format!("phase diagram, {label}")) {
            div.diagram style=(format!("--plot:{:.3}", plot_share(drawn))) {
                (picture(&drawn.svg))
                div.cells.scripted hidden role="grid" aria-label=(format!("cells of the phase diagram, {label}")) {
                    @for row in &drawn.rows {
                        @if !row.is_empty() {
                            div role="row" {
                                @for cell in row { (grid_cell(page, drawn, *cell)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Which part of a picture, from its left, the cells take: where there is little room, they fill it.
fn plot_share(drawn: &DrawnDiagram) -> f64 {
    let rights_px = drawn.rows.iter().flatten().map(|cell| cell.left_px + cell.width_px);
    (rights_px.fold(0.0, f64::max) / drawn.size_px.0).clamp(0.3, 1.0)
}

fn grid_cell(page: &ReportPage, drawn: &DrawnDiagram, at: CellBox) -> Markup {
    let (corner_px, size_px) = ((at.left_px, at.top_px), (at.width_px, at.height_px));
    let is_first = at.index == page.first_cell;
    html! {
        div role="gridcell" data-cell=(at.index)
            style=(placed(corner_px, size_px, drawn.size_px))
            tabindex=(if is_first { "0" } else { "-1" })
            aria-selected=(is_first)
            aria-label=(in_words(&page.cells[at.index])) {}
    }
}

/// A cell in one line, for those who do not see it.
fn in_words(cell: &CellFacts) -> String {
    let chosen = if cell.is_chosen { ", chosen" } else { "" };
    let ended = cell.worlds.first().map_or_else(String::new, |world| {
        let counts = &world.counts;
        match counts.majority() {
            Some(phase) => format!(
                ": {} of {} {phase}, B_s {:.2}",
                counts.get(phase),
                counts.total(),
                counts.wanted_share()
            ),
            None => ": no runs".to_owned(),
        }
    });
    let real = match cell.runs.len() {
        0 => String::new(),
        1 => "; 1 experiment".to_owned(),
        n => format!("; {n} experiments"),
    };
    format!("{}{chosen}{ended}{real}", cell.name)
}

fn facts(page: &ReportPage, (index, cell): (usize, &CellFacts), replay: Option<usize>) -> Markup {
    html! {
        div.facts id=(format!("cell-{index}")) data-replay=[replay] hidden[index != page.first_cell] {
            h3 { (cell.name) @if cell.is_chosen { " " span.chosen { "chosen cell" } } }
            div.numbers {
                p.caption { (cell.caption) }
                @if let Some(address) = &cell.address {
                    p.scripted hidden {
                        button.simulate type="button" data-address=(address) {
                            "Simulate it, and change it"
                        }
                    }
                }
                @for world in &cell.worlds { div.world { (shares(world)) } }
                @if !cell.runs.is_empty() {
                    h4 { "Experiments" }
                    ul.experiments {
                        @for run in cell.runs.iter().map(|run| (run, &page.runs[*run])) {
                            li {
                                (symbol(run.1.phase)) " "
                                a href=(format!("#run-{}", run.0)) { (run.1.name) }
                                ": " (run.1.label)
                            }
                        }
                    }
                }
            }
        }
    }
}

/// How the runs of a cell ended in one world.
fn shares(world: &WorldFacts) -> Markup {
    let WorldFacts { name, counts, interval } = world;
    let phases = counts.behaviour().phases().iter().copied();
    let seen = phases.filter(|phase| counts.get(*phase) > 0);
    html! {
        table.shares {
            caption { (name) ": " (counts.total()) " runs" }
            tbody {
                @for phase in seen {
                    tr {
                        th scope="row" { (symbol(phase)) " " (phase) }
                        td { (counts.get(phase)) }
                        td { (bar(phase, counts.share(phase))) }
                    }
                }
            }
        }
        p { "B" sub { "s" } " = " (with_interval(counts.wanted_share(), *interval)) }
    }
}

fn all_cells(cells: &[CellFacts]) -> Table {
    let worlds: Vec<&str> = cells
        .first()
        .into_iter()
        .flat_map(|cell| &cell.worlds)
        .map(|world| world.name.as_str())
        .collect();
    let columns = worlds.iter().flat_map(|world| {
        ["runs", "most frequent phase", "B_s"].map(|column| format!("{column}, {world}"))
    });
    let of_world = |world: &WorldFacts| {
        let counts = &world.counts;
        [
            counts.total().to_string(),
            counts.majority().map_or_else(String::new, |phase| phase.to_string()),
            with_interval(counts.wanted_share(), world.interval),
        ]
    };
    let row = |cell: &CellFacts| {
        let experiments = cell.runs.len().to_string();
        std::iter::once(cell.name.clone())
            .chain(cell.worlds.iter().flat_map(of_world))
            .chain([experiments])
            .collect()
    };
    Table {
        caption: "Every cell of the sweep".to_owned(),
        head: std::iter::once("cell".to_owned())
            .chain(columns)
            .chain(["experiments".to_owned()])
            .collect(),
        rows: cells.iter().map(row).collect(),
    }
}
