//! Geometry of robots on a floor, for one world or for a world in each lane.

use crate::judge::number::{Mask, Number};

/// Two components, along x and y.
pub type Vector<N> = (N, N);

#[inline(always)]
pub fn dot<N: Number>(one: Vector<N>, other: Vector<N>) -> N {
    one.0 * other.0 + one.1 * other.1
}

/// How far the second vector points to the left of the first, times both lengths.
#[inline(always)]
pub fn cross<N: Number>(one: Vector<N>, other: Vector<N>) -> N {
    one.0 * other.1 - one.1 * other.0
}

#[inline(always)]
pub fn distance_m2<N: Number>(one: Vector<N>, other: Vector<N>) -> N {
    let between = (one.0 - other.0, one.1 - other.1);
    dot(between, between)
}

#[inline(always)]
pub fn centroid<N: Number<Scalar = f64>>(zero: N, places: &[Vector<N>]) -> Vector<N> {
    let add = |sum: Vector<N>, place: &Vector<N>| (sum.0 + place.0, sum.1 + place.1);
    let sum = places.iter().fold((zero, zero), add);
    let n_robots = zero.all(places.len() as f64);
    (sum.0 / n_robots, sum.1 / n_robots)
}

/// The angle from one vector to another, in radians, counterclockwise; 0 if either is zero.
#[inline(always)]
pub fn angle_between<N: Number<Scalar = f64>>(from: Vector<N>, to: Vector<N>) -> N {
    let (across, along) = (cross(from, to), dot(from, to));
    let tangent = across / along;
    // The arctangent's series: a robot goes around by little in one period, and this is ten times
    // cheaper. The first term left out is below 1e-15.
    let one = |constant| tangent.all(constant);
    let square = tangent * tangent;
    let sixth = one(1.0 / 13.0) - square * one(1.0 / 15.0);
    let fourth = one(1.0 / 9.0) - square * (one(1.0 / 11.0) - square * sixth);
    let second = one(1.0 / 5.0) - square * (one(1.0 / 7.0) - square * fourth);
    let angle = tangent * (one(1.0) - square * (one(1.0 / 3.0) - square * second));
    let is_small = (along.gt(one(0.0)) & tangent.abs().lt(one(0.1))).bits();
    if is_small == (1 << N::LANES) - 1 {
        return angle;
    }
    large_angles(is_small, angle, (across, along))
}

/// The lanes in which a robot went around by much, one by one.
#[cold]
#[inline(never)]
fn large_angles<N: Number<Scalar = f64>>(is_small: u32, angle: N, (across, along): Vector<N>) -> N {
    angle.by_lane(|lane| {
        let is_small = is_small >> lane & 1 == 1;
        if is_small { angle.lane(lane) } else { libm::atan2(across.lane(lane), along.lane(lane)) }
    })
}

/// Squared distance of every robot to its nearest neighbour, in square metres; infinite for a
/// robot that is the only one.
#[inline(always)]
pub fn nearest_neighbours<N: Number<Scalar = f64>>(
    zero: N,
    places: &[Vector<N>],
    nearest_m2: &mut [N],
) {
    nearest_m2.fill(zero.all(f64::INFINITY));
    let (mut places, mut nearest_m2) = (places, nearest_m2);
    // Some at a time, so that what is loaded of the others serves each of them.
    while places.len() > 4 {
        (places, nearest_m2) = nearest_of_some::<N, 4>(places, nearest_m2);
    }
    while !places.is_empty() {
        (places, nearest_m2) = nearest_of_some::<N, 1>(places, nearest_m2);
    }
}

/// The rest of the robots, and how far their nearest neighbours are.
type Rest<'a, N> = (&'a [Vector<N>], &'a mut [N]);

/// Holds the first robots against each other and the rest, which is returned.
#[inline(always)]
fn nearest_of_some<'a, N: Number<Scalar = f64>, const SOME: usize>(
    places: &'a [Vector<N>],
    nearest_m2: &'a mut [N],
) -> Rest<'a, N> {
    let (some, others) = places.split_first_chunk::<SOME>().expect("so many are left");
    let (found_m2, rest_m2) = nearest_m2.split_first_chunk_mut::<SOME>().expect("one for each");
    let mut some_m2 = *found_m2;
    for one in 0..SOME {
        for other in one + 1..SOME {
            let between_m2 = distance_m2(some[other], some[one]);
            some_m2[one] = some_m2[one].least(between_m2);
            some_m2[other] = some_m2[other].least(between_m2);
        }
    }
    for (other, other_m2) in others.iter().zip(&mut *rest_m2) {
        let mut least_m2 = *other_m2;
        for one in 0..SOME {
            let between_m2 = distance_m2(*other, some[one]);
            some_m2[one] = some_m2[one].least(between_m2);
            least_m2 = least_m2.least(between_m2);
        }
        *other_m2 = least_m2;
    }
    *found_m2 = some_m2;
    (others, rest_m2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_of_the_angle_agrees_with_the_arctangent() {
        for step in -2000..2000 {
            let angle = f64::from(step) * 1e-3;
            let to = (0.7 * libm::cos(angle), 0.7 * libm::sin(angle));

            assert!((angle_between((0.8, 0.0), to) - angle).abs() < 1e-14, "{angle}");
        }
    }
}
