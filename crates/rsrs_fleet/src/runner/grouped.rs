//! What keeps a run from starting, each cause once, however many robots it holds.

use rsrs_msgs::topics;

use super::outcome::{Failure, Target};
use crate::preflight::{Problem, UnfitTopic};
use crate::record::LostRobot;

/// Names of robots that one line has before the rest of them are only counted.
const MOST_NAMES: usize = 12;

/// One line for each cause, in the order in which they were found.
///
/// What is wrong with several robots in the same words is one cause with several names; nine lines of
/// one sentence hide the tenth.
pub fn grouped(failures: &[Failure]) -> Vec<String> {
    let mut causes: Vec<(String, Vec<&str>)> = Vec::new();
    for failure in failures {
        let text = failure.to_string();
        let Some(robot) = failure.robot() else {
            causes.push((text, Vec::new()));
            continue;
        };
        add(&mut causes, text.replace(robot, PLACE), robot);
    }
    causes.into_iter().map(|(cause, robots)| line(&cause, &robots)).collect()
}

/// Adds a robot to its cause.
fn add<'a>(causes: &mut Vec<(String, Vec<&'a str>)>, cause: String, robot: &'a str) {
    match causes.iter_mut().find(|(other, _)| *other == cause) {
        Some((_, robots)) => robots.push(robot),
        None => causes.push((cause, vec![robot])),
    }
}

/// A cause with the names of its robots; names of topics have several in braces, as shells do.
fn line(cause: &str, robots: &[&str]) -> String {
    let names = names(robots);
    let topics = match robots.len() {
        0 | 1 => format!("/{names}/"),
        _ => format!("/{{{names}}}/"),
    };
    cause.replace(&format!("/{PLACE}/"), &topics).replace(PLACE, &names)
}

/// Why robots were lost, `robot_1, robot_4: silent for more than 1 s`, each reason once.
pub(super) fn by_reason(lost: &[LostRobot]) -> Vec<String> {
    let mut reasons = Vec::new();
    for LostRobot { robot, reason, .. } in lost {
        add(&mut reasons, reason.clone(), robot);
    }
    reasons.iter().map(|(reason, robots)| format!("{}: {reason}", names(robots))).collect()
}

/// Stands for the robot's name; no text of ours has it.
const PLACE: &str = "\u{0}";

/// Names in one line; of very many, only some.
pub(super) fn names(robots: &[&str]) -> String {
    if robots.len() <= MOST_NAMES {
        return robots.join(", ");
    }
    format!("{} and {} more", robots[..MOST_NAMES].join(", "), robots.len() - MOST_NAMES)
}

impl Failure {
    /// The robot that it is about, if it is about one.
    fn robot(&self) -> Option<&str> {
        match self {
            Self::Preflight(problem) => problem.robot(),
            Self::NotSet { target, .. } | Self::NotConfirmed { target, .. } => match target {
                Target::Robot(robot) => Some(robot),
                Target::Simulator => None,
            },
            Self::NotArmed { robot, .. }
            | Self::NoPose { robot }
            | Self::NoSample { robot, .. } => Some(robot),
            Self::Recorder { .. } => None,
        }
    }
}

impl Problem {
    /// The robot that it is about, if it is about one; that of a topic is its namespace.
    fn robot(&self) -> Option<&str> {
        match self {
            Self::RobotMissing { robot }
            | Self::LeaseNotHeld { robot }
            | Self::ControllerMissing { robot }
            | Self::Faulted { robot, .. }
            | Self::BatteryLow { robot, .. }
            | Self::BatteryUnknown { robot, .. }
            | Self::WithoutWorld { robot }
            | Self::Epoch { robot, .. }
            | Self::Setting { robot, .. }
            | Self::PoseClock { robot, .. }
            | Self::PoseUnusable { robot, .. }
            | Self::Outside { robot, .. }
            | Self::PlaceUnknown { robot }
            | Self::Clock { robot, .. } => Some(robot),
            Self::Diagnostic(diagnostic_error) => Some(&diagnostic_error.robot),
            Self::Unfit(UnfitTopic { topic, .. })
            | Self::WrongType { topic, .. }
            | Self::WrongSubscriber { topic, .. }
            | Self::NoPublisher { topic, .. }
            | Self::Renamed { topic, .. }
            | Self::NobodyObeys { topic }
            | Self::SeveralPublishers { topic, .. } => robot_of(topic),
            Self::SimulatorMissing
            | Self::Unrecordable { .. }
            | Self::StrangeObjects { .. }
            | Self::OtherRunner { .. }
            | Self::TooSlow { .. }
            | Self::Locked { .. }
            | Self::OneSpot { .. }
            | Self::Misplaced(_)
            | Self::PlacesInFrames { .. }
            | Self::Frames { .. }
            | Self::FenceFrames { .. }
            | Self::EStop { .. } => None,
        }
    }
}

