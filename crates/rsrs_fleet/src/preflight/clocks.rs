//! Clocks that are not ours.
//!
//! Nothing on a robot depends on them. Recorded stamps do, and whoever reads a bag puts those of several
//! clocks on one by when they were received; that takes clocks that go evenly, and not right ones.

use std::collections::BTreeMap;
use std::fmt;

use super::{Expected, Seen};
use crate::timing::{CLOCK_LOOK, MAX_CLOCK_CHANGE, MAX_CLOCK_SKEW};

/// How far a clock is ahead of ours, by the stamps that it makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockLead {
    /// Its lead, in seconds; negative behind ours.
    pub ahead_s: f64,
    /// By how much that has changed since it was received first, in seconds; `None` if that was less
    /// than [`CLOCK_LOOK`] ago.
    pub change_s: Option<f64>,
}

impl ClockLead {
    /// Whether it is another clock than ours.
    pub fn is_apart(&self) -> bool {
        self.ahead_s.abs() > MAX_CLOCK_SKEW.as_secs_f64()
    }

    /// Whether it goes as ours does, so that its stamps can be aligned.
    pub fn is_steady(&self) -> bool {
        self.change_s.is_some_and(|change_s| change_s.abs() <= MAX_CLOCK_CHANGE.as_secs_f64())
    }

    /// What is wrong with a clock that is not steady.
    pub(super) fn unsteady(&self) -> String {
        match self.change_s {
            Some(change_s) => format!(
                "it has changed by {:.1} s since it was received first, so its stamps cannot be \
                 aligned",
                change_s.abs()
            ),
            None => format!(
                "its stamps have not come for {} s yet, by which they would be aligned",
                CLOCK_LOOK.as_secs()
            ),
        }
    }
}

impl fmt::Display for ClockLead {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.ahead_s > 0.0 { "ahead of" } else { "behind" };
        write!(formatter, "{:.1} s {side}", self.ahead_s.abs())
    }
}

/// Notes for the operator on clocks that are not ours, each with all robots that it is of.
pub(crate) fn notes(expected: &Expected, seen: &Seen) -> Vec<String> {
    let clocks = groups(&expected.robots, &seen.clocks).into_iter().map(|(lead, robots)| {
        format!("note: {robots}: clock {lead} ours; stamps are aligned by when they are received")
    });
    let poses = groups(&expected.robots, &seen.pose_clocks).into_iter().map(|(lead, robots)| {
        format!(
            "note: {robots}: poses are stamped {lead} our clock; they are aligned by when they are \
             received"
        )
    });
    clocks.chain(poses).collect()
}

/// Clocks that are not ours, with the names of their robots: one tracker stamps the poses of all.
fn groups(robots: &[String], clocks: &BTreeMap<String, ClockLead>) -> Vec<(ClockLead, String)> {
    let mut groups: Vec<(ClockLead, Vec<&str>)> = Vec::new();
    for robot in robots {
        let Some(lead) = clocks.get(robot).filter(|lead| lead.is_apart()) else { continue };
        let is_same = |other: &ClockLead| {
            (other.ahead_s - lead.ahead_s).abs() <= MAX_CLOCK_CHANGE.as_secs_f64()
        };
        match groups.iter_mut().find(|(other, _)| is_same(other)) {
            Some((_, robots)) => robots.push(robot),
            None => groups.push((*lead, vec![robot])),
        }
    }
    groups.into_iter().map(|(lead, robots)| (lead, robots.join(", "))).collect()
}
