//! Sessions over real DDS, each test in a network of its own.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_msgs::{RosMessage, cdr};
use rsrs_ros::session::{Endpoint, EndpointKind, Received, ReceivedRaw, Session};
use rsrs_testing::network::{
    TIMEOUT, eventually, fail_as_starved, in_own_network, in_own_network_with, session, within,
};
use tokio::sync::mpsc;

/// A closure that puts what it is given into a channel.
fn channel<T>() -> (impl FnMut(T) + Send + 'static, mpsc::UnboundedReceiver<T>)
where
    T: Send + 'static,
{
    let (sender, receiver) = mpsc::unbounded_channel();
    let deliver = move |item| {
        // The test has seen enough and has dropped its receiver.
        sender.send(item).ok();
    };
    (deliver, receiver)
}

async fn next<T>(receiver: &mut mpsc::UnboundedReceiver<T>) -> T {
    let received = tokio::time::timeout(TIMEOUT, receiver.recv()).await;
    received.expect("a sample comes in time").expect("the subscription is alive")
}

#[test]
fn best_effort_and_reliable_publishers_are_both_received_each_sample_once() {
    let name = "best_effort_and_reliable_publishers_are_both_received_each_sample_once";
    in_own_network(name, async || {
        let (robot, sensor, other) = (session(), session(), session());
        let reliable = Qos::reliable(200);
        let node = robot.node("/robot_1", "controller").unwrap();
        let (deliver, mut typed) = channel();
        let _typed = robot.subscribe(&node, "/robot_1/detection", reliable, deliver).unwrap();
        let (deliver, mut bytes) = channel::<ReceivedRaw>();
        let _raw =
            robot.subscribe_raw("/robot_1/detection", Bool::TYPE_NAME, reliable, deliver).unwrap();
        let publish = |session: &Session, qos| {
            let node = session.node("/robot_1", "sensor").unwrap();
            session.publish_on::<Bool>(&node, "/robot_1/detection", qos).unwrap()
        };
        let from_sensor = publish(&sensor, Qos::best_effort(10));
        let from_other = publish(&other, reliable);
        // Both subscriptions, and those that best-effort publishers need.
        sensor.wait_for_readers("/robot_1/detection", 4, TIMEOUT).await.unwrap();
        other.wait_for_readers("/robot_1/detection", 4, TIMEOUT).await.unwrap();

        // What is sent before discovery of a publisher is lost if it is best effort.
        let mut of_sensor: Option<[u8; 16]> = None;
        while of_sensor.is_none() {
            from_sensor.publish(Bool { data: false }).await.unwrap();
            tokio::time::sleep(Duration::from_millis(50)).await;
            let received = typed.try_recv();
            of_sensor = received.ok().map(|received: Received<Bool>| received.writer);
        }
        for _ in 0..100 {
            from_sensor.publish(Bool { data: true }).await.unwrap();
            from_other.publish(Bool { data: true }).await.unwrap();
            tokio::time::sleep(Duration::from_millis(2)).await;
        }

        let mut sequences: BTreeMap<[u8; 16], Vec<u64>> = BTreeMap::new();
        let is_done = |sequences: &BTreeMap<[u8; 16], Vec<u64>>| {
            sequences.len() == 2 && sequences.values().all(|those| those.len() >= 100)
        };
        while !is_done(&sequences) {
            let received = next(&mut typed).await;
            if received.message.data {
                sequences.entry(received.writer).or_default().push(received.sequence);
            }
        }
        for those in sequences.values() {
            assert!(those.windows(2).all(|pair| pair[1] == pair[0] + 1), "{those:?}");
        }
        assert!(sequences.contains_key(&of_sensor.unwrap()));
        let mut raw: BTreeMap<[u8; 16], u64> = BTreeMap::new();
        while raw.len() < 2 || raw.values().any(|last| *last < 100) {
            let received = next(&mut bytes).await;
            let before = raw.insert(received.writer, received.sequence);
            assert!(before.is_none_or(|before| before < received.sequence), "once each");
        }
        drop((from_sensor, from_other));
        for session in [sensor, other, robot] {
            session.close().await;
        }
    });
}

#[test]
fn raw_bytes_go_through_unchanged_in_both_directions() {
    in_own_network("raw_bytes_go_through_unchanged_in_both_directions", async || {
        let (typed, raw) = (session(), session());
        let node = typed.node("/", "typed").unwrap();
        let qos = Qos::reliable(10);
        let (deliver, mut bytes) = channel::<ReceivedRaw>();
        let listening = raw.subscribe_raw("/there", Bool::TYPE_NAME, qos, deliver).unwrap();
        let (deliver, mut messages) = channel::<Received<Bool>>();
        let _answers = typed.subscribe(&node, "/back", qos, deliver).unwrap();
        let there = typed.publish_on(&node, "/there", qos).unwrap();
        let back = raw.publish_raw("/back", Bool::TYPE_NAME, qos).unwrap();
        typed.wait_for_readers("/there", 1, TIMEOUT).await.unwrap();
        raw.wait_for_readers("/back", 1, TIMEOUT).await.unwrap();
        raw.wait_for_writers("/there", 1, TIMEOUT).await.unwrap();

        there.publish(Bool { data: true }).await.unwrap();
        let sample = next(&mut bytes).await;
        back.publish(&cdr::encode(&Bool { data: true })).await.unwrap();

        assert_eq!(cdr::decode::<Bool>(&sample.message).unwrap(), Bool { data: true });
        assert_eq!(sample.message[..4], cdr::ENCAPSULATION);
        assert_eq!(sample.sequence, 1);
        assert!(sample.source_time_ns.unwrap() > 1_700_000_000_000_000_000);
        assert!(next(&mut messages).await.message.data);
        eventually("the writer belongs to a node", || {
            let endpoints = raw.endpoints();
            let writer = endpoints.iter().find(|endpoint| endpoint.guid == sample.writer);
            writer.and_then(|writer| writer.node.as_deref()) == Some("/typed")
        })
        .await;
        assert_eq!(listening.counts().taken, 1);
        assert!(back.publish(&[0, 0, 0, 0, 1]).await.is_err());
        drop((there, back));
        raw.close().await;
        typed.close().await;
    });
}

#[test]
fn a_sample_of_another_type_is_counted_and_not_delivered() {
    in_own_network("a_sample_of_another_type_is_counted_and_not_delivered", async || {
        let (one, other) = (session(), session());
        let node = one.node("/", "one").unwrap();
        let qos = Qos::reliable(10);
        let (deliver, mut messages) = channel::<Received<Bool>>();
        let subscription = one.subscribe(&node, "/topic", qos, deliver).unwrap();
        let publisher = other.publish_raw("/topic", TwistStamped::TYPE_NAME, qos).unwrap();
        other.wait_for_readers("/topic", 1, TIMEOUT).await.unwrap();
        one.wait_for_writers("/topic", 1, TIMEOUT).await.unwrap();

        publisher.publish(&cdr::encode(&TwistStamped::default())).await.unwrap();
        publisher.publish(&cdr::encode(&Bool { data: true })).await.unwrap();

        assert_eq!(next(&mut messages).await.sequence, 2);
        assert_eq!(subscription.counts().undecodable, 1);
        drop(publisher);
        one.close().await;
        other.close().await;
    });
}

#[test]
fn twenty_thousand_reliable_messages_arrive_in_order_when_the_sender_waits_for_the_reader() {
    let name =
        "twenty_thousand_reliable_messages_arrive_in_order_when_the_sender_waits_for_the_reader";
    in_own_network(name, async || {
        const N_MESSAGES: u64 = 20_000;
        // As in lockstep: never more unread than the depth.
        const WINDOW: u64 = 100;
        let (sender, receiver) = (session(), session());
        let node = receiver.node("/", "receiver").unwrap();
        let topic = topics::DETECTION.for_robot("robot_1");
        let taken = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&taken);
        let (mut report, mut reports) = channel();
        let deliver = move |received: Received<Bool>| {
            let so_far = count.fetch_add(1, Ordering::Relaxed) + 1;
            assert_eq!(received.sequence, so_far, "out of order");
            report(so_far);
        };
        let qos = topics::DETECTION.qos;
        let subscription = receiver.subscribe(&node, &topic, qos, deliver).unwrap();
        let node = sender.node("/", "sender").unwrap();
        let publisher = sender.publish_on(&node, &topic, qos).unwrap();
        sender.wait_for_readers(&topic, 1, TIMEOUT).await.unwrap();
        receiver.wait_for_writers(&topic, 1, TIMEOUT).await.unwrap();

        let mut seen = 0;
        for sent in 0..N_MESSAGES {
            publisher.publish(Bool { data: sent % 2 == 0 }).await.unwrap();
            while sent >= seen + WINDOW {
                seen = next(&mut reports).await;
            }
        }
        while seen < N_MESSAGES {
            seen = next(&mut reports).await;
        }

        assert_eq!(subscription.counts().taken, N_MESSAGES);
        assert_eq!(subscription.counts().lost, 0);
        drop(publisher);
        sender.close().await;
        receiver.close().await;
    });
}

