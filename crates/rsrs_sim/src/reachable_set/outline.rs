//! The outline of a region of any shape, by marching squares.
//!
//! Whether a point lies in the region is asked at the nodes of a grid; where an edge of the grid
//! joins a node inside to one outside, the border is found on it by bisection. So every vertex lies
//! on the border of the region that is tested, and between vertices the outline is straight.
//!
//! # Source
//!
//! W. E. Lorensen, H. E. Cline, "Marching cubes", SIGGRAPH 1987, in the plane. Where two corners that
//! face each other are inside and the others are not, the middle of the square decides.

use std::collections::BTreeMap;

use rsrs_core::plane::{Point, area};

/// A grid of square cells over a region.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Its lower corner, in metres: ahead, left.
    pub low_m: Point,
    /// Side of a cell, in metres; above 0.
    pub cell_m: f64,
    /// Cells ahead and cells to the left; 1 or more of each.
    pub n_cells: [usize; 2],
}

/// Halvings of a cell's side until a crossing is found: to a four thousandth of it.
const HALVINGS: usize = 12;

/// The outline of what a predicate holds for: closed loops with the region to the left of each,
/// outer ones counterclockwise, holes clockwise. What is smaller than a cell may be missing.
///
/// The nodes at the grid's border count as outside, so that every loop closes within the grid.
pub fn outline(grid: Grid, contains: impl Fn(Point) -> bool) -> Vec<Vec<Point>> {
    let [n_ahead, n_left] = grid.n_cells;
    let inside: Vec<bool> = (0..(n_ahead + 1) * (n_left + 1))
        .map(|node| !grid.is_border(node) && contains(grid.place(node)))
        .collect();
    let mut next = BTreeMap::new();
    for cell in 0..n_ahead * n_left {
        let first = cell / n_ahead * (n_ahead + 1) + cell % n_ahead;
        let square = Square::new(first, n_ahead + 1);
        next.extend(square.segments(&inside, || contains(grid.middle(first))));
    }
    loops(next)
        .into_iter()
        .map(|crossings| {
            crossings.into_iter().map(|edge| grid.crossing(edge, &inside, &contains)).collect()
        })
        .collect()
}

/// The area within loops, in square metres; holes are taken off.
pub fn area_m2(loops: &[Vec<Point>]) -> f64 {
    loops.iter().map(|corners| area(corners)).sum()
}

/// An edge of the grid: its first node, and whether it goes ahead or to the left.
type Edge = (usize, Direction);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Direction {
    Ahead,
    Left,
}

impl Grid {
    fn place(&self, node: usize) -> Point {
        let per_row = self.n_cells[0] + 1;
        let at = |axis: usize, index: usize| self.low_m[axis] + index as f64 * self.cell_m;
        [at(0, node % per_row), at(1, node / per_row)]
    }

    fn middle(&self, node: usize) -> Point {
        self.place(node).map(|coordinate_m| coordinate_m + self.cell_m / 2.0)
    }

    fn is_border(&self, node: usize) -> bool {
        let per_row = self.n_cells[0] + 1;
        let (ahead, left) = (node % per_row, node / per_row);
        ahead == 0 || left == 0 || ahead == self.n_cells[0] || left == self.n_cells[1]
    }

    /// Where the border crosses an edge, one end of which is inside.
    fn crossing(
        &self,
        (node, axis): Edge,
        inside: &[bool],
        contains: &impl Fn(Point) -> bool,
    ) -> Point {
        let other = node + if axis == Direction::Ahead { 1 } else { self.n_cells[0] + 1 };
        let (within, without) = if inside[node] { (node, other) } else { (other, node) };
        let (mut within_m, mut without_m) = (self.place(within), self.place(without));
        for _ in 0..HALVINGS {
            let middle_m = between(within_m, without_m);
            if contains(middle_m) {
                within_m = middle_m;
            } else {
                without_m = middle_m;
            }
        }
        between(within_m, without_m)
    }
}

fn between(one: Point, other: Point) -> Point {
    [0, 1].map(|axis| f64::midpoint(one[axis], other[axis]))
}

