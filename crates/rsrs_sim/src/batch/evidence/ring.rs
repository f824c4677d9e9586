//! The motion around the centroid, in double precision.
//!
//! The definition takes a heading as an angle, and then its sine and cosine. Here it is a vector
//! whose length is one but for rounding, and is divided by it. The two ways differ in the last bits
//! of a mean, which is why the definition rounds it; where the rounding itself is in doubt, a lane
//! is taken the definition's way.

use rsrs_core::order::{RESOLUTION, rounded};

use super::{Commanded, Window};
use crate::vector::simd::{Mask, Number, Simd, Work};

/// By how much the two ways may differ in a mean of headings: a constant for the terms, which are
/// at most 1, and for each addition.
const TERM_MARGIN: f64 = 1e-14;
const ADDITION_MARGIN: f64 = 2.3e-16;

/// Where the robots were in the sample before, from the centroid; shape `[n_robots]`.
pub struct Arms<S: Simd>(Vec<(S::D, S::D)>);

impl<S: Simd> Arms<S> {
    /// No memory yet.
    pub fn new() -> Self {
        Self(Vec::new())
    }
}

/// Sums the motion of one half of the lanes.
pub struct SumMotion<'a, S: Simd, const HALF: usize> {
    pub simd: S,
    pub window: Window<'a, S::F>,
    pub arms: &'a mut Arms<S>,
}

/// The sums of one lane.
#[derive(Clone, Copy)]
pub struct Motion {
    rotation: f64,
    tangentness: f64,
    radius_m: f64,
    fatness: f64,
    orbited_m: f64,
}

/// The sums of half of the lanes.
struct Sums<D> {
    rotation: D,
    tangentness: D,
    radius_m: D,
    fatness: D,
    orbited_m: D,
}

impl<S: Simd, const HALF: usize> Work for SumMotion<'_, S, HALF> {
    type Output = Vec<Motion>;

    #[inline(always)]
    fn run(self) -> Vec<Motion> {
        let Self { simd, window, arms: Arms(arms) } = self;
        let zero = simd.double(0.0);
        let n_robots = window.rows.at(window.start).len();
        arms.clear();
        arms.resize(n_robots, (zero, zero));
        let mut sums = Sums {
            rotation: zero,
            tangentness: zero,
            radius_m: zero,
            fatness: zero,
            orbited_m: zero,
        };
        add::<S, HALF, true>(simd, (&window, window.start), arms, &mut sums);
        for sample in window.start + 1..window.end {
            add::<S, HALF, false>(simd, (&window, sample), arms, &mut sums);
        }
        let motion = |lane| Motion {
            rotation: sums.rotation.lane(lane),
            tangentness: sums.tangentness.lane(lane),
            radius_m: sums.radius_m.lane(lane),
            fatness: sums.fatness.lane(lane),
            orbited_m: sums.orbited_m.lane(lane),
        };
        (0..S::LANES / 2).map(motion).collect()
    }
}

