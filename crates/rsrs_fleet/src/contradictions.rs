//! Readings of which one at most can be true, as their sensor tells kinds of things from each other, and that come
//! true together, for the operator of a run.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_msgs::topics;

/// So many detections in a row must contradict a further reading: two topics of one moment may come the other way
/// round.
const IN_A_ROW: u32 = 3;

/// What the robots of a run report.
#[derive(Clone, Debug, Default)]
pub struct Contradictions {
    names: ReadingNames,
    robots: BTreeMap<String, Reported>,
}

#[derive(Clone, Debug, Default)]
struct Reported {
    newest: Readings,
    /// Detections in a row that could not be.
    n_in_a_row: u32,
    /// Of which it was said.
    said: BTreeSet<(usize, usize)>,
}

impl Contradictions {
    /// Robots with these readings, of which nothing was received.
    pub fn new(names: ReadingNames) -> Self {
        Self { names, robots: BTreeMap::new() }
    }

    /// Takes a further reading.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    pub fn on_further(&mut self, robot: &str, reading: &str, is_true: bool) {
        if let Some(place) = self.names.place(reading) {
            self.robots.entry(robot.to_owned()).or_default().newest.set(place, is_true);
        }
    }

    /// Takes a detection, after the further readings of its time, and returns what cannot be, once
    /// for each two readings of a robot.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    pub fn on_detection(&mut self, robot: &str, is_true: bool) -> Option<String> {
        if self.names.is_detection() {
            return None;
        }
        let reported = self.robots.entry(robot.to_owned()).or_default();
        reported.newest.set(0, is_true);
        let pair = contradiction(&self.names, reported.newest);
        reported.n_in_a_row = if pair.is_some() { reported.n_in_a_row + 1 } else { 0 };
        let pair = pair.filter(|_| reported.n_in_a_row >= IN_A_ROW)?;
        if !reported.said.insert(pair) {
            return None;
        }
        let topic = |place: usize| match self.names.iter().nth(place) {
            Some(name) if place > 0 => topics::further_detection(robot, name),
            _ => topics::DETECTION.for_robot(robot),
        };
        Some(in_words(robot, [topic(pair.0), topic(pair.1)]))
    }
}

/// That two topics of a robot contradict each other, of which the first counts.
pub fn in_words(robot: &str, [first, second]: [String; 2]) -> String {
    format!(
        "{robot}: {first} and {second} are true at once, and one at most can be, because one sensor tells them apart \
         (`one_of` of the profile): {first} counts; mend who publishes them"
    )
}

/// Two readings of one sensor that are both true, the one that counts first.
fn contradiction(names: &ReadingNames, found: Readings) -> Option<(usize, usize)> {
    let possible = names.possible(found);
    let second = (0..names.n_readings()).find(|it| found.has(*it) && !possible.has(*it))?;
    let first = (0..second).find(|it| {
        let mut alone = Readings::default();
        alone.set(*it, true);
        alone.set(second, true);
        found.has(*it) && names.possible(alone) != alone
    })?;
    Some((first, second))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> ReadingNames {
        let sensors = [vec!["detection", "wall"], vec!["left"], vec!["goal", "object"]];
        ReadingNames::new(sensors.map(|names| names.into_iter().map(str::to_owned).collect()))
    }

    #[test]
    fn readings_of_one_sensor_that_stay_true_together_are_said_once_for_each_robot() {
        let mut contradictions = Contradictions::new(names());
        let mut said = Vec::new();
        for _ in 0..10 {
            for robot in ["robot_1", "robot_2"] {
                contradictions.on_further(robot, "wall", true);
                contradictions.on_further(robot, "left", true);
                said.extend(contradictions.on_detection(robot, robot == "robot_1"));
            }
        }
        for _ in 0..10 {
            contradictions.on_further("robot_2", "goal", true);
            contradictions.on_further("robot_2", "object", true);
            said.extend(contradictions.on_detection("robot_2", false));
        }

        let of_which =
            |text: &String| text.split(" are true").next().unwrap_or_default().to_owned();
        let of_which: Vec<String> = said.iter().map(of_which).collect();
        assert_eq!(
            of_which,
            [
                "robot_1: /robot_1/detection and /robot_1/detection/wall",
                "robot_2: /robot_2/detection/goal and /robot_2/detection/object",
            ]
        );
    }

    #[test]
    fn a_message_that_comes_late_is_no_contradiction() {
        let mut contradictions = Contradictions::new(names());

        for step in 0..20 {
            let sees_wall = step % 2 == 0;
            // The wall's reading of this step comes after the detection.
            assert_eq!(contradictions.on_detection("robot_1", !sees_wall), None, "{step}");
            contradictions.on_further("robot_1", "wall", sees_wall);
        }
        let mut single = Contradictions::new(ReadingNames::default());
        assert_eq!(single.on_detection("robot_1", true), None);
    }
}
