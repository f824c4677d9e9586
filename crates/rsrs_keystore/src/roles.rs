//! Who may publish and receive what in a secured fleet, from the table of topics.

use rsrs_msgs::topics::{self, Topic};

/// A member of a fleet: one enclave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// What runs on a robot: gate, controller, and drivers of other packages.
    Robot(String),
    /// Controllers that are not on their robots: of a simulated fleet, or of trials.
    Controllers,
    /// The simulator.
    Simulator,
    /// Who conducts runs.
    Runner,
    /// Who stops all robots: `rsrs stop`, an e-stop box.
    Stop,
    /// Who publishes poses.
    Tracker,
    /// Who looks: `RViz`, Foxglove, `ros2 topic echo`.
    Viewer,
}

/// A kind of member, as it stands in the table of publishers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`Role::Robot`], for its own topics alone.
    Robot,
    /// [`Role::Controllers`].
    Controllers,
    /// [`Role::Simulator`].
    Simulator,
    /// [`Role::Runner`].
    Runner,
    /// [`Role::Stop`].
    Stop,
    /// [`Role::Tracker`].
    Tracker,
    /// [`Role::Viewer`].
    Viewer,
}

/// What a member may do, by names of topics in DDS, with wildcards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rights {
    /// Goes before what it may publish.
    pub may_not_publish: Vec<String>,
    /// What it may publish.
    pub may_publish: Vec<String>,
    /// What it may receive.
    pub may_receive: Vec<String>,
}

const EVERYBODY: &[Kind] = &[
    Kind::Robot,
    Kind::Controllers,
    Kind::Simulator,
    Kind::Runner,
    Kind::Stop,
    Kind::Tracker,
    Kind::Viewer,
];

/// Who publishes each topic; nobody else may.
pub const PUBLISHERS: &[(Topic, &[Kind])] = &[
    (topics::DETECTION, &[Kind::Robot, Kind::Simulator]),
    (topics::CMD_VEL, &[Kind::Robot, Kind::Controllers]),
    (topics::CMD_VEL_UNSTAMPED, &[Kind::Robot, Kind::Controllers]),
    (topics::ODOM, &[Kind::Robot, Kind::Simulator]),
    (topics::POSE, &[Kind::Tracker, Kind::Simulator]),
    (topics::RANGE, &[Kind::Robot]),
    (topics::VIRTUAL_DETECTION, &[Kind::Simulator]),
    (topics::HARDWARE_CMD_VEL, &[Kind::Robot]),
    (topics::HARDWARE_CMD_VEL_UNSTAMPED, &[Kind::Robot]),
    (topics::HARDWARE_RANGE, &[Kind::Robot]),
    (topics::HARDWARE_SCAN, &[Kind::Robot]),
    (topics::STATUS, &[Kind::Robot, Kind::Controllers, Kind::Simulator]),
    (topics::CONTROLLER_STATUS, &[Kind::Robot, Kind::Controllers]),
    (topics::SIMULATOR_STATUS, &[Kind::Simulator]),
    (topics::LEASE, &[Kind::Runner]),
    (topics::E_STOP, &[Kind::Stop]),
    (topics::E_STOP_RELEASE, &[Kind::Stop]),
    (topics::E_STOP_LOCKS, &[Kind::Robot, Kind::Controllers, Kind::Simulator]),
    (topics::EXPERIMENT, &[Kind::Runner]),
    (topics::ENDING, &[Kind::Runner]),
    (topics::WORLD_DIGEST, &[Kind::Simulator]),
    (topics::RECORDED, &[Kind::Runner]),
    (topics::CLOCK, &[Kind::Simulator]),
    (topics::DIAGNOSTICS, &[Kind::Robot, Kind::Simulator]),
    (topics::TF, &[Kind::Simulator, Kind::Tracker]),
    (topics::TF_STATIC, &[Kind::Simulator, Kind::Tracker]),
    (topics::MARKERS, &[Kind::Simulator]),
    (topics::PARAMETER_EVENTS, EVERYBODY),
    (topics::ROSOUT, EVERYBODY),
];

/// On which participants announce their nodes.
const GRAPH: &str = "ros_discovery_info";
/// What the tools of `RViz` publish when a person clicks.
const CLICKS: [&str; 3] = ["rt/clicked_point", "rt/goal_pose", "rt/initialpose"];

impl Role {
    /// All members of a fleet.
    pub fn all_of(robots: &[String]) -> Vec<Self> {
        let others = [
            Self::Controllers,
            Self::Simulator,
            Self::Runner,
            Self::Stop,
            Self::Tracker,
            Self::Viewer,
        ];
        robots.iter().cloned().map(Self::Robot).chain(others).collect()
    }

    /// The name of its enclave, such as `/robot_3`.
    pub fn enclave(&self) -> String {
        let name = match self {
            Self::Robot(name) => name,
            Self::Controllers => "controllers",
            Self::Simulator => "simulator",
            Self::Runner => "runner",
            Self::Stop => "stop",
            Self::Tracker => "tracker",
            Self::Viewer => "viewer",
        };
        format!("/{name}")
    }

    fn kind(&self) -> Kind {
        match self {
            Self::Robot(_) => Kind::Robot,
            Self::Controllers => Kind::Controllers,
            Self::Simulator => Kind::Simulator,
            Self::Runner => Kind::Runner,
            Self::Stop => Kind::Stop,
            Self::Tracker => Kind::Tracker,
            Self::Viewer => Kind::Viewer,
        }
    }

