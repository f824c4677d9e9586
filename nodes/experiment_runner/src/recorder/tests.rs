//! The recorder over real DDS, in a network of its own.

#[expect(dead_code, reason = "others use all of it")]
#[path = "../../../ros/tests/support/mod.rs"]
mod support;

use std::time::Duration;

use rsrs_bags::Bag;
use rsrs_fleet::record::EndingKind;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use support::{PATIENCE, in_own_network, session};
use tokio::sync::mpsc::unbounded_channel;
use tokio::time::MissedTickBehavior;

use super::*;
use crate::ears;

const N_ROBOTS: usize = 100;

/// 5 s at 20 Hz.
const N_STEPS: usize = 100;

const STEP: Duration = Duration::from_millis(50);

fn ear(robot: usize, topic: topics::Topic) -> Ear {
    Ear::new(topic.for_robot(&format!("robot_{robot}")), topic, Role::Other)
}

fn recorder(folder: &Path, ears: &[Ear]) -> Recorder {
    let writer = BagWriter::create(folder, BagOptions::default()).expect("it is new");
    Recorder::around(writer, Pace::Wall, ears)
}

fn completed() -> Ending {
    Ending { kind: EndingKind::Completed, reason: String::new() }
}

#[test]
fn samples_that_never_came_are_counted_by_topic_and_told_in_the_bag() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let ears = [ear(1, topics::DETECTION), ear(2, topics::DETECTION)];
    let mut recorder = recorder(&path, &ears);

    for (index, writer, sequence) in [(0, 1, 5), (1, 2, 1), (0, 1, 6), (0, 1, 9), (0, 3, 1)] {
        let message = cdr::encode(&Bool { data: true });
        let writer = [writer; 16];
        let (source_time_ns, received_time_ns) = (None, 0);
        let received = ReceivedRaw { message, source_time_ns, received_time_ns, sequence, writer };
        recorder.take((index, &ears[index]), &received).unwrap();
    }
    assert_eq!(recorder.n_lost(), 2);
    recorder.close(&completed()).unwrap();

    let bag = Bag::open(&path).unwrap();
    let told = bag.metadata("rsrs.recording").unwrap();
    assert_eq!(told["n_missing"], "2");
    assert_eq!(told["n_missing /robot_1/detection"], "2");
    assert_eq!(told["n_overflowed"], "0");
    assert_eq!(told.len(), 3);
}

#[test]
fn a_hundred_robots_with_three_topics_at_20_hz_are_recorded_without_loss() {
    let name =
        "recorder::tests::a_hundred_robots_with_three_topics_at_20_hz_are_recorded_without_loss";
    in_own_network(name, async || {
        let topics = [topics::DETECTION, topics::CMD_VEL, topics::ODOM];
        let ears: Vec<Ear> =
            (0..N_ROBOTS).flat_map(|robot| topics.map(|topic| ear(robot, topic))).collect();
        let (robots, listener) = (session(), session());
        let (sender, mut samples) = unbounded_channel();
        let _subscriptions = ears::listen(&listener, &ears, &ears::Queue::new(sender)).unwrap();
        let mut publishers = Vec::new();
        for ear in &ears {
            // As deep as the recorder listens, because this machine may be busy with other tests.
            let qos = Qos::reliable(100);
            let publisher = robots.publish_raw(&ear.name, &ear.type_name, qos).unwrap();
            let message = match ear.type_name.as_str() {
                name if name == topics::DETECTION.type_name => cdr::encode(&Bool { data: true }),
                name if name == topics::CMD_VEL.type_name => cdr::encode(&TwistStamped::default()),
                _ => cdr::encode(&Odometry::default()),
            };
            publishers.push((publisher, message));
        }
        for ear in &ears {
            robots.wait_for_readers(&ear.name, 1, PATIENCE).await.unwrap();
            listener.wait_for_writers(&ear.name, 1, PATIENCE).await.unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = recorder(&folder.path().join("run"), &ears);

        let publish = async {
            let mut clock = tokio::time::interval(STEP);
            clock.set_missed_tick_behavior(MissedTickBehavior::Delay);
            for _ in 0..N_STEPS {
                clock.tick().await;
                for (publisher, message) in &publishers {
                    publisher.publish(message).await.unwrap();
                }
            }
        };
        let record = async {
            for n_recorded in 0..ears.len() * N_STEPS {
                let sample = tokio::time::timeout(PATIENCE, samples.recv()).await;
                let Ok(Some(sample)) = sample else { panic!("only {n_recorded} samples came") };
                let heard = (sample.ear, &ears[sample.ear]);
                recorder.take(heard, &sample.received).unwrap();
            }
        };
        futures::join!(publish, record);
        let summary = recorder.close(&completed()).unwrap();

        assert_eq!(summary.n_messages_of_topic.len(), ears.len());
        assert!(summary.n_messages_of_topic.values().all(|n| *n == N_STEPS as u64));
        let bag = Bag::open(&summary.folder).unwrap();
        assert_eq!(bag.metadata("rsrs.recording").unwrap()["n_missing"], "0");
        drop(publishers);
        robots.close().await;
        listener.close().await;
    });
}
