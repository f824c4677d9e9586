//! Who may publish and receive what in a secured fleet, from the table of topics.

use rsrs_msgs::node_kind::NodeKind;
use rsrs_msgs::node_names::{CONTROLLER, RUNNER, SIMULATOR_FULL_NAME, STOP};
use rsrs_msgs::topics::{self, Topic};

/// A member of a fleet: one enclave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Role {
    kind: Kind,
    /// Its robot, of [`Kind::Robot`] alone.
    robot: Option<String>,
}

/// A kind of member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// What runs on a robot, with its own topics alone: gate, controller, and drivers of other
    /// packages.
    Robot,
    /// Controllers that are not on their robots: of a simulated fleet, or of trials.
    Controllers,
    /// The simulator.
    Simulator,
    /// Who runs experiments.
    Runner,
    /// Who stops all robots: `rsrs stop`, an e-stop box.
    Stop,
    /// Who publishes poses.
    Tracker,
    /// Who only watches: `RViz`, Foxglove, `ros2 topic echo`.
    Viewer,
}

/// What a member may do, by names of topics in DDS, with wildcards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rights {
    /// Goes before what it may publish.
    pub may_not_publish: Vec<String>,
    /// Goes before what it may receive.
    pub may_not_receive: Vec<String>,
    /// What it may publish.
    pub may_publish: Vec<String>,
    /// What it may receive.
    pub may_receive: Vec<String>,
}

impl Kind {
    const ALL: [Self; 7] = [
        Self::Robot,
        Self::Controllers,
        Self::Simulator,
        Self::Runner,
        Self::Stop,
        Self::Tracker,
        Self::Viewer,
    ];

    /// The nodes that run in its enclave.
    const fn nodes(self) -> &'static [NodeKind] {
        match self {
            Self::Robot => &[
                NodeKind::Robot,
                NodeKind::Controller,
                NodeKind::BaseDriver,
                NodeKind::SensorDriver,
            ],
            Self::Controllers => &[NodeKind::Controller],
            Self::Simulator => &[NodeKind::Simulator],
            Self::Runner => &[NodeKind::Runner],
            Self::Stop => &[NodeKind::Stop],
            Self::Tracker => &[NodeKind::Tracker],
            Self::Viewer => &[NodeKind::Viewer],
        }
    }

    /// Whether any of its nodes is among these.
    fn is_among(self, nodes: &[NodeKind]) -> bool {
        self.nodes().iter().any(|node| nodes.contains(node))
    }
}

/// On which participants announce their nodes.
const GRAPH: &str = "ros_discovery_info";
/// What the tools of `RViz` publish when a person clicks.
const CLICKS: [&str; 3] = ["rt/clicked_point", "rt/goal_pose", "rt/initialpose"];

impl Role {
    /// All members of a fleet.
    pub fn all_of(robots: &[String]) -> Vec<Self> {
        let others = Kind::ALL.into_iter().filter(|kind| *kind != Kind::Robot);
        let of_robots = robots.iter().map(|name| Self::of_robot(name));
        of_robots.chain(others.map(Self::on_no_robot)).collect()
    }

    /// Whether a robot of this name would have rights of another member: its enclave's name, or the
    /// namespace of its topics or services.
    pub fn is_taken(robot: &str) -> bool {
        let first = robot.split('/').next().unwrap_or_default();
        let of_swarm = topics::ALL.iter().filter(|topic| topic.is_absolute());
        let mut names = of_swarm.filter_map(|topic| topic.name.split('/').nth(1));
        let is_of = |role: Self| {
            let mut namespaces = role.services(&[]).into_iter().chain([role.enclave()]);
            namespaces.any(|name| name.trim_start_matches('/') == first)
        };
        names.any(|name| name == first) || Self::all_of(&[]).into_iter().any(is_of)
    }

    /// The member on this robot.
    pub fn of_robot(name: &str) -> Self {
        Self { kind: Kind::Robot, robot: Some(name.to_owned()) }
    }

    /// The member of a kind that is on no robot.
    ///
    /// # Panics
    ///
    /// For [`Kind::Robot`], whose members have names: [`Role::of_robot`].
    pub fn on_no_robot(kind: Kind) -> Self {
        assert_ne!(kind, Kind::Robot, "a robot's member has its name");
        Self { kind, robot: None }
    }

