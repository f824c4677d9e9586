//! Which cells to confirm, and in which order.

use std::collections::{BTreeMap, BTreeSet};

use super::{Edge, Margin};
use crate::diagram::{PhaseDiagram, Point, moved};
use crate::quantity::{Axis, Cell};
use crate::robot::harsher::tidy;
use crate::statistics::interval_kind::IntervalKind;
use crate::statistics::share::Share;

/// The two worlds of a sweep: the same cells, with other robots.
#[derive(Clone, Copy, Debug)]
pub struct Worlds<'a> {
    /// Robots as the sweep makes them worse.
    pub simulated: &'a PhaseDiagram,
    /// Robots as measured; `None` if the simulated ones are just that.
    pub as_measured: Option<&'a PhaseDiagram>,
}

impl Worlds<'_> {
    fn n_cells(self) -> usize {
        self.simulated.cells.len()
    }

    /// Milling replicates of a cell, in each world.
    fn shares(self, index: usize) -> impl Iterator<Item = Share> {
        let of = move |diagram: &PhaseDiagram| Share::milling(&diagram.cells[index].counts);
        [Some(self.simulated), self.as_measured].into_iter().flatten().map(of)
    }

    /// The share of mills in the world in which they are rarer.
    fn least(self, index: usize) -> f64 {
        self.shares(index).map(Share::value).fold(1.0, f64::min)
    }

    /// Whether what was counted leaves it open that the share is so much in both worlds.
    fn may_be(self, index: usize, viable: f64, kind: IntervalKind) -> bool {
        self.shares(index).all(|share| kind.interval(share.hits, share.n).high >= viable)
    }
}

/// A cell that may be worth running.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Index in [`PhaseDiagram::cells`].
    pub index: usize,
    /// Whether the next cells in every direction may be viable in both worlds, as far as they were swept.
    pub is_robust: bool,
    /// The cell.
    pub cell: Cell,
    /// Milling replicates of the sweep, in the world of robots made worse. They chose the cell, so
    /// they flatter it; only a confirmation estimates its share without bias.
    pub swept: Share,
    /// Mean over the cell and its neighbours of the share of mills in the world in which they are
    /// rarer.
    pub smooth: f64,
    /// Distance to the nearest cell outside the milling region or beyond the grid's border, in grid
    /// steps; 0 outside.
    pub depth: f64,
    /// How far each swept axis may drift.
    pub margin: BTreeMap<Axis, Margin>,
    /// Axes on which the margin ends where the sweep does.
    pub edge: BTreeMap<Axis, Edge>,
}

/// Ranks the cells that are to be confirmed, the most robust first: every cell whose counts leave it
/// open that it is viable in both worlds, which have the same cells.
///
/// The share that counts is the smaller of both worlds', as robots that are made worse may mill more
/// often. It is smoothed: a cell stands for its neighbours as well, on every swept axis, so that chance
/// makes no holes, however few replicates there are. Where it is at least `viable`, from 0 to 1, there
/// is the milling region. Counts of a sweep that decided by itself when to stop need the `kind` of
/// interval that is valid at any time.
///
/// Cells whose neighbours on every swept axis may be viable, too, come first. Of them, a cell is better
/// the deeper it lies inside the region: a grid step on any swept axis counts the
/// same, distances are Euclidean, and the border of the grid is an edge, because nothing is known
/// beyond it. An axis with a single value is not swept. A point of the grid that was not simulated
/// is outside. Equally deep cells are ranked by their smoothed share, then by nearness to the
/// centroid of the region, then by their order in the sweep. Cells outside the region come last: a
/// viable one may lie alone.
///
/// # Panics
///
/// If the worlds have different cells.
pub fn rank(worlds: Worlds<'_>, kind: IntervalKind, viable: f64) -> Vec<Candidate> {
    let grid = Grid::new(worlds, kind, viable);
    let mut ranked: Vec<Candidate> = (0..worlds.n_cells())
        .filter(|index| grid.may_be[*index])
        .map(|index| grid.candidate(index))
        .collect();
    let centroid = grid.centroid();
    let off = |candidate: &Candidate| distance(&grid.points[candidate.index], &centroid);
    ranked.sort_by(|left, right| {
        (right.is_robust.cmp(&left.is_robust))
            .then(right.depth.total_cmp(&left.depth))
            .then(right.smooth.total_cmp(&left.smooth))
            .then(off(left).total_cmp(&off(right)))
            .then(left.index.cmp(&right.index))
    });
    ranked
}

/// The cell that milled most often, in the world in which mills are rarer; of equals the one that milled
/// most often as measured, of these the first.
///
/// # Panics
///
/// If there is no cell, and as [`rank`].
pub fn most_frequent(worlds: Worlds<'_>, kind: IntervalKind, viable: f64) -> Candidate {
    let measured = |index: usize| worlds.shares(index).last().map_or(0.0, Share::value);
    let most = (0..worlds.n_cells()).rev().max_by(|&one, &other| {
        let least = worlds.least(one).total_cmp(&worlds.least(other));
        least.then(measured(one).total_cmp(&measured(other)))
    });
    Grid::new(worlds, kind, viable).candidate(most.expect("a sweep has cells"))
}

/// The milling region on the grid of the swept values.
struct Grid<'a> {
    worlds: Worlds<'a>,
    axes: Vec<(Axis, Vec<f64>)>,
    /// Where every cell is, in the order of the sweep.
    points: Vec<Point>,
    /// Whether every cell may be viable by its own counts.
    may_be: Vec<bool>,
    /// Smoothed share of every cell.
    smooth: Vec<f64>,
    region: BTreeSet<Point>,
}

