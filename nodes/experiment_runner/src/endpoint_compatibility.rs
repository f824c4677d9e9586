//! Whether the ends of topics fit each other: those that do not are silent.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_fleet::fleet_file::CmdVel;
use rsrs_fleet::parameters::gate::{ROS_CMD_VEL_TYPE, ROS_SENSOR_TOPIC, ROS_SENSOR_TYPE};
use rsrs_fleet::preflight::{UnfitTopic, commands_as};
use rsrs_msgs::node_names::SIMULATOR_FULL_NAME;
use rsrs_msgs::topics::{self, Durability, Qos, Reliability, Topic};
use rsrs_ros::session::{Endpoint, EndpointKind};

/// Who publishes or subscribes, where nothing names it.
const UNNAMED: &str = "a program without a name";
/// Bytes of an identity that name the participant.
const PARTICIPANT: usize = 12;
/// How identities begin in our middleware, whose reliable subscriptions receive best-effort
/// publishers, too.
const OUR_VENDOR: [u8; 2] = [1, 0x12];

/// Topics by which robots are steered: who receives nothing there does not move.
const STEERING: [Topic; 2] = [topics::CMD_VEL, topics::HARDWARE_CMD_VEL];
/// Topics by which robots sense: who receives nothing there is blind.
const SENSING: [Topic; 4] = [
    topics::HARDWARE_RANGE,
    topics::HARDWARE_SCAN,
    topics::HARDWARE_DETECTION,
    topics::VIRTUAL_DETECTION,
];

/// Topics whose ends do not fit each other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compatibility {
    /// Those that robots of the run need.
    pub unfit: BTreeSet<UnfitTopic>,
    /// Those without which the run can do: an observer that receives nothing.
    pub onlookers: BTreeSet<UnfitTopic>,
}

/// Looks at every topic of these robots and of the swarm, among all endpoints that are known.
pub fn compatibility(endpoints: &[Endpoint], robots: &[String]) -> Compatibility {
    let mut found = Compatibility::default();
    for (name, Candidates { topic, robot, ends }) in &topics_of(endpoints, robots) {
        let (writers, readers): (Vec<&Endpoint>, Vec<_>) =
            ends.iter().copied().partition(|end| end.kind == EndpointKind::Writer);
        let unfit = |reason| UnfitTopic { topic: name.clone(), reason };
        let is_hardware = topic.name == topics::HARDWARE_CMD_VEL.name;
        if is_hardware && writers.len() > 1 {
            let reason = format!("{} publish it, expected 1 publisher", names(&writers));
            found.unfit.insert(unfit(reason));
        }
        // What nodes of the robot itself expect of `cmd_vel` is compared with the fleet file.
        let is_compared = |end: &Endpoint| {
            topic.name == topics::CMD_VEL.name
                && end.node.as_deref().is_some_and(|node| is_of(node, robot))
        };
        let is_among = |all: &[Topic]| all.iter().any(|one| one.name == topic.name);
        let mut programs: BTreeMap<&[u8], Vec<&Endpoint>> = BTreeMap::new();
        for reader in &readers {
            programs.entry(participant(reader)).or_default().push(reader);
        }
        for reader in &readers {
            let own = &programs[participant(reader)];
            let types = if is_compared(reader) { Types::Compared } else { Types::Open };
            let Some(reason) = why_silent(reader, own, &writers, types) else { continue };
            if is_among(&STEERING) || (is_among(&SENSING) && is_ours(reader)) {
                found.unfit.insert(unfit(reason));
            } else if !is_ours(reader) && reader.node.is_some() {
                found.onlookers.insert(unfit(reason));
            }
        }
        found.onlookers.extend(not_kept(topic, &writers).map(unfit));
    }
    found
}

/// The ends of a topic that is in our table.
struct Candidates<'a> {
    topic: Topic,
    robot: &'a str,
    ends: Vec<&'a Endpoint>,
}

