//! The recorder over real DDS, in a network of its own.

use std::path::Path;
use std::time::Duration;

use rsrs_bags::{Bag, BagSummary};
use rsrs_fleet::record::Ending;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_testing::network::{TIMEOUT, in_own_network, session};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::time::MissedTickBehavior;

use super::disk::{Job, Room};
use super::*;
use crate::recorded_topics;

const N_ROBOTS: usize = 100;

/// What a recorder writes when it is closed.
const ENDING_MESSAGE: u64 = 1;

/// 5 s at 20 Hz.
const N_STEPS: usize = 100;

const STEP: Duration = Duration::from_millis(50);

fn recorded_topic(robot: usize, topic: Topic) -> RecordedTopic {
    RecordedTopic::new(topic.for_robot(&format!("robot_{robot}")), topic, Role::Other)
}

/// A recorder whose thread does `before` each job.
fn recorder_before(
    folder: &Path,
    recorded_topics: &[RecordedTopic],
    before: impl FnMut(&Job) + Send + 'static,
    room: Room,
) -> (Recorder, UnboundedReceiver<Written>) {
    let (report, written) = unbounded_channel();
    let folder = folder.to_owned();
    let open = move || Ok(BagWriter::create(&folder, BagOptions::default())?);
    let disk = Disk::start(open, before, report, room).expect("there are threads");
    (Recorder::around(disk, BagClock::Wall, recorded_topics), written)
}

fn recorder(
    folder: &Path,
    recorded_topics: &[RecordedTopic],
) -> (Recorder, UnboundedReceiver<Written>) {
    recorder_before(folder, recorded_topics, |_| {}, ROOM)
}

fn sample(sequence: u64) -> ReceivedRaw {
    let message = cdr::encode(&Bool { data: true });
    let (source_time_ns, received_time_ns, writer) = (None, 0, [1; 16]);
    ReceivedRaw { message, source_time_ns, received_time_ns, sequence, writer }
}

/// Lets a recorder take so many samples of its only topic.
fn take(recorder: &mut Recorder, topic: &RecordedTopic, n_samples: u64) {
    (1..=n_samples).for_each(|sequence| recorder.take(0, topic, &sample(sequence)).unwrap());
}

/// Waits until the bag is closed.
fn summary(written: &mut UnboundedReceiver<Written>) -> BagSummary {
    loop {
        match written.blocking_recv().expect("the thread reports how it ends") {
            Written::Closed(summary) => return summary,
            Written::Opened | Written::Step(_) => {}
            failed => panic!("{failed:?}"),
        }
    }
}

#[test]
fn samples_that_never_came_are_counted_by_topic_in_the_bag() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let recorded_topics =
        [recorded_topic(1, topics::DETECTION), recorded_topic(2, topics::DETECTION)];
    let (mut recorder, mut written) = recorder(&path, &recorded_topics);

    for (index, writer, sequence) in [(0, 1, 5), (1, 2, 1), (0, 1, 6), (0, 1, 9), (0, 3, 1)] {
        let received = ReceivedRaw { writer: [writer; 16], ..sample(sequence) };
        recorder.take(index, &recorded_topics[index], &received).unwrap();
    }
    assert_eq!(recorder.n_lost(), 2);
    recorder.close(&Ending::completed());
    summary(&mut written);

    let bag = Bag::open(&path).unwrap();
    let given = bag.metadata("rsrs.recording").unwrap();
    assert_eq!(given["n_missing"], "2");
    assert_eq!(given["n_missing /robot_1/detection"], "2");
    assert_eq!(given["n_overflowed"], "0");
    assert_eq!(given.len(), 3);
}