    /// The name of its enclave, such as `/robot_3`.
    pub fn enclave(&self) -> String {
        let name = match self.kind {
            Kind::Robot => self.robot_name(),
            Kind::Controllers => "controllers",
            Kind::Simulator => "simulator",
            Kind::Runner => "runner",
            Kind::Stop => "stop",
            Kind::Tracker => "tracker",
            Kind::Viewer => "viewer",
        };
        format!("/{name}")
    }

    fn robot_name(&self) -> &str {
        self.robot.as_deref().expect("a member on a robot is made with its name")
    }

    /// What it may do in a fleet of these robots.
    ///
    /// What a member receives, its thief reads. A robot and a tracker receive what concerns all, and no other
    /// robot's topics; who conducts, moves, stops or watches robots receives all.
    pub fn rights(&self, robots: &[String]) -> Rights {
        let own: Vec<&str> = match self.kind {
            Kind::Robot => vec![self.robot_name()],
            _ => robots.iter().map(String::as_str).collect(),
        };
        let is_own = |topic: &&Topic| self.kind.is_among(topic.publishers);
        let published = topics::ALL.iter().filter(is_own).flat_map(|topic| {
            let absolute = topic.is_absolute().then(|| topic.name.to_owned());
            let relative = own.iter().filter(|_| !topic.is_absolute());
            absolute.into_iter().chain(relative.map(|robot| topic.for_robot(robot)))
        });
        let mut may_publish: Vec<String> = published.map(|name| format!("rt{name}")).collect();
        let mut may_receive = self.received(robots);
        may_publish.push(GRAPH.to_owned());
        for service in self.services(robots) {
            may_publish.push(format!("rr{service}/*Reply"));
            may_receive.push(format!("rq{service}/*Request"));
        }
        let (mut may_not_publish, mut may_not_receive) = (Vec::new(), Vec::new());
        match self.kind {
            // Sets parameters, and moves the simulated world.
            Kind::Runner => {
                may_publish.push("rq/*Request".to_owned());
                may_receive.push("rr/*Reply".to_owned());
            }
            // Programs of other people with nodes of any name, which answer for none of ours, and are not
            // asked what those are.
            Kind::Tracker | Kind::Viewer => {
                let services =
                    Self::all_of(robots).into_iter().flat_map(|role| role.services(robots));
                for name in services {
                    may_not_publish.push(format!("rr{name}/*"));
                    may_not_receive.push(format!("rq{name}/*"));
                }
                may_publish.push("rr/*Reply".to_owned());
                may_receive.push("rq/*Request".to_owned());
            }
            _ => {}
        }
        if self.kind == Kind::Viewer {
            may_publish.extend(CLICKS.map(str::to_owned));
        }
        for names in [&mut may_publish, &mut may_not_publish, &mut may_not_receive] {
            names.sort();
            names.dedup();
        }
        Rights { may_not_publish, may_not_receive, may_publish, may_receive }
    }

    /// Topics that it may receive.
    fn received(&self, robots: &[String]) -> Vec<String> {
        let pose = |robot: &String| format!("rt{}", topics::POSE.for_robot(robot));
        let own: Vec<String> = match self.kind {
            Kind::Robot => vec![format!("rt/{}/*", self.robot_name())],
            Kind::Tracker => {
                let of_all = format!("rt{}", topics::NAMED_POSES.name);
                robots.iter().map(pose).chain([of_all]).collect()
            }
            _ => return vec!["rt/*".to_owned(), GRAPH.to_owned()],
        };
        // What the nodes on robots need; those of a tracker need the same.
        let is_of_all =
            |topic: &&Topic| topic.is_absolute() && Kind::Robot.is_among(topic.subscribers);
        let of_all = topics::ALL.iter().filter(is_of_all);
        let of_all = of_all.map(|topic| format!("rt{}", topic.name));
        of_all.chain(own).chain([GRAPH.to_owned()]).collect()
    }

