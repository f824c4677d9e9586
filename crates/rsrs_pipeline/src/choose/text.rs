//! A choice as a person reads it.

use rsrs_core::diagram::choice::{Choice, Margin};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::harsher::tidy;

use super::{NoViableCell, alternatives_text, as_measured};
use crate::sweep::settling;
use crate::wording::counted;

/// What a chosen cell is called.
pub const VIABLE: &str = "viable";
/// What it is called that there is none.
pub const NO_VIABLE_CELL: &str = "no viable cell";

/// Why no cell is viable where a share of `wanted` was wanted, and what other starts and numbers would give.
pub fn none_viable(none: &NoViableCell, wanted: f64) -> String {
    let mut lines = vec![format!("{NO_VIABLE_CELL}: {}", none.reason)];
    lines.extend(alternatives(&none.best, wanted));
    lines.join("\n")
}

/// A viable cell, of which a share of `wanted` was wanted: how often its runs show it, and how far it may drift.
pub fn viable(choice: &Choice, wanted: f64) -> String {
    let margins = choice.margin.iter().map(|(axis, margin)| drift(choice, *axis, *margin));
    let mut lines = vec![
        format!(
            "{VIABLE}: {} (surely {:.0} % of its runs or more {}, made worse and as measured)",
            choice.cell,
            100.0 * wanted,
            choice.behaviour().verb().plain
        ),
        format!(
            "  made worse, it {} in {:.1} % of {} fresh runs (95 % interval {:.1} to {:.1} %)",
            choice.behaviour().verb().does,
            100.0 * choice.b_s,
            choice.n_replicates,
            100.0 * choice.b_s_low,
            100.0 * choice.b_s_high
        ),
    ];
    lines.extend(tried(choice));
    lines.extend(as_measured(choice).map(|text| format!("  {text}")));
    lines.extend(choice.settling.map(|settling| format!("  {}", settling::text(&settling))));
    let did = choice.behaviour().verb().did;
    let converged =
        |time_s: f64| format!("  half of the runs that {did} had come to it by {time_s:.0} s");
    lines.extend(choice.converged_s.map(converged));
    lines.extend(alternatives(choice, wanted));
    lines.extend(by_circliness(choice));
    lines.extend(margins);
    if choice.margin.values().any(|margin| margin.low > 0.0 || margin.high > 0.0) {
        lines.push(
            "  (by the runs of the sweep, from swept value to swept value; the margins of `rsrs answer` \
             are of finer values and runs of their own, and may be wider or narrower)"
                .to_owned(),
        );
    }
    lines.join("\n")
}

/// How far a value may drift, and what is known beyond.
fn drift(choice: &Choice, axis: Axis, margin: Margin) -> String {
    let Margin { low, high } = margin;
    let edge = choice.edge.get(&axis).copied().unwrap_or_default();
    let value = choice.cell.get(axis).unwrap_or_default();
    let unit = axis.unit();
    let edges = match (edge.low, edge.high) {
        (false, false) => String::new(),
        (true, false) => {
            format!("edge of the sweep: nothing was swept below {}", tidy(value - low))
        }
        (false, true) => {
            format!("edge of the sweep: nothing was swept above {}", tidy(value + high))
        }
        (true, true) => format!(
            "edge of the sweep: nothing was swept below {} and above {}",
            tidy(value - low),
            tidy(value + high)
        ),
    };
    let behind = |edges: String| if edges.is_empty() { edges } else { format!("; {edges}") };
    if low == 0.0 && high == 0.0 {
        return match (edge.low, edge.high) {
            (false, false) => {
                format!(
                    "  {axis} may not drift: the next values that were swept are not surely viable"
                )
            }
            (true, true) => {
                format!("  how far {axis} may drift is unknown: no value beside {value} was swept")
            }
            (true, false) => {
                format!(
                    "  {axis} may not drift upward: the next value is not surely viable; {edges}"
                )
            }
            (false, true) => {
                format!(
                    "  {axis} may not drift downward: the next value is not surely viable; {edges}"
                )
            }
        };
    }
    let low = if low == 0.0 { low.to_string() } else { format!("-{low}") };
    format!("  {axis} may drift by {low} to +{high} {unit}{}", behind(edges))
}

/// How many cells came before this one and did not hold.
fn tried(choice: &Choice) -> Option<String> {
    let n_before = choice.candidates_tried?.checked_sub(1).filter(|n| *n > 0)?;
    Some(format!("  {} ranked before it did not hold", counted(n_before, "cell")))
}

/// What other starts and numbers would give.
fn alternatives(choice: &Choice, wanted: f64) -> Vec<String> {
    alternatives_text(choice, wanted).into_iter().map(|line| format!("  {line}")).collect()
}

/// How `B_s` moves with the circliness from which a mill is called stable.
fn by_circliness(choice: &Choice) -> Option<String> {
    let [lower, stable, higher] = choice.by_circliness.as_slice() else { return None };
    Some(format!(
        "  a mill is stable from a circliness of {} on (0: a filled disc, 1: a thin ring); from {} on it \
         would be {:.1} %, from {} on {:.1} %",
        stable.stable_circliness,
        lower.stable_circliness,
        100.0 * lower.b_s,
        higher.stable_circliness,
        100.0 * higher.b_s
    ))
}
