//! Worlds whose robots are not all alike.

use rsrs_core::conditions::{Conditions, SimulatedRobot};

use crate::contact::{Blocked, Contact};
use crate::detections::Detections;
use crate::field_of_view::FieldOfView;
use crate::robots::{Robots, WorldParameters};

/// What each robot of a world is, where they differ. Each pair is looked at, so that it is for fleets and
/// not for swarms of thousands.
pub struct Kinds {
    /// The kind of each robot; shape `[n_robots]`.
    kind_of: Vec<usize>,
    /// Shape `[n_kinds]`.
    rules: Vec<WorldParameters>,
    /// How a kind meets another; shape `[n_kinds][n_kinds]`.
    meetings: Vec<Vec<Meeting>>,
}

/// What robots of one kind have to do with those of another.
struct Meeting {
    view: FieldOfView,
    contact: Contact,
}

impl Kinds {
    /// The kinds of a world; `None` if all of its robots are alike.
    pub fn new(conditions: &Conditions) -> Option<Self> {
        if conditions.are_robots_alike() {
            return None;
        }
        let mut kinds: Vec<&SimulatedRobot> = Vec::new();
        let mut kind = |robot| {
            let robot = conditions.robot_at(robot);
            let known = kinds.iter().position(|other| *other == robot);
            known.unwrap_or_else(|| {
                kinds.push(robot);
                kinds.len() - 1
            })
        };
        let kind_of = (0..conditions.robots).map(&mut kind).collect();
        let meeting = |robot: &SimulatedRobot, other: &SimulatedRobot| Meeting {
            view: FieldOfView::upon(robot, other.radius_m),
            contact: Contact::with(robot, other),
        };
        let meetings = |robot: &&SimulatedRobot| {
            kinds.iter().map(|other| meeting(robot, other)).collect::<Vec<_>>()
        };
        let rules = kinds.iter().map(|robot| WorldParameters::of_robot(conditions, robot));
        Some(Self {
            kind_of,
            rules: rules.collect(),
            meetings: kinds.iter().map(meetings).collect(),
        })
    }

    /// The rules for one robot.
    pub fn rules_for(&self, robot: usize) -> &WorldParameters {
        &self.rules[self.kind_of[robot]]
    }

    /// The rules of all kinds.
    pub fn rules(&self) -> &[WorldParameters] {
        &self.rules
    }

    /// Finds out for every robot whether its view contains another, and whether one is in its way.
    /// Both are written for every robot, shape `[n_robots]`.
    pub fn sense(&self, robots: &Robots, (seen, blocked): (&mut [bool], &mut [Blocked])) {
        for (robot, kind) in self.kind_of.iter().enumerate() {
            let (x_m, y_m) = (robots.x_m[robot], robots.y_m[robot]);
            let (cosine, sine) = (robots.cosine[robot], robots.sine[robot]);
            let (mut is_seen, mut is_blocked) = (false, Blocked::default());
            for (other, kind_of_other) in self.kind_of.iter().enumerate() {
                let Meeting { view, contact } = &self.meetings[*kind][*kind_of_other];
                let (dx_m, dy_m) = (robots.x_m[other] - x_m, robots.y_m[other] - y_m);
                let d2_m2 = dx_m * dx_m + dy_m * dy_m;
                let forward_m = dx_m * cosine + dy_m * sine;
                let lateral_m = dy_m * cosine - dx_m * sine;
                is_seen |= view.sees(forward_m, lateral_m, d2_m2);
                is_blocked.ahead |= contact.blocks_ahead(forward_m, d2_m2);
                is_blocked.behind |= contact.blocks_behind(forward_m, d2_m2);
            }
            (seen[robot], blocked[robot]) = (is_seen, is_blocked);
        }
    }
}

/// The detections of a world in which nothing was detected yet.
pub fn detections(conditions: &Conditions) -> Detections {
    if conditions.are_robots_alike() {
        return Detections::new(conditions.robots, conditions.robot.latency_steps);
    }
    let latency = |robot| conditions.robot_at(robot).latency_steps;
    Detections::with_latencies(&(0..conditions.robots).map(latency).collect::<Vec<_>>())
}
