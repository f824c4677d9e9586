//! Where objects were, at the times of the samples.

use std::collections::BTreeMap;

use rsrs_core::judge::window::MAX_GAP_S;
use rsrs_core::natural_order::natural_key;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::tracker::TrackerFrame;
use rsrs_msgs::geometry_msgs::{Point, PoseStamped};
use rsrs_msgs::{RosMessage, cdr, topics};

use super::command::set_back;
use super::finding::Finding;
use super::frame_changes::FrameChanges;
use super::{TrajectoryError, clocks};
use crate::Bag;

/// Whether a time without a pose of an object is bridged, in nanoseconds.
fn is_bridged(gap_ns: u64) -> bool {
    gap_ns as f64 / 1e9 <= MAX_GAP_S
}

/// What was recorded of one object.
pub struct RecordedObject {
    pub name: String,
    /// By their stamps, in nanoseconds, where it was, in metres; not empty, and in their order.
    places: Vec<(u64, [f64; 2])>,
    /// The frames of its poses.
    pub frames: FrameChanges,
}

/// All objects that have poses, on the floor and by the clock of the robots' poses, whose stamps
/// are `poses_ns` ahead of their log times; `object_2` comes before `object_10`.
pub fn collect(
    bag: &Bag,
    poses_ns: i128,
    frame: TrackerFrame,
) -> Result<Vec<RecordedObject>, TrajectoryError> {
    let topics = bag.topics();
    let has_objects = topics.iter().filter(|topic| {
        topics::object_of(&topic.name).is_some() && topic.type_name == PoseStamped::TYPE_NAME
    });
    let names: Vec<&str> = has_objects.map(|topic| topic.name.as_str()).collect();
    let mut found: BTreeMap<String, Vec<(u64, [f64; 2])>> = BTreeMap::new();
    let (mut times_ns, mut frames) = (Vec::new(), BTreeMap::<String, FrameChanges>::new());
    if names.is_empty() {
        return Ok(Vec::new());
    }
    for message in bag.messages_on(names) {
        let message = message?;
        let name = topics::object_of(&message.topic).expect("only such topics were asked for");
        let time_s = message.log_time_ns as f64 / 1e9;
        let PoseStamped { header, pose } = cdr::decode(&message.bytes).map_err(|source| {
            TrajectoryError::Message { topic: message.topic.to_string(), time_s, source }
        })?;
        let Point { x, y, z } = pose.position;
        let [x_m, y_m, _] = frame.upright([x, y, z]);
        let Pose { x_m, y_m, .. } = frame.on_floor(Pose { x_m, y_m, heading_rad: 0.0 });
        let place_m = [x_m, y_m];
        // A tracker that has lost it says so in this way.
        if !place_m.iter().all(|at_m| at_m.is_finite()) {
            continue;
        }
        let stamp_ns = header.stamp.to_nanos().filter(|stamp_ns| *stamp_ns > 0);
        let at_ns = stamp_ns.unwrap_or(message.log_time_ns);
        times_ns.push((at_ns, message.log_time_ns));
        if !header.frame_id.is_empty() {
            let of_object = frames.entry(name.to_owned()).or_default();
            of_object.take(message.log_time_ns, &header.frame_id);
        }
        found.entry(name.to_owned()).or_default().push((at_ns, place_m));
    }
    let behind_ns = clocks::behind_poses_ns(&times_ns, poses_ns);
    let mut objects: Vec<RecordedObject> = found
        .into_iter()
        .map(|(name, mut places)| {
            for (at_ns, _) in &mut places {
                *at_ns = set_back(*at_ns, behind_ns);
            }
            places.sort_by_key(|(at_ns, _)| *at_ns);
            let frames = frames.remove(&name).unwrap_or_default();
            RecordedObject { name, places, frames }
        })
        .collect();
    objects.sort_by_cached_key(|object| natural_key(&object.name));
    Ok(objects)
}

