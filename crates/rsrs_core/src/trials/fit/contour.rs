//! The measured polygon: where a sensor is reliable, between the places that were tried.

use std::collections::BTreeMap;

use serde::Serialize;

use super::detection_rate::{SensorPoint, place_m};
use crate::plane::area;

/// The share of detections that the paper's blue polygon stands for.
///
/// # Source
///
/// `fig:sim_sensing`, §IV step 1: "the 80 % positive detection threshold".
pub const RELIABLE: f64 = 0.8;

/// Where a sensor is reliable.
pub struct Contour {
    /// A simple polygon, counterclockwise, in metres.
    pub corners_m: Vec<[f64; 2]>,
    /// How far it reaches at each bearing of the polygon, from the right to the left.
    pub reach: Vec<BearingReach>,
    /// Bearings with reliable places that are apart from the polygon.
    pub left_out_rad: Vec<f64>,
    /// Outermost bearings that were tried and are reliable, farther than robots that nearly touch;
    /// nothing was tried beyond.
    pub outermost_rad: Vec<f64>,
}

/// How far a sensor reaches at one bearing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BearingReach {
    /// The bearing, in radians; left is positive.
    pub bearing_rad: f64,
    /// How far detections are reliable, in metres: between the places that were tried.
    pub far_m: f64,
    /// The last place at which they were, in metres: it reaches at least there.
    pub low_m: f64,
    /// The first place beyond at which they were not, in metres; `None` if none was tried there.
    pub high_m: Option<f64>,
}

/// One bearing: distances, ascending, with the share of detections at each; chance dips in between
/// reliable places are lifted to [`RELIABLE`].
struct Ray {
    bearing_rad: f64,
    places: Vec<(f64, f64)>,
}

/// The reliable part of a ray.
#[derive(Clone, Copy)]
struct Reach {
    near_m: f64,
    far_m: f64,
    first: usize,
    last: usize,
}

/// Draws the contour; `None` if no place is reliable, or if reliable places span no area.
///
/// Between neighbouring places on a ray, and between rays, the edge is at [`crossing`]. Nothing is
/// claimed beyond the places that were tried, with one exception: where the nearest of them is at
/// contact, `contact_m` from centre to centre, the contour goes on to the robot's centre, because
/// no neighbour can stand there.
pub fn contour(nodes: &[SensorPoint], contact_m: f64) -> Option<Contour> {
    let rays = rays(nodes);
    let reaches: Vec<Option<Reach>> =
        rays.iter().map(|ray| reach(&ray.places, contact_m)).collect();
    let block = largest_block(&reaches)?;
    let left_out_rad = (0..rays.len())
        .filter(|ray| reaches[*ray].is_some() && !block.contains(ray))
        .map(|ray| rays[ray].bearing_rad)
        .collect();
    let inside: Vec<(&Ray, Reach)> = block
        .clone()
        .map(|ray| (&rays[ray], reaches[ray].expect("a block has reaches only")))
        .collect();
    let found = |(ray, reach): &(&Ray, Reach)| BearingReach {
        bearing_rad: ray.bearing_rad,
        far_m: reach.far_m,
        low_m: ray.places[reach.last].0,
        high_m: ray.places.get(reach.last + 1).map(|place| place.0),
    };
    let reach = inside.iter().map(found).collect();
    let mut corners_m: Vec<[f64; 2]> =
        inside.iter().map(|(ray, reach)| place_m(reach.far_m, ray.bearing_rad)).collect();
    let mut outermost_rad = Vec::new();
    if !is_all_around(&rays, block.len()) {
        let ((right, right_reach), (left, left_reach)) = (inside[0], inside[inside.len() - 1]);
        let beyond_left = rays.get(block.end);
        let beyond_right = block.start.checked_sub(1).map(|before| &rays[before]);
        // A neighbour that nearly touches fills a wide angle, whatever the sensor's is.
        let is_open = |(_, reach, beyond): &(&Ray, Reach, Option<&Ray>)| {
            beyond.is_none() && reach.far_m > 2.0 * contact_m
        };
        let ends = [(right, right_reach, beyond_right), (left, left_reach, beyond_left)];
        outermost_rad.extend(ends.into_iter().filter(is_open).map(|(ray, ..)| ray.bearing_rad));
        outermost_rad.dedup();
        corners_m.extend(side(left, left_reach, beyond_left).into_iter().rev());
        for (ray, reach) in inside.iter().rev() {
            corners_m.push(place_m(reach.near_m, ray.bearing_rad));
        }
        corners_m.extend(side(right, right_reach, beyond_right));
    }
    corners_m.dedup_by(|left, right| is_same(*left, *right));
    while corners_m.len() > 1 && is_same(corners_m[0], corners_m[corners_m.len() - 1]) {
        corners_m.pop();
    }
    (corners_m.len() >= 3 && area(&corners_m) > 1e-6).then_some(Contour {
        corners_m,
        reach,
        left_out_rad,
        outermost_rad,
    })
}

fn rays(nodes: &[SensorPoint]) -> Vec<Ray> {
    let mut rays: BTreeMap<i64, Vec<SensorPoint>> = BTreeMap::new();
    for node in nodes {
        rays.entry((node.bearing_rad * 1e6).round() as i64).or_default().push(*node);
    }
    let ray = |mut nodes: Vec<SensorPoint>| {
        nodes.sort_by(|left, right| left.distance_m.total_cmp(&right.distance_m));
        let places = (0..nodes.len()).map(|node| (nodes[node].distance_m, share(&nodes, node)));
        Ray { bearing_rad: nodes[0].bearing_rad, places: places.collect() }
    };
    rays.into_values().map(ray).collect()
}