#[test]
fn a_reader_that_is_flooded_counts_what_it_lost() {
    in_own_network("a_reader_that_is_flooded_counts_what_it_lost", async || {
        const N_MESSAGES: u64 = 5_000;
        let (sender, receiver) = (session(), session());
        let qos = Qos::reliable(10);
        let (mut deliver, mut sequences) = channel();
        let slow = move |received: ReceivedRaw| {
            std::thread::sleep(Duration::from_micros(200));
            deliver(received.sequence);
        };
        let subscription = receiver.subscribe_raw("/flood", Bool::TYPE_NAME, qos, slow).unwrap();
        let publisher = sender.publish_raw("/flood", Bool::TYPE_NAME, qos).unwrap();
        sender.wait_for_readers("/flood", 1, TIMEOUT).await.unwrap();
        receiver.wait_for_writers("/flood", 1, TIMEOUT).await.unwrap();

        let bytes = cdr::encode(&Bool { data: true });
        for _ in 0..N_MESSAGES {
            publisher.publish(&bytes).await.unwrap();
        }
        let first = next(&mut sequences).await;
        while next(&mut sequences).await < N_MESSAGES {}

        let counts = subscription.counts();
        assert!(counts.lost > 0, "{counts:?}");
        assert_eq!(first - 1 + counts.taken + counts.lost, N_MESSAGES, "{counts:?}");
        drop(publisher);
        sender.close().await;
        receiver.close().await;
    });
}