/// An object moves this many times as far as robots are commanded, at most: their gains are 2 or less.
const MOST_PUSHED: f64 = 3.0;
/// And so much further, in metres: a tracker's noise, and a disc that rolls on when it was nudged.
const NOISE_M: f64 = 0.15;

/// Leaves out single poses that are far away from those before and behind, as a tracker has them
/// now and then; no robot was commanded more than `speed_m_s`.
///
/// # Errors
///
/// [`Finding::ObjectJump`] where an object moved so far in the run that no robot can have pushed it.
pub fn tidy(
    objects: &mut [RecordedObject],
    speed_m_s: f64,
    times_ns: &[u64],
) -> Result<Vec<Finding>, Finding> {
    let (Some(start_ns), Some(end_ns)) = (times_ns.first(), times_ns.last()) else {
        return Ok(Vec::new());
    };
    let seconds = |ns: u64| ns as f64 / 1e9;
    let distance_m =
        |[x_m, y_m]: [f64; 2], [to_x_m, to_y_m]: [f64; 2]| libm::hypot(to_x_m - x_m, to_y_m - y_m);
    let is_far = |&(from_ns, from_m): &(u64, [f64; 2]), &(to_ns, to_m): &(u64, [f64; 2])| {
        let most_m = MOST_PUSHED * speed_m_s * seconds(to_ns.abs_diff(from_ns)) + NOISE_M;
        distance_m(from_m, to_m) > most_m
    };
    let mut findings = Vec::new();
    for object in objects {
        let places = &object.places;
        // The first and the last one have those on one side only.
        let is_alone = |at: &usize| {
            let at = *at;
            let others = match at {
                0 => [1, 2],
                _ if at + 1 == places.len() => [at - 2, at - 1],
                _ => [at - 1, at + 1],
            };
            let [one, other] = others.map(|other| &places[other]);
            let is_off = |other| is_far(other, &places[at]);
            is_off(one) && is_off(other) && !is_far(one, other)
        };
        let n_places = if places.len() < 3 { 0 } else { places.len() };
        let alone: Vec<usize> = (0..n_places).filter(is_alone).collect();
        for at in alone.iter().rev() {
            object.places.remove(*at);
        }
        if !alone.is_empty() {
            let (robot, n_poses) = (object.name.clone(), alone.len());
            findings.push(Finding::Outliers { robot, n_poses });
        }
        let in_run = |pair: &&[(u64, [f64; 2])]| pair[1].0 > *start_ns && pair[0].0 < *end_ns;
        let mut pairs = object.places.windows(2).filter(in_run);
        if let Some([from, to]) = pairs.find(|pair| is_far(&pair[0], &pair[1])) {
            return Err(Finding::ObjectJump {
                object: object.name.clone(),
                by_m: distance_m(from.1, to.1),
                in_s: seconds(to.0 - from.0),
                time_s: seconds(from.0.saturating_sub(*start_ns)),
            });
        }
    }
    Ok(findings)
}

/// Where objects were at these times, in nanoseconds: sample by sample, object by object, in metres.
///
/// # Errors
///
/// [`Finding::LostObject`] where one was not seen for too long.
pub fn at(objects: &[RecordedObject], times_ns: &[u64]) -> Result<Vec<[f64; 2]>, Finding> {
    let mut places_m = Vec::with_capacity(objects.len() * times_ns.len());
    for time_ns in times_ns {
        for object in objects {
            let place_m = object.place_at(*time_ns).ok_or_else(|| Finding::LostObject {
                object: object.name.clone(),
                time_s: time_ns.saturating_sub(times_ns[0]) as f64 / 1e9,
            })?;
            places_m.push(place_m);
        }
    }
    Ok(places_m)
}

