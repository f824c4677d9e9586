//! Which cell to run: the one from which the robots may drift furthest and still mill.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::axis::{Axis, Cell};
use crate::comparison::Share;
use crate::diagram::{PhaseCounts, PhaseDiagram};
use crate::harsher::tidy;
use crate::interval_kind::IntervalKind;
use crate::order::Evidence;
use crate::phase::{Phase, Thresholds};

/// A cell inside the milling region.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Index in [`PhaseDiagram::cells`].
    pub index: usize,
    /// The cell.
    pub cell: Cell,
    /// Milling replicates of the sweep. They chose the cell, so they flatter it; only a
    /// confirmation says how good it is.
    pub swept: Share,
    /// Distance to the nearest cell outside the region or beyond the grid's border, in grid steps.
    pub depth: f64,
    /// How far each swept axis may drift.
    pub margin: BTreeMap<Axis, Margin>,
}

/// How far a value may drift, in the unit of its axis, and still be that of a swept cell in the
/// region, the other axes unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Downward.
    pub low: f64,
    /// Upward.
    pub high: f64,
}

/// The chosen cell, confirmed on fresh seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The cell.
    pub cell: Cell,
    /// Share of confirming replicates that milled.
    pub b_s: f64,
    /// Lower bound of its 95 % interval.
    pub b_s_low: f64,
    /// Upper bound.
    pub b_s_high: f64,
    /// Number of confirming replicates.
    pub n_replicates: u64,
    /// How far each swept axis may drift.
    pub margin: BTreeMap<Axis, Margin>,
    /// How the confirming replicates ended; `None` in a file that does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phases: Option<PhaseCounts>,
    /// The same cell with the robots as measured; `None` if they were not made worse, or in a file
    /// that does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_measured: Option<AsMeasured>,
    /// `b_s` for other circliness at which semi-stable mills end and stable ones begin; empty in a
    /// file that does not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_circliness: Vec<AtCircliness>,
}

/// What `B_s` would be if a mill were called stable from another circliness on.
///
/// Stable and semi-stable mills are a continuum (§IV step 3), and where to cut it is a convention.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AtCircliness {
    /// Least circliness of a stable mill; 0.5 is what every phase rests on.
    pub stable_circliness: f64,
    /// Share of replicates that milled.
    pub b_s: f64,
}

impl AtCircliness {
    /// Judges replicates again with lower, equal and higher thresholds.
    ///
    /// # Arguments
    ///
    /// * `evidence` — the order parameters of simulated replicates, whose range is known; at least
    ///   one.
    pub fn of(evidence: &[Evidence]) -> Vec<Self> {
        let at = |stable_circliness: f64| {
            let thresholds = Thresholds { stable_circliness, ..Thresholds::default() };
            let is_mill =
                |evidence: &&Evidence| thresholds.phase(evidence, None) == Phase::StableMilling;
            let n_mills = evidence.iter().filter(is_mill).count();
            Self { stable_circliness, b_s: n_mills as f64 / evidence.len() as f64 }
        };
        [0.4, Thresholds::default().stable_circliness, 0.6].map(at).into()
    }
}

/// What robots as measured do where robots made worse were chosen.
///
/// That a robot is nowhere less capable does not mean that a swarm of them mills more often
/// (`eq:finalgap` is a claim, and not a theorem): some imperfections help.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AsMeasured {
    /// Share of replicates that milled.
    pub share: f64,
    /// Lower bound of its 95 % interval.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Number of replicates.
    pub n_replicates: u64,
}

impl AsMeasured {
    /// What follows from how replicates ended.
    pub fn of(phases: &PhaseCounts) -> Self {
        let milling = Share::milling(phases);
        let interval = milling.interval();
        Self {
            share: milling.value(),
            low: interval.low,
            high: interval.high,
            n_replicates: milling.n,
        }
    }
}

/// A cell belongs to the milling region when the lower bound of its `B_s` is at least this.
pub const REGION_B_S_LOW: f64 = 0.5;

/// A confirmed cell is viable when the lower bound of its `B_s` is at least this, unless asked
/// otherwise.
pub const VIABLE_B_S_LOW: f64 = 0.8;

impl Choice {
    /// The choice of a candidate after its confirmation.
    ///
    /// # Arguments
    ///
    /// * `candidate` — the winner of [`rank`].
    /// * `phases` — how fresh replicates ended; those of the sweep do not count.
    pub fn new(candidate: &Candidate, phases: PhaseCounts) -> Self {
        let confirmed = Share::milling(&phases);
        let interval = confirmed.interval();
        Self {
            cell: candidate.cell.clone(),
            b_s: confirmed.value(),
            b_s_low: interval.low,
            b_s_high: interval.high,
            n_replicates: confirmed.n,
            margin: candidate.margin.clone(),
            phases: Some(phases),
            as_measured: None,
            by_circliness: Vec::new(),
        }
    }

    /// Whether robots as measured surely mill less often than these, which are worse: no point of
    /// one interval is in the other. Then fewer mills on the floor are to be expected.
    pub fn worse_is_better(&self) -> bool {
        self.as_measured.is_some_and(|measured| measured.high < self.b_s_low)
    }

    /// Whether the simulated robots are capable enough: the lower bound of the confirmed `B_s` is
    /// at least `least_b_s_low` ([`VIABLE_B_S_LOW`] by default).
    pub fn is_viable(&self, least_b_s_low: f64) -> bool {
        self.b_s_low >= least_b_s_low
    }
}

