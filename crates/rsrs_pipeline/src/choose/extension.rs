//! How a sweep would have to go on, where its chosen cell lies at its edge.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::choice::Choice;
use rsrs_core::numerals::significant;
use rsrs_core::quantity::{Axis, Cell};
use serde::Serialize;

use crate::sweep::result::SweepResult;

/// An axis at whose end the chosen cell lies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extension {
    /// The axis.
    pub axis: Axis,
    /// The end of the axis that the chosen cell has.
    pub end: f64,
    /// Which end it is.
    pub side: Side,
    /// All values that the axis would have to have; empty if the robots can do nothing beyond it.
    pub values: Vec<f64>,
}

/// An end of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Nothing was swept below.
    Below,
    /// Nothing was swept above.
    Above,
}

/// Values that are added at an end.
const ADDED: usize = 3;

/// The axes at whose end a chosen cell lies, with what would have to be swept besides.
pub fn extensions(result: &SweepResult, choice: &Choice) -> Vec<Extension> {
    let mut found = Vec::new();
    for (axis, edge) in &choice.edge {
        let values = result.diagram.values(*axis);
        // One value alone shows no step.
        if values.len() < 2 {
            continue;
        }
        let (Some(first), Some(last), Some(here)) =
            (values.first().copied(), values.last().copied(), choice.cell.get(*axis))
        else {
            continue;
        };
        for (side, end, is_edge) in [(Side::Below, first, edge.low), (Side::Above, last, edge.high)]
        {
            if is_edge && here.total_cmp(&end).is_eq() {
                let added = beyond(result, choice, *axis, side, &values);
                let none = added.is_empty();
                let mut all: Vec<f64> = values.iter().copied().chain(added).collect();
                all.sort_by(f64::total_cmp);
                let values = if none { Vec::new() } else { all };
                found.push(Extension { axis: *axis, end, side, values });
            }
        }
    }
    found
}

/// The next values beyond an end, as far as such robots can be simulated and may be commanded.
fn beyond(
    result: &SweepResult,
    choice: &Choice,
    axis: Axis,
    side: Side,
    values: &[f64],
) -> Vec<f64> {
    let source = &result.source;
    let is_possible = |value: &f64| {
        let pairs =
            choice.cell.iter().map(|(other, at)| (other, if other == axis { *value } else { at }));
        let Ok(cell) = Cell::new(pairs) else { return false };
        let settings = source.sweep.settings().with_cell(&cell);
        Conditions::resolve(&source.profile, &settings)
            .is_ok_and(|conditions| conditions.is_within_limits(&source.profile))
    };
    let n = values.len();
    let next = |from: f64| match (axis, side) {
        (Axis::Robots | Axis::LatencySteps, Side::Below) => from - (values[1] - values[0]),
        // By the same ratio, which never comes to zero.
        (_, Side::Below) => significant(from * values[0] / values[1]),
        (_, Side::Above) => significant(from + (values[n - 1] - values[n - 2])),
    };
    let end = if side == Side::Below { values[0] } else { values[n - 1] };
    std::iter::successors(Some(next(end)), |value| Some(next(*value)))
        .take(ADDED)
        .take_while(is_possible)
        .filter(|value| value.total_cmp(&end).is_ne())
        .collect()
}
