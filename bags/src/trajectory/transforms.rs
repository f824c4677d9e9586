//! Transforms of robots' bodies, followed up to the frame that all robots share.

use std::collections::HashMap;

use rsrs_msgs::geometry_msgs::{Quaternion, Transform, Vector3};
use rsrs_msgs::tf2_msgs::{MAX_CHAIN, TFMessage};

use super::pose::{self, RawPose};

/// The frames of a bag, each in its parent as it was last received.
///
/// A localisation that moves `map` to `odom` seldom is taken as it last was: between two of its
/// messages nothing is interpolated.
#[derive(Clone, Default)]
pub struct Tree {
    edges: HashMap<String, Edge>,
}

/// A frame in its parent.
#[derive(Clone)]
struct Edge {
    parent: String,
    transform: Transform,
}

impl Tree {
    /// The poses of the robots' bodies in a message, each in the frame at the upper end of its
    /// chain, such as `map` for `map` → `robot_1/odom` → `robot_1/base_link`. A body that is fixed
    /// to another one of the same robot (`base_footprint` → `base_link`) has none of its own.
    ///
    /// With a `parent`, chains are followed to that frame, and bodies that do not lead there are
    /// left out. `robot_of` a frame is the robot whose body it is.
    pub fn take(
        &mut self,
        message: TFMessage,
        robot_of: &dyn Fn(&str) -> Option<String>,
        parent: Option<&str>,
    ) -> Vec<RawPose> {
        for transform in &message.transforms {
            let child = plain(&transform.child_frame_id);
            match self.edges.get_mut(child) {
                // As nearly always: nothing but numbers is new.
                Some(known) if known.parent == transform.header.frame_id => {
                    known.transform = transform.transform;
                }
                _ => {
                    let parent = transform.header.frame_id.clone();
                    let edge = Edge { parent, transform: transform.transform };
                    self.edges.insert(child.to_owned(), edge);
                }
            }
        }
        let bodies = pose::of_transforms(message, robot_of).into_iter();
        bodies
            .filter(|body| robot_of(plain(&body.frame)).is_none())
            .filter_map(|body| self.lift(body, parent.map(plain)))
            .collect()
    }

    /// Whether the frame leads up to another one.
    pub fn leads(&self, frame: &str, to: &str) -> bool {
        let mut frame = plain(frame);
        for _ in 0..MAX_CHAIN {
            if frame == plain(to) {
                return true;
            }
            let Some(edge) = self.edges.get(frame) else { return false };
            frame = plain(&edge.parent);
        }
        false
    }

    /// The same pose in the frame at the upper end of the chain, or in the one that it leads to.
    fn lift(&self, mut body: RawPose, parent: Option<&str>) -> Option<RawPose> {
        for _ in 0..MAX_CHAIN {
            if parent == Some(plain(&body.frame)) {
                return Some(body);
            }
            let Some(edge) = self.edges.get(plain(&body.frame)) else { break };
            let turn = &edge.transform.rotation;
            let turned = rotated(turn, &body.position);
            let offset = &edge.transform.translation;
            body.position =
                Vector3 { x: offset.x + turned.x, y: offset.y + turned.y, z: offset.z + turned.z };
            body.orientation = product(turn, &body.orientation);
            body.frame.clone_from(&edge.parent);
        }
        parent.is_none().then_some(body)
    }
}

/// A frame without the slash that older nodes put in front, as tf2 compares them.
pub(super) fn plain(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

/// One rotation after another, the right one first.
fn product(left: &Quaternion, right: &Quaternion) -> Quaternion {
    let (a, b) = (left, right);
    Quaternion {
        x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    }
}

fn rotated(turn: &Quaternion, point: &Vector3) -> Vector3 {
    let as_quaternion = Quaternion { x: point.x, y: point.y, z: point.z, w: 0.0 };
    let back = Quaternion { x: -turn.x, y: -turn.y, z: -turn.z, w: turn.w };
    let Quaternion { x, y, z, .. } = product(&product(turn, &as_quaternion), &back);
    Vector3 { x, y, z }
}