    /// What it may do in a fleet of these robots.
    ///
    /// Everybody receives all topics: what a member publishes is no secret from the others, and who
    /// does not belong to the fleet receives nothing.
    pub fn rights(&self, robots: &[String]) -> Rights {
        let own: Vec<&str> = match self {
            Self::Robot(name) => vec![name],
            _ => robots.iter().map(String::as_str).collect(),
        };
        let is_own = |(_, kinds): &&(Topic, &[Kind])| kinds.contains(&self.kind());
        let published = PUBLISHERS.iter().filter(is_own).flat_map(|(topic, _)| {
            let absolute = topic.is_absolute().then(|| topic.name.to_owned());
            let relative = own.iter().filter(|_| !topic.is_absolute());
            absolute.into_iter().chain(relative.map(|robot| topic.for_robot(robot)))
        });
        let mut may_publish: Vec<String> = published.map(|name| format!("rt{name}")).collect();
        let mut may_receive = vec!["rt/*".to_owned(), GRAPH.to_owned()];
        may_publish.push(GRAPH.to_owned());
        for service in self.services(robots) {
            may_publish.push(format!("rr{service}/*Reply"));
            may_receive.push(format!("rq{service}/*Request"));
        }
        let mut may_not_publish = Vec::new();
        match self {
            // Sets parameters, and moves the simulated world.
            Self::Runner => {
                may_publish.push("rq/*Request".to_owned());
                may_receive.push("rr/*Reply".to_owned());
            }
            // Programs of other people with nodes of any name, which answer for none of ours.
            Self::Tracker | Self::Viewer => {
                let services =
                    Self::all_of(robots).into_iter().flat_map(|role| role.services(robots));
                may_not_publish = services.map(|name| format!("rr{name}/*")).collect();
                may_publish.push("rr/*Reply".to_owned());
                may_receive.push("rq/*Request".to_owned());
            }
            _ => {}
        }
        if *self == Self::Viewer {
            may_publish.extend(CLICKS.map(str::to_owned));
        }
        for names in [&mut may_publish, &mut may_not_publish] {
            names.sort();
            names.dedup();
        }
        Rights { may_not_publish, may_publish, may_receive }
    }

    /// What the services of its nodes begin with.
    fn services(&self, robots: &[String]) -> Vec<String> {
        let of_robots = |node: &str| robots.iter().map(|name| format!("/{name}{node}")).collect();
        match self {
            Self::Robot(name) => vec![format!("/{name}")],
            Self::Controllers => of_robots("/controller"),
            Self::Simulator => {
                let mut all: Vec<String> = of_robots("");
                all.push("/simulator".to_owned());
                all
            }
            Self::Runner => vec!["/experiment_runner".to_owned()],
            Self::Stop => vec!["/rsrs_stop".to_owned()],
            Self::Tracker | Self::Viewer => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn robots() -> Vec<String> {
        ["robot_1", "robot_2"].map(str::to_owned).to_vec()
    }

    fn may_publish(role: &Role) -> BTreeSet<String> {
        role.rights(&robots()).may_publish.into_iter().collect()
    }

    #[test]
    fn every_topic_has_publishers_and_the_order_of_the_table_of_topics() {
        let topics: Vec<Topic> = PUBLISHERS.iter().map(|(topic, _)| *topic).collect();

        assert_eq!(topics, topics::ALL);
        assert!(PUBLISHERS.iter().all(|(_, kinds)| !kinds.is_empty()));
    }

    #[test]
    fn a_robot_publishes_its_own_topics_and_no_lease_stop_or_clock() {
        let own = may_publish(&Role::Robot("robot_1".to_owned()));

        assert!(own.contains("rt/robot_1/detection") && own.contains("rt/robot_1/cmd_vel"));
        assert!(own.contains("rr/robot_1/*Reply"));
        let of_others = |name: &&String| name.contains("robot_2") || name.contains("rt/*");
        assert_eq!(own.iter().find(of_others), None);
        for forbidden in ["rt/swarm/lease", "rt/swarm/e_stop", "rt/clock", "rq/*Request"] {
            assert!(!own.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn only_the_runner_holds_leases_and_only_a_stop_stops() {
        let publishers = |topic: &str| -> Vec<Role> {
            let all = Role::all_of(&robots()).into_iter();
            all.filter(|role| may_publish(role).contains(topic)).collect()
        };

        assert_eq!(publishers("rt/swarm/lease"), [Role::Runner]);
        assert_eq!(publishers("rq/*Request"), [Role::Runner]);
        assert_eq!(publishers("rt/swarm/e_stop"), [Role::Stop]);
        let robot = Role::Robot("robot_1".to_owned());
        assert_eq!(publishers("rt/robot_1/cmd_vel"), [robot.clone(), Role::Controllers]);
        assert_eq!(publishers("rt/robot_1/hardware/cmd_vel"), [robot]);
    }

    #[test]
    fn trackers_and_viewers_may_have_any_name_and_answer_for_no_node_of_ours() {
        for role in [Role::Tracker, Role::Viewer] {
            let rights = role.rights(&robots());

            for node in ["rr/robot_1/*", "rr/simulator/*", "rr/experiment_runner/*"] {
                assert!(rights.may_not_publish.iter().any(|name| name == node), "{rights:?}");
            }
            assert!(rights.may_publish.contains(&"rr/*Reply".to_owned()), "{rights:?}");
            assert!(!rights.may_publish.iter().any(|name| name.starts_with("rr/robot")));
        }
        let of_robots = |name: &String| name.starts_with("rt/robot");
        assert!(!Role::Viewer.rights(&robots()).may_publish.iter().any(of_robots));
        let poses: Vec<_> = may_publish(&Role::Tracker).into_iter().filter(of_robots).collect();
        assert_eq!(poses, ["rt/robot_1/pose", "rt/robot_2/pose"]);
    }
}