fn topics_of<'a>(
    endpoints: &'a [Endpoint],
    robots: &'a [String],
) -> BTreeMap<String, Candidates<'a>> {
    let mut found = BTreeMap::new();
    for topic in topics::ALL {
        for robot in robots {
            let ends = Candidates { topic: *topic, robot, ends: Vec::new() };
            found.entry(topic.for_robot(robot)).or_insert(ends);
        }
    }
    for end in endpoints {
        if let Some(of_topic) = found.get_mut(&end.topic) {
            of_topic.ends.push(end);
        }
    }
    found
}

/// Who publishes for the moment what late subscribers are to receive, too: none of ours does then.
fn not_kept(topic: &Topic, writers: &[&Endpoint]) -> impl Iterator<Item = String> {
    let is_kept = topic.qos.durability == Durability::TransientLocal;
    // Whatever a log or the locks of another program lack, no run needs it.
    let is_needed = is_kept && topic.name == topics::TF_STATIC.name;
    let volatile: Vec<&Endpoint> = writers
        .iter()
        .filter(|end| is_needed && end.qos.durability == Durability::Volatile)
        .copied()
        .collect();
    volatile.into_iter().map(|end| {
        format!(
            "{} publishes volatile, and it is subscribed transient local: set the durability of the \
             publisher to transient local",
            names(&[end])
        )
    })
}

/// What names the program of an end.
fn participant(end: &Endpoint) -> &[u8] {
    &end.guid[..PARTICIPANT]
}

fn is_ours(end: &Endpoint) -> bool {
    end.guid[..2] == OUR_VENDOR
}

/// Whether the type of a subscriber is compared elsewhere.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Types {
    Compared,
    Open,
}

/// Why a subscriber receives nothing from any publisher; `None` if it does, or if that does not
/// matter.
///
/// Its program may subscribe one topic in several ways, its `own`, of which one has to match.
fn why_silent(
    reader: &Endpoint,
    own: &[&Endpoint],
    writers: &[&Endpoint],
    types: Types,
) -> Option<String> {
    // One that has not been named yet may be anybody's: the run waits until it is.
    let node = reader.node.as_deref().unwrap_or(UNNAMED);
    if is_tool(node) || node == SIMULATOR_FULL_NAME {
        return None;
    }
    let writer = *writers.first()?;
    let is_matched = |reader: &Endpoint, writer: &Endpoint| {
        mismatch(asked(reader), writer.qos).is_none()
            && (types == Types::Compared || reader.type_name == writer.type_name)
    };
    if own
        .iter()
        .flat_map(|own| writers.iter().map(move |writer| (own, writer)))
        .any(|(own, writer)| is_matched(own, writer))
    {
        return None;
    }
    let from = names(&[writer]);
    if reader.type_name != writer.type_name && types == Types::Open {
        let (found, expected) = (&reader.type_name, &writer.type_name);
        let advice = advice(reader, writer);
        return Some(format!("{node} subscribes {found}, and {from} publishes {expected}{advice}"));
    }
    mismatch(asked(reader), writer.qos).map(|(asked, offered, change)| {
        format!("{node} subscribes {asked}, and {from} publishes {offered}: {change}")
    })
}

/// What to type so that the types are the same; empty where it depends.
fn advice(reader: &Endpoint, writer: &Endpoint) -> String {
    let ends_with = |topic: &Topic| reader.topic.ends_with(&format!("/{}", topic.name));
    let short = |type_name: &str| type_name.rsplit('/').next().map(str::to_owned);
    if ends_with(&topics::HARDWARE_CMD_VEL) && is_ours(writer) {
        let start = |taken: CmdVel| {
            format!(": start `rsrs node robot` with `-p {ROS_CMD_VEL_TYPE}:={}`", taken.key())
        };
        return CmdVel::of_type(&reader.type_name).map_or_else(String::new, start);
    }
    if ends_with(&topics::CMD_VEL) {
        return commands_as(&reader.type_name).unwrap_or_default();
    }
    let is_sensor = SENSING.iter().any(ends_with) && !ends_with(&topics::VIRTUAL_DETECTION);
    let word = match short(&writer.type_name).as_deref() {
        Some("Range") => "range",
        Some("LaserScan") => "laser_scan",
        Some("Bool") => "bool",
        _ => return String::new(),
    };
    if is_sensor && is_ours(reader) {
        let topic = &reader.topic;
        return format!(
            ": start `rsrs node robot` with `-p {ROS_SENSOR_TYPE}:={word} -p {ROS_SENSOR_TOPIC}:={topic}`"
        );
    }
    String::new()
}

