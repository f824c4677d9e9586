//! One panel of a phase diagram: the heat map, and what lies over it.

use rsrs_core::judge::phase::Phase;

use crate::axes::axes;
use crate::boundary::{self, Boundary};
use crate::header::Heading;
use crate::legend::Contents;
use crate::marks;
use crate::overlay::{self, ChosenShape};
use crate::picture::{DiagramPicture, Numbers, Panel};
use crate::plot::{self, NumberPlace, Plot, quantity};
use crate::svg::Element;
use crate::symbol::Filling;

/// A panel that is drawn.
pub struct Drawing {
    /// What is drawn, the lowest first.
    pub elements: Vec<Element>,
    /// How the chosen cell is marked; `None` where it is not shown.
    chosen: Option<ChosenShape>,
    /// The labels of the boundaries that are visible.
    visible: Vec<String>,
}

impl Drawing {
    /// Draws a panel.
    pub fn new(picture: &DiagramPicture, panel: &Panel, plot: &Plot) -> Self {
        let number_px = plot.number_px().filter(|_| picture.numbers == Numbers::Shown);
        let places = marks::places(plot, picture.experiments, number_px);
        let place = |column: usize, row: usize| {
            let here = places.iter().find(|place| place.grid_cell == Some((column, row)));
            here.map_or(NumberPlace::Middle, |place| place.number)
        };
        let (numbers, mut kept) = match picture.numbers {
            Numbers::Shown => plot::numbers(plot, place),
            Numbers::Hidden => (None, Vec::new()),
        };
        kept.extend(places.iter().map(marks::MarkPlace::kept));
        let labels = labels(picture);
        let number_of = |line: &Boundary| labels.iter().position(|label| *label == line.label);
        // Across an axis of one value nothing lies on either side of a line.
        let has_sides = plot.x.values.len() > 1 && plot.y.values.len() > 1;
        let boundaries = panel.boundaries.iter().filter(|_| has_sides);
        let numbered: Vec<(usize, &Boundary)> =
            boundaries.filter_map(|boundary| Some((number_of(boundary)?, boundary))).collect();
        let (lines, shown) = boundary::boundaries(plot, &numbered, &kept);
        let (chosen, frame) = picture.chosen.and_then(|cell| overlay::chosen(plot, cell)).unzip();
        let symbols = places.iter().map(marks::MarkPlace::drawn);
        let y = picture.y.expect("a heat map has two axes");

        let mut elements = vec![plot::heat_map(plot)];
        elements.extend(picture.values.is_none().then(|| plot::region_lines(plot)));
        elements.extend(plot::frames(plot));
        elements.push(axes(plot, y));
        elements.extend(heading(panel, plot, Lines::new(picture)));
        elements.extend(lines);
        elements.extend(numbers);
        elements.extend(frame);
        elements.extend(symbols);
        let visible = numbered.iter().zip(shown).filter(|(_, is_shown)| *is_shown);
        let visible = visible.map(|((_, boundary), _)| boundary.label.clone()).collect();
        Self { elements, chosen, visible }
    }
}

/// Whether some panel has lines of theory, whose letters stand beside and above the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lines {
    /// Some has.
    Drawn,
    /// None has.
    None,
}

impl Lines {
    /// Those of a picture.
    pub fn new(picture: &DiagramPicture) -> Self {
        let has_lines = picture.panels.iter().any(|panel| !panel.boundaries.is_empty());
        if has_lines { Self::Drawn } else { Self::None }
    }
}

/// What stands above the cells besides a heading, in pixels.
pub fn above_px(lines: Lines) -> f64 {
    match lines {
        Lines::Drawn => 2.0 * boundary::OUTSIDE_PX + 3.0,
        Lines::None => 16.0,
    }
}

