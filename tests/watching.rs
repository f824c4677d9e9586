//! `rsrs watch` in a window: over a fleet of the simulator's, and over bags.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs;
use rsrs_msgs::topics;
use rsrs_ros::session::{Endpoint, Publisher, Session};
use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::network::{CYCLONE_ON_LOOPBACK, TIMEOUT, eventually, session};
use rsrs_testing::python;
use rsrs_testing::record::fleet_record;

use crate::command;
use crate::fleet::{ROBOTS, signal};
use crate::processes::{Process, in_own_network, rsrs};
use crate::simulated_bags::Run;
use crate::stopping::FleetUnderTest;
use crate::terminal::Window;

fn watch(arguments: &[&str]) -> Command {
    let mut command = rsrs();
    command.arg("watch").args(arguments);
    command
}

#[test]
fn a_fleet_that_runs_is_watched_and_stopped_with_a_key() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let mut window = Window::open(&watch(&["--interface", "127.0.0.1"]), (100, 30));
        window.wait_until("nine robots without a run", |text| text.matches(" idle ").count() == 9);
        assert!(window.text().contains("no run: no lease is received"), "{}", window.text());

        let mut run = fleet.start_run("bag");
        fleet.wait_until_all_move().await;
        window.wait_until("nine robots that move", |text| text.matches(" moving ").count() == 9);
        window.wait_for("RUNNING ");
        window.wait_for("circliness");
        for row in window.text().lines().filter(|row| row.starts_with("robot_")) {
            let rates = row.split_whitespace().skip(3).take(3);
            let is_rate = |rate: &str| rate.parse::<f64>().is_ok_and(|hz| hz > 1.0);
            assert!(rates.clone().all(is_rate), "{row}\n{}", window.text());
        }
        window.resize((60, 20));
        window.wait_until("a narrow screen", |text| {
            text.lines().all(|row| row.chars().count() <= 60) && text.contains(" moving ")
        });

        window.press("s");
        window.wait_for("9 of 9 robots stand");
        window.wait_for("E-STOP holds 9 of 9");
        // Which the test receives as well.
        eventually("every robot stands", || {
            fleet.watch.update();
            fleet.watch.all_hold()
        })
        .await;

        window.press("q");
        assert_eq!(window.ended().code(), Some(0), "{}", window.text());
        assert!(window.is_as_before());
        window.wait_for("9 of 9 robots stand");
        run.wait();
        let bag = Bag::open(&fleet.bag("bag")).expect("the bag is whole");
        let ending = Ending::from_pairs(bag.metadata(ENDING).expect("it was closed"));
        assert_eq!(ending.expect("it is an ending").kind, EndingKind::Aborted);
        fleet.close().await;
    });
}

#[test]
fn the_window_is_as_before_however_watching_ends() {
    in_own_network(async || {
        let opened = || {
            let mut window = Window::open(&watch(&["--interface", "127.0.0.1"]), (80, 24));
            window.wait_for("looking for robots");
            window
        };
        for keys in ["q", "\u{1b}", "\u{3}"] {
            let mut window = opened();
            assert!(!window.is_as_before());

            window.press(keys);

            assert_eq!(window.ended().code(), Some(0), "{keys:?}: {}", window.text());
            assert!(window.is_as_before(), "{keys:?}: {}", window.text());
        }
        let mut window = opened();

        signal(window.process(), "TERM");

        assert_eq!(window.ended().code(), Some(0), "{}", window.text());
        assert!(window.is_as_before(), "{}", window.text());
    });
}

#[test]
fn a_key_that_is_pressed_while_the_size_changes_is_not_lost() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bag = Run::new(1).record(folder.path(), "run");
    let mut window = Window::open(&watch(&[bag.to_str().expect("its path is text")]), (80, 24));
    window.wait_for("x1");

    for change in 0..40_u16 {
        // The second change and the key come while the screen is drawn because of the first one.
        window.resize((81, 24));
        std::thread::sleep(Duration::from_millis(u64::from(change % 5)));
        window.resize((80, 24));
        window.press(" ");
        let is_paused = change % 2 == 0;
        window.wait_until("every key", |text| text.contains("paused") == is_paused);
    }

    window.press("q");
    assert_eq!(window.ended().code(), Some(0), "{}", window.text());
}

#[test]
fn a_bag_is_watched_to_its_end_where_it_has_the_phase_of_its_label() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bag = Run::new(1).record(folder.path(), "run");
    let bag = bag.to_str().expect("its path is text");
    let label = command::json(&command::rsrs(folder.path(), &["label", bag, "--format", "json"]));
    let mut window = Window::open(&watch(&[bag]), (80, 24));

    window.wait_for("x1");
    window.press(" ");
    window.wait_for("paused");
    window.press("\u{1b}[C");
    window.wait_for(" of 60 s");
    window.press(" ++++++");
    window.wait_for(" end");

    let circliness = label[0]["evidence"]["circliness"].as_f64().expect("it was judged");
    let phase = label[0]["phase"].as_str().expect("it was judged").replace('_', " ");
    let text = window.text();
    assert!(text.contains(&phase) || text.contains(&phase.replace("semi ", "semi-")), "{text}");
    assert!(text.contains(&format!("circliness {circliness:.2}")), "{text}");
    assert!(text.contains("last 60 s"), "{text}");
    window.press("q");
    assert_eq!(window.ended().code(), Some(0), "{}", window.text());
    assert!(window.is_as_before());
}

