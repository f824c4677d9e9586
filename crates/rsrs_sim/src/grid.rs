//! Who could be near whom: a uniform grid over the swarm, for large swarms.
//!
//! Without it a robot is held against all others. With it, against those in the few cells that its
//! view and its body reach into, so that a step costs the same for each robot however many there
//! are. What is seen does not depend on it: the grid only leaves out robots for which the answer is
//! no, with a margin for rounding, and those that it leaves in are asked as before.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

use crate::contact::{Blocked, Contact};
use crate::field_of_view::{Extent, FieldOfView};
use crate::robots::Robots;
use crate::vector::simd::Work;
use crate::vector::with_vectors;

/// From this many robots on, the grid is worth its sorting: measured, at the density of nine
/// Flockbots.
pub const WORTH_FROM: usize = 56;

/// Steps after which robots are kept in the order of their cells again: in fewer, they hardly leave
/// their cells.
pub const REORDERED_EVERY: u64 = 64;

/// Neighbours that are looked at together. The last of them may lie beyond the cells that were asked
/// for, which changes nothing: they are robots, too, and who is too far away is not seen.
const BLOCK: usize = 8;

/// What rounding may do to a distance, relative to it.
const MARGIN: f32 = 1e-5;

/// What it may do to a coordinate, relative to the greatest one.
const COORDINATE_MARGIN: f32 = 1e-6;

/// The robots by cell, row by row.
pub struct Grid {
    extent: Extent,
    body_m: f32,
    /// Coordinates of the lower left corner, in metres.
    corner_m: (f32, f32),
    /// Cells per metre.
    per_m: f32,
    n_columns: usize,
    n_rows: usize,
    /// The cell of each robot; shape `[n_robots]`.
    cells: Vec<u32>,
    /// Where each cell ends in the order of cells; shape `[n_cells + 1]`, with a zero in front.
    ends: Vec<u32>,
    /// The robots in the order of cells, and where they are; shape `[n_robots]` each.
    order: Vec<u32>,
    x_m: Vec<f32>,
    y_m: Vec<f32>,
}

/// A box around what a robot may see or touch: where it begins and ends on both axes, in metres.
type Around = ((f32, f32), (f32, f32));

impl Grid {
    /// A grid for robots with a view; `None` if the view has no useful extent.
    pub fn new(view: &FieldOfView, contact: Contact) -> Option<Self> {
        Some(Self {
            extent: view.extent()?,
            body_m: contact.diameter_squared_m2.sqrt(),
            corner_m: (0.0, 0.0),
            per_m: 1.0,
            n_columns: 0,
            n_rows: 0,
            cells: Vec::new(),
            ends: Vec::new(),
            order: Vec::new(),
            x_m: Vec::new(),
            y_m: Vec::new(),
        })
    }

    /// The robots in the order of their cells; `None` if one is not at a finite place.
    pub fn order(&mut self, robots: &Robots) -> Option<&[u32]> {
        self.sort(robots).map(|_| self.order.as_slice())
    }

    /// Finds out for every robot whether its view contains another, and whether one is in its way:
    /// as [`Robots::sense_pairs`], to the bit.
    #[inline]
    pub fn sense(
        &mut self,
        robots: &Robots,
        contact: Contact,
        found: (&mut [bool], &mut [Blocked]),
        sees: impl Fn(f32, f32, f32) -> bool,
    ) {
        let Some(slack_m) = self.sort(robots) else {
            return robots.sense_pairs(contact, found, sees);
        };
        with_vectors(Look { grid: self, robots, contact, slack_m, found, sees });
    }

    /// Sorts the robots into cells. Returns what rounding may do to a coordinate, in metres; `None`
    /// if a coordinate is not finite.
    fn sort(&mut self, robots: &Robots) -> Option<f32> {
        let x = range(&robots.x_m)?;
        let y = range(&robots.y_m)?;
        let n_robots = robots.x_m.len();
        let widest_m = (x.1 - x.0).max(y.1 - y.0);
        // Cells as wide as the reach, but no more of them than a few for each robot.
        let most_per_side = (4.0 * n_robots as f32).sqrt().ceil();
        let cell_m = self
            .extent
            .reach_m
            .max(self.body_m)
            .max(widest_m / most_per_side)
            .max(f32::MIN_POSITIVE);
        self.corner_m = (x.0, y.0);
        self.per_m = 1.0 / cell_m;
        self.n_columns = self.cell_of(x.1 - x.0) + 1;
        self.n_rows = self.cell_of(y.1 - y.0) + 1;
        self.cells.clear();
        for (x_m, y_m) in robots.x_m.iter().zip(&robots.y_m) {
            let cell = self.row(*y_m) * self.n_columns + self.column(*x_m);
            self.cells.push(cell as u32);
        }
        self.fill(robots);
        let greatest_m =
            [x.0, x.1, y.0, y.1].into_iter().fold(0.0, |most: f32, c| most.max(c.abs()));
        Some(greatest_m * COORDINATE_MARGIN)
    }

