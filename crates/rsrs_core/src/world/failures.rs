//! Robots that fail at a time, as they are in files.

use serde::{Deserialize, Serialize};

use super::WorldFile;
use super::problem::{Place, WorldFlaw, WorldProblem, within};
use crate::quantity::Bounds;

/// A failure of a robot, or of several that are drawn; give `robot` or `count`, and what fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    /// Which robot, by its number from 1, as in `robot_3`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<usize>,
    /// How many robots: each replicate draws them anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// When, in seconds from the start.
    pub at_s: f64,
    /// Whether it stands still from then on, whatever it is commanded.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stops: bool,
    /// Whether its sensors report from then on what they reported then.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sensors_stick: bool,
}

/// When a failure may be, in seconds: within the longest run.
const AT: Bounds = Bounds { least: 0.0, most: 604_800.0 };
/// Numbers of robots; more are a mistake.
const ROBOTS: Bounds = Bounds { least: 1.0, most: 1e9 };

impl Failure {
    pub(super) fn check(&self) -> Result<(), WorldProblem> {
        within("at_s", self.at_s, AT)?;
        match (self.robot, self.count) {
            (Some(robot), None) => within("robot", robot as f64, ROBOTS)?,
            (None, Some(count)) => within("count", count as f64, ROBOTS)?,
            _ => return Err(WorldProblem::WhoFails),
        }
        if self.stops || self.sensors_stick {
            return Ok(());
        }
        Err(WorldProblem::WhatFails)
    }
}

impl WorldFile {
    /// Whether so many robots can fail as a checked world says.
    pub fn check_failures_of(&self, robots: usize) -> Result<(), WorldFlaw> {
        let wrong = |failure: &Failure| {
            failure.robot.is_some_and(|robot| robot > robots)
                || failure.count.is_some_and(|count| count > robots)
        };
        match self.failures.iter().position(wrong) {
            None => Ok(()),
            Some(place) => {
                let Failure { robot, count, .. } = self.failures[place];
                let problem = match robot {
                    Some(robot) => WorldProblem::NoSuchRobot { robot, robots },
                    None => WorldProblem::TooManyFail { count: count.unwrap_or(0), robots },
                };
                Err(WorldFlaw { place: Place::Failure(place), problem })
            }
        }
    }
}
