//! Where a sensor's region reaches a wall: a straight line, far enough to both sides.
//!
//! In the sensor's frame the wall has an outward normal `n`, a unit vector, and is `g` away from the sensor.
//!
//! **Cone**, of half-angle `a` and range `R`: the direction of the cone that is nearest to the normal leads to the nearest
//! point. If the normal lies in the cone, that is the foot of the perpendicular, `g` away; else it lies on the edge on the
//! normal's side, `g / (n_x cos a + |n_y| sin a)` away. It is reached if that is at most `R`.
//!
//! **Polygon**: the part of the wall between the sides that it crosses; of that the point nearest to the sensor. Of a polygon
//! that is all beyond the wall none is.

use rsrs_core::robot::region::Region;

/// A region, ready for walls.
pub enum WallView {
    /// A cone.
    Cone {
        /// Cosine of its half-angle.
        cosine: f32,
        /// Sine of its half-angle.
        sine: f32,
        /// Tangent of its half-angle.
        slope: f32,
        /// In metres.
        range_m: f32,
    },
    /// The corners of a polygon, in metres.
    Polygon(Vec<[f32; 2]>),
}

impl WallView {
    /// The region of a sensor.
    pub fn new(region: &Region) -> Self {
        match region {
            Region::Cone { half_angle_rad, range_m } => {
                let (sine, cosine) = libm::sincos(*half_angle_rad);
                Self::Cone {
                    cosine: cosine as f32,
                    sine: sine as f32,
                    slope: (sine / cosine) as f32,
                    range_m: *range_m as f32,
                }
            }
            Region::Polygon { corners_m } => {
                Self::Polygon(corners_m.iter().map(|corner| corner.map(|at| at as f32)).collect())
            }
        }
    }

    /// The nearest point of a wall in the region, and how far away it is, in metres.
    pub fn nearest(&self, normal: (f32, f32), gap_m: f32) -> Option<((f32, f32), f32)> {
        match self {
            Self::Cone { cosine, sine, slope, range_m } => {
                let (ahead, aside) = (normal.0, normal.1.abs());
                let is_within = ahead > 0.0 && aside <= ahead * slope;
                let (along, direction) = if is_within {
                    (1.0, normal)
                } else {
                    let side = if normal.1 < 0.0 { -*sine } else { *sine };
                    (ahead * cosine + aside * sine, (*cosine, side))
                };
                if along <= 0.0 {
                    return None;
                }
                let away_m = gap_m / along;
                let point_m = (direction.0 * away_m, direction.1 * away_m);
                (away_m <= *range_m).then_some((point_m, away_m))
            }
            Self::Polygon(corners) => {
                // Along the wall, to the left of its normal, from the foot of the perpendicular.
                let [mut least_m, mut most_m] = [f32::INFINITY, f32::NEG_INFINITY];
                let beyond_m = |[x, y]: [f32; 2]| x * normal.0 + y * normal.1 - gap_m;
                let along_m = |[x, y]: [f32; 2]| y * normal.0 - x * normal.1;
                for (side, from) in corners.iter().enumerate() {
                    let to = corners[(side + 1) % corners.len()];
                    let (before_m, behind_m) = (beyond_m(*from), beyond_m(to));
                    if (before_m < 0.0) == (behind_m < 0.0) {
                        continue;
                    }
                    let share = before_m / (before_m - behind_m);
                    let crossed_m = along_m(*from) + share * (along_m(to) - along_m(*from));
                    least_m = least_m.min(crossed_m);
                    most_m = most_m.max(crossed_m);
                }
                if least_m > most_m {
                    return None;
                }
                let at_m = 0.0_f32.max(least_m).min(most_m);
                let point_m =
                    (gap_m * normal.0 - at_m * normal.1, gap_m * normal.1 + at_m * normal.0);
                Some((point_m, (gap_m * gap_m + at_m * at_m).sqrt()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wall_sight::tests::is_in;

    /// The nearest point of a wall in a region by its definition: of many points of the wall, those in the region.
    fn by_definition(region: &Region, normal: (f64, f64), gap_m: f64) -> Option<f64> {
        let points = (-40_000..=40_000).map(|step| f64::from(step) * 1e-4);
        points
            .map(|at| (gap_m * normal.0 - at * normal.1, gap_m * normal.1 + at * normal.0))
            .filter(|(x, y)| is_in(region, [*x, *y]))
            .map(|(x, y)| libm::hypot(x, y))
            .min_by(f64::total_cmp)
    }

    #[test]
    fn a_wall_is_as_far_as_its_nearest_point_in_the_region() {
        let polygons = [
            vec![[0.1, -0.2], [0.9, -0.4], [0.9, 0.5], [0.1, 0.2]],
            vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        ];
        let polygons = polygons.into_iter().map(|corners_m| Region::Polygon { corners_m });
        let cones =
            [0.1, 0.6, 1.4].map(|half_angle_rad| Region::Cone { half_angle_rad, range_m: 0.9 });
        let mut n_seen = 0;
        for region in polygons.chain(cones) {
            let view = WallView::new(&region);
            for turn in 0..40 {
                let (sine, cosine) =
                    libm::sincos(f64::from(turn) * std::f64::consts::TAU / 40.0 + 0.01);
                for gap_m in [0.05, 0.3, 0.47, 0.8, 0.95] {
                    let expected = by_definition(&region, (cosine, sine), gap_m);
                    let found = view.nearest((cosine as f32, sine as f32), gap_m as f32);
                    let place = format!("{region:?} {turn} {gap_m}: {expected:?} {found:?}");
                    assert_eq!(found.is_some(), expected.is_some(), "{place}");
                    let (Some(((x, y), away_m)), Some(expected)) = (found, expected) else {
                        continue;
                    };
                    assert!((f64::from(away_m) - expected).abs() < 1e-3, "{place}");
                    assert!((libm::hypot(x.into(), y.into()) - expected).abs() < 1e-3, "{place}");
                    n_seen += 1;
                }
            }
        }
        assert!(n_seen > 100, "{n_seen}");
    }

    #[test]
    fn a_line_of_sight_meets_the_wall_that_it_points_at() {
        let view = WallView::new(&Region::Cone { half_angle_rad: 0.0, range_m: 1.0 });
        let at = |bearing_rad: f64, gap_m: f32| {
            let (sine, cosine) = libm::sincos(bearing_rad);
            view.nearest((cosine as f32, sine as f32), gap_m).map(|(_, away_m)| away_m)
        };

        assert_eq!(at(0.0, 0.5), Some(0.5));
        let slanted = at(1.0, 0.5).expect("it is 0.5 / cos 1 away");
        assert!((f64::from(slanted) - 0.5 / libm::cos(1.0)).abs() < 1e-6);
        assert_eq!(at(1.2, 0.5), None, "1.38 m are too far");
        assert_eq!(at(2.0, 0.1), None, "it points away");
    }
}
