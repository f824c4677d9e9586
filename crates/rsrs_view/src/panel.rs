//! One panel of a phase diagram: the heat map, and what lies over it.

use rsrs_core::judge::phase::Phase;

use crate::axes::axes;
use crate::boundary::{self, Boundary};
use crate::legend::{Contents, Visibility};
use crate::marks;
use crate::overlay::{self, ChosenShape};
use crate::palette::INK;
use crate::picture::{DiagramPicture, Numbers, Panel};
use crate::plot::{self, Plot, quantity};
use crate::svg::{Element, line_of_text};
use crate::symbol::Filling;

/// Height of the letters above a panel, in pixels.
pub const HEADING_PX: f64 = 12.5;

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
    pub fn of(picture: &DiagramPicture, panel: &Panel, plot: &Plot) -> Self {
        let is_covered = |column: usize, row: usize| {
            let here = Some((column, row));
            let is_here = |run: &marks::ExperimentMark| overlay::grid_cell(plot, &run.cell) == here;
            picture.experiments.iter().any(|run| run.n > 0 && is_here(run))
        };
        let (numbers, kept) = match picture.numbers {
            Numbers::Shown => plot::numbers(plot, is_covered),
            Numbers::Hidden => (None, Vec::new()),
        };
        let labels = labels(picture);
        let number_of = |line: &Boundary| labels.iter().position(|label| *label == line.label);
        let numbered: Vec<(usize, &Boundary)> = panel
            .boundaries
            .iter()
            .filter_map(|boundary| Some((number_of(boundary)?, boundary)))
            .collect();
        let (lines, shown) = boundary::boundaries(plot, &numbered, &kept);
        let (chosen, frame) = picture.chosen.and_then(|cell| overlay::chosen(plot, cell)).unzip();
        let (symbols, _) = marks::experiments(plot, picture.experiments);
        let y = picture.y.expect("a heat map has two axes");

        let mut elements = vec![plot::heat_map(plot), plot::region_lines(plot), axes(plot, y)];
        elements.extend(heading(panel, plot, Lines::of(picture)));
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
    pub fn of(picture: &DiagramPicture) -> Self {
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

fn heading(panel: &Panel, plot: &Plot, lines: Lines) -> Option<Element> {
    let is_alone = panel.heading.is_empty();
    let bottom_px = match lines {
        Lines::Drawn => above_px(lines),
        Lines::None => 7.0,
    };
    let text = line_of_text(plot.left_px, plot.top_px - bottom_px, &panel.heading)
        .at("font-size", HEADING_PX)
        .with("font-weight", "bold")
        .with("fill", INK);
    (!is_alone).then_some(text)
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

/// What the legend has to contain about all panels.
pub fn contents(picture: &DiagramPicture, plots: &[Plot], drawings: &[Drawing]) -> Contents {
    let boundaries = || picture.panels.iter().flat_map(|panel| &panel.boundaries);
    let in_legend = |label: String| {
        let is_visible = drawings.iter().any(|drawing| drawing.visible.contains(&label));
        let side = boundaries().find(|boundary| boundary.label == label);
        let side = side.map_or("", |boundary| boundary.holds.in_words());
        let visibility = if is_visible { Visibility::Shown } else { Visibility::Outside };
        (format!("{label}, {side}"), visibility)
    };
    let chosen = picture.chosen.map(|cell| {
        let values = cell.iter().map(|(axis, value)| quantity(axis, value));
        let shape = drawings.iter().find_map(|drawing| drawing.chosen);
        (values.chain(picture.chosen_note.clone()).collect(), shape)
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
    let kinds = Phase::ALL.map(|phase| [Filling::Full, Filling::Hollow].map(|it| (phase, it)));
    let experiments: Vec<(Phase, Filling, u64)> = (kinds.into_iter().flatten())
        .map(|(phase, filling)| (phase, filling, n_shown(phase, filling)))
        .filter(|(_, _, n)| *n > 0)
        .collect();
    let n_experiments_elsewhere = n_all - experiments.iter().map(|(_, _, n)| n).sum::<u64>();
    let numbers = plots.iter().filter_map(Plot::number_px);
    let behaviour = picture.panels.first().map(|panel| panel.diagram.behaviour());
    Contents {
        behaviour: behaviour.unwrap_or_default(),
        number_px: numbers.reduce(f64::max).filter(|_| picture.numbers == Numbers::Shown),
        chosen,
        boundaries: labels(picture).into_iter().map(in_legend).collect(),
        experiments,
        n_experiments_elsewhere,
        has_holes: plots.iter().any(|plot| plot.slice.has_holes()),
    }
}
