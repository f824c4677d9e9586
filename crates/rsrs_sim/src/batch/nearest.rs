//! How far the nearest neighbours are, in single precision.

use super::sense::Body;
use crate::vector::simd::{Number, Simd};

/// Squared distance of two robots.
#[inline(always)]
pub fn between_m2<F: Number>(one: &Body<F>, other: &Body<F>) -> F {
    let (dx_m, dy_m) = (one.x_m - other.x_m, one.y_m - other.y_m);
    dx_m * dx_m + dy_m * dy_m
}

/// Squared distance of every robot to its nearest neighbour, infinite for one that is the only one.
///
/// # Arguments
///
/// * `row` — all robots; shape `[n_robots]`.
/// * `nearest_m2` — written for every robot; shape `[n_robots]`.
#[inline(always)]
pub fn nearest_neighbours<S: Simd>(simd: S, row: &[Body<S::F>], nearest_m2: &mut [S::F]) {
    nearest_m2.fill(simd.single(f32::INFINITY));
    let (mut row, mut nearest_m2) = (row, nearest_m2);
    // Some at a time, so that what is loaded of the others serves each of them.
    while row.len() > 4 {
        (row, nearest_m2) = some::<S, 4>(row, nearest_m2);
    }
    while !row.is_empty() {
        (row, nearest_m2) = some::<S, 1>(row, nearest_m2);
    }
}

/// The rest of the robots, and how far their nearest neighbours are.
type Rest<'a, F> = (&'a [Body<F>], &'a mut [F]);

/// Holds the first robots against each other and the rest, which is returned.
#[inline(always)]
fn some<'a, S: Simd, const SOME: usize>(
    row: &'a [Body<S::F>],
    nearest_m2: &'a mut [S::F],
) -> Rest<'a, S::F> {
    let (us, others) = row.split_first_chunk::<SOME>().expect("so many are left");
    let (ours, theirs) = nearest_m2.split_first_chunk_mut::<SOME>().expect("one for each robot");
    let mut nearest = *ours;
    for me in 0..SOME {
        for other in me + 1..SOME {
            let between_m2 = between_m2(&us[me], &us[other]);
            nearest[me] = nearest[me].least(between_m2);
            nearest[other] = nearest[other].least(between_m2);
        }
    }
    for (other, their_nearest) in others.iter().zip(&mut *theirs) {
        let mut their_least = *their_nearest;
        for me in 0..SOME {
            let between_m2 = between_m2(&us[me], other);
            nearest[me] = nearest[me].least(between_m2);
            their_least = their_least.least(between_m2);
        }
        *their_nearest = their_least;
    }
    *ours = nearest;
    (others, theirs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::portable::Portable;

    #[test]
    fn everybody_finds_the_nearest_of_all_others() {
        for n_robots in 1..=12_u16 {
            let place = |robot: u16, lane: usize| f32::from((robot * 7 + 3) % 13) * lane as f32;
            let body = |robot: u16| {
                let number = |number: fn(f32) -> f32| {
                    Portable.singles(|lane| number(place(robot, lane + 1)))
                };
                Body {
                    x_m: number(|place| place),
                    y_m: number(|place| 0.1 * place * place),
                    cosine: number(|_| 1.0),
                    sine: number(|_| 0.0),
                }
            };
            let row: Vec<_> = (0..n_robots).map(body).collect();
            let mut nearest_m2 = vec![Portable.single(0.0); row.len()];

            nearest_neighbours(Portable, &row, &mut nearest_m2);

            for (robot, found_m2) in nearest_m2.iter().enumerate() {
                for lane in 0..Portable::LANES {
                    let others = row.iter().enumerate().filter(|(other, _)| *other != robot);
                    let expected_m2 = others
                        .map(|(_, other)| between_m2(&row[robot], other).lane(lane))
                        .fold(f32::INFINITY, f32::min);
                    assert_eq!(found_m2.lane(lane).to_bits(), expected_m2.to_bits());
                }
            }
        }
    }
}
