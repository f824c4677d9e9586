//! What the runner knows of the floor beyond statuses: clocks, diagnoses, poses, the e-stop.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::unicycle::Pose;

use crate::placement::{self, StartDisc};
use crate::preflight::Ailment;

/// The floor, as heard.
#[derive(Clone, Debug, Default)]
pub(super) struct Floor {
    clock_ahead_s: BTreeMap<String, f64>,
    /// By robot and part: the diagnosis.
    ailments: BTreeMap<(String, String), String>,
    /// By robot: the frame and the last pose in it.
    poses: BTreeMap<String, (String, Pose)>,
    has_e_stop: bool,
}

impl Floor {
    pub(super) fn hear_clock(&mut self, robot: String, ahead_s: f64) {
        self.clock_ahead_s.insert(robot, ahead_s);
    }

    /// Returns what to tell the operator, if it is news of an error.
    pub(super) fn hear_diagnosis(
        &mut self,
        robot: String,
        part: String,
        error: Option<String>,
    ) -> Option<String> {
        let Some(message) = error else {
            self.ailments.remove(&(robot, part));
            return None;
        };
        let text = format!("diagnostics of {robot}: {part}: {message}");
        self.ailments.insert((robot, part), message).is_none().then_some(text)
    }

    pub(super) fn hear_pose(&mut self, robot: String, frame: String, pose: Pose) {
        self.poses.insert(robot, (frame, pose));
    }

    pub(super) fn hear_e_stop(&mut self) {
        self.has_e_stop = true;
    }

    pub(super) fn has_e_stop(&self) -> bool {
        self.has_e_stop
    }

    pub(super) fn clock_ahead_s(&self) -> BTreeMap<String, f64> {
        self.clock_ahead_s.clone()
    }

    pub(super) fn ailments(&self) -> BTreeSet<Ailment> {
        let ailments = self.ailments.iter().map(|((robot, part), message)| Ailment {
            robot: robot.clone(),
            part: part.clone(),
            message: message.clone(),
        });
        ailments.collect()
    }

    /// What to tell the operator of where the robots stand.
    pub(super) fn standing_places(&self, wanted: StartDisc, robots: &[String]) -> Vec<String> {
        let (known, unknown): (Vec<_>, Vec<_>) =
            robots.iter().partition(|robot| self.poses.contains_key(*robot));
        if known.is_empty() {
            return vec!["start poses not checked: none is heard".to_owned()];
        }
        let frames: BTreeSet<_> = known.iter().map(|robot| &self.poses[*robot].0).collect();
        if frames.len() > 1 {
            let frames: Vec<_> = frames.into_iter().map(|frame| format!("`{frame}`")).collect();
            return vec![format!(
                "start poses not checked: they are in different frames, {}",
                frames.join(", ")
            )];
        }
        let poses: Vec<_> =
            known.iter().map(|robot| ((*robot).clone(), self.poses[*robot].1)).collect();
        let deviations = placement::deviations(wanted, &poses);
        let told = unknown.iter().map(|robot| format!("{robot}: no pose heard"));
        let mut told: Vec<_> = told.chain(deviations.iter().map(ToString::to_string)).collect();
        if told.is_empty() {
            told.push(format!("all {} robots stand where they should start", robots.len()));
        }
        told
    }
}
