//! Whether runs were "given enough time": whether their phases still change towards their end.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::diagram::{DiagramCell, PhaseDiagram, Point, moved};
use crate::judge::phase::Phase;
use crate::judge::window::Window;
use crate::statistics::share::Share;

/// How many runs of a cell end in another phase than they had at two thirds of their time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settling {
    /// Runs that were looked at.
    pub n_replicates: u64,
    /// Those whose phase changed in the last third.
    pub n_changed: u64,
    /// When the last third begins, in seconds.
    pub from_s: f64,
}

/// A cell of whose runs surely more than this share change in the last third is not settled;
/// dimensionless.
pub const UNSETTLED_SHARE: f64 = 0.1;

impl Settling {
    /// Counts the changes from the phases at two thirds to those at the end, shape `[n_replicates]`
    /// both; the last third begins at `from_s`, in seconds.
    pub fn new(before: &[Phase], after: &[Phase], from_s: f64) -> Self {
        let changed = before.iter().zip(after).filter(|(before, after)| before != after);
        Self {
            n_replicates: before.len().min(after.len()) as u64,
            n_changed: changed.count() as u64,
            from_s,
        }
    }

    /// When the last third of a run begins; `None` if the judge cannot look at what is before.
    pub fn last_third_s(duration_s: f64, window: Window) -> Option<f64> {
        let from_s = duration_s * 2.0 / 3.0;
        (from_s >= window.least_s()).then_some(from_s)
    }

    /// Whether the cell is settled, as far as these runs can show: not surely more than
    /// [`UNSETTLED_SHARE`] of them change their phase, with 95 % confidence.
    pub fn is_settled(&self) -> bool {
        let Self { n_replicates: n, n_changed: hits, .. } = *self;
        n == 0 || Share { hits, n }.interval().low <= UNSETTLED_SHARE
    }
}

/// The cells on both sides of the edge of the milling region, by their index in the diagram.
///
/// A cell belongs to the region if half of its runs mill. The border of the grid is no edge here:
/// nothing was simulated beyond it that could still change.
pub fn edge(diagram: &PhaseDiagram) -> BTreeSet<usize> {
    let mills = |entry: &DiagramCell| entry.counts.wanted_share() >= 0.5;
    let inside = (0..).zip(diagram.cells.iter().map(mills));
    let cells: BTreeMap<Point, (usize, bool)> = diagram.points().into_iter().zip(inside).collect();
    let mut edge = BTreeSet::new();
    for (place, (index, is_inside)) in &cells {
        for axis in 0..place.len() {
            let next = moved(place, axis, place[axis] + 1);
            if let Some((other, is_other_inside)) = cells.get(&next)
                && is_inside != is_other_inside
            {
                edge.extend([*index, *other]);
            }
        }
    }
    edge
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::counts::PhaseCounts;
    use crate::quantity::{Axis, Cell};

    #[test]
    fn a_cell_is_unsettled_when_surely_more_than_a_tenth_of_its_runs_change() {
        let settling =
            |n_changed, n_replicates| Settling { n_replicates, n_changed, from_s: 200.0 };

        assert!(settling(0, 16).is_settled());
        assert!(settling(4, 16).is_settled(), "sixteen runs are few");
        assert!(!settling(6, 16).is_settled());
        assert!(settling(24, 200).is_settled());
        assert!(!settling(40, 200).is_settled());
    }

    #[test]
    fn changes_are_counted_run_by_run() {
        let [mill, apart] = [Phase::STABLE_MILLING, Phase::DISPERSION];
        let before = [mill, apart, apart];
        let after = [mill, mill, apart];

        let expected = Settling { n_replicates: 3, n_changed: 1, from_s: 80.0 };
        assert_eq!(Settling::new(&before, &after, 80.0), expected);
        assert_eq!(Settling::last_third_s(300.0, Window::default()), Some(200.0));
        assert_eq!(
            Settling::last_third_s(60.0, Window::default()),
            None,
            "the judge needs a minute"
        );
    }

    #[test]
    fn the_edge_is_where_neighbours_differ_and_not_the_border_of_the_grid() {
        let cell = |x: usize, y: usize, mills: bool| DiagramCell {
            cell: Cell::new([(Axis::Speed, x as f64), (Axis::TurnRate, y as f64)]).unwrap(),
            counts: PhaseCounts::new([if mills { Phase::STABLE_MILLING } else { Phase::UNFORMED }]),
        };
        let cells = (0..4).flat_map(|x| (0..3).map(move |y| cell(x, y, x < 2)));
        let diagram =
            PhaseDiagram { axes: vec![Axis::Speed, Axis::TurnRate], cells: cells.collect() };

        let found: Vec<f64> = edge(&diagram)
            .into_iter()
            .map(|index| diagram.cells[index].cell.get(Axis::Speed).unwrap())
            .collect();

        assert_eq!(found, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    }
}
