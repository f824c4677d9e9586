//! What a run does when something goes wrong: programs over DDS, as a laboratory starts them.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::fleet::{ROBOTS, experiment, node, signal};
use crate::processes::{Process, confined_rsrs, in_own_network, nodes_of, rsrs};
use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_msgs::rsrs::{Recorded, RobotState, RobotStatus};
use rsrs_msgs::topics;
use rsrs_ros::session::{NodeHandle, Session, Subscription};
use rsrs_testing::network::{TIMEOUT, eventually, session};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// So long that no run of a test comes to its end.
const ENDLESS_S: u64 = 100_000;

/// Starts a run with the simulator in a network of its own.
fn start_run(folder: &Path, changes: &[(&str, &str)]) -> Process {
    let experiment = experiment(folder, ENDLESS_S, changes);
    let mut command = confined_rsrs();
    Process::start(command.current_dir(folder).arg("run").arg(experiment).args(["-o", "bag"]))
}

/// Waits until a run is under way: its bag has grown.
fn wait_until_it_runs(folder: &Path, process: &mut Process) {
    let start = Instant::now();
    let bag = folder.join("bag/bag_0.mcap");
    while !std::fs::metadata(&bag).is_ok_and(|file| file.len() > 100_000) {
        assert!(start.elapsed() < TIMEOUT, "the run does not start");
        if let Some(status) = process.0.try_wait().expect("it is our child") {
            let (_, errors) = process.wait();
            panic!("the run ended: {status}\n{errors}");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn ending_of(bag: &Path) -> Ending {
    let bag = Bag::open(bag).expect("the bag is whole");
    assert_eq!(bag.damage().len(), 0);
    let pairs = bag.metadata(ENDING).expect("a bag that was closed states how it ended");
    Ending::from_pairs(pairs).expect("it is an ending")
}

#[test]
fn an_interrupted_run_closes_its_bag_and_leaves_no_process() {
    for (name, reason, code) in [("INT", "interrupted", 130), ("TERM", "asked to terminate", 143)] {
        let folder = tempfile::tempdir().unwrap();
        let mut process = start_run(folder.path(), &[]);
        let pid = process.0.id();
        wait_until_it_runs(folder.path(), &mut process);
        assert_eq!(nodes_of(pid).len(), 2);

        signal(&process, name);
        let (status, errors) = process.wait();

        assert_eq!(status.code(), Some(code), "{errors}");
        assert!(errors.contains(&format!("run aborted: {reason}")), "{errors}");
        assert_eq!(nodes_of(pid), Vec::<u32>::new());
        let expected =
            Ending { kind: EndingKind::Aborted, reason: reason.to_owned(), ..Ending::completed() };
        assert_eq!(ending_of(&folder.path().join("bag")), expected);
    }
}

#[test]
fn nodes_end_with_a_run_that_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let mut process = start_run(folder.path(), &[]);
    let pid = process.0.id();
    wait_until_it_runs(folder.path(), &mut process);

    signal(&process, "KILL");
    process.wait();

    let start = Instant::now();
    while !nodes_of(pid).is_empty() {
        assert!(start.elapsed() < TIMEOUT, "nodes outlive their run");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_run_whose_simulator_dies_reports_it_and_closes_its_bag() {
    let folder = tempfile::tempdir().unwrap();
    let mut process = start_run(folder.path(), &[]);
    wait_until_it_runs(folder.path(), &mut process);
    let nodes = nodes_of(process.0.id());
    let is_simulator = |pid: &&u32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap();
        String::from_utf8_lossy(&line).contains("\0sim\0")
    };
    let simulator = nodes.iter().find(is_simulator).unwrap().to_string();

    let killed = std::process::Command::new("kill").args(["-s", "KILL", &simulator]).status();

    assert!(killed.unwrap().success());
    let (status, errors) = process.wait();
    assert_eq!(status.code(), Some(1), "{errors}");
    assert!(errors.contains("the process of the node `sim` ended"), "{errors}");
    assert_eq!(ending_of(&folder.path().join("bag")).kind, EndingKind::Aborted);
}

#[test]
fn a_robot_that_rejects_its_parameters_is_named_and_nothing_is_recorded() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        // By their profile the robots may be that fast; their controllers were started with less.
        let faster = [
            ("speed_m_s: 0.15", "speed_m_s: 0.6"),
            ("limits_m_s: [0.02, 0.30]", "limits_m_s: [0.02, 0.70]"),
        ];
        let experiment = experiment(folder.path(), ENDLESS_S, &faster);
        let _simulator = node("sim", &ROBOTS);
        let _controllers = node("controller", &ROBOTS);
        let bag = folder.path().join("bag");
        let mut runner = start_runner(&experiment, &bag);

        let (status, errors) = runner.wait();

        assert_eq!(status.code(), Some(1), "{errors}");
        assert!(errors.contains("robot_9: parameters not set"), "{errors}");
        assert!(errors.contains("must be between -0.3 and 0.3, found 0.6"), "{errors}");
        assert!(!bag.exists());
    });
}