/// The share of detections at a place of a ray. A place between two reliable ones whose share is
/// below [`RELIABLE`], but not surely, is as reliable as it must be.
fn share(nodes: &[SensorPoint], node: usize) -> f64 {
    let rate = nodes[node].rate;
    let is_reliable =
        |other: Option<&SensorPoint>| other.is_some_and(|other| other.rate.value >= RELIABLE);
    let before = node.checked_sub(1).and_then(|before| nodes.get(before));
    let is_chance =
        is_reliable(before) && is_reliable(nodes.get(node + 1)) && rate.high >= RELIABLE;
    if is_chance { rate.value.max(RELIABLE) } else { rate.value }
}

/// The longest reliable part of a ray, the nearer of equally long ones.
fn reach(places: &[(f64, f64)], contact_m: f64) -> Option<Reach> {
    let mut best: Option<Reach> = None;
    let mut first = 0;
    while first < places.len() {
        if places[first].1 < RELIABLE {
            first += 1;
            continue;
        }
        let n_more = places[first + 1..].iter().take_while(|place| place.1 >= RELIABLE).count();
        let last = first + n_more;
        let far_m =
            places.get(last + 1).map_or(places[last].0, |next| crossing(places[last], *next));
        let near_m = match first.checked_sub(1) {
            Some(before) => crossing(places[first], places[before]),
            None if places[first].0 <= CONTACT_SLACK * contact_m => 0.0,
            None => places[first].0,
        };
        let found = Reach { near_m, far_m, first, last };
        if best.is_none_or(|best| far_m - near_m > best.far_m - best.near_m) {
            best = Some(found);
        }
        first = last + 1;
    }
    best
}

/// A place this much further than contact still counts as at contact: robots stand on a floor, not
/// in a vice.
const CONTACT_SLACK: f64 = 1.25;

/// Where detections cease to be reliable between a reliable place and another: where their share falls to
/// [`RELIABLE`], or half of the way down if that comes later. A sensor with a sharp edge falls at one
/// place, which may be anywhere between the two; the middle is off by half of their distance at most,
/// and a line down to [`RELIABLE`] would stay close to the last place that was seen.
fn crossing(reliable: (f64, f64), other: (f64, f64)) -> f64 {
    let level = RELIABLE.min(f64::midpoint(reliable.1, other.1));
    let share = (reliable.1 - level) / (reliable.1 - other.1);
    reliable.0 + share * (other.0 - reliable.0)
}

/// Neighbouring rays with reliable parts that together cover the most.
fn largest_block(reaches: &[Option<Reach>]) -> Option<std::ops::Range<usize>> {
    let mut best: Option<(f64, std::ops::Range<usize>)> = None;
    let mut start = 0;
    while start < reaches.len() {
        let covered: Vec<f64> = reaches[start..]
            .iter()
            .map_while(|reach| {
                reach.map(|reach| reach.far_m * reach.far_m - reach.near_m * reach.near_m)
            })
            .collect();
        let size: f64 = covered.iter().sum();
        let end = start + covered.len();
        if end > start && best.as_ref().is_none_or(|(most, _)| size > *most) {
            best = Some((size, start..end));
        }
        start = end.max(start + 1);
    }
    best.map(|(_, block)| block)
}

/// Whether reliable rays surround the robot without a gap that is wider than those between them.
fn is_all_around(rays: &[Ray], n_reliable: usize) -> bool {
    if n_reliable < rays.len() || rays.len() < 3 {
        return false;
    }
    let widest =
        rays.windows(2).map(|pair| pair[1].bearing_rad - pair[0].bearing_rad).fold(0.0, f64::max);
    let around = rays[0].bearing_rad + std::f64::consts::TAU - rays[rays.len() - 1].bearing_rad;
    around <= 1.5 * widest
}

/// How far detections stay reliable beyond the outermost ray, at its reliable places from near to
/// far: the share falls towards the next ray out, where that was tried at this distance.
fn side(ray: &Ray, reach: Reach, beyond: Option<&Ray>) -> Vec<[f64; 2]> {
    let Some(beyond) = beyond else { return Vec::new() };
    let places = &ray.places[reach.first..=reach.last];
    let widened = |(distance_m, share): &(f64, f64)| {
        let other = share_at(&beyond.places, *distance_m)?;
        let bearing_rad =
            crossing((ray.bearing_rad, *share), (beyond.bearing_rad, other.min(RELIABLE - 1e-9)));
        Some(place_m(*distance_m, bearing_rad))
    };
    places.iter().filter_map(widened).collect()
}

/// The share at a distance between tried places; `None` beyond them.
fn share_at(places: &[(f64, f64)], distance_m: f64) -> Option<f64> {
    let above = places.partition_point(|place| place.0 < distance_m);
    let high = places.get(above)?;
    if high.0 <= distance_m {
        return Some(high.1);
    }
    let low = places[above.checked_sub(1)?];
    Some(low.1 + (distance_m - low.0) / (high.0 - low.0) * (high.1 - low.1))
}

fn is_same([x_m, y_m]: [f64; 2], [other_x_m, other_y_m]: [f64; 2]) -> bool {
    (x_m - other_x_m).abs() < 1e-6 && (y_m - other_y_m).abs() < 1e-6
}
