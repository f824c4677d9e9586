//! What must be there before anything is set or moved; every problem is named at once.

use std::collections::{BTreeMap, BTreeSet};

use crate::message::{RobotState, Status};

/// What an experiment needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    /// The robots.
    pub robots: Vec<String>,
    /// Whether a simulator must be there.
    pub simulator: bool,
    /// The topics it reads and writes.
    pub topics: Vec<ExpectedTopic>,
}

/// A topic that an experiment needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedTopic {
    /// Full name: `/robot_1/detection`.
    pub name: String,
    /// Type: `std_msgs/msg/Bool`.
    pub type_name: String,
    /// How many may publish it.
    pub publishers: Publishers,
}

/// How many publishers a topic must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Publishers {
    /// Exactly one.
    One,
    /// Any number, none included.
    Any,
}

/// The part of the discovery database that preflight looks at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// All publishers of all topics.
    pub publishers: Vec<Publisher>,
    /// Whether the simulator's node is there.
    pub simulator: bool,
}

/// One publisher.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publisher {
    /// Full name of its topic.
    pub topic: String,
    /// Type of its topic.
    pub type_name: String,
}

/// What is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Discovered endpoints.
    pub graph: Graph,
    /// Last status of each robot that was heard.
    pub robots: BTreeMap<String, Status>,
    /// Controllers that were heard, by robot.
    pub controllers: BTreeSet<String>,
    /// Runs of other runners whose leases are heard now.
    pub other_runs: BTreeSet<String>,
    /// Whether the e-stop is engaged.
    pub e_stop: bool,
}

/// One reason not to start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// No status of a robot.
    #[error("{robot}: no status heard")]
    RobotMissing {
        /// The robot.
        robot: String,
    },
    /// No status of a controller.
    #[error("{robot}: no status of its controller heard")]
    ControllerMissing {
        /// The robot.
        robot: String,
    },
    /// No simulator.
    #[error("no simulator discovered")]
    SimulatorMissing,
    /// A topic has another type than expected; the middleware would never match it.
    #[error("{topic}: type is {found}, expected {expected}")]
    WrongType {
        /// The topic.
        topic: String,
        /// The type found.
        found: String,
        /// The type expected.
        expected: String,
    },
    /// A topic that must have one publisher has none or several.
    #[error("{topic}: {found} publishers, expected 1")]
    NotOnePublisher {
        /// The topic.
        topic: String,
        /// Publishers found, of the right type.
        found: usize,
    },
    /// Another runner is at work.
    #[error("another runner is active, run {run_id}")]
    OtherRunner {
        /// Its run.
        run_id: String,
    },
    /// A robot's hardware has failed.
    #[error("{robot}: {reason}")]
    Faulted {
        /// The robot.
        robot: String,
        /// What it says.
        reason: String,
    },
    /// The e-stop is engaged.
    #[error("the e-stop is engaged")]
    EStop,
}

/// Every reason not to start, in the order in which a person would look.
///
/// # Arguments
///
/// * `expected` — what the experiment needs.
/// * `seen` — what is there.
///
/// # Returns
///
/// All problems; none if the experiment can start.
pub fn problems(expected: &Expected, seen: &Seen) -> Vec<Problem> {
    let mut problems = Vec::new();
    if seen.e_stop {
        problems.push(Problem::EStop);
    }
    problems.extend(seen.other_runs.iter().map(|run| Problem::OtherRunner { run_id: run.clone() }));
    if expected.simulator && !seen.graph.simulator {
        problems.push(Problem::SimulatorMissing);
    }
    for robot in &expected.robots {
        problems.extend(of_robot(robot, seen));
    }
    for topic in &expected.topics {
        problems.extend(of_topic(topic, &seen.graph));
    }
    problems
}

fn of_robot(robot: &str, seen: &Seen) -> Vec<Problem> {
    let named = || robot.to_owned();
    let mut problems = Vec::new();
    match seen.robots.get(robot) {
        None => problems.push(Problem::RobotMissing { robot: named() }),
        Some(status) if status.state == RobotState::Fault => {
            problems.push(Problem::Faulted { robot: named(), reason: status.stop_reason.clone() });
        }
        Some(_) => {}
    }
    if !seen.controllers.contains(robot) {
        problems.push(Problem::ControllerMissing { robot: named() });
    }
    problems
}