impl RecordedObject {
    /// Where it was, in metres: as it was seen then, or on the way between.
    fn place_at(&self, time_ns: u64) -> Option<[f64; 2]> {
        let next = self.places.partition_point(|(at_ns, _)| *at_ns < time_ns);
        let after = self.places.get(next);
        let before = next.checked_sub(1).map(|before| self.places[before]);
        match (before, after) {
            (_, Some((at_ns, place_m))) if *at_ns == time_ns => Some(*place_m),
            (Some((from_ns, from_m)), Some((to_ns, to_m))) => {
                let share = (time_ns - from_ns) as f64 / (to_ns - from_ns) as f64;
                let on_the_way = |axis: usize| from_m[axis] + share * (to_m[axis] - from_m[axis]);
                is_bridged(to_ns - from_ns).then(|| [on_the_way(0), on_the_way(1)])
            }
            (Some((at_ns, place_m)), None) => is_bridged(time_ns - at_ns).then_some(place_m),
            (None, Some((at_ns, place_m))) => is_bridged(at_ns - time_ns).then_some(*place_m),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_is_where_it_was_seen_or_on_the_way_and_nowhere_if_it_was_lost() {
        let second = 1_000_000_000;
        let places = vec![(second, [0.0, 1.0]), (2 * second, [1.0, 1.0]), (9 * second, [3.0, 1.0])];
        let object =
            RecordedObject { name: "object_1".to_owned(), places, frames: FrameChanges::default() };

        assert_eq!(object.place_at(2 * second), Some([1.0, 1.0]));
        assert_eq!(object.place_at(second + second / 4), Some([0.25, 1.0]));
        assert_eq!(object.place_at(0), Some([0.0, 1.0]), "it stood there before");
        assert_eq!(object.place_at(5 * second), None, "7 s without a pose");
        assert_eq!(object.place_at(12 * second), None);
        let error = at(&[object], &[2 * second, 5 * second]).unwrap_err();
        assert!(error.to_string().starts_with("object_1 was not seen for more than 2 s, 3.0 s"));
    }

    #[test]
    fn single_poses_far_away_are_left_out_and_what_no_robot_pushes_is_said() {
        let tenth = 100_000_000;
        let pushed = |at: u64| (at * tenth, [0.02 * at as f64, 1.0]);
        let times_ns: Vec<u64> = (0..20).map(|at| at * tenth).collect();
        let tidied = |change: &dyn Fn(usize, &mut [f64; 2])| {
            let mut places: Vec<(u64, [f64; 2])> = (0..20).map(pushed).collect();
            places.iter_mut().enumerate().for_each(|(at, (_, place_m))| change(at, place_m));
            let name = "object_1".to_owned();
            let mut objects = [RecordedObject { name, places, frames: FrameChanges::default() }];
            let findings = tidy(&mut objects, 0.2, &times_ns);
            (findings.map_err(|error| error.to_string()), objects[0].places.len())
        };

        assert_eq!(tidied(&|_, _| {}), (Ok(Vec::new()), 20));
        let outliers = Finding::Outliers { robot: "object_1".to_owned(), n_poses: 1 };
        for bad in [0, 7, 19] {
            let glitch =
                |at, place_m: &mut [f64; 2]| place_m[1] += if at == bad { 1.5 } else { 0.0 };
            assert_eq!(tidied(&glitch), (Ok(vec![outliers.clone()]), 19), "{bad}");
        }
        let (carried, n_places) =
            tidied(&|at, place_m| place_m[1] += if at >= 7 { 1.5 } else { 0.0 });
        assert_eq!(n_places, 20);
        let expected = "object_1 moved by 1.50 m in 0.10 s, 0.6 s after the start";
        assert!(carried.as_ref().is_err_and(|text| text.starts_with(expected)), "{carried:?}");
        let (in_mm, _) = tidied(&|_, place_m| *place_m = place_m.map(|at_m| 1000.0 * at_m));
        assert!(in_mm.is_err_and(|text| text.starts_with("object_1 moved by 20.00 m in 0.10 s")));
    }
}