#[test]
fn many_nodes_of_one_participant_are_listed_with_their_topics() {
    in_own_network("many_nodes_of_one_participant_are_listed_with_their_topics", async || {
        const N_ROBOTS: usize = 30;
        let (fleet, observer) = (session(), session());
        let mut publishers = Vec::new();
        for robot in 1..=N_ROBOTS {
            let namespace = format!("/robot_{robot}");
            let node = fleet.node(&namespace, "controller").unwrap();
            let topic = topics::CMD_VEL.for_robot(&namespace[1..]);
            let publisher = fleet.publish_on::<TwistStamped>(&node, &topic, topics::CMD_VEL.qos);
            publishers.push(publisher.unwrap());
        }

        let wanted = |endpoint: &Endpoint| {
            endpoint.topic.ends_with("/cmd_vel")
                && endpoint.type_name == TwistStamped::TYPE_NAME
                && endpoint.kind == EndpointKind::Writer
                && endpoint.node.as_deref().is_some_and(|node| node.ends_with("/controller"))
        };
        for session in [&observer, &fleet] {
            eventually("all topics are listed", || {
                session.endpoints().iter().filter(|&endpoint| wanted(endpoint)).count() == N_ROBOTS
            })
            .await;
            let names = session.node_names();
            assert!(names.contains(&"/robot_17/controller".to_owned()), "{names:?}");
        }

        drop(publishers);
        fleet.close().await;
        // Long before the lease of a participant that says nothing is over.
        within(Duration::from_secs(30), "nodes that have gone are forgotten", || {
            observer.node_names().is_empty()
        })
        .await;
        observer.close().await;
    });
}

#[test]
fn a_subscriber_that_never_comes_is_named_with_the_topic() {
    in_own_network("a_subscriber_that_never_comes_is_named_with_the_topic", async || {
        let alone = session();

        let wait = alone.wait_for_readers("/nobody", 2, Duration::from_millis(100));
        let error = wait.await.unwrap_err();

        assert_eq!(
            error.to_string(),
            "topic `/nobody` has 0 subscribers after 0.1 s, expected at least 2"
        );
        alone.close().await;
    });
}

#[test]
fn what_a_driver_holds_can_go_to_another_thread() {
    fn is_send<T: Send + 'static>() {}

    is_send::<Session>();
    is_send::<rsrs_ros::session::Publisher<Bool>>();
    is_send::<rsrs_ros::session::RawPublisher>();
    is_send::<rsrs_ros::session::Subscription>();
    is_send::<rsrs_ros::session::NodeHandle>();
    is_send::<rsrs_ros::parameters::ParameterServer>();
}

/// Where a body leaves that it was run.
const LEFT: &str = "RSRS_TEST_LEFT";

#[test]
fn a_body_that_the_machine_starved_is_run_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let left = folder.path().join("left");
    let test = "a_body_that_the_machine_starved_is_run_again";

    in_own_network_with(test, &[(LEFT, left.clone().into())], async || {
        let left = std::env::var_os(LEFT).expect("it was given");
        if std::fs::exists(&left).expect("it can be looked for") {
            std::fs::write(left, "twice").expect("the folder is writable");
        } else {
            std::fs::write(left, "once").expect("the folder is writable");
            fail_as_starved("it is the first time");
        }
    });

    if std::env::var_os(LEFT).is_none() {
        assert_eq!(std::fs::read_to_string(left).expect("it was run"), "twice");
    }
}
