//! Clusters: robots between which no other one fits, objects likewise, robots of one class that are near each other, and
//! robots that are gathered at one goal.

use std::ops::Range;

use super::Samples;
use super::geometry::{Vector, distance_m2};
use crate::judge::number::Number;
use crate::judge::window::{BLOCK_S, samples_in};
use crate::world::Goal;

/// Share of the robots in the largest cluster of one lane: a mean over the last sample of a window,
/// which is not empty, and those every [`BLOCK_S`] before it.
///
/// # Source
///
/// Clusters as in M. Gauci et al., IJRR 33(8), 2014: two robots are neighbours if another one cannot
/// fit in between them.
pub fn clustered<S: Samples>(samples: &S, window: Range<usize>, lane: usize, radius_m: f64) -> f64 {
    let n_block = samples_in(BLOCK_S, samples.period_s());
    let near_m = 4.0 * radius_m;
    let (mut shares, mut n_looks) = (0.0, 0.0);
    for sample in window.rev().step_by(n_block) {
        let place = |pose| {
            let (x_m, y_m) = samples.place(pose);
            (x_m.lane(lane), y_m.lane(lane))
        };
        let places: Vec<Vector<f64>> = samples.poses_at(sample).iter().map(place).collect();
        let are_near =
            |one: &Vector<f64>, other: &Vector<f64>| distance_m2(*one, *other) < near_m * near_m;
        shares += largest(&places, are_near) as f64 / places.len() as f64;
        n_looks += 1.0;
    }
    shares / n_looks
}

/// Share of objects in the largest cluster: a mean over the last sample and those every [`BLOCK_S`] before it. Two
/// objects are neighbours if the smallest one does not fit between them.
///
/// There is at least one object, and a sample of where objects are, in metres; samples are `period_s` apart.
pub fn clustered_objects(period_s: f64, radii_m: &[f64], objects: &[Vector<f64>]) -> f64 {
    let smallest_m = radii_m.iter().copied().fold(f64::INFINITY, f64::min);
    let n_block = samples_in(BLOCK_S, period_s);
    let (mut shares, mut n_looks) = (0.0, 0.0);
    for places in objects.chunks_exact(radii_m.len()).rev().step_by(n_block) {
        let discs: Vec<(Vector<f64>, f64)> =
            places.iter().copied().zip(radii_m.iter().copied()).collect();
        let are_near = |one: &(Vector<f64>, f64), other: &(Vector<f64>, f64)| {
            let near_m = one.1 + other.1 + 2.0 * smallest_m;
            distance_m2(one.0, other.0) < near_m * near_m
        };
        shares += largest(&discs, are_near) as f64 / radii_m.len() as f64;
        n_looks += 1.0;
    }
    shares / n_looks
}

/// How far apart the bodies of two robots of one cluster of their class are at most, in metres: `ε` of the source.
const KIN_APART_M: f64 = 0.05;

/// For each class the share of its robots in its largest cluster, a mean over samples of where all
/// robots are, in metres. There is at least one sample; `classes` has that of each robot, and none
/// is without a robot.
///
/// # Source
///
/// `K_i(t) / k_i` of P. Mitrano, J. Burklund, M. Giancola and C. Pinciroli, "A minimalistic approach to segregation in
/// robot swarms", MRS 2019: two robots of a class are connected if their centres are at most `2r + ε` apart.
pub fn clustered_by_class(radius_m: f64, classes: &[usize], robots: &[Vector<f64>]) -> Vec<f64> {
    let near_m = 2.0 * radius_m + KIN_APART_M;
    let are_near =
        |one: &Vector<f64>, other: &Vector<f64>| distance_m2(*one, *other) <= near_m * near_m;
    let n_classes = classes.iter().max().map_or(0, |last| last + 1);
    let (mut shares, samples) = (vec![0.0; n_classes], robots.chunks_exact(classes.len()));
    let n_samples = samples.len() as f64;
    for places in samples {
        for (class, share) in shares.iter_mut().enumerate() {
            let of_class = places.iter().zip(classes).filter(|(_, it)| **it == class);
            let kin: Vec<Vector<f64>> = of_class.map(|(place, _)| *place).collect();
            *share += largest(&kin, are_near) as f64 / kin.len() as f64;
        }
    }
    shares.into_iter().map(|share| share / n_samples).collect()
}

/// Share of robots that are gathered at the goal that has most of them: a mean over the last sample and those every
/// [`BLOCK_S`] before it. A robot is gathered at a goal if no other one fits between the two, or between it and one that
/// is gathered there.
///
/// Samples have the places of `n_robots`, in metres, and are `period_s` apart; there is at least one.
///
/// # Source
///
/// The options of A. Özdemir, M. Gauci, S. Bonnet and R. Groß, "Finding consensus without computation", IEEE RA-L 3(3),
/// 2018, one of which all robots are to choose and move to. That what has gathered is a cluster as in M. Gauci et al.,
/// IJRR 33(8), 2014, is ours.
pub fn at_one_goal(
    (period_s, radius_m): (f64, f64),
    goals: &[Goal],
    n_robots: usize,
    robots: &[Vector<f64>],
) -> f64 {
    let near_m = 4.0 * radius_m;
    let are_near =
        |one: &Vector<f64>, other: &Vector<f64>| distance_m2(*one, *other) < near_m * near_m;
    let n_block = samples_in(BLOCK_S, period_s);
    let (mut shares, mut n_looks) = (0.0, 0.0);
    for places in robots.chunks_exact(n_robots).rev().step_by(n_block) {
        let gathered = |goal: &Goal| {
            let near_m = goal.radius_m + 3.0 * radius_m;
            let is_there = |place: &Vector<f64>| {
                distance_m2(*place, (goal.place_m[0], goal.place_m[1])) < near_m * near_m
            };
            let (mut there, mut others) = places.iter().partition(|place| is_there(place));
            grow(&mut there, &mut others, &are_near);
            there.len()
        };
        shares += goals.iter().map(gathered).max().unwrap_or(0) as f64 / n_robots as f64;
        n_looks += 1.0;
    }
    shares / n_looks
}

