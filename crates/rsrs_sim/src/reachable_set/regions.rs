//! The simulated regions of one kind of drive.

use rsrs_core::robot::unicycle::Pose;

use super::region::PositionRegion;
use super::{Drives, ReachOptions};

/// The simulated regions of one body of one kind at each horizon.
pub struct Regions {
    /// Where.
    pub positions: Vec<PositionRegion>,
    /// Least and greatest heading change.
    pub headings_rad: Vec<[f64; 2]>,
}

impl Regions {
    /// Makes the regions of a body of a kind, the robot or its object: one half of the robots places them, the
    /// other calibrates their size.
    pub fn new(
        (kind, body): (usize, usize),
        reference: &[Drives],
        calibration: &[Drives],
        options: &ReachOptions,
    ) -> Self {
        let n_horizons = reference[0][kind][0][body].len();
        let at = |robots: &[Drives], horizon: usize| -> Vec<Pose> {
            robots.iter().map(|drives| drives[kind][0][body][horizon]).collect()
        };
        let position = |horizon| {
            let place = |pose: &Pose| [pose.x_m, pose.y_m];
            let reference = at(reference, horizon).iter().map(place).collect();
            let calibration: Vec<[f64; 2]> = at(calibration, horizon).iter().map(place).collect();
            PositionRegion::new(reference, &calibration, options.share, options.tolerance_m)
        };
        let heading = |horizon| {
            let mut headings_rad: Vec<f64> =
                at(reference, horizon).iter().map(|pose| pose.heading_rad).collect();
            headings_rad.extend(at(calibration, horizon).iter().map(|pose| pose.heading_rad));
            headings_rad.sort_by(f64::total_cmp);
            let n_out = ((1.0 - options.share) / 2.0 * headings_rad.len() as f64).floor() as usize;
            [
                headings_rad[n_out] - options.tolerance_rad,
                headings_rad[headings_rad.len() - 1 - n_out] + options.tolerance_rad,
            ]
        };
        Self {
            positions: (0..n_horizons).map(position).collect(),
            headings_rad: (0..n_horizons).map(heading).collect(),
        }
    }

    /// Whether a heading change is inside at a horizon.
    pub fn heading_is_inside(&self, horizon: usize, heading_rad: f64) -> bool {
        let [least_rad, most_rad] = self.headings_rad[horizon];
        (least_rad..=most_rad).contains(&heading_rad)
    }

    /// Whether a path stays inside at each of its horizons.
    pub fn contain(&self, path: &[Pose]) -> bool {
        path.iter().enumerate().all(|(horizon, pose)| {
            self.heading_is_inside(horizon, pose.heading_rad)
                && self.positions[horizon].contains([pose.x_m, pose.y_m])
        })
    }
}
