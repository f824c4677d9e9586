//! The picture of a sweep: what to write on it.

use rsrs_core::axis::{Axis, Cell};
use rsrs_core::conditions::Conditions;
use rsrs_core::profile::Sees;
use rsrs_core::theory::Ring;
use rsrs_view::diagram::{Boundary, DiagramPicture, ExperimentMark};

use crate::failure::with_help;
use crate::result_folder::SweepResult;

/// Width of PNG pictures, in pixels: sharp in print across a column.
pub const PNG_WIDTH_PX: u32 = 1600;

/// What a person asked of the picture.
#[derive(Clone, Debug, Default)]
pub struct Wish {
    /// Horizontal axis; the first swept one if not said.
    pub x: Option<Axis>,
    /// Vertical axis; the second swept one if not said.
    pub y: Option<Axis>,
    /// Values on further axes.
    pub at: Vec<(Axis, f64)>,
    /// The chosen cell.
    pub chosen: Option<Cell>,
    /// Where experiments were run.
    pub experiments: Vec<ExperimentMark>,
}

/// Draws a sweep as SVG.
///
/// # Errors
///
/// If an axis or value was not swept.
pub fn of_sweep(result: &SweepResult, wish: &Wish) -> anyhow::Result<String> {
    let diagram = &result.diagram;
    let mut unused =
        diagram.axes.iter().copied().filter(|axis| wish.at.iter().all(|(at, _)| at != axis));
    let x = wish.x.or_else(|| unused.next()).unwrap_or(Axis::Speed);
    let y = wish.y.or_else(|| {
        diagram
            .axes
            .iter()
            .copied()
            .find(|axis| *axis != x && wish.at.iter().all(|(at, _)| at != axis))
    });
    let cells = result.source.cells("sweep.yaml")?;
    let (_, conditions) = cells.first().expect("a sweep has cells");
    let boundaries = turn_balance(&diagram.values(Axis::TurnRate), conditions, (x, y));
    let picture = DiagramPicture {
        diagram,
        x,
        y,
        at: &wish.at,
        title: format!("Phases of a milling swarm: {}", result.source.profile.name),
        subtitle: subtitle(result, conditions),
        chosen: wish.chosen.as_ref(),
        boundaries: &boundaries,
        experiments: &wish.experiments,
        note: Some("simulated robots not validated against real trajectories".to_owned()),
    };
    rsrs_view::diagram::svg(&picture).map_err(|error| match error.help() {
        Some(help) => with_help(error.to_string(), help),
        None => error.into(),
    })
}

fn subtitle(result: &SweepResult, conditions: &Conditions) -> String {
    let sweep = &result.source.sweep;
    let sees = match conditions.robot.sees {
        Sees::Body => "sees bodies",
        Sees::Centre => "sees centres",
    };
    let robots = if result.diagram.axes.contains(&Axis::Robots) {
        String::new()
    } else {
        format!("N = {}, ", conditions.robots)
    };
    format!("{robots}{} s, {} replicates per cell, {sees}", sweep.duration_s, sweep.replicates)
}

/// The line beyond which robots turn too slowly for their speed to balance left and right
/// (`theory::Ring::greatest_speed_m_s`), where speed and turning rate are the picture's axes.
fn turn_balance(
    turn_rates: &[f64],
    conditions: &Conditions,
    axes: (Axis, Option<Axis>),
) -> Vec<Boundary> {
    let is_flipped = match axes {
        (Axis::Speed, Some(Axis::TurnRate)) => false,
        (Axis::TurnRate, Some(Axis::Speed)) => true,
        _ => return Vec::new(),
    };
    let (Some(ring), Some(low), Some(high)) =
        (Ring::of(conditions), turn_rates.first(), turn_rates.last())
    else {
        return Vec::new();
    };
    let points = (0..=SEGMENTS).filter_map(|segment| {
        // The plot reaches beyond the outermost cells' centres.
        let turn_rate = 0.5 * low + (1.5 * high - 0.5 * low) * f64::from(segment) / SEGMENTS_F;
        let speed = ring.greatest_speed_m_s(turn_rate)?;
        Some(if is_flipped { (turn_rate, speed) } else { (speed, turn_rate) })
    });
    let points: Vec<(f64, f64)> = points.collect();
    if points.len() < 2 {
        return Vec::new();
    }
    vec![Boundary { label: "turn balance, analytic".to_owned(), points }]
}

const SEGMENTS: u32 = 100;
const SEGMENTS_F: f64 = 100.0;
