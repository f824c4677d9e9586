//! A sensor from detection trials: a map, its 80 % contour, and how often it is wrong.

use std::collections::BTreeMap;

use serde::Serialize;

use super::FitError;
use super::contour::{BearingReach, RELIABLE, contour};
use super::detection_rate::{Rate, SensorPoint};
use super::held_out::{HeldOut, held_out};
use super::inscribed::{contains, inscribed};
use crate::statistics::interval::{Interval, TAIL};
use crate::trials::trial::{DetectionTrial, Neighbour, Trials};

/// A sensor as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorMap {
    /// Places that were tried, by bearing and then by distance.
    pub nodes: Vec<SensorPoint>,
    /// Where a neighbour's centre is detected at least 80 % of the time: a simple polygon,
    /// counterclockwise, in the robot's frame, in metres.
    pub contour_m: Vec<[f64; 2]>,
    /// How far it reaches at each bearing of the contour, with between which places that was found.
    pub reach: Vec<BearingReach>,
    /// The simpler convex polygon inside it that the simulator uses.
    pub polygon_m: Vec<[f64; 2]>,
    /// Detections while a neighbour stood inside that polygon, by readings that did not influence
    /// where the polygon is.
    pub true_positive: Rate,
    /// Detections while none was near.
    pub false_positive: Rate,
    /// Bearings at which detections are reliable, but apart from the contour, which leaves them out.
    pub left_out_rad: Vec<f64>,
    /// Outermost bearings that were tried and are reliable: the sensor may see beyond them.
    pub outermost_rad: Vec<f64>,
}

/// Maps a sensor from the readings of all robots, which are pooled; no centre comes closer than two
/// radii of a body. False positives must be measured, and a region must be reliable.
pub fn sensor_map(trials: &Trials<DetectionTrial>, radius_m: f64) -> Result<SensorMap, FitError> {
    let file = || trials.file.clone();
    let alone = trials.rows.iter().filter(|trial| trial.neighbour.is_none());
    let false_positive = Rate::sum(alone.map(|trial| (trial.detections, trial.samples)))
        .ok_or_else(|| FitError::NoFalsePositives { file: file() })?;
    let nodes = nodes(trials);
    let best = nodes.iter().map(|node| node.rate.value).fold(0.0, f64::max);
    let contour = contour(&nodes, 2.0 * radius_m).ok_or_else(|| FitError::NoRegion {
        file: file(),
        n_places: nodes.len(),
        best,
    })?;
    let polygon_m = inscribed(&contour.corners_m).ok_or_else(|| FitError::NoRegion {
        file: file(),
        n_places: nodes.len(),
        best,
    })?;
    let inside = nodes.iter().filter(|node| contains(&polygon_m, node.place_m()));
    let reliable = nodes.iter().filter(|node| node.rate.value >= RELIABLE);
    let true_positive = held_out(&nodes, 2.0 * radius_m)
        .map(rate_of)
        .or_else(|| Rate::sum(inside.map(counts)))
        .or_else(|| Rate::sum(reliable.map(counts)))
        .expect("a contour goes around a reliable place");
    Ok(SensorMap {
        nodes,
        contour_m: contour.corners_m,
        reach: contour.reach,
        polygon_m,
        true_positive,
        false_positive,
        left_out_rad: contour.left_out_rad,
        outermost_rad: contour.outermost_rad,
    })
}

fn counts(node: &SensorPoint) -> (u64, u64) {
    (node.rate.detections, node.rate.samples)
}

/// Pools readings at the same place.
fn nodes(trials: &Trials<DetectionTrial>) -> Vec<SensorPoint> {
    let mut places: BTreeMap<(i64, i64), (Neighbour, u64, u64)> = BTreeMap::new();
    for trial in &trials.rows {
        let Some(neighbour) = trial.neighbour else { continue };
        // Spreadsheets that compute bearings differ in the last digits.
        let key = |number: f64| (number * 1e6).round() as i64;
        let entry = places
            .entry((key(neighbour.bearing_rad), key(neighbour.distance_m)))
            .or_insert((neighbour, 0, 0));
        entry.1 += trial.detections;
        entry.2 += trial.samples;
    }
    let node = |(neighbour, detections, samples): (Neighbour, u64, u64)| SensorPoint {
        distance_m: neighbour.distance_m,
        bearing_rad: neighbour.bearing_rad,
        rate: Rate::new(detections, samples),
    };
    places.into_values().map(node).collect()
}

/// A share whose readings count as fewer independent ones.
///
/// # Source
///
/// E. L. Korn, B. I. Graubard, "Confidence intervals for proportions with small expected number of
/// positive counts estimated from survey data", Survey Methodology 24, 1998: Clopper and Pearson's
/// interval at the effective number of readings.
fn rate_of(found: HeldOut) -> Rate {
    let plain = Rate::new(found.detections, found.samples);
    if found.independent >= found.samples as f64 {
        return plain;
    }
    let hit = plain.value * found.independent;
    let missed = found.independent - hit;
    let Interval { low, high } = Interval::of_amounts(hit, missed, TAIL);
    Rate { low, high, ..plain }
}