/// What a subscriber asks for; ours receive best-effort publishers, whatever is discovered of them.
fn asked(reader: &Endpoint) -> Qos {
    let reliability =
        if is_ours(reader) { Reliability::BestEffort } else { reader.qos.reliability };
    Qos { reliability, ..reader.qos }
}

/// What keeps a subscriber from matching a publisher.
fn mismatch(reader: Qos, writer: Qos) -> Option<(&'static str, &'static str, &'static str)> {
    if reader.durability == Durability::TransientLocal && writer.durability == Durability::Volatile
    {
        return Some((
            "transient local",
            "volatile",
            "set the durability of the subscription to volatile",
        ));
    }
    if reader.reliability == Reliability::Reliable && writer.reliability == Reliability::BestEffort
    {
        return Some((
            "reliable",
            "best effort",
            "set the reliability of the subscription to best effort",
        ));
    }
    None
}

/// Whether a node is in the namespace of a robot.
fn is_of(node: &str, robot: &str) -> bool {
    node.strip_prefix('/')
        .and_then(|node| node.strip_prefix(robot))
        .is_some_and(|rest| rest.starts_with('/'))
}

/// Nodes of command-line tools have hidden names; that they receive nothing does no harm.
fn is_tool(node: &str) -> bool {
    node.rsplit('/').next().is_some_and(|name| name.starts_with('_'))
}

