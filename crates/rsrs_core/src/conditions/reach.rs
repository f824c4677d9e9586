//! How far robots see each other.

use super::Region;
use crate::robot::profile::Sees;

impl Region {
    /// The reach of a sensor: how far from a robot's centre the centre of another can be seen, in
    /// metres.
    ///
    /// Where centres are seen this is [`Region::range_m`]. Where bodies are seen it is more: a disc
    /// whose edge touches the region has its centre up to a radius outside. The region of the
    /// simulator is what counts: the cone's range and the radius, or the polygon whose sides are
    /// moved out by the radius, in front only.
    ///
    /// # Arguments
    ///
    /// * `sees` — what of a neighbour must lie in the region.
    /// * `radius_m` — radius of the neighbour's body, in metres.
    ///
    /// # Example
    ///
    /// A Flockbot sees 0.75 m far, and a robot whose centre is 7.5 cm beyond.
    ///
    /// ```
    /// use rsrs_core::conditions::Region;
    /// use rsrs_core::robot::profile::Sees;
    ///
    /// let cone = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };
    /// assert_eq!(format!("{:.3}", cone.reach_m(Sees::Body, 0.075)), "0.825");
    /// assert_eq!(cone.reach_m(Sees::Centre, 0.075), 0.75);
    /// ```
    pub fn reach_m(&self, sees: Sees, radius_m: f64) -> f64 {
        match (self, sees) {
            (_, Sees::Centre) => self.range_m(),
            (Self::Cone { range_m, .. }, Sees::Body) => range_m + radius_m,
            (Self::Polygon { corners_m }, Sees::Body) => {
                farthest_in_front_m(&moved_out(corners_m, radius_m))
            }
        }
    }
}

/// The corners of a convex polygon whose sides are moved out by a distance.
fn moved_out(corners_m: &[[f64; 2]], by_m: f64) -> Vec<[f64; 2]> {
    let n_corners = corners_m.len();
    let normal = |side: usize| {
        let (from, to) = (corners_m[side % n_corners], corners_m[(side + 1) % n_corners]);
        let (along_x, along_y) = (to[0] - from[0], to[1] - from[1]);
        let length = libm::hypot(along_x, along_y);
        // The region lies left of each side (counterclockwise), so outside is to the right.
        [along_y / length, -along_x / length]
    };
    let corner = |index: usize| {
        let ([before_x, before_y], [after_x, after_y]) =
            (normal(index + n_corners - 1), normal(index));
        // The point that is `by_m` outside of both sides.
        let share = by_m / (1.0 + before_x * after_x + before_y * after_y);
        let [x, y] = corners_m[index];
        [x + share * (before_x + after_x), y + share * (before_y + after_y)]
    };
    (0..n_corners).map(corner).collect()
}

/// The greatest distance from the origin to a point of a convex polygon that lies in front of it;
/// 0 if none does.
fn farthest_in_front_m(corners_m: &[[f64; 2]]) -> f64 {
    let mut farthest_m = 0.0_f64;
    for (index, [x, y]) in corners_m.iter().enumerate() {
        if *x >= 0.0 {
            farthest_m = farthest_m.max(libm::hypot(*x, *y));
        }
        let [next_x, next_y] = corners_m[(index + 1) % corners_m.len()];
        if (*x < 0.0) != (next_x < 0.0) {
            let at_y = y + (next_y - y) * x / (x - next_x);
            farthest_m = farthest_m.max(at_y.abs());
        }
    }
    farthest_m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners_m: &[[f64; 2]]) -> Region {
        Region::Polygon { corners_m: corners_m.to_vec() }
    }

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn a_box_reaches_to_the_corner_of_the_larger_box() {
        let region = polygon(&[[0.1, -0.2], [0.6, -0.2], [0.6, 0.2], [0.1, 0.2]]);

        assert_near(region.reach_m(Sees::Body, 0.075), libm::hypot(0.675, 0.275));
        assert_near(region.reach_m(Sees::Centre, 0.075), libm::hypot(0.6, 0.2));
    }

    #[test]
    fn bodies_are_not_seen_behind() {
        let region = polygon(&[[-3.0, -0.5], [0.4, -0.5], [0.4, 0.5], [-3.0, 0.5]]);

        assert_near(region.reach_m(Sees::Body, 0.1), libm::hypot(0.5, 0.6));
        let slanted = polygon(&[[-2.0, -1.0], [0.2, 0.0], [-2.0, 1.0]]);
        let reach_m = slanted.reach_m(Sees::Body, 0.0);
        assert_near(reach_m, 0.2);
        let behind = polygon(&[[-2.0, -1.0], [-1.0, 0.0], [-2.0, 1.0]]);
        assert_near(behind.reach_m(Sees::Body, 0.1), 0.0);
    }
}