impl<'a> Grid<'a> {
    fn new(worlds: Worlds<'a>, kind: IntervalKind, viable: f64) -> Self {
        let diagram = worlds.simulated;
        if let Some(measured) = worlds.as_measured {
            assert_eq!(diagram.cells.len(), measured.cells.len(), "two worlds of the same cells");
        }
        let axes: Vec<(Axis, Vec<f64>)> =
            diagram.axes.iter().map(|axis| (*axis, diagram.values(*axis))).collect();
        let points = diagram.points();
        let least: BTreeMap<&Point, f64> =
            points.iter().enumerate().map(|(index, point)| (point, worlds.least(index))).collect();
        let smooth: Vec<f64> = points.iter().map(|point| smoothed(&least, point)).collect();
        let mills = |index: &usize| smooth[*index] >= viable;
        let region = (0..points.len()).filter(mills).map(|index| points[index].clone()).collect();
        let may_be = (0..points.len()).map(|index| worlds.may_be(index, viable, kind)).collect();
        Self { worlds, axes, points, may_be, smooth, region }
    }

    fn candidate(&self, index: usize) -> Candidate {
        let point = &self.points[index];
        let entry = &self.worlds.simulated.cells[index];
        Candidate {
            index,
            is_robust: self.is_robust(point),
            cell: entry.cell.clone(),
            swept: Share::milling(&entry.counts),
            smooth: self.smooth[index],
            depth: self.depth(point),
            margin: self.margin(point),
            edge: self.edge(point),
        }
    }

    /// Whether no neighbour on a swept axis surely fails.
    fn is_robust(&self, point: &Point) -> bool {
        let fails = |neighbour: Point| {
            let found = self.points.iter().position(|other| *other == neighbour);
            found.is_some_and(|index| !self.may_be[index])
        };
        (0..self.axes.len()).all(|axis| {
            let here = point[axis];
            let below = here.checked_sub(1);
            !below.into_iter().chain([here + 1]).any(|position| fails(moved(point, axis, position)))
        })
    }

    fn centroid(&self) -> Vec<f64> {
        let mean = |axis: usize| {
            let sum: usize = self.region.iter().map(|point| point[axis]).sum();
            sum as f64 / self.region.len().max(1) as f64
        };
        (0..self.axes.len()).map(mean).collect()
    }

    /// The cell at a point moved along one axis, if it belongs to the region.
    fn contains(&self, point: &Point, axis: usize, position: Option<usize>) -> bool {
        position.is_some_and(|position| self.region.contains(&moved(point, axis, position)))
    }

    /// How many steps a point can go along an axis, down and up, and stay in the region.
    fn reach(&self, point: &Point, axis: usize) -> (usize, usize) {
        let here = point[axis];
        let down = (1..).take_while(|step| self.contains(point, axis, here.checked_sub(*step)));
        let up = (1..).take_while(|step| self.contains(point, axis, Some(here + step)));
        (down.count(), up.count())
    }

    fn depth(&self, point: &Point) -> f64 {
        if !self.region.contains(point) {
            return 0.0;
        }
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
        self.search(&swept, &mut point.clone(), 0, &mut least_squared);
        (least_squared as f64).sqrt()
    }

    /// Looks for a point outside that is nearer than what was found, one axis after the other.
    fn search(&self, axes: &[usize], moved: &mut Point, squared: usize, least_squared: &mut usize) {
        if squared >= *least_squared {
            return;
        }
        let Some((axis, others)) = axes.split_first() else {
            if !self.region.contains(moved) {
                *least_squared = squared;
            }
            return;
        };
        let here = moved[*axis];
        let most = least_squared.isqrt();
        for position in here.saturating_sub(most)..=here + most {
            let step = position.abs_diff(here);
            moved[*axis] = position;
            self.search(others, moved, squared + step * step, least_squared);
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

impl Grid<'_> {
    /// Where the margins of a point end at something that was not simulated.
    fn edge(&self, point: &Point) -> BTreeMap<Axis, Edge> {
        let is_swept = |axis: usize, position: Option<usize>| {
            position.is_some_and(|position| self.points.contains(&moved(point, axis, position)))
        };
        let edge = |(index, (axis, _)): (usize, &(Axis, Vec<f64>))| {
            let (here, (down, up)) = (point[index], self.reach(point, index));
            let edge = Edge {
                low: !is_swept(index, here.checked_sub(down + 1)),
                high: !is_swept(index, Some(here + up + 1)),
            };
            edge.is_any().then_some((*axis, edge))
        };
        self.axes.iter().enumerate().filter_map(edge).collect()
    }
}

/// The mean over a point and its neighbours, diagonal ones too, as far as they were simulated.
fn smoothed(least: &BTreeMap<&Point, f64>, point: &Point) -> f64 {
    let mut around: Vec<Point> = vec![Point::new()];
    for position in point {
        let to = |before: &Point| {
            let with = |next: usize| before.iter().copied().chain([next]).collect::<Point>();
            (position.saturating_sub(1)..=position + 1).map(with).collect::<Vec<Point>>()
        };
        around = around.iter().flat_map(to).collect();
    }
    let shares: Vec<f64> = around.iter().filter_map(|point| least.get(point).copied()).collect();
    shares.iter().sum::<f64>() / shares.len() as f64
}

fn distance(point: &Point, centroid: &[f64]) -> f64 {
    let squares = point.iter().zip(centroid).map(|(at, centre)| (*at as f64 - centre).powi(2));
    squares.sum::<f64>().sqrt()
}