/// A disk that is slow for what `is_slow` selects, longer than a lease holds.
fn slow_disk(is_slow: impl Fn(&Job) -> bool + Send + 'static) -> impl FnMut(&Job) + Send + 'static {
    move |job| {
        if is_slow(job) {
            std::thread::sleep(Duration::from_millis(600));
        }
    }
}

/// For which jobs a disk takes its time.
type IsSlow = fn(&Job) -> bool;

#[test]
fn a_disk_that_is_slow_to_write_or_to_synchronise_holds_up_nobody_and_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let recorded_topics = [recorded_topic(1, topics::DETECTION)];
    let is_synchronised = |job: &Job| matches!(job, Job::Close(_));
    let is_third = |job: &Job| matches!(job, Job::Write(message) if message.sequence == 3);
    let disks: [(&str, IsSlow); 2] = [("write", is_third), ("sync", is_synchronised)];
    for (name, is_slow) in disks {
        let path = folder.path().join(name);
        let (mut recorder, mut written) =
            recorder_before(&path, &recorded_topics, slow_disk(is_slow), ROOM);

        let start = std::time::Instant::now();
        take(&mut recorder, &recorded_topics[0], 500);
        let closing = recorder.close(&Ending::completed());
        let took = start.elapsed();

        assert_eq!(summary(&mut written).n_messages, 500 + ENDING_MESSAGE, "{name}");
        assert!(closing.end(), "{name}: the thread has ended");
        assert!(start.elapsed() >= Duration::from_millis(600), "{name}: the disk was slow");
        assert!(took < Duration::from_millis(500), "{name}: the lease would have lapsed: {took:?}");
        assert_eq!(Bag::open(&path).unwrap().metadata(RECORDING).unwrap()["n_missing"], "0");
    }
}

/// Writes a message each time a test sends something.
fn disk_that_waits() -> (std::sync::mpsc::Sender<()>, impl FnMut(&Job) + Send + 'static) {
    let (go, gone) = std::sync::mpsc::channel::<()>();
    let wait = move |job: &Job| {
        if matches!(job, Job::Write(_)) {
            gone.recv().unwrap_or_default();
        }
    };
    (go, wait)
}

#[test]
fn a_bag_that_is_closed_slowly_shows_what_is_left_and_ends_with_its_thread() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let recorded_topics = [recorded_topic(1, topics::DETECTION)];
    let (go, wait) = disk_that_waits();
    let (mut recorder, mut written) = recorder_before(&path, &recorded_topics, wait, ROOM);
    take(&mut recorder, &recorded_topics[0], 20);

    let closing = recorder.close(&Ending::completed());

    let n_bytes = sample(0).message.len() as u64;
    let (mut done, mut left_bytes) = closing.progress();
    assert!(left_bytes > 20 * n_bytes, "{left_bytes}: the ending comes on top");
    for _ in 0..20 {
        go.send(()).unwrap();
        let start = std::time::Instant::now();
        while closing.progress().0 == done {
            assert!(start.elapsed() < TIMEOUT, "nothing is written");
            std::thread::sleep(Duration::from_millis(1));
        }
        let (now_done, now_left) = closing.progress();
        assert!(now_done > done && now_left < left_bytes, "{now_left} of {left_bytes} left");
        (done, left_bytes) = (now_done, now_left);
    }
    go.send(()).unwrap();
    assert_eq!(summary(&mut written).n_messages, 20 + ENDING_MESSAGE);
    assert_eq!(closing.progress().1, 0);
    assert!(closing.end(), "the thread has ended");
}

#[test]
fn a_bag_that_is_given_up_ends_its_thread_unless_the_disk_hangs() {
    let folder = tempfile::tempdir().unwrap();
    let recorded_topics = [recorded_topic(1, topics::DETECTION)];
    for hangs in [false, true] {
        let path = folder.path().join(format!("run {hangs}"));
        let (go, wait) = disk_that_waits();
        let (mut recorder, _written) = recorder_before(&path, &recorded_topics, wait, ROOM);
        take(&mut recorder, &recorded_topics[0], 20);
        let closing = recorder.close(&Ending::completed());
        // The topic is added, and the thread is at the first message.
        while closing.progress().0 == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        if hangs {
            assert!(!closing.end(), "nobody can end it");
            drop(go);
        } else {
            let releasing = std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(100));
                drop(go);
            });
            assert!(closing.end(), "it ends with the message that it is at");
            assert!(!path.join("metadata.yaml").exists(), "the bag is not closed");
            releasing.join().expect("it does not panic");
        }
    }
}