fn heading(panel: &Panel, plot: &Plot, lines: Lines) -> Vec<Element> {
    let bottom_px = match lines {
        Lines::Drawn => above_px(lines),
        Lines::None => 7.0,
    };
    Heading::new(&panel.heading, plot.right_px - plot.left_px)
        .drawn(plot.left_px, plot.top_px - bottom_px)
}

/// The boundaries of all panels, each once: a line has one letter and one kind of dashes everywhere.
fn labels(picture: &DiagramPicture) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for boundary in picture.panels.iter().flat_map(|panel| &panel.boundaries) {
        if !labels.contains(&boundary.label) {
            labels.push(boundary.label.clone());
        }
    }
    labels
}

/// The phases that some cell shows, in their order.
fn seen(plots: &[Plot]) -> Vec<Phase> {
    let cells = plots.iter().flat_map(Plot::majorities).collect::<Vec<Phase>>();
    Phase::all().filter(|phase| cells.contains(phase)).collect()
}

/// What the legend has to contain about all panels.
pub fn contents(picture: &DiagramPicture, plots: &[Plot], drawings: &[Drawing]) -> Contents {
    let boundaries = || picture.panels.iter().flat_map(|panel| &panel.boundaries);
    let in_legend = |(index, label): (usize, String)| {
        let is_visible = drawings.iter().any(|drawing| drawing.visible.contains(&label));
        let side = boundaries().find(|boundary| boundary.label == label);
        let side = side.map_or("", |boundary| boundary.holds.in_words());
        is_visible.then(|| (index, format!("{label}, {side}")))
    };
    let chosen = picture.chosen.and_then(|cell| {
        let values = cell.iter().map(|(axis, value)| quantity(axis, value));
        let shape = drawings.iter().find_map(|drawing| drawing.chosen)?;
        Some((values.chain(picture.chosen_note.clone()).collect(), shape))
    });
    let is_shown = |run: &&marks::ExperimentMark| {
        plots.iter().any(|plot| overlay::position_px(plot, &run.cell).is_some())
    };
    let n_shown = |phase: Phase, filling: Filling| -> u64 {
        let is_its = |run: &&marks::ExperimentMark| run.phase == phase && run.filling() == filling;
        let runs = picture.experiments.iter().filter(is_its);
        runs.filter(is_shown).map(|run| run.n).sum()
    };
    let n_all: u64 = picture.experiments.iter().map(|run| run.n).sum();
    let simulated = picture.experiments.iter().filter(|run| run.is_simulated);
    let n_simulated: u64 = simulated.map(|run| run.n).sum();
    let kinds =
        Phase::all().flat_map(|phase| [Filling::Full, Filling::Hollow].map(|it| (phase, it)));
    let experiments: Vec<(Phase, Filling, u64)> = kinds
        .map(|(phase, filling)| (phase, filling, n_shown(phase, filling)))
        .filter(|(_, _, n)| *n > 0)
        .collect();
    let n_experiments_elsewhere = n_all - experiments.iter().map(|(_, _, n)| n).sum::<u64>();
    let numbers = plots.iter().filter_map(Plot::number_px);
    let behaviour = picture.panels.first().map(|panel| panel.diagram.behaviour());
    Contents {
        behaviour: behaviour.unwrap_or_default(),
        values: picture.values.as_ref().map(|values| {
            let framed = values.framed.as_ref().map(|(words, _)| words.clone());
            (values.name.clone(), values.scale, framed)
        }),
        number_px: numbers.reduce(f64::max).filter(|_| picture.numbers == Numbers::Shown),
        phases: seen(plots),
        chosen,
        boundaries: labels(picture).into_iter().enumerate().filter_map(in_legend).collect(),
        experiments,
        n_experiments_elsewhere,
        experiments_are: match n_simulated {
            0 => "experiments",
            n if n == n_all => "simulated experiments",
            _ => "experiments, some simulated",
        },
        has_b_s: picture.panels.iter().all(|panel| panel.is_b_s),
        has_holes: plots.iter().any(Plot::has_blanks),
    }
}
