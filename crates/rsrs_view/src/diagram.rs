//! The phase diagram as a picture for a paper.

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::help::Help;
use rsrs_core::statistics::share::Share;

use crate::arrangement::{Arrangement, BETWEEN_PX, LegendPlace};
use crate::chart::BELOW_PX;
use crate::curves::{self, Curve, CurvesPicture, CurvesPictureError, UprightBoundary};
use crate::header::{header, quiet_lines};
use crate::layout;
use crate::legend::{WIDTH_PX, compact, legend};
use crate::panel::{Drawing, contents};
use crate::plot::{Plot, quantity};
use crate::slice::{Slice, is_same};
use crate::svg::Element;
use crate::theme::Theme;

pub use crate::boundary::{Boundary, Side};
pub use crate::cell_values::{CellValues, ValueScale};
pub use crate::layout::{CellBox, DrawnDiagram};
pub use crate::marks::ExperimentMark;
pub use crate::picture::{DiagramPicture, LEAST_WIDTH_PX, Numbers, Panel};
pub use crate::slice::SliceError;

const NOTE_PX: f64 = 10.5;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// The diagram has no such slice.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// The curve over the only axis cannot be drawn.
    #[error(transparent)]
    Curve(#[from] CurvesPictureError),
    /// There is nothing to draw.
    #[error("the picture has no panels, expected 1 or more")]
    NoPanels,
    /// The page has no room for a diagram.
    #[error("the page is {found_px:.0} px wide, expected {LEAST_WIDTH_PX} px or more")]
    TooNarrow {
        /// Its width, in pixels.
        found_px: f64,
    },
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
            Self::Curve(_)
            | Self::NoPanels
            | Self::TooNarrow { .. }
            | Self::BoundaryNotFinite { .. } => None,
        }
    }
}

/// Draws a phase diagram as a self-contained SVG document: the same text for the same picture, on
/// every machine.
///
/// Hue is the most frequent phase of a cell, lightness its share, the number the share of stable
/// milling `B_s`; hovering a cell shows its counts. Lines separate the phases. Below the number of
/// a cell with real runs stands how many of them ended in the wanted phase, behind the symbol of
/// their most frequent one.
///
/// # Errors
///
/// [`PictureError::Slice`] if a diagram is empty, an axis or value was not swept, or a further axis
/// is left open; [`PictureError::Curve`] if the only axis has no cell.
///
/// # Example
///
/// ```
/// use rsrs_core::quantity::Axis;
/// use rsrs_core::judge::counts::PhaseCounts;
/// use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
/// use rsrs_core::judge::phase::Phase;
/// use rsrs_view::diagram::{DiagramPicture, Numbers, Panel, svg};
///
/// let cell: rsrs_core::quantity::Cell = "speed_m_s=0.15,turn_rate_rad_s=0.75".parse()?;
/// let counts = PhaseCounts::new([Phase::STABLE_MILLING; 16]);
/// let diagram = PhaseDiagram {
///     axes: cell.axes(),
///     cells: vec![DiagramCell { cell: cell.clone(), counts }],
/// };
/// let picture = DiagramPicture {
///     panels: vec![Panel::new(&diagram)],
///     x: Axis::Speed,
///     y: Some(Axis::TurnRate),
///     title: "Nine Flockbots".to_owned(),
///     subtitle: "300 s, 16 replicates".to_owned(),
///     details: "seed 42".to_owned(),
///     chosen: Some(&cell),
///     chosen_note: None,
///     values: None,
///     numbers: Numbers::Shown,
///     experiments: &[],
///     wanted: None,
///     note: None,
///     theme: rsrs_view::theme::Theme::Screen,
///     width_px: None,
/// };
///
/// assert!(svg(&picture)?.contains("16 replicates: 16 stable milling"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn svg(picture: &DiagramPicture) -> Result<String, PictureError> {
    Ok(drawn(picture)?.svg)
}

/// As [`svg`], with where the cells lie, for pages on which they respond.
pub fn drawn(picture: &DiagramPicture) -> Result<DrawnDiagram, PictureError> {
    check(picture)?;
    let slice = |panel: &Panel| Slice::new(panel.diagram, picture.x, picture.y, &panel.at);
    let slices: Vec<Slice> = picture.panels.iter().map(slice).collect::<Result<_, _>>()?;
    if picture.y.is_none() {
        return drawn_curves(picture, &slices);
    }
    let arrangement = Arrangement::new(picture, &slices);
    let margin_px = arrangement.margin_px;
    let room_px = arrangement.page_px - 2.0 * margin_px;
    let subtitles = subtitles(picture, &slices);
    let (header, header_px) = header(picture.theme, &picture.title, &subtitles, margin_px, room_px);
    let plots: Vec<Plot> = slices
        .iter()
        .enumerate()
        .map(|(index, slice)| {
            let corner_px = arrangement.corner_px(index, header_px);
            let plot = Plot::new(slice, corner_px, arrangement.plot_px);
            match &picture.values {
                Some(values) => plot.with_values(values, picture.panels[index].diagram, index),
                None => plot,
            }
        })
        .collect();
    let drawings: Vec<Drawing> = picture
        .panels
        .iter()
        .zip(&plots)
        .map(|(panel, plot)| Drawing::new(picture, panel, plot))
        .collect();
    let plots_px = plots.iter().map(|plot| plot.bottom_px).fold(0.0, f64::max) + BELOW_PX;
    let legend_corner_px = match arrangement.legend {
        LegendPlace::Right => {
            let right_px = plots.iter().map(|plot| plot.right_px).fold(0.0, f64::max);
            (right_px + BETWEEN_PX, plots[0].top_px)
        }
        LegendPlace::Below => (margin_px, plots_px + 8.0),
    };
    let contents = contents(picture, &plots, &drawings);
    let (legend, legend_px) = match picture.theme {
        Theme::Screen => legend(&contents, legend_corner_px, WIDTH_PX.min(room_px)),
        Theme::Paper => compact(&contents, (margin_px, plots_px), room_px),
    };
    let note = picture.note.as_deref().filter(|_| picture.theme == Theme::Screen);
    let corner_px = (margin_px, plots_px.max(legend_px) + 6.0);
    let (note, bottom_px) = quiet_lines(note.unwrap_or_default(), NOTE_PX, corner_px, room_px);

    let below_px = if picture.theme == Theme::Paper { 2.0 } else { 14.0 };
    let size_px = (arrangement.page_px, bottom_px + below_px);
    let page = Element::picture(size_px.0, size_px.1, &picture.title)
        .described(&description(picture, &subtitles))
        .children(header)
        .children(drawings.into_iter().flat_map(|drawing| drawing.elements))
        .children(legend)
        .children(note);
    let panels = picture.panels.iter().zip(&plots);
    let rows = panels.flat_map(|(panel, plot)| layout::in_plot(panel.diagram, plot)).collect();
    Ok(DrawnDiagram { svg: format!("{page}\n"), size_px, rows })
}