/// The robot of a topic, which may have a namespace; of one that is not in the table, what stands before its last part. An
/// object is none.
fn robot_of(topic: &str) -> Option<&str> {
    if topics::object_of(topic).is_some() {
        return None;
    }
    let before_last = || Some(topic.strip_prefix('/')?.rsplit_once('/')?.0);
    topics::ALL.iter().find_map(|known| known.robot_of(topic)).or_else(before_last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(robot: usize) -> Failure {
        Problem::RobotMissing { robot: format!("robot_{robot}") }.into()
    }

    fn silent(robot: usize) -> Failure {
        Problem::NoPublisher { topic: format!("/robot_{robot}/detection"), nearest: None }.into()
    }

    #[test]
    fn a_cause_is_one_line_however_many_robots_it_holds() {
        let failures: Vec<Failure> = [Problem::SimulatorMissing.into()]
            .into_iter()
            .chain((1..=9).flat_map(|robot| [missing(robot), silent(robot)]))
            .collect();

        let lines = grouped(&failures);

        let nine =
            "robot_1, robot_2, robot_3, robot_4, robot_5, robot_6, robot_7, robot_8, robot_9";
        assert_eq!(
            lines,
            [
                "no simulator discovered".to_owned(),
                format!("{nine}: no status received"),
                format!("/{{{nine}}}/detection: no publisher"),
            ]
        );
    }

    #[test]
    fn robots_in_a_namespace_are_grouped_like_others() {
        let silent = |topic: &str| {
            Failure::from(Problem::NoPublisher { topic: topic.to_owned(), nearest: None })
        };
        let failures = [
            "/lab/robot_1/detection",
            "/lab/robot_2/detection",
            "/b/controller/status",
            "/robot_1/detection/wall",
            "/robot_2/detection/wall",
            "/objects/object_1/pose",
        ];

        assert_eq!(
            grouped(&failures.map(silent)),
            [
                "/{lab/robot_1, lab/robot_2}/detection: no publisher",
                "/b/controller/status: no publisher",
                "/{robot_1, robot_2}/detection/wall: no publisher",
                "/objects/object_1/pose: no publisher (an object of the run's world: have it tracked, or take it \
                 out of the world's file)",
            ]
        );
    }

    #[test]
    fn what_differs_is_reported_of_each_robot() {
        let faulted = |robot: &str, reason: &str| {
            let (robot, reason) = (robot.to_owned(), reason.to_owned());
            Failure::from(Problem::Faulted { robot, reason })
        };
        let failures =
            [faulted("a", "no battery"), faulted("b", "no motor"), faulted("c", "no motor")];

        assert_eq!(grouped(&failures), ["a: no battery", "b, c: no motor"]);
    }

    #[test]
    fn robots_that_are_lost_at_once_are_all_named() {
        let lost = |robot: &str, reason: &str| LostRobot {
            robot: robot.to_owned(),
            after_s: 3.0,
            reason: reason.to_owned(),
        };
        let lost = [lost("a", "silent"), lost("b", "no pose"), lost("c", "silent")];

        assert_eq!(by_reason(&lost), ["a, c: silent", "b: no pose"]);
    }

    #[test]
    fn of_very_many_robots_some_are_named() {
        let failures: Vec<Failure> = (1..=100).map(missing).collect();

        let [line] = &grouped(&failures)[..] else { panic!("one cause") };

        assert!(line.ends_with("robot_12 and 88 more: no status received"), "{line}");
    }
}
