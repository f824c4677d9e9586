//! The experiments: each from above, in motion, and its order parameters over time.

use maud::{Markup, html};

use super::{RecordedRun, Replays, ReportPage, RunFacts, placed, player, symbol};
use crate::page::{picture, table};

/// The section of the experiments.
pub fn section(page: &ReportPage, replays: &Replays) -> Markup {
    html! {
        @if page.runs.is_empty() { p { "No run counts." } }
        @for (index, run) in page.runs.iter().enumerate() {
            (article(run, index, replays.of_runs[index]))
        }
        @if let Some(not_counted) = &page.not_counted { (table(not_counted)) }
    }
}

fn article(run: &RunFacts, index: usize, replay: Option<usize>) -> Markup {
    let id = format!("run-{index}");
    html! {
        article.run id=(id) data-replay=[replay] aria-labelledby=(format!("{id}-name")) {
            h3 id=(format!("{id}-name")) { (symbol(run.phase)) " " (run.name) }
            p { strong { (run.label) } ", at " (run.cell) }
            @if let Some(recorded) = &run.recorded { (moving(run, recorded, &id)) }
            ul { @for note in &run.notes { li { (note) } } }
        }
    }
}

fn moving(run: &RunFacts, recorded: &RecordedRun, id: &str) -> Markup {
    let RecordedRun { above_svg, order, .. } = recorded;
    html! {
        div.pair {
            div {
                div.still { (picture(above_svg)) }
                (player(&format!("{id}-player"), &run.name, "stop"))
            }
            div.order {
                (picture(&order.svg))
                div.cursor.scripted hidden style=(placed(order.corner_px, order.curves_px, order.size_px)) { span {} }
            }
        }
    }
}