    /// A counting sort: how many in each cell, where each cell begins, and each robot to its place.
    fn fill(&mut self, robots: &Robots) {
        let n_robots = self.cells.len();
        self.ends.clear();
        self.ends.resize(self.n_columns * self.n_rows + 2, 0);
        for cell in &self.cells {
            self.ends[*cell as usize + 2] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        self.order.resize(n_robots, 0);
        // Behind the last robot is padding: what is not a number is neither seen nor touched.
        self.x_m.resize(n_robots + BLOCK, f32::NAN);
        self.y_m.resize(n_robots + BLOCK, f32::NAN);
        for (robot, cell) in self.cells.iter().enumerate() {
            // Until the robot is placed, this is where its cell begins; in the end, where it ends.
            let end = &mut self.ends[*cell as usize + 1];
            let place = *end as usize;
            *end += 1;
            self.order[place] = robot as u32;
            self.x_m[place] = robots.x_m[robot];
            self.y_m[place] = robots.y_m[robot];
        }
    }

    /// A box that holds all centres that a robot may see or touch.
    #[inline]
    fn reach(&self, at: (f32, f32), heading: (f32, f32), slack_m: f32) -> Around {
        let body_m = self.body_m;
        let along = |toward: f32, aside: f32, coordinate_m: f32| {
            let Extent { reach_m, edge } = self.extent;
            let (least_m, most_m) = match edge {
                Some((near_m, far_m)) => {
                    let (near_m, far_m) = (near_m * aside.abs(), far_m.max(0.0) * aside.abs());
                    let ahead_m = reach_m * toward;
                    ((ahead_m - far_m).min(-near_m), (ahead_m + far_m).max(near_m))
                }
                None => (-reach_m, reach_m),
            };
            // The body's diameter, which covers what is seen behind the robot, too.
            let least_m = least_m.max(-reach_m).min(-body_m);
            let most_m = most_m.min(reach_m).max(body_m);
            let margin_m = slack_m + MARGIN * (reach_m + body_m);
            (coordinate_m + (least_m - margin_m), coordinate_m + (most_m + margin_m))
        };
        (along(heading.0, heading.1, at.0), along(heading.1, heading.0, at.1))
    }

    #[inline]
    fn column(&self, x_m: f32) -> usize {
        self.cell_of(x_m - self.corner_m.0).min(self.n_columns - 1)
    }

    #[inline]
    fn row(&self, y_m: f32) -> usize {
        self.cell_of(y_m - self.corner_m.1).min(self.n_rows - 1)
    }

    /// Never less for a greater distance, so what lies between two places lies between their cells.
    /// The cast takes what is negative to zero.
    #[inline]
    fn cell_of(&self, distance_m: f32) -> usize {
        (distance_m * self.per_m) as usize
    }
}

/// Holds every robot against those in the cells that it reaches into, as work for a vector unit.
struct Look<'a, F> {
    grid: &'a Grid,
    robots: &'a Robots,
    contact: Contact,
    slack_m: f32,
    found: (&'a mut [bool], &'a mut [Blocked]),
    sees: F,
}

impl<F: Fn(f32, f32, f32) -> bool> Work for Look<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { grid, robots, contact, slack_m, found: (seen, blocked), sees } = self;
        for (place, robot) in grid.order.iter().enumerate() {
            let robot = *robot as usize;
            let at = (grid.x_m[place], grid.y_m[place]);
            let heading = (robots.cosine[robot], robots.sine[robot]);
            let ((from_x, to_x), (from_y, to_y)) = grid.reach(at, heading, slack_m);
            let (first, last) = (grid.column(from_x), grid.column(to_x));
            let [mut n_seen, mut n_ahead, mut n_behind] = [[0_u32; BLOCK]; 3];
            for row in grid.row(from_y)..=grid.row(to_y) {
                let cells = row * grid.n_columns + first..=row * grid.n_columns + last;
                let near = grid.ends[*cells.start()] as usize..grid.ends[*cells.end() + 1] as usize;
                for block in near.step_by(BLOCK) {
                    let xs = &grid.x_m[block..block + BLOCK];
                    let ys = &grid.y_m[block..block + BLOCK];
                    for lane in 0..BLOCK {
                        let (dx_m, dy_m) = (xs[lane] - at.0, ys[lane] - at.1);
                        let d2_m2 = dx_m * dx_m + dy_m * dy_m;
                        let forward_m = dx_m * heading.0 + dy_m * heading.1;
                        let lateral_m = dy_m * heading.0 - dx_m * heading.1;
                        n_seen[lane] |= u32::from(sees(forward_m, lateral_m, d2_m2));
                        n_ahead[lane] |= u32::from(contact.blocks_ahead(forward_m, d2_m2));
                        n_behind[lane] |= u32::from(contact.blocks_behind(forward_m, d2_m2));
                    }
                }
            }
            let is_any =
                |lanes: [u32; BLOCK]| lanes.into_iter().fold(0, |any, lane| any | lane) != 0;
            seen[robot] = is_any(n_seen);
            blocked[robot] = Blocked { ahead: is_any(n_ahead), behind: is_any(n_behind) };
        }
    }
}

