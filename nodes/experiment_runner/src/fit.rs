//! Whether the ends of topics by which robots are steered fit each other: those that do not are silent.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_fleet::preflight::UnfitTopic;
use rsrs_msgs::topics::{self, Durability, Qos, Reliability};
use rsrs_ros::session::{Endpoint, EndpointKind};

/// The simulator, in which virtual robots are.
const SIMULATOR: &str = "/simulator";
/// Bytes of an identity that name the participant.
const PARTICIPANT: usize = 12;

/// Topics of these robots whose ends do not fit each other.
///
/// # Arguments
///
/// * `endpoints` — all that are known.
/// * `robots` — names.
pub fn unfit(endpoints: &[Endpoint], robots: &[String]) -> BTreeSet<UnfitTopic> {
    let steering = [topics::CMD_VEL, topics::HARDWARE_CMD_VEL];
    let mut topics: BTreeMap<String, (&str, Vec<&Endpoint>)> = BTreeMap::new();
    for robot in robots {
        for topic in steering {
            topics.insert(topic.for_robot(robot), (robot, Vec::new()));
        }
    }
    for end in endpoints {
        if let Some((_, ends)) = topics.get_mut(&end.topic) {
            ends.push(end);
        }
    }
    let mut unfit = BTreeSet::new();
    for (topic, (robot, ends)) in topics {
        let (writers, readers): (Vec<&Endpoint>, Vec<_>) =
            ends.into_iter().partition(|end| end.kind == EndpointKind::Writer);
        let is_hardware = topic.ends_with(topics::HARDWARE_CMD_VEL.name);
        if is_hardware && writers.len() > 1 {
            let reason = format!("{} publish it, expected 1 publisher", names(&writers));
            unfit.insert(UnfitTopic { topic: topic.clone(), reason });
        }
        // What nodes of the robot itself expect of `cmd_vel` is compared with the fleet file.
        let is_compared = |end: &Endpoint| {
            !is_hardware && end.node.as_deref().is_some_and(|node| is_of(node, robot))
        };
        for reader in &readers {
            let types = if is_compared(reader) { Types::Compared } else { Types::Open };
            let reason = why_silent(reader, (&readers, &writers), types);
            unfit.extend(reason.map(|reason| UnfitTopic { topic: topic.clone(), reason }));
        }
    }
    unfit
}

/// Whether the type of a subscriber is compared elsewhere.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Types {
    Compared,
    Open,
}

/// Why a subscriber receives nothing from any publisher; `None` if it does, or if nobody minds.
fn why_silent(
    reader: &Endpoint,
    (readers, writers): (&[&Endpoint], &[&Endpoint]),
    types: Types,
) -> Option<String> {
    let node = reader.node.as_deref().filter(|node| !is_tool(node) && *node != SIMULATOR)?;
    let writer = *writers.first()?;
    let participant = |end: &Endpoint| end.guid[..PARTICIPANT].to_owned();
    // A program may subscribe one topic in several ways, of which one has to match.
    let own = readers.iter().filter(|other| participant(other) == participant(reader));
    let is_matched = |reader: &Endpoint, writer: &Endpoint| {
        mismatch(reader.qos, writer.qos).is_none()
            && (types == Types::Compared || reader.type_name == writer.type_name)
    };
    if own
        .flat_map(|own| writers.iter().map(move |writer| (own, writer)))
        .any(|(own, writer)| is_matched(own, writer))
    {
        return None;
    }
    let from = names(&[writer]);
    if reader.type_name != writer.type_name && types == Types::Open {
        let (found, expected) = (&reader.type_name, &writer.type_name);
        return Some(format!("{node} subscribes {found}, and {from} publishes {expected}"));
    }
    mismatch(reader.qos, writer.qos).map(|(asked, offered, change)| {
        format!("{node} subscribes {asked}, and {from} publishes {offered}: {change}")
    })
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

/// Nodes of command-line tools have hidden names; that they see nothing harms nobody.
fn is_tool(node: &str) -> bool {
    node.rsplit('/').next().is_some_and(|name| name.starts_with('_'))
}

fn names(ends: &[&Endpoint]) -> String {
    let names: BTreeSet<&str> =
        ends.iter().map(|end| end.node.as_deref().unwrap_or("a program without a name")).collect();
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
        let unfit = unfit(&ends, &["robot_1".to_owned()]);
        assert!(unfit.iter().all(|unfit| unfit.topic == "/robot_1/cmd_vel"));
        unfit.into_iter().map(|unfit| unfit.reason).collect()
    }

    #[test]
    fn bases_that_match_are_fit_whatever_they_ask_for() {
        let fit = [
            ("/robot_1/base", STAMPED, Qos::reliable(1)),
            ("/base_1", STAMPED, Qos::best_effort(5)),
        ];

        assert_eq!(reasons(&fit), [""; 0]);
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
              geometry_msgs/msg/TwistStamped"]
        );
    }

    #[test]
    fn who_subscribes_in_two_ways_is_fit_if_one_matches() {
        let kept = Qos { durability: Durability::TransientLocal, ..Qos::reliable(1) };
        let both = [("/base_1", STAMPED, kept), ("/base_1", STAMPED, Qos::best_effort(1))];

        assert_eq!(reasons(&both), [""; 0]);
    }

    #[test]
    fn two_publishers_of_a_bases_commands_are_named() {
        let writers = ["/robot_1/robot", "/teleop"].map(|node| Endpoint {
            topic: "/robot_1/hardware/cmd_vel".to_owned(),
            ..end(node, EndpointKind::Writer, STAMPED, Qos::reliable(1))
        });

        let unfit: Vec<_> = unfit(&writers, &["robot_1".to_owned()]).into_iter().collect();

        assert_eq!(unfit[0].topic, "/robot_1/hardware/cmd_vel");
        assert_eq!(unfit[0].reason, "/robot_1/robot and /teleop publish it, expected 1 publisher");
    }
}
