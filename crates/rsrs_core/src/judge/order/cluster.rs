//! Clusters: robots between which no other one fits.

use std::ops::Range;

use super::Samples;
use super::geometry::{Vector, distance_m2};
use crate::judge::number::Number;
use crate::judge::phase::{BLOCK_S, samples_in};

/// Share of the robots in the largest cluster of one lane: a mean over the last sample of a window and
/// those every [`BLOCK_S`] before it.
///
/// # Arguments
///
/// * `window` — not empty.
/// * `radius_m` — radius of the bodies, in metres.
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
        shares += largest(&places, near_m * near_m) as f64 / places.len() as f64;
        n_looks += 1.0;
    }
    shares / n_looks
}

/// How many robots the largest cluster has.
fn largest(places: &[Vector<f64>], near_m2: f64) -> usize {
    let mut others: Vec<Vector<f64>> = places.to_vec();
    let mut cluster: Vec<Vector<f64>> = Vec::new();
    let mut most = 0;
    while let Some(first) = others.pop() {
        cluster.clear();
        cluster.push(first);
        let mut looked_at = 0;
        while let Some(place) = cluster.get(looked_at).copied() {
            looked_at += 1;
            let mut index = 0;
            while index < others.len() {
                if distance_m2(others[index], place) < near_m2 {
                    cluster.push(others.swap_remove(index));
                } else {
                    index += 1;
                }
            }
        }
        most = most.max(cluster.len());
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_in_a_chain_are_one_cluster_and_those_apart_are_others() {
        let chain = (0..5).map(|robot| (f64::from(robot) * 0.29, 0.0));
        let apart = [(3.0, 0.0), (3.1, 0.0), (-2.0, 1.0)];
        let places: Vec<Vector<f64>> = chain.chain(apart).collect();

        assert_eq!(largest(&places, 0.3 * 0.3), 5);
        assert_eq!(largest(&places, 0.28 * 0.28), 2);
        assert_eq!(largest(&places, 9.0), 8);
    }
}