/// One cell: its corners and edges, counterclockwise; edge k goes from corner k to the next one.
struct Square {
    corners: [usize; 4],
    edges: [Edge; 4],
}

impl Square {
    fn new(first: usize, per_row: usize) -> Self {
        Self {
            corners: [first, first + 1, first + 1 + per_row, first + per_row],
            edges: [
                (first, Direction::Ahead),
                (first + 1, Direction::Left),
                (first + per_row, Direction::Ahead),
                (first, Direction::Left),
            ],
        }
    }

    /// The pieces of the outline in this cell, from edge to edge.
    fn segments(&self, inside: &[bool], middle: impl Fn() -> bool) -> Vec<(Edge, Edge)> {
        let is_in = self.corners.map(|corner| inside[corner]);
        let leaves = |edge: &usize| is_in[*edge] && !is_in[(*edge + 1) % 4];
        let enters = |edge: &usize| !is_in[*edge] && is_in[(*edge + 1) % 4];
        let leaving: Vec<usize> = (0..4).filter(leaves).collect();
        let entering: Vec<usize> = (0..4).filter(enters).collect();
        match (&leaving[..], &entering[..]) {
            ([from], [to]) => vec![(self.edges[*from], self.edges[*to])],
            ([], _) => Vec::new(),
            // Corners that face each other: a bridge between them cuts off the other two.
            _ => {
                let step = if middle() { 1 } else { 3 };
                let to = |from: usize| self.edges[(from + step) % 4];
                leaving.iter().map(|from| (self.edges[*from], to(*from))).collect()
            }
        }
    }
}

/// Closed walks along edges, each of which has one next.
fn loops(mut next: BTreeMap<Edge, Edge>) -> Vec<Vec<Edge>> {
    let mut loops = Vec::new();
    while let Some((start, mut edge)) = next.pop_first() {
        let mut walk = vec![start];
        while edge != start {
            walk.push(edge);
            edge = next.remove(&edge).expect("the outline goes on in the next cell");
        }
        loops.push(walk);
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n_cells: usize) -> Grid {
        Grid { low_m: [-1.0, -1.0], cell_m: 2.0 / n_cells as f64, n_cells: [n_cells, n_cells] }
    }

    fn is_within(radius_m: f64, [x, y]: Point) -> bool {
        libm::hypot(x, y) <= radius_m
    }

    #[test]
    fn a_disc_has_one_loop_whose_vertices_lie_on_its_border() {
        let loops = outline(grid(40), |point| is_within(0.7, point));

        assert_eq!(loops.len(), 1);
        for [x, y] in &loops[0] {
            assert!((libm::hypot(*x, *y) - 0.7).abs() < 0.05 / 2048.0, "{x} {y}");
        }
        let ratio = area_m2(&loops) / (std::f64::consts::PI * 0.49);
        assert!((0.995..1.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_hole_is_taken_off() {
        let loops = outline(grid(80), |point| is_within(0.7, point) && !is_within(0.3, point));

        assert_eq!(loops.len(), 2);
        let ratio = area_m2(&loops) / (std::f64::consts::PI * 0.4);
        assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
    }

    #[test]
    fn corners_that_face_each_other_are_joined_by_the_sign_of_the_middle() {
        // Two regions that nearly touch at the origin, in the middle of a cell.
        let quadrants = |[x, y]: Point| x * y > 1e-3 && x.abs() < 0.9 && y.abs() < 0.9;
        let apart = outline(grid(7), quadrants);
        let joined = outline(grid(7), |point| quadrants(point) || is_within(0.1, point));

        assert_eq!((apart.len(), joined.len()), (2, 1));
    }

    #[test]
    fn a_region_beyond_the_grid_is_cut_off_at_its_border() {
        let loops = outline(grid(10), |_| true);

        assert_eq!(loops.len(), 1);
        assert!(loops[0].iter().flatten().all(|coordinate_m| coordinate_m.abs() < 1.0 + 1e-12));
    }
}