fn of_topic(topic: &ExpectedTopic, graph: &Graph) -> Vec<Problem> {
    let publishers = graph.publishers.iter().filter(|publisher| publisher.topic == topic.name);
    let (right, wrong): (Vec<_>, Vec<_>) =
        publishers.partition(|publisher| publisher.type_name == topic.type_name);
    let found_types: BTreeSet<_> = wrong.iter().map(|publisher| &publisher.type_name).collect();
    let mut problems: Vec<_> = found_types
        .into_iter()
        .map(|found| Problem::WrongType {
            topic: topic.name.clone(),
            found: found.clone(),
            expected: topic.type_name.clone(),
        })
        .collect();
    let explained = right.is_empty() && !wrong.is_empty();
    if topic.publishers == Publishers::One && right.len() != 1 && !explained {
        problems.push(Problem::NotOnePublisher { topic: topic.name.clone(), found: right.len() });
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Expected {
        Expected {
            robots: vec!["robot_1".to_owned(), "robot_2".to_owned()],
            simulator: true,
            topics: ["/robot_1/cmd_vel", "/robot_2/cmd_vel"]
                .map(|name| ExpectedTopic {
                    name: name.to_owned(),
                    type_name: "geometry_msgs/msg/TwistStamped".to_owned(),
                    publishers: Publishers::One,
                })
                .to_vec(),
        }
    }

    fn publisher(topic: &str, type_name: &str) -> Publisher {
        Publisher { topic: topic.to_owned(), type_name: format!("geometry_msgs/msg/{type_name}") }
    }

    fn status(state: RobotState, stop_reason: &str) -> Status {
        Status {
            counter: 1,
            epoch: 0,
            parameter_digest: 0,
            state,
            stop_reason: stop_reason.to_owned(),
            battery_v: f32::NAN,
        }
    }

    fn complete() -> Seen {
        let names = ["robot_1".to_owned(), "robot_2".to_owned()];
        Seen {
            graph: Graph {
                publishers: vec![
                    publisher("/robot_1/cmd_vel", "TwistStamped"),
                    publisher("/robot_2/cmd_vel", "TwistStamped"),
                ],
                simulator: true,
            },
            robots: names.clone().map(|name| (name, status(RobotState::Idle, ""))).into(),
            controllers: names.into(),
            ..Seen::default()
        }
    }

    #[test]
    fn a_complete_fleet_has_no_problem() {
        assert_eq!(problems(&expected(), &complete()), []);
    }

    #[test]
    fn every_problem_is_named_at_once() {
        let mut seen = complete();
        seen.graph.simulator = false;
        seen.graph.publishers = vec![
            publisher("/robot_1/cmd_vel", "Twist"),
            publisher("/robot_2/cmd_vel", "TwistStamped"),
            publisher("/robot_2/cmd_vel", "TwistStamped"),
        ];
        seen.robots.remove("robot_1");
        seen.robots.insert("robot_2".to_owned(), status(RobotState::Fault, "motor driver hot"));
        seen.controllers.remove("robot_2");
        seen.other_runs.insert("other".to_owned());
        seen.e_stop = true;

        let sentences: Vec<_> =
            problems(&expected(), &seen).iter().map(ToString::to_string).collect();

        assert_eq!(
            sentences,
            [
                "the e-stop is engaged",
                "another runner is active, run other",
                "no simulator discovered",
                "robot_1: no status heard",
                "robot_2: motor driver hot",
                "robot_2: no status of its controller heard",
                "/robot_1/cmd_vel: type is geometry_msgs/msg/Twist, expected \
                 geometry_msgs/msg/TwistStamped",
                "/robot_2/cmd_vel: 2 publishers, expected 1",
            ]
        );
    }

    #[test]
    fn a_topic_that_nobody_publishes_is_a_problem() {
        let mut seen = complete();
        seen.graph.publishers.pop();

        assert_eq!(
            problems(&expected(), &seen),
            [Problem::NotOnePublisher { topic: "/robot_2/cmd_vel".to_owned(), found: 0 }]
        );
    }
}