fn names(ends: &[&Endpoint]) -> String {
    let names: BTreeSet<&str> =
        ends.iter().map(|end| end.node.as_deref().unwrap_or(UNNAMED)).collect();
    names.into_iter().collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAMPED: &str = "geometry_msgs/msg/TwistStamped";

    fn end(node: &str, kind: EndpointKind, type_name: &str, qos: Qos) -> Endpoint {
        let mut guid = [0; 16];
        guid[..4].copy_from_slice(&u32::try_from(node.len()).expect("short").to_le_bytes());
        Endpoint {
            topic: "/robot_1/cmd_vel".to_owned(),
            type_name: type_name.to_owned(),
            kind,
            qos,
            guid,
            node: Some(node.to_owned()),
        }
    }

    fn reasons(readers: &[(&str, &str, Qos)]) -> Vec<String> {
        let controller = ("/robot_1/controller", STAMPED, Qos::reliable(10));
        let writer = end(controller.0, EndpointKind::Writer, controller.1, controller.2);
        let mut ends = vec![writer];
        ends.extend(
            readers
                .iter()
                .map(|(node, type_name, qos)| end(node, EndpointKind::Reader, type_name, *qos)),
        );
        let unfit = compatibility(&ends, &["robot_1".to_owned()]).unfit;
        assert!(unfit.iter().all(|unfit| unfit.topic == "/robot_1/cmd_vel"));
        unfit.into_iter().map(|unfit| unfit.reason).collect()
    }

    #[test]
    fn bases_that_match_are_fit_whatever_they_ask_for() {
        let found = [
            ("/robot_1/base", STAMPED, Qos::reliable(1)),
            ("/base_1", STAMPED, Qos::best_effort(5)),
        ];

        assert_eq!(reasons(&found), [""; 0]);
    }

    #[test]
    fn a_base_that_subscribes_transient_local_is_named_with_what_to_change() {
        let kept = Qos { durability: Durability::TransientLocal, ..Qos::reliable(1) };

        assert_eq!(
            reasons(&[("/robot_1/base", STAMPED, kept)]),
            [
                "/robot_1/base subscribes transient local, and /robot_1/controller publishes volatile: \
              set the durability of the subscription to volatile"
            ]
        );
    }

    #[test]
    fn a_base_of_another_type_is_named_wherever_it_is_and_tools_are_not() {
        let twist = "geometry_msgs/msg/Twist";
        let readers =
            [("/base_1", twist, Qos::reliable(1)), ("/_ros2cli_7", twist, Qos::reliable(1))];

        assert_eq!(
            reasons(&readers),
            ["/base_1 subscribes geometry_msgs/msg/Twist, and /robot_1/controller publishes \
              geometry_msgs/msg/TwistStamped: set `cmd_vel: twist` in the fleet file, and start \
              the controller with `-p cmd_vel_type:=twist`"]
        );
    }

    #[test]
    fn who_subscribes_in_two_ways_is_fit_if_one_matches() {
        let kept = Qos { durability: Durability::TransientLocal, ..Qos::reliable(1) };
        let both = [("/base_1", STAMPED, kept), ("/base_1", STAMPED, Qos::best_effort(1))];

        assert_eq!(reasons(&both), [""; 0]);
    }

    fn on(topic: &str, end: Endpoint) -> Endpoint {
        Endpoint { topic: topic.to_owned(), ..end }
    }

    fn ours(mut end: Endpoint) -> Endpoint {
        end.guid[..2].copy_from_slice(&OUR_VENDOR);
        end
    }

    #[test]
    fn a_sensor_of_another_type_is_named_with_what_to_type_and_one_that_is_best_effort_is_fit() {
        let scan = "sensor_msgs/msg/LaserScan";
        let (topic, effort) = ("/robot_1/hardware/range", Qos::best_effort(5));
        let gate =
            |qos| ours(end("/robot_1/robot", EndpointKind::Reader, "sensor_msgs/msg/Range", qos));
        let sensor = |type_name| end("/robot_1/base", EndpointKind::Writer, type_name, effort);
        let ends = |type_name, qos| [gate(qos), sensor(type_name)].map(|end| on(topic, end));
        let robots = ["robot_1".to_owned()];

        assert_eq!(
            compatibility(&ends("sensor_msgs/msg/Range", Qos::reliable(1)), &robots),
            Compatibility::default()
        );
        let unfit: Vec<_> = compatibility(&ends(scan, effort), &robots).unfit.into_iter().collect();
        assert_eq!(
            unfit[0].reason,
            "/robot_1/robot subscribes sensor_msgs/msg/Range, and /robot_1/base publishes \
             sensor_msgs/msg/LaserScan: start `rsrs node robot` with \
             `-p ros.sensor_type:=laser_scan -p ros.sensor_topic:=/robot_1/hardware/range`"
        );
    }

    #[test]
    fn onlookers_who_receive_nothing_are_named_and_keep_no_run_from_starting() {
        let lease = topics::LEASE;
        let runner =
            ours(end("/experiment_runner", EndpointKind::Writer, lease.type_name, lease.qos));
        let board = end("/board", EndpointKind::Reader, lease.type_name, Qos::reliable(1));
        let camera = end("/camera", EndpointKind::Writer, topics::TF.type_name, Qos::reliable(1));
        let ends = [on(lease.name, runner), on(lease.name, board), on("/tf_static", camera)];

        let Compatibility { unfit, onlookers } = compatibility(&ends, &["robot_1".to_owned()]);

        assert!(unfit.is_empty(), "{unfit:?}");
        let reasons: Vec<String> = onlookers.into_iter().map(|it| it.reason).collect();
        assert_eq!(
            reasons,
            [
                "/board subscribes reliable, and /experiment_runner publishes best effort: set the \
                 reliability of the subscription to best effort",
                "/camera publishes volatile, and it is subscribed transient local: set the durability \
                 of the publisher to transient local",
            ]
        );
    }

    #[test]
    fn two_publishers_of_a_bases_commands_are_named() {
        let writers = ["/robot_1/robot", "/teleop"].map(|node| Endpoint {
            topic: "/robot_1/hardware/cmd_vel".to_owned(),
            ..end(node, EndpointKind::Writer, STAMPED, Qos::reliable(1))
        });

        let unfit = compatibility(&writers, &["robot_1".to_owned()]).unfit;
        let unfit: Vec<_> = unfit.into_iter().collect();

        assert_eq!(unfit[0].topic, "/robot_1/hardware/cmd_vel");
        assert_eq!(unfit[0].reason, "/robot_1/robot and /teleop publish it, expected 1 publisher");
    }
}