/// Adds one sample.
#[inline(always)]
fn add<S: Simd, const HALF: usize, const IS_FIRST: bool>(
    simd: S,
    (window, sample): (&Window<'_, S::F>, u64),
    arms: &mut [(S::D, S::D)],
    sums: &mut Sums<S::D>,
) {
    let (zero, one) = (simd.double(0.0), simd.double(1.0));
    let row = window.rows.at(sample);
    let place = |body: &super::super::sense::Body<S::F>| {
        (simd.half::<HALF>(body.x_m), simd.half::<HALF>(body.y_m))
    };
    let sum = row.iter().map(place).fold((zero, zero), |sum, at| (sum.0 + at.0, sum.1 + at.1));
    let n_robots = simd.double(row.len() as f64);
    let centroid = (sum.0 / n_robots, sum.1 / n_robots);
    let (mut least_m2, mut most_m2) = (simd.double(f64::INFINITY), zero);
    for (body, arm_before) in row.iter().zip(arms) {
        let place = place(body);
        let arm = (place.0 - centroid.0, place.1 - centroid.1);
        let arm_m2 = arm.0 * arm.0 + arm.1 * arm.1;
        let arm_m = arm_m2.sqrt();
        least_m2 = least_m2.least(arm_m2);
        most_m2 = most_m2.most(arm_m2);
        sums.radius_m = sums.radius_m + arm_m;
        let (cosine, sine) = (simd.half::<HALF>(body.cosine), simd.half::<HALF>(body.sine));
        let inverse = one / (arm_m * (cosine * cosine + sine * sine).sqrt());
        // On the centroid there is no direction around it: such a robot faces outward.
        let is_central = arm_m.le(zero);
        let around = (arm.0 * sine - arm.1 * cosine) * inverse;
        let outward = (arm.0 * cosine + arm.1 * sine) * inverse;
        sums.rotation = sums.rotation + around.unless(is_central);
        sums.tangentness = sums.tangentness + S::D::select(is_central, one, outward.abs());
        if !IS_FIRST {
            sums.orbited_m = sums.orbited_m + angle_between(simd, *arm_before, arm) * arm_m;
        }
        *arm_before = arm;
    }
    let fatness = one - least_m2 / most_m2;
    sums.fatness = sums.fatness + fatness.unless(most_m2.le(zero));
}

/// The angle from one vector to another, as the judge takes it.
#[inline(always)]
fn angle_between<S: Simd>(simd: S, from: (S::D, S::D), to: (S::D, S::D)) -> S::D {
    let one = |number| simd.double(number);
    let across = from.0 * to.1 - from.1 * to.0;
    let along = from.0 * to.0 + from.1 * to.1;
    let tangent = across / along;
    let square = tangent * tangent;
    let sixth = one(1.0 / 13.0) - square * one(1.0 / 15.0);
    let fourth = one(1.0 / 9.0) - square * (one(1.0 / 11.0) - square * sixth);
    let second = one(1.0 / 5.0) - square * (one(1.0 / 7.0) - square * fourth);
    let angle = tangent * (one(1.0) - square * (one(1.0 / 3.0) - square * second));
    let is_small = (along.gt(one(0.0)) & tangent.abs().lt(one(0.1))).bits();
    if is_small == (1 << (S::LANES / 2)) - 1 {
        return angle;
    }
    large_angles(simd, (is_small, angle), |lane| (across.lane(lane), along.lane(lane)))
}

/// The lanes in which a robot went around by much, one by one.
#[cold]
#[inline(never)]
fn large_angles<S: Simd>(
    simd: S,
    (is_small, angle): (u32, S::D),
    vector: impl Fn(usize) -> (f64, f64),
) -> S::D {
    simd.doubles(|lane| {
        let (across, along) = vector(lane);
        if is_small >> lane & 1 == 1 { angle.lane(lane) } else { libm::atan2(across, along) }
    })
}

impl Motion {
    /// Rotation and tangentness.
    pub fn headings<F>(&self, window: &Window<'_, F>, lane: usize) -> (f64, f64)
    where
        F: Number<Scalar = f32>,
    {
        let n_poses =
            (window.end - window.start) as f64 * window.rows.at(window.start).len() as f64;
        let means = [(self.rotation / n_poses).abs(), self.tangentness / n_poses];
        let margin = TERM_MARGIN + ADDITION_MARGIN * n_poses;
        if means.iter().all(|mean| rounds_surely(*mean, margin)) {
            return (rounded(means[0]), rounded(means[1]));
        }
        let (rotation, tangentness) = headings_by_definition(window, lane);
        (rounded((rotation / n_poses).abs()), rounded(tangentness / n_poses))
    }

    /// Way around the centroid over the way commanded.
    pub fn orbit(&self, commanded: &Commanded) -> f64 {
        let orbit = if commanded.way_m > 0.0 { self.orbited_m / commanded.way_m } else { 0.0 };
        orbit.abs()
    }

    /// `1 - (r_min / r_max)²`
    pub fn fatness(&self, n_samples: f64) -> f64 {
        self.fatness / n_samples
    }

    /// Mean distance from the centroid, in metres.
    pub fn mean_radius_m(&self, n_poses: f64) -> f64 {
        self.radius_m / n_poses
    }
}

/// Whether all numbers within a margin of a mean are rounded to the same one. What is not a number
/// is not.
fn rounds_surely(mean: f64, margin: f64) -> bool {
    let whole = mean / RESOLUTION;
    ((whole - whole.floor()) - 0.5).abs() * RESOLUTION > margin
}

/// The sums of rotation and tangentness in one lane, term by term as the definition has them.
#[cold]
fn headings_by_definition<F>(window: &Window<'_, F>, lane: usize) -> (f64, f64)
where
    F: Number<Scalar = f32>,
{
    let number = |number: F| f64::from(number.lane(lane));
    let (mut rotation, mut tangentness) = (0.0, 0.0);
    for sample in window.start..window.end {
        let row = window.rows.at(sample);
        let sum = row
            .iter()
            .fold((0.0, 0.0), |sum, body| (sum.0 + number(body.x_m), sum.1 + number(body.y_m)));
        let centroid = (sum.0 / row.len() as f64, sum.1 / row.len() as f64);
        for body in row {
            let arm = (number(body.x_m) - centroid.0, number(body.y_m) - centroid.1);
            let arm_m = (arm.0 * arm.0 + arm.1 * arm.1).sqrt();
            let heading_rad = libm::atan2(number(body.sine), number(body.cosine));
            let (sine, cosine) = libm::sincos(heading_rad);
            let is_central = arm_m <= 0.0;
            rotation += if is_central { 0.0 } else { (arm.0 * sine - arm.1 * cosine) / arm_m };
            let outward = (arm.0 * cosine + arm.1 * sine) / arm_m;
            tangentness += if is_central { 1.0 } else { outward.abs() };
        }
    }
    (rotation, tangentness)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_next_to_where_rounding_changes_is_left_to_the_definition() {
        let middle = (12_345.0 + 0.5) * RESOLUTION;

        for (mean, is_sure) in [
            (middle, false),
            (middle - 0.9e-12, false),
            (middle + 0.9e-12, false),
            (middle - 1.1e-12, true),
            (middle + 1.1e-12, true),
            (f64::NAN, false),
        ] {
            assert_eq!(rounds_surely(mean, 1e-12), is_sure, "{mean}");
        }
    }
}
