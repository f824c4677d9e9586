//! A report as one page of HTML that needs no other file: a diagram whose cells respond, and runs that
//! can be watched.
//!
//! The page is whole without its script: pictures, tables and labels are in it as they are, and what
//! the script adds is movement. Data for it are the [`Replay`]s, as JSON; the script and the styles
//! are `assets/report.js` and `assets/page.css`. A cell can be changed and watched on the page that simulates,
//! which is in the report, packed.

mod cells;
mod runs;

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use maud::{Markup, PreEscaped, html};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;

use crate::diagram::DrawnDiagram;
use crate::order_over_time::DrawnOrder;
use crate::page::{SIMULATING, Table, details, document, table};
use crate::palette::hue;
use crate::replay::Replay;
use crate::simulator::PAGE;
use crate::svg::Element;
use crate::symbol::{Filling, MARK_PX, mark};

const SCRIPTS: [&str; 2] =
    [include_str!("../assets/canvas.js"), include_str!("../assets/report.js")];

/// All that is on the page; texts are any texts.
#[derive(Clone, Debug)]
pub struct ReportPage {
    /// The title.
    pub title: String,
    /// What follows from the runs, if some were compared: it is the first thing on the page.
    pub verdict: Option<Verdict>,
    /// What follows, in sentences.
    pub summary: Vec<String>,
    /// The diagram, one picture for each slice.
    pub diagrams: Vec<Slice>,
    /// Its cells, in its order.
    pub cells: Vec<CellFacts>,
    /// The sweep and the robot that cells are simulated of on [`crate::simulator::PAGE`], as JSON.
    pub source: String,
    /// The cell that is shown first.
    pub first_cell: usize,
    /// What is known of the chosen cell.
    pub chosen: Option<String>,
    /// The comparison.
    pub comparison: Vec<Table>,
    /// The runs.
    pub runs: Vec<RunFacts>,
    /// Those that do not count.
    pub not_counted: Option<Table>,
    /// The robots: their profile, and those of classes that have their own.
    pub profiles: Vec<Table>,
    /// Where it comes from.
    pub provenance: Table,
    /// Heading and text of what is shown on demand.
    pub details: Vec<(String, String)>,
}

/// What follows from the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// In a word.
    pub words: String,
    /// Which way it points.
    pub mark: VerdictMark,
}

/// Which way a verdict points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerdictMark {
    /// The claim is supported.
    Supported,
    /// It is violated.
    Violated,
    /// Nothing follows.
    Open,
}

impl VerdictMark {
    fn sign(self) -> &'static str {
        match self {
            Self::Supported => "✓",
            Self::Violated => "✗",
            Self::Open => "?",
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Supported => "verdict supported",
            Self::Violated => "verdict violated",
            Self::Open => "verdict open",
        }
    }
}

/// One slice of the diagram.
#[derive(Clone, Debug)]
pub struct Slice {
    /// Its values on the axes that it does not show; empty if it is the only one.
    pub heading: String,
    /// The picture.
    pub drawn: DrawnDiagram,
}

/// What is known of one cell.
#[derive(Clone, Debug)]
pub struct CellFacts {
    /// Its values in words.
    pub name: String,
    /// Whether it is the chosen one.
    pub is_chosen: bool,
    /// How its runs ended, in each world that was simulated.
    pub worlds: Vec<WorldFacts>,
    /// The real runs in it, by their place in [`ReportPage::runs`].
    pub runs: Vec<usize>,
    /// One of its runs.
    pub replay: Option<Replay>,
    /// What the replay shows, or why there is none.
    pub caption: String,
    /// What stands behind the address of the simulator's page for this cell, without its source; `None` of a
    /// controller or sensors that the page does not have.
    pub address: Option<String>,
}

/// How the runs of one cell ended in one world.
#[derive(Clone, Debug)]
pub struct WorldFacts {
    /// Its robots.
    pub name: String,
    /// How the runs ended.
    pub counts: PhaseCounts,
    /// The 95 % interval of the share of the wanted phase.
    pub interval: [f64; 2],
}

/// What is known of one real run.
#[derive(Clone, Debug)]
pub struct RunFacts {
    /// Its name.
    pub name: String,
    /// Its cell in words.
    pub cell: String,
    /// Its label.
    pub phase: Phase,
    /// Its label with a warning, and whose it is.
    pub label: String,
    /// What moved the robots, what the label rests on, and what else there is to note.
    pub notes: Vec<String>,
    /// The run; `None` where it has no poses.
    pub recorded: Option<RecordedRun>,
}

/// What a bag shows of a run.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// From above, for paper.
    pub above_svg: String,
    /// Its order parameters over time.
    pub order: DrawnOrder,
    /// The run in motion.
    pub replay: Replay,
}