#[test]
fn a_full_queue_is_reported_once_and_what_it_drops_is_counted_in_the_bag() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let recorded_topics = [recorded_topic(1, topics::DETECTION)];
    let (go, gone) = std::sync::mpsc::channel::<()>();
    let stuck = move |job: &Job| {
        if matches!(job, Job::Write(message) if message.sequence == 1) {
            gone.recv().unwrap();
        }
    };
    let room = Room { messages: 10, bytes: 1 << 20 };
    let (mut recorder, mut written) = recorder_before(&path, &recorded_topics, stuck, room);

    let taken: Vec<_> =
        (1..=15).map(|sequence| recorder.take(0, &recorded_topics[0], &sample(sequence))).collect();
    go.send(()).unwrap();
    recorder.close(&Ending::completed());
    let summary = summary(&mut written);

    let refused: Vec<usize> =
        (0..15).filter(|index| taken[*index].is_err()).map(|index| index + 1).collect();
    assert_eq!(refused, [11]);
    let error = taken[10].as_ref().unwrap_err().to_string();
    assert!(error.starts_with("the disk is too slow: 10 messages wait"), "{error}");
    assert_eq!(summary.n_messages, 10 + ENDING_MESSAGE);
    let bag = Bag::open(&path).unwrap();
    let given = bag.metadata(RECORDING).unwrap();
    assert_eq!(given["n_overflowed"], "5");
    assert_eq!(given["n_overflowed /robot_1/detection"], "5");
}

#[test]
fn a_bag_that_cannot_be_closed_is_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let (recorder, mut written) = recorder(&path, &[]);
    assert!(matches!(written.blocking_recv(), Some(Written::Opened)));
    // Its metadata has no folder to lie in.
    std::fs::remove_dir_all(&path).unwrap();

    recorder.close(&Ending::completed());

    let last = std::iter::from_fn(|| written.blocking_recv()).last();
    assert!(matches!(last, Some(Written::NotClosed(_))), "{last:?}");
}

#[test]
fn a_run_that_breaks_off_leaves_what_was_in_the_queue() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let recorded_topics = [recorded_topic(1, topics::DETECTION)];
    let is_first = |job: &Job| matches!(job, Job::Write(message) if message.sequence == 1);
    let (mut recorder, _written) =
        recorder_before(&path, &recorded_topics, slow_disk(is_first), ROOM);

    take(&mut recorder, &recorded_topics[0], 20);
    drop(recorder);

    let bag = Bag::open(&path).unwrap();
    assert_eq!(bag.messages().flatten().count(), 20);
}

#[test]
fn a_hundred_robots_with_three_topics_at_20_hz_are_recorded_without_loss() {
    let name =
        "recorder::tests::a_hundred_robots_with_three_topics_at_20_hz_are_recorded_without_loss";
    in_own_network(name, async || {
        let topics = [topics::DETECTION, topics::CMD_VEL, topics::ODOM];
        let recorded_topics: Vec<RecordedTopic> = (0..N_ROBOTS)
            .flat_map(|robot| topics.map(|topic| recorded_topic(robot, topic)))
            .collect();
        let (robots, listener) = (session(), session());
        let (sender, mut samples) = unbounded_channel();
        let _subscriptions = recorded_topics::listen(
            &listener,
            &recorded_topics,
            &recorded_topics::Queue::new(sender),
        )
        .unwrap();
        let mut publishers = Vec::new();
        for recorded_topic in &recorded_topics {
            // As deep as the recorder's subscriptions, because this machine may be busy with other tests.
            let qos = Qos::reliable(100);
            let publisher =
                robots.publish_raw(&recorded_topic.name, &recorded_topic.type_name, qos).unwrap();
            let message = match recorded_topic.type_name.as_str() {
                name if name == topics::DETECTION.type_name => cdr::encode(&Bool { data: true }),
                name if name == topics::CMD_VEL.type_name => cdr::encode(&TwistStamped::default()),
                _ => cdr::encode(&Odometry::default()),
            };
            publishers.push((publisher, message));
        }
        for recorded_topic in &recorded_topics {
            robots.wait_for_readers(&recorded_topic.name, 1, TIMEOUT).await.unwrap();
            listener.wait_for_writers(&recorded_topic.name, 1, TIMEOUT).await.unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        let (mut recorder, mut written) = recorder(&folder.path().join("run"), &recorded_topics);

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
            for n_recorded in 0..recorded_topics.len() * N_STEPS {
                let sample = tokio::time::timeout(TIMEOUT, samples.recv()).await;
                let Ok(Some(sample)) = sample else { panic!("only {n_recorded} samples came") };
                let index = sample.topic_index;
                recorder.take(index, &recorded_topics[index], &sample.received).unwrap();
            }
        };
        futures::join!(publish, record);
        recorder.close(&Ending::completed());
        let closed = tokio::task::spawn_blocking(move || summary(&mut written));
        let summary = closed.await.expect("the bag is closed");

        let mut counts = summary.n_messages_of_topic;
        assert_eq!(counts.remove(topics::ENDING.name), Some(ENDING_MESSAGE));
        assert_eq!(counts.len(), recorded_topics.len());
        assert!(counts.values().all(|n| *n == N_STEPS as u64));
        let bag = Bag::open(&summary.folder).unwrap();
        assert_eq!(bag.metadata("rsrs.recording").unwrap()["n_missing"], "0");
        drop(publishers);
        robots.close().await;
        listener.close().await;
    });
}

