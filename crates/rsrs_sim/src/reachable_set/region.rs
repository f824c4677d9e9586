//! Where a share of simulated robots is at one time: a region of any shape.

use rsrs_core::plane::Point;
use rsrs_core::trials::validation::RegionOutline;

use super::outline::{Grid, area_m2, outline};

/// A region of positions around a cloud of simulated ones.
pub struct PositionRegion {
    /// Simulated positions, by their first coordinate.
    cloud: Vec<Point>,
    /// Mean of the cloud.
    pub mean_m: Point,
    /// Greatest score inside, tolerance included.
    limit_m: f64,
}

/// Which nearest neighbour's distance is the score: few follow the cloud's shape, many its mass.
const NEIGHBOURS: usize = 5;

/// Cells of an outline's grid along the region's longer side, and how many at most if it is thin.
const CELLS: f64 = 96.0;
const MOST_CELLS: f64 = 384.0;

impl PositionRegion {
    /// A region that holds a share of simulated positions: those of the cloud place it, others
    /// calibrate its size. Measured positions may be off by `tolerance_m`.
    pub fn new(mut cloud: Vec<Point>, calibration: &[Point], share: f64, tolerance_m: f64) -> Self {
        cloud.sort_by(|left, right| left[0].total_cmp(&right[0]));
        let n = cloud.len() as f64;
        let mean_m = [0, 1].map(|axis| cloud.iter().map(|point| point[axis]).sum::<f64>() / n);
        let mut region = Self { cloud, mean_m, limit_m: f64::INFINITY };
        let mut scores: Vec<f64> = calibration.iter().map(|point| region.score_m(*point)).collect();
        scores.sort_by(f64::total_cmp);
        // Exchangeability puts a new draw below this one with at least the share's probability.
        let rank = (share * (scores.len() + 1) as f64).ceil() as usize;
        region.limit_m = scores[rank.clamp(1, scores.len()) - 1] + tolerance_m;
        region
    }

    /// Whether a position is in the region.
    pub fn contains(&self, point: Point) -> bool {
        self.score_m(point) <= self.limit_m
    }

    /// Distance to the k-th nearest simulated position, in metres; beyond the limit, any number
    /// beyond it.
    fn score_m(&self, point: Point) -> f64 {
        let mut nearest = [f64::INFINITY; NEIGHBOURS];
        let middle = self.cloud.partition_point(|other| other[0] < point[0]);
        let (before, after) = self.cloud.split_at(middle);
        // Outwards from the point, until its first coordinate alone is too far away.
        for side in
            [&mut before.iter().rev() as &mut dyn Iterator<Item = &Point>, &mut after.iter()]
        {
            for other in side {
                let dx_m = other[0] - point[0];
                let worst = nearest[NEIGHBOURS - 1];
                if dx_m * dx_m >= worst || dx_m.abs() > self.limit_m {
                    break;
                }
                let dy_m = other[1] - point[1];
                let squared = dx_m * dx_m + dy_m * dy_m;
                if squared < worst {
                    insert(&mut nearest, squared);
                }
            }
        }
        nearest[NEIGHBOURS - 1].sqrt()
    }

    /// The region's outline, and its area, in square metres.
    pub fn outline(&self) -> (RegionOutline, f64) {
        let edge = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
            self.cloud.iter().map(|point| point[axis]).fold(start, pick)
        };
        let low_m = [0, 1].map(|axis| edge(axis, f64::INFINITY, f64::min) - self.limit_m);
        let high_m = [0, 1].map(|axis| edge(axis, f64::NEG_INFINITY, f64::max) + self.limit_m);
        let size_m = [high_m[0] - low_m[0], high_m[1] - low_m[1]];
        let longest_m = size_m[0].max(size_m[1]);
        // A region along a line is about as wide as twice the limit: no cell may step over it.
        let cell_m = (longest_m / CELLS).min(self.limit_m).max(longest_m / MOST_CELLS).max(1e-6);
        let n_cells = size_m.map(|size_m| (size_m / cell_m).ceil() as usize + 2);
        let low_m = low_m.map(|low_m| low_m - cell_m);
        let loops_m = outline(Grid { low_m, cell_m, n_cells }, |point| self.contains(point));
        let area_m2 = area_m2(&loops_m);
        (RegionOutline { loops_m }, area_m2)
    }
}

/// Keeps the smallest numbers, ascending.
fn insert(smallest: &mut [f64; NEIGHBOURS], number: f64) {
    let mut place = NEIGHBOURS - 1;
    while place > 0 && smallest[place - 1] > number {
        smallest[place] = smallest[place - 1];
        place -= 1;
    }
    smallest[place] = number;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::{Purpose, RunKey, Seed, normal};

    fn normals(n: usize, sd_m: [f64; 2]) -> Vec<Point> {
        let key = |purpose| RunKey::new(Seed { seed: 1, replicate: 0 }, 0).key(0, purpose);
        (0..n as u32)
            .map(|counter| {
                let [x, y] = [Purpose::GustX, Purpose::GustY]
                    .map(|purpose| f64::from(normal(key(purpose), counter)));
                [x * sd_m[0], y * sd_m[1]]
            })
            .collect()
    }

    #[test]
    fn a_region_of_normal_positions_has_about_the_area_of_their_ellipse() {
        let cloud = normals(4000, [0.2, 0.1]);
        let (reference, calibration) = cloud.split_at(2000);

        let region = PositionRegion::new(reference.to_vec(), calibration, 0.99, 0.0);

        // The 99 % ellipse has the area -2 ln(0.01) π times both standard deviations.
        let ellipse_m2 = 9.2103 * std::f64::consts::PI * 0.2 * 0.1;
        let ratio = region.outline().1 / ellipse_m2;
        assert!((0.8..=1.4).contains(&ratio), "{ratio}");
        let fresh = normals(20_000, [0.2, 0.1]);
        let n_inside = fresh[4000..].iter().filter(|point| region.contains(**point)).count();
        let share = n_inside as f64 / 16_000.0;
        // Calibrated on 2000 draws, the share itself has a standard error of 0.22 %.
        assert!((share - 0.99).abs() < 0.009, "{share}");
    }

    #[test]
    fn a_region_of_positions_on_a_line_is_as_thin_as_the_tolerance() {
        let cloud = normals(2000, [0.2, 0.0]);
        let (reference, calibration) = cloud.split_at(1000);

        let region = PositionRegion::new(reference.to_vec(), calibration, 0.99, 0.005);

        assert!(region.contains([0.1, 0.004]) && !region.contains([0.1, 0.2]));
        assert!(region.contains([0.4, 0.0]) && !region.contains([0.8, 0.0]));
        // About 1 m long, and as wide as twice the limit.
        let (drawn, area_m2) = region.outline();
        assert!((1.5..2.5).contains(&(area_m2 / region.limit_m)), "{area_m2}");
        let highest = drawn.loops_m.iter().flatten().map(|[_, left_m]| left_m.abs());
        assert!(highest.fold(0.0, f64::max) <= region.limit_m, "{}", region.limit_m);
    }
}