/// How many the largest cluster has.
fn largest<T: Copy>(places: &[T], are_near: impl Fn(&T, &T) -> bool) -> usize {
    let mut others: Vec<T> = places.to_vec();
    let mut cluster: Vec<T> = Vec::new();
    let mut most = 0;
    while let Some(first) = others.pop() {
        cluster.clear();
        cluster.push(first);
        grow(&mut cluster, &mut others, &are_near);
        most = most.max(cluster.len());
    }
    most
}

/// Moves into a cluster all others that are near one of it.
fn grow<T: Copy>(cluster: &mut Vec<T>, others: &mut Vec<T>, are_near: &impl Fn(&T, &T) -> bool) {
    let mut looked_at = 0;
    while let Some(place) = cluster.get(looked_at).copied() {
        looked_at += 1;
        let mut index = 0;
        while index < others.len() {
            if are_near(&others[index], &place) {
                cluster.push(others.swap_remove(index));
            } else {
                index += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_in_a_chain_are_one_cluster_and_those_apart_are_others() {
        let chain = (0..5).map(|robot| (f64::from(robot) * 0.29, 0.0));
        let apart = [(3.0, 0.0), (3.1, 0.0), (-2.0, 1.0)];
        let places: Vec<Vector<f64>> = chain.chain(apart).collect();

        let largest = |near_m: f64| {
            largest(&places, |one, other| distance_m2(*one, *other) < near_m * near_m)
        };

        assert_eq!(largest(0.3), 5);
        assert_eq!(largest(0.28), 2);
        assert_eq!(largest(3.0), 8);
    }

    #[test]
    fn objects_are_apart_if_the_smallest_fits_between_them() {
        let radii_m = [0.05, 0.1, 0.02];
        let share = |gap_m: f64| {
            let objects = [(0.0, 0.0), (0.15 + gap_m, 0.0), (5.0, 5.0)];
            clustered_objects(0.1, &radii_m, &objects)
        };

        assert!((share(0.039) - 2.0 / 3.0).abs() < 1e-12);
        assert!((share(0.041) - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn robots_of_a_class_are_one_cluster_if_they_are_at_most_5_cm_apart() {
        let shares = |gap_m: f64| {
            // The second class stands between the robots of the first, and one of the third is away.
            let places =
                [(0.0, 0.0), (0.1, 0.2), (0.0, 0.5), (0.2 + gap_m, 0.0), (2.0, 0.0), (3.0, 0.0)];
            clustered_by_class(0.1, &[0, 1, 2, 0, 1, 2], &places)
        };

        assert_eq!(shares(0.0499), [1.0, 0.5, 0.5]);
        assert_eq!(shares(0.0501), [0.5, 0.5, 0.5]);
    }

    #[test]
    fn robots_are_at_the_goal_that_has_most_of_those_between_which_and_it_no_other_one_fits() {
        let goals = [([-1.0, 0.0], 0.2), ([1.0, 0.0], 0.1)]
            .map(|(place_m, radius_m)| Goal { place_m, radius_m });
        let share = |goals: &[Goal], gap_m: f64| {
            // Two at the first goal, three in a row at the second, and one that is in a cluster with nobody.
            let row = [0.0, 0.25, 0.5].map(|way_m| (1.2 + gap_m + way_m, 0.0));
            let robots = [(-1.0, 0.0), (-1.0, 0.3), row[0], row[1], row[2], (0.0, 3.0)];
            at_one_goal((0.1, 0.1), goals, robots.len(), &robots)
        };

        assert!((share(&goals, 0.199) - 3.0 / 6.0).abs() < 1e-12, "the row reaches its goal");
        assert!((share(&goals, 0.201) - 2.0 / 6.0).abs() < 1e-12, "another one fits between");
        assert!((share(&goals[..1], 0.199) - 2.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn shares_of_clustered_objects_are_a_mean_over_looks_10_s_apart() {
        let together = [(0.0, 0.0), (0.1, 0.0)];
        let apart = [(0.0, 0.0), (1.0, 0.0)];
        // 20 s; looks at the last sample and 10 s before it.
        let samples = (0..200).flat_map(|sample| if sample == 99 { together } else { apart });
        let objects: Vec<Vector<f64>> = samples.collect();

        assert!((clustered_objects(0.1, &[0.05; 2], &objects) - 0.75).abs() < 1e-12);
    }
}