/// The least and the greatest number; `None` if one is not finite.
fn range(numbers: &[f32]) -> Option<(f32, f32)> {
    let start = (f32::INFINITY, f32::NEG_INFINITY);
    let range = numbers.iter().fold(start, |(least, most), x| (least.min(*x), most.max(*x)));
    let sum: f32 = numbers.iter().map(|number| number * 0.0).sum();
    (sum == 0.0 && range.0 <= range.1).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Purpose, RunKey, Seed, Stream};
    use rsrs_core::conditions::SimulatedRobot;
    use rsrs_core::robot::profile::Sees;
    use rsrs_core::robot::region::Region;
    use rsrs_testing::conditions::flockbot_conditions;

    fn regions() -> Vec<Region> {
        let cone = |half_angle_rad, range_m| Region::Cone { half_angle_rad, range_m };
        let square = vec![[-0.3, -0.2], [0.4, -0.2], [0.4, 0.5], [-0.3, 0.5]];
        let beam = vec![[0.0, -0.02], [0.9, -0.2], [0.9, 0.2], [0.0, 0.02]];
        vec![
            cone(0.2, 0.75),
            cone(0.02, 2.0),
            cone(1.5, 0.5),
            cone(0.8, 0.05),
            Region::Polygon { corners_m: square },
            Region::Polygon { corners_m: beam },
        ]
    }

    /// Neighbours around robots of all headings, whom the view or the body meets outside the box.
    fn missed(robot: &SimulatedRobot, shrink_by: f32) -> usize {
        let (view, contact) = (FieldOfView::new(robot), Contact::new(robot));
        let mut grid = Grid::new(&view, contact).expect("no sharp corners");
        grid.extent.reach_m *= 1.0 - shrink_by;
        let mut stream =
            Stream::new(RunKey::new(Seed { seed: 1, replicate: 0 }, 0), 0, Purpose::Placement);
        let mut uniform = |most: f64| (most * (2.0 * stream.uniform() - 1.0)) as f32;
        let mut n_missed = 0;
        for _ in 0..100_000 {
            let (at, heading) = ((uniform(20.0), uniform(20.0)), crate::turn::turn(uniform(3.2)));
            let width_m = 1.2 * f64::from(grid.extent.reach_m.max(grid.body_m));
            let other = (at.0 + uniform(width_m), at.1 + uniform(width_m));
            let (dx_m, dy_m) = (other.0 - at.0, other.1 - at.1);
            let d2_m2 = dx_m * dx_m + dy_m * dy_m;
            let forward_m = dx_m * heading.0 + dy_m * heading.1;
            let lateral_m = dy_m * heading.0 - dx_m * heading.1;
            let is_met = contact.blocks_ahead(forward_m, d2_m2)
                || contact.blocks_behind(forward_m, d2_m2)
                || view.sees(forward_m, lateral_m, d2_m2);
            let ((from_x, to_x), (from_y, to_y)) =
                grid.reach(at, heading, 20.0 * COORDINATE_MARGIN);
            let is_in_box =
                (from_x..=to_x).contains(&other.0) && (from_y..=to_y).contains(&other.1);
            n_missed += usize::from(is_met && !is_in_box);
        }
        n_missed
    }

    #[test]
    fn whoever_is_seen_or_touched_is_in_the_box() {
        for region in regions() {
            for sees in [Sees::Body, Sees::Centre] {
                for front_half_angle_rad in [0.5, 3.1] {
                    let region = region.clone();
                    let robot = SimulatedRobot {
                        region,
                        sees,
                        front_half_angle_rad,
                        ..flockbot_conditions().robot
                    };
                    assert_eq!(missed(&robot, 0.0), 0, "{robot:?}");
                }
            }
        }
    }

    #[test]
    fn a_box_that_is_too_small_is_noticed() {
        assert!(missed(&flockbot_conditions().robot, 0.05) > 0);
    }
}
