//! The phase diagram as a picture for a paper.

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::help::Help;
use rsrs_core::judge::phase::Phase;
use rsrs_core::statistics::share::Share;

use crate::axes::{self, axes};
use crate::curves::{self, Curve, CurvesPicture, CurvesPictureError};
use crate::header::header;
use crate::legend::{self, Contents, Visibility, legend};
use crate::overlay;
use crate::palette::QUIET_INK;
use crate::plot::{self, Plot, quantity};
use crate::slice::{Slice, is_same};
use crate::svg::{Element, line_of_text};
use crate::text::{Weight, wrap};

pub use crate::overlay::{Boundary, ExperimentMark};
pub use crate::slice::SliceError;

const MARGIN_PX: f64 = 24.0;
const BETWEEN_PX: f64 = 26.0;
const NOTE_PX: f64 = 10.5;

/// A two-dimensional slice of a phase diagram, and what to lay over it.
///
/// # Source
///
/// `fig:phase_plot2`.
#[derive(Clone, Debug)]
pub struct DiagramPicture<'a> {
    /// The result of a sweep.
    pub diagram: &'a PhaseDiagram,
    /// The axis drawn to the right.
    pub x: Axis,
    /// The axis drawn upwards; `None` for a curve of the share of stable milling over the other one.
    pub y: Option<Axis>,
    /// Values of the further axes, each in its own unit; an axis with one value needs none.
    pub at: &'a [(Axis, f64)],
    /// The title; any text.
    pub title: String,
    /// Under the title: profile, replicates, duration, how robots see; any text.
    pub subtitle: String,
    /// The recommended cell, to be marked.
    pub chosen: Option<&'a Cell>,
    /// What is known of it, beside its values; any text.
    pub chosen_note: Option<String>,
    /// Whether `B_s` is written into the cells.
    pub numbers: Numbers,
    /// Analytic boundaries, to be drawn as dashed lines.
    pub boundaries: &'a [Boundary],
    /// Real experiments, to be laid over the simulated cells.
    pub experiments: &'a [ExperimentMark],
    /// Under the picture: what a reader must not overlook; any text.
    pub note: Option<String>,
}

/// Whether a diagram has numbers in its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Numbers {
    /// Where they fit.
    #[default]
    Shown,
    /// None.
    Hidden,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// The diagram has no such slice.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// The curve over the only axis cannot be drawn.
    #[error(transparent)]
    Curve(#[from] CurvesPictureError),
    /// A boundary has a point nowhere.
    #[error("boundary `{label}` has the point ({x}, {y}); expected finite numbers")]
    BoundaryNotFinite {
        /// The boundary.
        label: String,
        /// The point's value on the x-axis.
        x: f64,
        /// The point's value on the y-axis.
        y: f64,
    },
}

impl Help for PictureError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Slice(error) => error.help(),
            Self::Curve(_) | Self::BoundaryNotFinite { .. } => None,
        }
    }
}

/// Draws a phase diagram.
///
/// Hue is the most frequent phase of a cell, lightness its share, the number the share of stable
/// milling `B_s`; hovering a cell shows its counts. Lines separate the phases. A real run is drawn
/// as its phase's symbol, and takes the place of the cell's number.
///
/// # Returns
///
/// A self-contained SVG document; the same text for the same picture, on every machine.
///
/// # Errors
///
/// [`PictureError::Slice`] if the diagram is empty, an axis or value was not swept, or a further
/// axis is left open; [`PictureError::BoundaryNotFinite`] if a boundary has such a point;
/// [`PictureError::Curve`] if the only axis has no cell.
///
/// # Example
///
/// ```
/// use rsrs_core::diagram::axis::Axis;
/// use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
/// use rsrs_core::judge::phase::Phase;
/// use rsrs_view::diagram::{DiagramPicture, Numbers, svg};
///
/// let cell: rsrs_core::diagram::axis::Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75".parse()?;
/// let counts = PhaseCounts::of([Phase::StableMilling; 16]);
/// let diagram = PhaseDiagram {
///     axes: cell.axes(),
///     cells: vec![DiagramCell { cell: cell.clone(), counts }],
/// };
/// let picture = DiagramPicture {
///     diagram: &diagram,
///     x: Axis::Speed,
///     y: Some(Axis::TurnRate),
///     at: &[],
///     title: "Nine Flockbots".to_owned(),
///     subtitle: "300 s, 16 replicates".to_owned(),
///     chosen: Some(&cell),
///     chosen_note: None,
///     numbers: Numbers::Shown,
///     boundaries: &[],
///     experiments: &[],
///     note: None,
/// };
///
/// assert!(svg(&picture)?.contains("16 replicates: 16 stable milling"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn svg(picture: &DiagramPicture) -> Result<String, PictureError> {
    check_boundaries(picture.boundaries)?;
    let slice = Slice::new(picture.diagram, picture.x, picture.y, picture.at)?;
    let Some(y) = picture.y else {
        return Ok(curves::svg(&one_curve(picture, &slice))?);
    };

    let left_px = axes::left_of_cells_px(&slice).max(MARGIN_PX);
    let legend_left_px = left_px + plot::size_px(&slice).0 + BETWEEN_PX;
    let page_width_px = legend_left_px + legend::WIDTH_PX + MARGIN_PX;
    let room_px = page_width_px - 2.0 * MARGIN_PX;

    let (header, header_px) =
        header(&picture.title, &subtitles(picture, &slice), MARGIN_PX, room_px);
    let plot = Plot::new(&slice, left_px, header_px + 16.0);
    let (lines, marks, contents) = overlays(picture, &plot);
    let (legend, legend_bottom_px) = legend(&contents, legend_left_px, plot.top_px);
    let body_bottom_px = legend_bottom_px.max(plot.bottom_px + axes::BELOW_PX);
    let (note, bottom_px) = note(picture.note.as_deref(), room_px, body_bottom_px);

    let is_covered = |column: usize, row: usize| {
        picture
            .experiments
            .iter()
            .any(|run| run.n > 0 && overlay::grid_cell(&plot, &run.cell) == Some((column, row)))
    };
    let page = Element::picture(page_width_px, bottom_px + 14.0, &picture.title)
        .children(header)
        .child(plot::heat_map(&plot))
        .child(plot::region_lines(&plot))
        .child(axes(&plot, y))
        .children(lines)
        .children(has_numbers(picture).then(|| plot::numbers(&plot, is_covered)).flatten())
        .children(marks)
        .children(legend)
        .children(note);
    Ok(format!("{page}\n"))
}