#[test]
fn a_bag_that_exists_is_refused_before_anything_starts() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("bag")).unwrap();
    let mut process = start_run(folder.path(), &[]);

    let (status, errors) = process.wait();

    assert_eq!(status.code(), Some(1), "{errors}");
    assert!(errors.contains("bag exists"), "{errors}");
    assert_eq!(std::fs::read_dir(folder.path().join("bag")).unwrap().count(), 0);
}

#[test]
fn a_robot_that_is_missing_is_named_at_preflight() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let experiment = experiment(folder.path(), ENDLESS_S, &[]);
        let _simulator = node("sim", &ROBOTS[..8]);
        let _controllers = node("controller", &ROBOTS[..8]);
        let bag = folder.path().join("bag");
        let mut runner = start_runner(&experiment, &bag);

        let (status, errors) = runner.wait();

        assert_eq!(status.code(), Some(1), "{errors}");
        assert!(errors.contains("robot_9: no status received"), "{errors}");
        assert!(errors.contains("robot_9: no status of its controller received"), "{errors}");
        assert!(!errors.contains("robot_8"), "{errors}");
        assert!(!bag.exists());
    });
}

fn start_runner(experiment: &Path, bag: &Path) -> Process {
    let mut command = rsrs();
    command.args(["node", "runner", "--backend", "sim", "--interface", "127.0.0.1"]);
    Process::start(command.arg("--experiment").arg(experiment).arg("--output").arg(bag))
}

#[test]
fn without_its_runner_every_robot_stands_and_the_bag_reads_to_its_last_second() {
    in_own_network(killed_runner);
}

/// A robot stands 500 ms after the status that the last lease echoed; the rest is for the status to
/// arrive on a busy machine.
const STANDS_WITHIN: Duration = Duration::from_secs(2);

async fn killed_runner() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let experiment = experiment(folder.path(), ENDLESS_S, &[]);
    let _simulator = node("sim", &ROBOTS);
    let _controllers = node("controller", &ROBOTS);
    let session = session();
    let witness_node = session.node("/", "witness").expect("the name is allowed");
    let (received, mut statuses) = unbounded_channel();
    let (to_steps, mut steps) = unbounded_channel();
    let subscriptions = witness(&session, &witness_node, &received, &to_steps);
    let bag = folder.path().join("bag");
    let runner = start_runner(&experiment, &bag);
    let mut states = [u8::from(RobotState::Idle); ROBOTS.len()];
    let mut recorded = 0;
    eventually("the run has made 1,000 steps with all robots moving", || {
        update(&mut states, &mut statuses);
        recorded = last(&mut steps).unwrap_or(recorded);
        recorded >= 1000 && states == [RobotState::Moving; ROBOTS.len()]
    })
    .await;

    signal(&runner, "KILL");
    let killed = Instant::now();
    eventually("every robot stands", || {
        update(&mut states, &mut statuses);
        states == [RobotState::Stopped; ROBOTS.len()]
    })
    .await;
    let stood_after = killed.elapsed();

    assert!(stood_after <= STANDS_WITHIN, "after {stood_after:?}");
    recorded = last(&mut steps).unwrap_or(recorded);
    let bag = Bag::open(&bag).expect("a killed recorder leaves a readable bag");
    let last_ns = bag.messages().map_while(Result::ok).map(|message| message.log_time_ns).max();
    let lost_ns = (recorded * 130_000_000).saturating_sub(last_ns.expect("it holds messages"));
    assert!(lost_ns <= 1_130_000_000, "{lost_ns} ns of the recording are lost");
    drop(subscriptions);
    session.close().await;
}

type Statuses = (usize, RobotStatus);

/// Receives every robot's status and what the recorder has taken.
fn witness(
    session: &Session,
    node: &NodeHandle,
    statuses: &UnboundedSender<Statuses>,
    steps: &UnboundedSender<u64>,
) -> Vec<Subscription> {
    let topic = topics::STATUS;
    let mut subscriptions: Vec<Subscription> = ROBOTS
        .iter()
        .enumerate()
        .map(|(index, robot)| {
            let statuses = statuses.clone();
            session
                .subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
                    // The test has ended when nobody listens.
                    drop(statuses.send((index, sample.message)));
                })
                .expect("the topic is allowed")
        })
        .collect();
    let steps = steps.clone();
    let topic = topics::RECORDED;
    let recorded = session.subscribe(node, topic.name, topic.qos, move |sample| {
        let recorded: Recorded = sample.message;
        // The test has ended when nobody listens.
        steps.send(recorded.step).unwrap_or_default();
    });
    subscriptions.push(recorded.expect("the topic is allowed"));
    subscriptions
}

fn update(states: &mut [u8; ROBOTS.len()], statuses: &mut UnboundedReceiver<Statuses>) {
    while let Ok((robot, status)) = statuses.try_recv() {
        states[robot] = status.state;
    }
}

fn last(steps: &mut UnboundedReceiver<u64>) -> Option<u64> {
    let mut last = None;
    while let Ok(step) = steps.try_recv() {
        last = Some(step);
    }
    last
}
