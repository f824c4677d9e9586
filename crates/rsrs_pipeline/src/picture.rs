//! Pictures of results: what to write on them, and into which file.

mod boundaries;
mod curves;
mod file;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::DiagramCell;
use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::diagram::choice::Choice;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::Sees;
use rsrs_view::diagram::{DiagramPicture, ExperimentMark, Numbers};

use crate::error::helped;
use crate::picture::boundaries::{Plane, boundaries};
use crate::sweep::result::{SweepResult, World};
use crate::wording::{count, percent};

/// Width of PNG pictures, in pixels: sharp in print across a column.
pub const PNG_WIDTH_PX: u32 = 1600;

pub use curves::of_answers;
pub use file::PictureFile;

/// The note on a picture whose simulator was not validated against real robots.
const NOT_VALIDATED: &str = "simulated robots not validated against real trajectories";

/// What a person asked of the picture.
#[derive(Clone, Debug, Default)]
pub struct DiagramOptions {
    /// Horizontal axis; the first swept one if not given.
    pub x: Option<Axis>,
    /// Vertical axis; the second swept one if not given.
    pub y: Option<Axis>,
    /// Values on further axes; where one is missing, that of the chosen cell, or else of the slice
    /// that has most cells.
    pub at: Vec<(Axis, f64)>,
    /// The chosen cell.
    pub chosen: Option<Choice>,
    /// The title; the robot's name in a sentence if not given.
    pub title: Option<String>,
    /// Whether `B_s` is written into the cells.
    pub numbers: Numbers,
    /// Where experiments were run.
    pub experiments: Vec<ExperimentMark>,
    /// The world.
    pub world: World,
    /// The result of `rsrs validate`, if there is one.
    pub validation: Option<String>,
}

/// Draws a sweep as SVG.
///
/// # Errors
///
/// If an axis or value was not swept, or the sweep does not hold the world.
pub fn of_sweep(result: &SweepResult, options: &DiagramOptions) -> anyhow::Result<String> {
    let diagram = result.of_world(options.world)?;
    let mut unused =
        diagram.axes.iter().copied().filter(|axis| options.at.iter().all(|(at, _)| at != axis));
    let x = options.x.or_else(|| unused.next()).unwrap_or(Axis::Speed);
    let y = options.y.or_else(|| {
        diagram
            .axes
            .iter()
            .copied()
            .find(|axis| *axis != x && options.at.iter().all(|(at, _)| at != axis))
    });
    let measured =
        (options.world == World::AsMeasured).then(|| result.source.as_measured()).flatten();
    let cells = measured.as_ref().unwrap_or(&result.source).cells("sweep.yaml")?;
    let at = slice(diagram, x, y, options);
    let (plane, conditions) = plane(diagram, &cells, x, y, &at);
    let boundaries = boundaries(&conditions, plane);
    let robot = &result.source.profile.name;
    let swarm = result.source.sweep.behaviour.swarm();
    let title = options.title.clone().unwrap_or_else(|| format!("Phases of {swarm}: {robot}"));
    let subtitle = format!(
        "{}. {}",
        subtitle(result, diagram, options.world, &conditions),
        how(result, options.world)?
    );
    let note = options.validation.clone().unwrap_or_else(|| NOT_VALIDATED.to_owned());
    let picture = DiagramPicture {
        diagram,
        x,
        y,
        at: &at,
        title,
        subtitle,
        chosen: options.chosen.as_ref().map(|choice| &choice.cell),
        chosen_note: options.chosen.as_ref().map(confirmed),
        numbers: options.numbers,
        boundaries: &boundaries,
        experiments: &options.experiments,
        note: Some(note),
    };
    rsrs_view::diagram::svg(&picture).map_err(helped)
}