#[test]
fn without_a_terminal_it_prints_what_to_do() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = command::rsrs(folder.path(), &["watch", "some_bag"]);

    assert_eq!(command::code(&output), 1);
    let errors = command::stderr(&output);
    assert!(errors.contains("standard output is not a terminal"), "{errors}");
    assert!(errors.contains("ssh -t"), "{errors}");
}

/// What anybody may publish: a robot that obeys nobody and writes over the table of others, a record of
/// another world, and, over Cyclone DDS, topics of no ROS name.
struct Stranger {
    _script: Process,
    status: Publisher<RobotStatus>,
    record: Publisher<std_msgs::String>,
    lease: Publisher<RunLease>,
}

/// Up a line, over it, and hidden from there on.
const HOSTILE: &str =
    "stopped by the e-stop \u{1b}[1A\r\u{1b}[2Krobot_8  yes\u{1b}[1B\r\u{1b}[8m\u{9b}2J";

impl Stranger {
    fn start(session: &Session) -> Self {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/watching/stranger.py");
        let python = python::python_with(&python::CYCLONE);
        let names = ["rt/my-robot/detection", "rt/9/detection"];
        let node = session.node("/", "stranger").expect("the name is allowed");
        let robot = topics::STATUS.for_robot("robot_8");
        let publish = "the names are allowed";
        Self {
            _script: Process::start(
                Command::new(python)
                    .arg("-B")
                    .arg(script)
                    .args(names)
                    .env("CYCLONEDDS_URI", CYCLONE_ON_LOOPBACK)
                    .stdin(Stdio::piped()),
            ),
            status: session.publish_on(&node, &robot, topics::STATUS.qos).expect(publish),
            record: session
                .publish_on(&node, topics::EXPERIMENT.name, topics::EXPERIMENT.qos)
                .expect(publish),
            lease: session.publish_on(&node, topics::LEASE.name, topics::LEASE.qos).expect(publish),
        }
    }

    async fn publish(&self, counter: u64, state: RobotState) {
        let stop_reason = HOSTILE.to_owned();
        let status = RobotStatus {
            counter,
            epoch: 1,
            state: state.into(),
            stop_reason,
            ..Default::default()
        };
        let lease =
            RunLease { epoch: 1, state: u8::from(LeaseState::Running), ..RunLease::default() };
        let mut record = fleet_record("0", flockbot_conditions());
        record.conditions.period_s = -1.0;
        self.status.publish(status).await.expect("there is a network");
        self.record
            .publish(std_msgs::String { data: record.to_json() })
            .await
            .expect("there is a network");
        self.lease.publish(lease).await.expect("there is a network");
    }

    /// Publishes one state until it is seen.
    async fn until(
        &self,
        counter: &mut u64,
        state: RobotState,
        shown: impl Fn() -> String,
        mut is_seen: impl FnMut() -> bool,
    ) {
        let start = Instant::now();
        while !is_seen() {
            assert!(start.elapsed() < TIMEOUT, "state {state} was never shown: {}", shown());
            *counter += 1;
            self.publish(*counter, state).await;
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }
}

#[test]
fn nothing_that_anybody_publishes_ends_watching_or_writes_over_what_a_stop_shows() {
    // Installed outside of the network without a package index.
    python::python_with(&python::CYCLONE);
    in_own_network(async || {
        let session = session();
        let stranger = Stranger::start(&session);
        let is_odd = |end: &Endpoint| end.topic.contains("my-robot");
        eventually("the odd topic is there", || session.endpoints().iter().any(is_odd)).await;
        let mut counter = 0;
        let window = Window::open(&watch(&["--interface", "127.0.0.1"]), (100, 30));
        let text = || window.text();
        let shows = |word: &str| {
            let row = |line: &str| line.starts_with("robot_8") && line.contains(word);
            window.text().lines().any(row)
        };
        stranger.until(&mut counter, RobotState::Moving, text, || shows("moving")).await;
        stranger.until(&mut counter, RobotState::Fault, text, || shows("FAULT")).await;
        stranger.until(&mut counter, RobotState::Moving, text, || shows("moving")).await;
        assert!(!window.text().contains("my-robot"), "{}", window.text());

        let mut stop = Process::start(rsrs().args(["stop", "--interface", "127.0.0.1"]));
        let ended = |stop: &mut Process| stop.0.try_wait().expect("it is a child").is_some();
        stranger.until(&mut counter, RobotState::Moving, text, || ended(&mut stop)).await;
        let (status, output, errors) = stop.output();

        assert_eq!(status.code(), Some(3), "{output}{errors}");
        let is_obeyed = |c: char| c.is_control() && c != '\n';
        assert!(!format!("{output}{errors}").contains(is_obeyed), "{output:?}{errors:?}");
        assert!(output.contains("robot_8  NO"), "{output}");
        assert!(output.contains("\\u001b[8m"), "{output}");
        assert!(errors.contains("go and look: robot_8"), "{errors}");
    });
}