/// Ranks the cells of the milling region, the most robust first.
///
/// A cell is better the deeper it lies inside the region: a grid step on any swept axis counts the
/// same, distances are Euclidean, and the border of the grid is an edge, because nothing is known
/// beyond it. An axis with a single value is not swept. A point of the grid that was not simulated
/// is outside. Equally deep cells are ranked by `B_s`, then by nearness to the centroid of the
/// region, then by their order in the sweep.
///
/// # Arguments
///
/// * `kind` — of the intervals whose lower bound makes the region: those of a sweep that decided by
///   itself when to stop must be valid at any time.
///
/// # Returns
///
/// Every cell of the region; empty if no cell mills well enough.
pub fn rank(diagram: &PhaseDiagram, kind: IntervalKind) -> Vec<Candidate> {
    let grid = Grid::of(diagram, kind);
    let centroid = grid.centroid();
    let mut ranked: Vec<(f64, Candidate)> = grid
        .region
        .iter()
        .map(|(point, index)| {
            let candidate = Candidate {
                index: *index,
                cell: diagram.cells[*index].cell.clone(),
                swept: Share::milling(&diagram.cells[*index].counts),
                depth: grid.depth(point),
                margin: grid.margin(point),
            };
            (distance(point, &centroid), candidate)
        })
        .collect();
    ranked.sort_by(|(left_off, left), (right_off, right)| {
        right
            .depth
            .total_cmp(&left.depth)
            .then(right.swept.value().total_cmp(&left.swept.value()))
            .then(left_off.total_cmp(right_off))
            .then(left.index.cmp(&right.index))
    });
    ranked.into_iter().map(|(_, candidate)| candidate).collect()
}

/// A cell as the positions of its values on their axes.
type Point = Vec<usize>;

/// The milling region on the grid of the swept values.
struct Grid {
    axes: Vec<(Axis, Vec<f64>)>,
    region: BTreeMap<Point, usize>,
}

impl Grid {
    fn of(diagram: &PhaseDiagram, kind: IntervalKind) -> Self {
        let axes: Vec<(Axis, Vec<f64>)> =
            diagram.axes.iter().map(|axis| (*axis, diagram.values(*axis))).collect();
        let mills = |index: &usize| {
            let share = Share::milling(&diagram.cells[*index].counts);
            kind.interval(share.hits, share.n).low >= REGION_B_S_LOW
        };
        let point = |cell: &Cell| -> Point {
            let position = |(axis, values): &(Axis, Vec<f64>)| {
                let value = cell.get(*axis).expect("a cell has a value on every swept axis");
                values.partition_point(|other| *other < value)
            };
            axes.iter().map(position).collect()
        };
        let region = (0..diagram.cells.len())
            .filter(mills)
            .map(|index| (point(&diagram.cells[index].cell), index))
            .collect();
        Self { axes, region }
    }

    fn centroid(&self) -> Vec<f64> {
        let mean = |axis: usize| {
            let sum: usize = self.region.keys().map(|point| point[axis]).sum();
            sum as f64 / self.region.len().max(1) as f64
        };
        (0..self.axes.len()).map(mean).collect()
    }

    /// The cell at a point moved along one axis, if it belongs to the region.
    fn contains(&self, point: &Point, axis: usize, position: Option<usize>) -> bool {
        position.is_some_and(|position| {
            let mut moved = point.clone();
            moved[axis] = position;
            self.region.contains_key(&moved)
        })
    }

    /// How many steps a point can go along an axis, down and up, and stay in the region.
    fn reach(&self, point: &Point, axis: usize) -> (usize, usize) {
        let here = point[axis];
        let down = (1..).take_while(|step| self.contains(point, axis, here.checked_sub(*step)));
        let up = (1..).take_while(|step| self.contains(point, axis, Some(here + step)));
        (down.count(), up.count())
    }

    fn depth(&self, point: &Point) -> f64 {
        let swept: Vec<usize> =
            (0..self.axes.len()).filter(|axis| self.axes[*axis].1.len() > 1).collect();
        // Nothing outside is further than the nearest point outside along an axis.
        let nearest = swept.iter().map(|axis| {
            let (down, up) = self.reach(point, *axis);
            down.min(up) + 1
        });
        let Some(bound) = nearest.min() else {
            return 1.0;
        };
        let mut least_squared = bound * bound;
        self.search(&swept, (&mut point.clone(), 0), &mut least_squared);
        (least_squared as f64).sqrt()
    }

    /// Looks for a point outside that is nearer than what was found, one axis after the other.
    fn search(
        &self,
        axes: &[usize],
        (moved, squared): (&mut Point, usize),
        least_squared: &mut usize,
    ) {
        if squared >= *least_squared {
            return;
        }
        let Some((axis, others)) = axes.split_first() else {
            if !self.region.contains_key(moved) {
                *least_squared = squared;
            }
            return;
        };
        let here = moved[*axis];
        let most = least_squared.isqrt();
        for position in here.saturating_sub(most)..=here + most {
            let step = position.abs_diff(here);
            moved[*axis] = position;
            self.search(others, (moved, squared + step * step), least_squared);
        }
        moved[*axis] = here;
    }

    fn margin(&self, point: &Point) -> BTreeMap<Axis, Margin> {
        let margin = |(position, (axis, values)): (usize, &(Axis, Vec<f64>))| {
            let here = point[position];
            let (down, up) = self.reach(point, position);
            let (low, high) =
                (values[here] - values[here - down], values[here + up] - values[here]);
            (*axis, Margin { low: tidy(low), high: tidy(high) })
        };
        self.axes.iter().enumerate().map(margin).collect()
    }
}

fn distance(point: &Point, centroid: &[f64]) -> f64 {
    let squares = point.iter().zip(centroid).map(|(at, centre)| (*at as f64 - centre).powi(2));
    squares.sum::<f64>().sqrt()
}