#[test]
fn a_run_in_lockstep_begins_with_its_first_step_however_late_its_lease_comes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let of = |topic: Topic, role| RecordedTopic::new(topic.name.to_owned(), topic, role);
    let recorded_topics =
        [of(topics::WORLD_DIGEST, Role::WorldDigest), of(topics::LEASE, Role::Lease)];
    let (mut recorder, mut written) = recorder(&path, &recorded_topics);
    let steps = Steps::new(std::iter::once(0));
    let period_ns = 100_000_000;
    recorder.clock = BagClock::Lockstep { period_ns, now_ns: 0, steps, has_begun: false };
    "ours".clone_into(&mut recorder.run_id);
    let mut take = |index: usize, message: Vec<u8>| {
        let received = ReceivedRaw { message, ..sample(1) };
        recorder.take(index, &recorded_topics[index], &received).unwrap();
    };
    let lease = |state: LeaseState, run_id: &str| {
        let (state, run_id) = (state.into(), run_id.to_owned());
        cdr::encode(&RunLease { state, run_id, ..RunLease::default() })
    };

    take(1, lease(LeaseState::Armed, "ours"));
    (1..=3).for_each(|step| take(0, cdr::encode(&WorldDigest { step, digest: 7 })));
    take(1, lease(LeaseState::Running, "theirs"));
    take(1, lease(LeaseState::Running, "ours"));
    take(1, lease(LeaseState::Running, "ours"));
    take(0, cdr::encode(&WorldDigest { step: 4, digest: 7 }));
    take(1, lease(LeaseState::Stopped, "ours"));

    recorder.close(&Ending::completed());
    summary(&mut written);
    let bag = Bag::open(&path).unwrap();
    let mut leases: Vec<(u64, u8)> = bag
        .messages_on([topics::LEASE.name])
        .map(|it| it.unwrap())
        .map(|it| (it.log_time_ns, cdr::decode::<RunLease>(&it.bytes).unwrap()))
        .filter(|(_, lease)| lease.run_id == "ours")
        .map(|(log_time_ns, lease)| (log_time_ns / period_ns, lease.state))
        .collect();
    leases.sort_unstable();
    assert_eq!(leases, [(0, 1), (1, 2), (3, 2), (4, 3)]);
}

#[test]
fn errors_of_the_disk_keep_their_reason() {
    let source = io::Error::from(io::ErrorKind::StorageFull);
    let reason = source.to_string();
    let path = std::path::PathBuf::from("run");

    let error = RecorderError::from(BagError::Write { path, source: source.into() });

    let printed = error.in_full();
    assert!(
        printed.starts_with("cannot record into run: ") && printed.ends_with(&reason),
        "{printed}"
    );
}