/// What is in the file and not on the picture.
fn description(picture: &DiagramPicture, subtitles: &[String]) -> String {
    let texts = subtitles.iter().map(String::as_str).chain(picture.note.as_deref());
    let texts = texts.chain(picture.chosen_note.as_deref());
    picture.theme.description(texts, &picture.details)
}

/// Diagrams of one axis.
fn drawn_curves(picture: &DiagramPicture, slices: &[Slice]) -> Result<DrawnDiagram, PictureError> {
    let panels = || picture.panels.iter().zip(slices);
    let mut subtitles = subtitles(picture, slices);
    subtitles.extend(picture.note.clone());
    let curves = curves::drawn(&CurvesPicture {
        title: picture.title.clone(),
        subtitles,
        details: picture.details.clone(),
        theme: picture.theme,
        curves: panels().map(|(panel, slice)| curve(picture, panel, slice)).collect(),
        marked: "chosen cell",
        wanted: picture.wanted.clone(),
        width_px: picture.width_px,
    })?;
    let rows = panels()
        .zip(&curves.charts)
        .flat_map(|((panel, slice), chart)| layout::along_curve(panel.diagram, slice, chart));
    Ok(DrawnDiagram { rows: rows.collect(), svg: curves.svg, size_px: curves.size_px })
}

/// The share of stable milling over one axis.
fn curve(picture: &DiagramPicture, panel: &Panel, slice: &Slice) -> Curve {
    let mut real: Vec<(f64, Share)> = Vec::new();
    for run in picture.experiments {
        let Some((value, _)) = slice.place(&run.cell) else { continue };
        let hits = if run.phase == run.phase.behaviour().wanted() { run.n } else { 0 };
        let ended = Share { hits, n: run.n };
        match real.iter_mut().find(|(other, _)| is_same(*other, value)) {
            Some((_, share)) => *share = *share + ended,
            None => real.push((value, ended)),
        }
    }
    let line = |boundary: &Boundary| {
        let value = boundary.points.first()?.0;
        Some(UprightBoundary { value, label: boundary.label.clone(), holds: boundary.holds })
    };
    let other = |diagram: &PhaseDiagram| {
        Slice::new(diagram, picture.x, None, &panel.at)
            .map_or_else(|_| Vec::new(), |it| shares(&it))
    };
    Curve {
        heading: panel.heading.clone(),
        axis: picture.x,
        behaviour: panel.diagram.behaviour(),
        points: shares(slice),
        range: None,
        marked: picture.chosen.and_then(|cell| slice.place(cell)).map(|(value, _)| value),
        boundaries: panel.boundaries.iter().filter_map(line).collect(),
        compared: panel.compared.as_ref().map(|(words, diagram)| (words.clone(), other(diagram))),
        real,
    }
}

/// The values of a slice of one axis that were swept, with their shares of the wanted phase.
fn shares(slice: &Slice) -> Vec<(f64, Share)> {
    let point = |(column, value): (usize, &f64)| {
        slice.counts(column, 0).map(|counts| (*value, Share::milling(&counts)))
    };
    slice.x_values.iter().enumerate().filter_map(point).collect()
}

fn check(picture: &DiagramPicture) -> Result<(), PictureError> {
    if picture.panels.is_empty() {
        return Err(PictureError::NoPanels);
    }
    if let Some(found_px) = picture.width_px
        && !(found_px.is_finite() && found_px >= LEAST_WIDTH_PX)
    {
        return Err(PictureError::TooNarrow { found_px });
    }
    for boundary in picture.panels.iter().flat_map(|panel| &panel.boundaries) {
        for (x, y) in &boundary.points {
            if !x.is_finite() || !y.is_finite() {
                let label = boundary.label.clone();
                return Err(PictureError::BoundaryNotFinite { label, x: *x, y: *y });
            }
        }
    }
    Ok(())
}

/// The caller's subtitle, and which slice a lone panel is if it is one of several.
fn subtitles(picture: &DiagramPicture, slices: &[Slice]) -> Vec<String> {
    let mut lines = vec![picture.subtitle.clone()];
    if let [slice] = slices
        && !slice.fixed.is_empty()
    {
        let values: Vec<String> =
            slice.fixed.iter().map(|(axis, value)| quantity(*axis, *value)).collect();
        lines.push(format!("Slice at {}", values.join(" · ")));
    }
    lines
}
