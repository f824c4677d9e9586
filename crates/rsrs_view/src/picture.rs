//! What is drawn of a phase diagram, and laid over it.

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::quantity::{Axis, Cell};

use crate::boundary::Boundary;
use crate::cell_values::CellValues;
use crate::marks::ExperimentMark;
use crate::theme::Theme;

/// The narrowest page, in pixels of 1/96 inch: 60 mm.
pub const LEAST_WIDTH_PX: f64 = 226.0;

/// Two-dimensional slices of phase diagrams, and what to lay over them.
///
/// # Source
///
/// `fig:phase_plot2`.
#[derive(Clone, Debug)]
pub struct DiagramPicture<'a> {
    /// What is drawn, side by side if there are several; at least one.
    pub panels: Vec<Panel<'a>>,
    /// The axis drawn to the right.
    pub x: Axis,
    /// The axis drawn upwards; `None` for a curve of the share of stable milling over the other one.
    pub y: Option<Axis>,
    /// The title; any text.
    pub title: String,
    /// Under the title: profile, replicates, duration; any text.
    pub subtitle: String,
    /// What else it takes to repeat the picture, in the file and not on it; any text.
    pub details: String,
    /// The recommended cell, to be marked.
    pub chosen: Option<&'a Cell>,
    /// What is known of it, beside its values; any text.
    pub chosen_note: Option<String>,
    /// Numbers that the cells show in the place of their phases.
    pub values: Option<CellValues>,
    /// Whether `B_s`, or what is shown in its place, is written into the cells.
    pub numbers: Numbers,
    /// Real experiments, to be laid over the simulated cells.
    pub experiments: &'a [ExperimentMark],
    /// A share to be drawn across a curve, with what it is; any text.
    pub wanted: Option<(f64, String)>,
    /// Under the picture: what a reader must not overlook; any text.
    pub note: Option<String>,
    /// Where it is looked at.
    pub theme: Theme,
    /// Width of the page, in pixels of 1/96 inch, at least [`LEAST_WIDTH_PX`]; as wide as it takes if
    /// not given.
    pub width_px: Option<f64>,
}

/// One slice of one diagram.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Above it; any text, empty for one that is alone.
    pub heading: String,
    /// The result of a sweep.
    pub diagram: &'a PhaseDiagram,
    /// Values of the axes that the picture does not show, each in its own unit; an axis with one value
    /// needs none.
    pub at: Vec<(Axis, f64)>,
    /// Analytic boundaries, to be drawn as dashed lines.
    pub boundaries: Vec<Boundary>,
    /// Whether its shares are `B_s`: those of robots made worse, and not as measured.
    pub is_b_s: bool,
    /// Other robots, in words, and their diagram: a second curve where there is one axis.
    pub compared: Option<(String, &'a PhaseDiagram)>,
}

impl<'a> Panel<'a> {
    /// A diagram of the axes of its picture, of robots made worse, without boundaries.
    pub fn new(diagram: &'a PhaseDiagram) -> Self {
        Self {
            heading: String::new(),
            diagram,
            at: Vec::new(),
            boundaries: Vec::new(),
            is_b_s: true,
            compared: None,
        }
    }
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