    /// What the services of its nodes begin with.
    fn services(&self, robots: &[String]) -> Vec<String> {
        let of_robots = |node: &str| robots.iter().map(|name| format!("/{name}{node}")).collect();
        match self.kind {
            Kind::Robot => vec![format!("/{}", self.robot_name())],
            Kind::Controllers => of_robots(&format!("/{CONTROLLER}")),
            Kind::Simulator => {
                let mut all: Vec<String> = of_robots("");
                all.push(SIMULATOR_FULL_NAME.to_owned());
                all
            }
            Kind::Runner => vec![format!("/{RUNNER}")],
            Kind::Stop => vec![format!("/{STOP}")],
            Kind::Tracker | Kind::Viewer => Vec::new(),
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

    fn role(kind: Kind) -> Role {
        Role { kind, robot: None }
    }

    fn may_publish(role: &Role) -> BTreeSet<String> {
        role.rights(&robots()).may_publish.into_iter().collect()
    }

    #[test]
    fn a_robot_publishes_its_own_topics_and_no_lease_stop_or_clock() {
        let own = may_publish(&Role::of_robot("robot_1"));

        assert!(own.contains("rt/robot_1/detection") && own.contains("rt/robot_1/cmd_vel"));
        assert!(own.contains("rr/robot_1/*Reply"));
        let of_others = |name: &&String| name.contains("robot_2") || name.contains("rt/*");
        assert_eq!(own.iter().find(of_others), None);
        for forbidden in ["rt/swarm/lease", "rt/swarm/e_stop", "rt/clock", "rq/*Request"] {
            assert!(!own.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn a_robot_receives_what_concerns_all_and_nothing_of_another_robot() {
        for role in [Role::of_robot("robot_1"), role(Kind::Tracker)] {
            let received = role.rights(&robots()).may_receive;

            let of_robot =
                |name: &&String| name.starts_with("rt/robot_2/") && !name.ends_with("/pose");
            assert_eq!(received.iter().find(of_robot), None);
            let mut of_swarm: Vec<&str> =
                received.iter().filter_map(|name| name.strip_prefix("rt/")).collect();
            of_swarm.retain(|name| !name.starts_with("robot") && *name != "poses");
            // Log lines, health and the record of a run are for who conducts and watches.
            let expected = [
                "swarm/lease",
                "swarm/e_stop",
                "swarm/e_stop_release",
                "swarm/e_stop_locks",
                "clock",
                "tf",
                "tf_static",
                "parameter_events",
            ];
            assert_eq!(of_swarm, expected);
            let is_tracker = role.kind == Kind::Tracker;
            assert_eq!(received.iter().any(|name| name == "rt/poses"), is_tracker);
        }
        assert!(role(Kind::Viewer).rights(&robots()).may_receive.contains(&"rt/*".to_owned()));
    }

    #[test]
    fn only_the_runner_holds_leases_and_only_a_stop_stops() {
        let publishers = |topic: &str| -> Vec<Role> {
            let all = Role::all_of(&robots()).into_iter();
            all.filter(|role| may_publish(role).contains(topic)).collect()
        };

        assert_eq!(publishers("rt/swarm/lease"), [role(Kind::Runner)]);
        assert_eq!(publishers("rq/*Request"), [role(Kind::Runner)]);
        assert_eq!(publishers("rt/swarm/e_stop"), [role(Kind::Stop)]);
        let robot = Role::of_robot("robot_1");
        assert_eq!(publishers("rt/robot_1/cmd_vel"), [robot.clone(), role(Kind::Controllers)]);
        assert_eq!(publishers("rt/robot_1/hardware/cmd_vel"), [robot]);
    }

    #[test]
    fn trackers_and_viewers_may_have_any_name_and_answer_for_no_node_of_ours() {
        for kind in [Kind::Tracker, Kind::Viewer] {
            let rights = role(kind).rights(&robots());

            for node in ["rr/robot_1/*", "rr/simulator/*", "rr/experiment_runner/*"] {
                assert!(rights.may_not_publish.iter().any(|name| name == node), "{rights:?}");
            }
            // What the runner asks of robots is for them.
            assert!(rights.may_not_receive.contains(&"rq/robot_1/*".to_owned()), "{rights:?}");
            assert!(rights.may_publish.contains(&"rr/*Reply".to_owned()), "{rights:?}");
            assert!(!rights.may_publish.iter().any(|name| name.starts_with("rr/robot")));
        }
        let of_robots = |name: &String| name.starts_with("rt/robot");
        assert!(!role(Kind::Viewer).rights(&robots()).may_publish.iter().any(of_robots));
        let poses: Vec<_> =
            may_publish(&role(Kind::Tracker)).into_iter().filter(of_robots).collect();
        assert_eq!(poses, ["rt/robot_1/pose", "rt/robot_2/pose"]);
    }
}