/// Which values further axes have in a picture.
///
/// # Arguments
///
/// * `x`, `y` — the axes of the picture.
///
/// # Returns
///
/// What was wished, and for every other axis with several values a value too.
fn slice(
    diagram: &PhaseDiagram,
    x: Axis,
    y: Option<Axis>,
    options: &DiagramOptions,
) -> Vec<(Axis, f64)> {
    let is_wished = |axis: Axis| options.at.iter().any(|(at, _)| *at == axis);
    let is_free = |axis: &Axis| *axis != x && Some(*axis) != y && !is_wished(*axis);
    let free: Vec<Axis> = diagram.axes.iter().copied().filter(is_free).collect();
    let values =
        |cell: &Cell| -> Option<Vec<f64>> { free.iter().map(|axis| cell.get(*axis)).collect() };
    let has_wished = |cell: &Cell| options.at.iter().all(|(axis, at)| cell.get(*axis) == Some(*at));
    let mut slices: Vec<(Vec<f64>, usize)> = Vec::new();
    for cell in diagram.cells.iter().map(|entry| &entry.cell).filter(|cell| has_wished(cell)) {
        let Some(values) = values(cell) else { continue };
        match slices.iter_mut().find(|(slice, _)| *slice == values) {
            Some((_, n_cells)) => *n_cells += 1,
            None => slices.push((values, 1)),
        }
    }
    let most = slices.iter().map(|(_, n_cells)| *n_cells).max().unwrap_or(0);
    slices.retain(|(_, n_cells)| *n_cells == most);
    let chosen = options.chosen.as_ref().and_then(|choice| values(&choice.cell));
    let middle = slices.get(slices.len().saturating_sub(1) / 2).map(|(values, _)| values.clone());
    let rest = chosen.or(middle).unwrap_or_default();
    options.at.iter().copied().chain(free.into_iter().zip(rest)).collect()
}

fn subtitle(
    result: &SweepResult,
    diagram: &PhaseDiagram,
    world: World,
    conditions: &Conditions,
) -> String {
    let sweep = &result.source.sweep;
    let is_one = result.source.as_measured().is_none();
    let world = match world {
        World::Harsher if !is_one => "robots made worse",
        World::Harsher | World::AsMeasured => "robots as measured",
    };
    let sees = match conditions.robot.sees {
        Sees::Body => "sees bodies",
        Sees::Centre => "sees centres",
    };
    let robots = if diagram.axes.contains(&Axis::Robots) {
        String::new()
    } else {
        format!("N = {}, ", conditions.robots)
    };
    let n = |entry: &DiagramCell| entry.counts.total();
    let least = diagram.cells.iter().map(n).min().unwrap_or(0);
    let most = diagram.cells.iter().map(n).max().unwrap_or(0);
    let replicates = if least == most { least.to_string() } else { format!("{least} to {most}") };
    format!("{world}, {robots}{} s, {replicates} replicates per cell, {sees}", sweep.duration_s)
}

/// What fresh runs said of the chosen cell.
fn confirmed(choice: &Choice) -> String {
    format!(
        "confirmed: {} of {} fresh runs {} ({} to {})",
        percent(choice.b_s),
        count(choice.n_replicates),
        choice.behaviour().verb().plain,
        percent(choice.b_s_low),
        percent(choice.b_s_high)
    )
}

/// What else one must know to repeat the sweep: what was fixed, how robots were made worse, the seed.
fn how(result: &SweepResult, world: World) -> anyhow::Result<String> {
    let sweep = &result.source.sweep;
    // The number of robots is said before.
    let fixed = sweep.fixed.values.iter().filter(|(axis, _)| *axis != Axis::Robots);
    let mut parts: Vec<String> = fixed.map(|(axis, value)| format!("{axis}={value}")).collect();
    if world == World::Harsher {
        let factors = serde_json::to_value(sweep.factors(&result.source.profile))?;
        let none = serde_json::to_value(HarsherFactors::NONE)?;
        let changed = factors.as_object().into_iter().flatten();
        let changed = changed.filter(|(key, factor)| none.get(key) != Some(factor));
        parts.extend(changed.map(|(key, factor)| format!("{key} {factor}")));
    }
    parts.push(format!("seed {}", sweep.seed));
    parts.push(format!("sweep {}", result.source.digest()));
    Ok(parts.join(", "))
}

/// The plane of the picture, and the conditions of a cell in it.
fn plane(
    diagram: &PhaseDiagram,
    cells: &[(Cell, Conditions)],
    x: Axis,
    y: Option<Axis>,
    at: &[(Axis, f64)],
) -> (Plane, Conditions) {
    let span = |axis: Axis| {
        let values = diagram.values(axis);
        Some((axis, *values.first()?, *values.last()?))
    };
    let is_here = |cell: &Cell| at.iter().all(|(axis, value)| cell.get(*axis) == Some(*value));
    let here = cells.iter().find(|(cell, _)| is_here(cell));
    let (_, conditions) = here.or(cells.first()).expect("a sweep has cells");
    let x = span(x).unwrap_or((x, 0.0, 0.0));
    (Plane { x, y: y.and_then(span) }, conditions.clone())
}