/// The share of stable milling over one axis.
fn one_curve(picture: &DiagramPicture, slice: &Slice) -> CurvesPicture {
    let point = |(column, value): (usize, &f64)| {
        slice.counts(column, 0).map(|counts| (*value, Share::milling(&counts)))
    };
    let mut real: Vec<(f64, Share)> = Vec::new();
    for run in picture.experiments {
        let Some((value, _)) = slice.place(&run.cell) else { continue };
        let hits = if run.phase == run.phase.behaviour().wanted() { run.n } else { 0 };
        match real.iter_mut().find(|(other, _)| is_same(*other, value)) {
            Some((_, share)) => *share = Share { hits: share.hits + hits, n: share.n + run.n },
            None => real.push((value, Share { hits, n: run.n })),
        }
    }
    let line = |boundary: &Boundary| Some((boundary.points.first()?.0, boundary.label.clone()));
    let curve = Curve {
        heading: String::new(),
        axis: picture.x,
        points: slice.x_values.iter().enumerate().filter_map(point).collect(),
        range: None,
        marked: picture.chosen.and_then(|cell| slice.place(cell)).map(|(value, _)| value),
        boundaries: picture.boundaries.iter().filter_map(line).collect(),
        real,
    };
    let mut subtitles = subtitles(picture, slice);
    subtitles.extend(picture.note.clone());
    CurvesPicture {
        title: picture.title.clone(),
        subtitles,
        curves: vec![curve],
        marked: "chosen cell",
        wanted: None,
    }
}

fn has_numbers(picture: &DiagramPicture) -> bool {
    picture.numbers == Numbers::Shown
}

fn check_boundaries(boundaries: &[Boundary]) -> Result<(), PictureError> {
    for boundary in boundaries {
        for (x, y) in &boundary.points {
            if !x.is_finite() || !y.is_finite() {
                let label = boundary.label.clone();
                return Err(PictureError::BoundaryNotFinite { label, x: *x, y: *y });
            }
        }
    }
    Ok(())
}

/// The caller's subtitle, and which slice this is if it is one of several.
fn subtitles(picture: &DiagramPicture, slice: &Slice) -> Vec<String> {
    let mut lines = vec![picture.subtitle.clone()];
    if !slice.fixed.is_empty() {
        let values: Vec<String> =
            slice.fixed.iter().map(|(axis, value)| quantity(*axis, *value)).collect();
        lines.push(format!("Slice at {}", values.join(" · ")));
    }
    lines
}

/// The lines under the numbers, the marks over them, and what the legend has to say about both.
fn overlays(picture: &DiagramPicture, plot: &Plot) -> (Vec<Element>, Vec<Element>, Contents) {
    let visibility =
        |is_shown: bool| if is_shown { Visibility::Shown } else { Visibility::Outside };
    let (lines, shown) = overlay::boundaries(plot, picture.boundaries);
    let boundaries = picture
        .boundaries
        .iter()
        .zip(shown)
        .map(|(boundary, is_shown)| (boundary.label.clone(), visibility(is_shown)))
        .collect();

    let mut marks = Vec::new();
    let chosen = picture.chosen.map(|cell| {
        let (shape, mark) = overlay::chosen(plot, cell).unzip();
        marks.extend(mark);
        let values = cell.iter().map(|(axis, value)| quantity(axis, value));
        (values.chain(picture.chosen_note.clone()).collect(), shape)
    });

    let (symbols, n_experiments_elsewhere) = overlay::experiments(plot, picture.experiments);
    marks.extend(symbols);
    let n_shown = |phase: Phase| -> u64 {
        let runs = picture.experiments.iter().filter(|run| run.phase == phase);
        runs.filter(|run| overlay::position_px(plot, &run.cell).is_some()).map(|run| run.n).sum()
    };
    let experiments = Phase::ALL.map(|phase| (phase, n_shown(phase)));

    let contents = Contents {
        behaviour: picture.diagram.behaviour(),
        number_px: plot.number_px().filter(|_| has_numbers(picture)),
        chosen,
        boundaries,
        experiments: experiments.into_iter().filter(|(_, n)| *n > 0).collect(),
        n_experiments_elsewhere,
        has_holes: plot.slice.has_holes(),
    };
    (lines, marks, contents)
}

fn note(text: Option<&str>, room_px: f64, top_px: f64) -> (Vec<Element>, f64) {
    let mut y_px = top_px + 6.0;
    let mut elements = Vec::new();
    for line in wrap(text.unwrap_or_default(), NOTE_PX, Weight::Regular, room_px) {
        y_px += NOTE_PX * 1.45;
        let text =
            line_of_text(MARGIN_PX, y_px, &line).at("font-size", NOTE_PX).with("fill", QUIET_INK);
        elements.push(text);
    }
    (elements, y_px)
}