/// Writes the page.
///
/// # Panics
///
/// If the first cell is none of the cells: they come from the same diagram.
pub fn html(page: &ReportPage) -> String {
    assert!(page.first_cell < page.cells.len(), "the first cell is one of the cells");
    let replays = Replays::new(page);
    let body = html! {
        (symbols())
        @if let Some(Verdict { words, mark }) = &page.verdict {
            p class=(mark.class()) {
                span.mark aria-hidden="true" { (mark.sign()) } " Verdict: " strong { (words) }
            }
        }
        @for sentence in &page.summary { p { (sentence) } }
        section aria-labelledby="diagram" {
            h2 id="diagram" { "Phase diagram" }
            (cells::section(page, &replays))
        }
        @if page.verdict.is_some() {
            section aria-labelledby="comparison" {
                h2 id="comparison" { "Comparison" }
                @for of in &page.comparison { (table(of)) }
            }
            section aria-labelledby="experiments" {
                h2 id="experiments" { "Experiments" }
                (runs::section(page, &replays))
            }
        }
        section aria-labelledby="robots" {
            h2 id="robots" { "Profile of the robots" }
            @for of in &page.profiles { (table(of)) }
        }
        section aria-labelledby="provenance" {
            h2 id="provenance" { "How it was made" }
            (table(&page.provenance))
            @for (summary, text) in &page.details { (details(summary, text)) }
        }
    };
    let end = html! {
        script type="application/json" id="replays" { (PreEscaped(replays.json())) }
        script type="application/json" id="source" { (PreEscaped(within_script(&page.source))) }
        script type="text/plain" id="simulator" { (simulator()) }
        @for script in SCRIPTS { script { (PreEscaped(script)) } }
    };
    document((&page.title, SIMULATING), &body, &end)
}

/// The page that simulates, packed: a report is mailed without other files.
fn simulator() -> String {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(PAGE.as_bytes()).expect("memory takes what is written");
    STANDARD.encode(packer.finish().expect("memory takes what is written"))
}

/// JSON that ends no script.
fn within_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

/// The replays of a page, in the order in which the script finds them: those of the cells, then those
/// of the runs.
struct Replays<'a> {
    all: Vec<&'a Replay>,
    of_cells: Vec<Option<usize>>,
    of_runs: Vec<Option<usize>>,
}

impl<'a> Replays<'a> {
    fn new(page: &'a ReportPage) -> Self {
        let mut all = Vec::new();
        let mut number = |replay: Option<&'a Replay>| {
            replay.map(|replay| {
                all.push(replay);
                all.len() - 1
            })
        };
        let of_cells = page.cells.iter().map(|cell| number(cell.replay.as_ref())).collect();
        let recorded = page.runs.iter().map(|run| run.recorded.as_ref());
        let of_runs = recorded.map(|run| number(run.map(|run| &run.replay))).collect();
        Self { all, of_cells, of_runs }
    }

    fn json(&self) -> String {
        within_script(&serde_json::to_string(&self.all).expect("replays are plain data"))
    }
}

/// Where a run is watched: a floor, and what moves it. The script shows it, and at its end does
/// what `ends` (`loop` or `stop`) wants.
fn player(id: &str, name: &str, ends: &str) -> Markup {
    html! {
        div.player id=(id) data-ends=(ends) hidden {
            canvas width="480" height="480" role="img" aria-label=(format!("{name}, from above")) {}
            div.controls role="group" aria-label=(format!("controls of {name}")) {
                button.play type="button" { "Play" }
                input.time type="range" min="0" max="1" step="any" value="0"
                    aria-label=(format!("time of {name}"));
                output.clock { "0 s" }
                label { "Speed "
                    select.speed {
                        @for speed in [1, 2, 5, 10, 20, 50] {
                            option value=(speed) selected[speed == 10] { (speed) "×" }
                        }
                    }
                }
            }
        }
    }
}

/// The symbols of all phases, as on the diagram, for [`symbol`] to show.
fn symbols() -> Markup {
    let one = |phase: Phase| {
        Element::new("symbol")
            .with("id", &format!("symbol-{}", phase.key()))
            .with("viewBox", "-9 -9 18 18")
            .child(mark(phase, Filling::Full, ((0.0, 0.0), MARK_PX)))
    };
    let all = Element::new("svg").with("hidden", "").children(Phase::all().map(one));
    PreEscaped(all.to_string())
}

fn symbol(phase: Phase) -> Markup {
    html! { svg.symbol aria-hidden="true" { use href=(format!("#symbol-{}", phase.key())) {} } }
}

/// A bar as long as a share.
fn bar(phase: Phase, share: f64) -> Markup {
    let style = format!("width:{:.1}%;background:{}", 100.0 * share, hue(phase).hex());
    html! { span.bar { span style=(style) {} } }
}

/// Where something lies over a picture, however large that is shown: its left and upper edge, its
/// width and height, and those of the picture are all in pixels of the picture.
fn placed(corner_px: (f64, f64), size_px: (f64, f64), whole_px: (f64, f64)) -> String {
    let percent = |part_px: f64, whole_px: f64| format!("{:.3}%", 100.0 * part_px / whole_px);
    format!(
        "left:{};top:{};width:{};height:{}",
        percent(corner_px.0, whole_px.0),
        percent(corner_px.1, whole_px.1),
        percent(size_px.0, whole_px.0),
        percent(size_px.1, whole_px.1)
    )
}

/// A share with its interval: `0.98 (0.94 to 1.00)`.
fn with_interval(share: f64, [low, high]: [f64; 2]) -> String {
    format!("{share:.2} (95 % interval {low:.2} to {high:.2})")
}
