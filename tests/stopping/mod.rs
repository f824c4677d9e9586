//! `rsrs stop` over DDS, against the simulator's robots, as on a real fleet.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rsrs_bags::Bag;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::rsrs::{RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::fleet::{ROBOTS, experiment, node, signal, start_run};
use crate::processes::{Process, in_own_network, rsrs};
use rsrs_testing::network::{TIMEOUT, eventually, session};

/// A robot stands at once when it receives the e-stop; the rest is for the status to arrive on a busy
/// machine.
const STANDS_WITHIN: Duration = Duration::from_secs(1);

/// Nine simulated robots with their controllers, and a node that receives what they publish.
pub struct FleetUnderTest {
    folder: tempfile::TempDir,
    experiment: PathBuf,
    simulator: Process,
    controllers: Process,
    session: Session,
    pub watch: Watch,
}

/// What was received from the robots.
pub struct Watch {
    _subscriptions: Vec<Subscription>,
    received: UnboundedReceiver<Input>,
    robots: [RobotStatus; ROBOTS.len()],
    has_moved: bool,
    /// When the e-stop was engaged first, and when the last robot stood because of it.
    engaged: Option<Instant>,
    stood: Option<Instant>,
}

enum Input {
    Status(usize, Box<RobotStatus>, Instant),
    EStop(bool, Instant),
}

impl FleetUnderTest {
    pub async fn new(robots: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let experiment = experiment(folder.path(), 1_000, &[("time: lockstep", "time: real_time")]);
        let (simulator, controllers) = (node("sim", robots), node("controller", robots));
        let session = session();
        let node = session.node("/", "witness").expect("the name is allowed");
        let watch = Watch::new(&session, &node);
        let fleet = Self { folder, experiment, simulator, controllers, session, watch };
        if robots.len() == ROBOTS.len() {
            fleet.place(&node).await;
        }
        fleet
    }

    /// Puts the simulator's robots where the experiment wants them.
    async fn place(&self, node: &NodeHandle) {
        let plan = Plan::read(&Request {
            experiment: self.experiment.clone(),
            cell: None,
            from: None,
            backend: Backend::Simulator,
            bag: Some(self.folder.path().join("none")),
            seed: None,
            place_check: PlaceCheck::Off,
            other_profile: OtherProfile::Refused,
        })
        .expect("the shipped experiment is good");
        let conditions =
            serde_json::to_string(&plan.record.conditions).expect("conditions are plain data");
        let values = [
            ("conditions", ParameterValue::String(conditions)),
            ("seed", ParameterValue::Integer(1)),
            ("replicate", ParameterValue::Integer(0)),
            ("steps", ParameterValue::Integer(100_000)),
            ("time", ParameterValue::String("real_time".to_owned())),
        ]
        .map(|(name, value)| (name.to_owned(), value));
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(&self.session, node, options);
        client.set_atomically("/simulator", &values).await.expect("the simulator takes it");
    }

    pub fn bag(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the experiment on these robots as if they were real.
    pub fn start_run(&self, bag: &str) -> Process {
        start_run(&self.experiment, &self.bag(bag))
    }

    pub async fn wait_until_all_move(&mut self) {
        let watch = &mut self.watch;
        eventually("all robots move", || {
            watch.update();
            watch.robots.iter().all(|status| status.state == RobotState::Moving)
        })
        .await;
    }

    pub async fn close(self) {
        let Self { session, watch, simulator, controllers, .. } = self;
        drop((watch, simulator, controllers));
        session.close().await;
    }
}

impl Watch {
    fn new(session: &Session, node: &NodeHandle) -> Self {
        let (sender, received) = unbounded_channel();
        let topic = topics::STATUS;
        let mut subscriptions: Vec<_> = (0..ROBOTS.len())
            .map(|robot| {
                let sender: UnboundedSender<Input> = sender.clone();
                session
                    .subscribe(node, &topic.for_robot(ROBOTS[robot]), topic.qos, move |sample| {
                        let status = Box::new(sample.message);
                        // The test has ended when nobody listens.
                        drop(sender.send(Input::Status(robot, status, Instant::now())));
                    })
                    .expect("the topic is allowed")
            })
            .collect();
        let topic = topics::E_STOP;
        let e_stop = session.subscribe(node, topic.name, topic.qos, move |sample| {
            let Bool { data } = sample.message;
            // The test has ended when nobody listens.
            drop(sender.send(Input::EStop(data, Instant::now())));
        });
        subscriptions.push(e_stop.expect("the topic is allowed"));
        Self {
            _subscriptions: subscriptions,
            received,
            robots: std::array::from_fn(|_| RobotStatus::default()),
            has_moved: false,
            engaged: None,
            stood: None,
        }
    }

    pub fn update(&mut self) {
        while let Ok(received) = self.received.try_recv() {
            match received {
                Input::EStop(engaged, at) => {
                    if engaged {
                        self.engaged.get_or_insert(at);
                    }
                }
                Input::Status(robot, status, at) => {
                    self.has_moved |= status.state == RobotState::Moving;
                    self.robots[robot] = *status;
                    if self.stood.is_none() && self.all_hold() {
                        self.stood = Some(at);
                    }
                }
            }
        }
    }

    /// Whether every robot stands because of the e-stop.
    pub fn all_hold(&self) -> bool {
        self.robots
            .iter()
            .all(|status| status.state == RobotState::Stopped && status.stop_reason == "e-stop")
    }
}

/// Waits for the end of a process, while the watch goes on: its exit code, standard output and standard
/// error.
async fn ended(mut process: Process) -> (Option<i32>, String, String) {
    let wait = move || {
        let (status, text, errors) = process.output();
        (status.code(), text, errors)
    };
    tokio::task::spawn_blocking(wait).await.expect("waiting does not panic")
}

/// Runs `rsrs stop` to its end.
async fn stop(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = rsrs();
    command.args(["stop", "--interface", "127.0.0.1"]).args(arguments);
    ended(Process::start(&mut command)).await
}

fn fleet_file(experiment: &Path) -> String {
    let folder = experiment.parent().expect("it is in a folder");
    folder.join("../fleets/nine_virtual.yaml").display().to_string()
}

fn ending_of(bag: &Path) -> Ending {
    let bag = Bag::open(bag).expect("the bag is whole");
    let pairs = bag.metadata(ENDING).expect("a bag that was closed states how it ended");
    Ending::from_pairs(pairs).expect("it is an ending")
}

#[test]
fn a_stop_in_the_middle_of_a_run_stops_the_fleet_until_it_is_released() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let run = fleet.start_run("bag");
        fleet.wait_until_all_move().await;

        let (code, table, errors) = stop(&["--fleet", &fleet_file(&fleet.experiment)]).await;
        fleet.watch.update();

        assert_eq!(code, Some(0), "{table}\n{errors}");
        let rows: Vec<_> = table.lines().filter(|line| line.contains("stopped: e-stop")).collect();
        assert_eq!(rows.len(), 9, "{table}");
        let (engaged, stood) = (fleet.watch.engaged, fleet.watch.stood);
        let engaged = engaged.expect("`rsrs stop` engages the e-stop");
        let stood = stood.expect("every robot has acknowledged");
        let stood_after = stood.saturating_duration_since(engaged);
        assert!(stood_after <= STANDS_WITHIN, "after {stood_after:?}");
        let (code, _, errors) = ended(run).await;
        assert_eq!(code, Some(1), "{errors}");
        for expected in [
            "all 9 robots stand where they should start",
            "the robots move in 3 s",
            "the robots move in 1 s",
            "run aborted: e-stop",
            "rsrs stop --release",
        ] {
            assert!(errors.contains(expected), "no `{expected}` in:\n{errors}");
        }
        let expected = Ending {
            kind: EndingKind::Aborted,
            reason: "e-stop".to_owned(),
            ..Ending::completed()
        };
        assert_eq!(ending_of(&fleet.bag("bag")), expected);
        // Whoever engaged it has left long ago, and still they stand.
        tokio::time::sleep(Duration::from_secs(1)).await;
        fleet.watch.update();
        assert!(fleet.watch.all_hold(), "{:?}", fleet.watch.robots);

        let (code, table, errors) = stop(&["--release"]).await;
        assert_eq!(code, Some(0), "{table}\n{errors}");
        let run = fleet.start_run("next_bag");
        fleet.wait_until_all_move().await;

        let (code, _, errors) = stop(&["--release"]).await;
        assert_eq!(
            (code, errors.trim()),
            (Some(3), "robots are in a run: nothing was published to them")
        );
        signal(&run, "INT");
        fleet.close().await;
    });
}

#[test]
fn a_stop_works_when_everything_else_is_killed() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let run = fleet.start_run("bag");
        fleet.wait_until_all_move().await;

        signal(&run, "KILL");
        signal(&fleet.controllers, "KILL");
        let (code, table, errors) = stop(&["--format", "json"]).await;

        assert_eq!(code, Some(0), "{table}\n{errors}");
        let report: serde_json::Value = serde_json::from_str(&table).expect("it is JSON");
        assert_eq!(report["acknowledged"], true);
        assert_eq!(report["robots"].as_array().map(Vec::len), Some(9));
        let watch = &mut fleet.watch;
        eventually("what the stop received is received here, too", || {
            watch.update();
            watch.all_hold()
        })
        .await;
        fleet.close().await;
    });
}

#[test]
fn a_robot_that_does_not_acknowledge_is_named() {
    in_own_network(async || {
        let fleet = FleetUnderTest::new(&ROBOTS[..8]).await;

        let (code, table, errors) = stop(&["--fleet", &fleet_file(&fleet.experiment)]).await;

        assert_eq!(code, Some(3), "{table}\n{errors}");
        assert!(table.contains("robot_9  NO             -  no status received"), "{table}");
        assert!(errors.contains("by 1 of 9 robots, go and look: robot_9"), "{errors}");
        assert_eq!(table.matches("stopped: e-stop").count(), 8, "{table}");
        fleet.close().await;
    });
}

#[test]
fn an_interrupted_countdown_moves_no_robot() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let run = fleet.start_run("bag");
        let watch = &mut fleet.watch;
        eventually("all robots are armed", || {
            watch.update();
            watch.robots.iter().all(|status| status.state == RobotState::Armed)
        })
        .await;

        signal(&run, "INT");
        let (code, _, errors) = ended(run).await;
        fleet.watch.update();

        assert_eq!(code, Some(130), "{errors}");
        assert!(errors.contains("run aborted: interrupted"), "{errors}");
        assert!(!fleet.watch.has_moved);
        assert!(fleet.watch.robots.iter().all(|status| status.state == RobotState::Stopped));
        fleet.close().await;
    });
}

#[test]
fn a_stop_with_nobody_there_reports_it() {
    in_own_network(async || {
        let (code, table, errors) = stop(&[]).await;

        assert_eq!((code, table.trim()), (Some(3), "no robot found"));
        assert!(errors.contains("is this their interface, and their ROS_DOMAIN_ID?"), "{errors}");
    });
}

/// Publishes on the e-stop topic, ten times a second, whether it is engaged.
async fn publish_all_the_time(publisher: &Publisher<Bool>, engaged: &AtomicBool) {
    let mut beat = tokio::time::interval(Duration::from_millis(100));
    loop {
        beat.tick().await;
        let data = engaged.load(Ordering::Relaxed);
        publisher.publish(Bool { data }).await.expect("a healthy network");
    }
}

/// Names robots that no network has, and more than anybody follows.
async fn publish_nonsense(publisher: &Publisher<RunLease>) {
    let mut beat = tokio::time::interval(Duration::from_millis(100));
    let names = ["", "no robot", "a//b", "x__y"].map(str::to_owned);
    loop {
        beat.tick().await;
        let lease = RunLease { robots: names.to_vec(), ..RunLease::default() };
        publisher.publish(lease).await.expect("a healthy network");
    }
}

#[test]
fn nobody_undoes_the_stop_of_another_and_a_release_names_who_still_holds() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let session = session();
        let node = session.node("/panel", "button").expect("the name is allowed");
        let topic = topics::E_STOP;
        let button = session.publish_on(&node, topic.name, topic.qos).expect("it is allowed");
        let topic = topics::LEASE;
        let nonsense = session.publish_on(&node, topic.name, topic.qos).expect("it is allowed");
        let engaged = AtomicBool::new(false);
        let others = async {
            tokio::join!(publish_all_the_time(&button, &engaged), publish_nonsense(&nonsense));
        };
        tokio::select! {
            () = others => {}
            () = stop_among_others(&mut fleet, &engaged) => {}
        }
        drop((button, nonsense));
        session.close().await;
        fleet.close().await;
    });
}

async fn stop_among_others(fleet: &mut FleetUnderTest, engaged: &AtomicBool) {
    let (code, table, errors) = stop(&[]).await;
    assert_eq!(code, Some(0), "{table}\n{errors}");
    assert_eq!(table.matches("stopped: e-stop").count(), 9, "{table}");
    // The button goes on publishing `false`.
    tokio::time::sleep(Duration::from_secs(1)).await;
    fleet.watch.update();
    assert!(fleet.watch.all_hold(), "{:?}", fleet.watch.robots);

    engaged.store(true, Ordering::Relaxed);
    let (code, table, errors) = stop(&["--release"]).await;
    assert_eq!(code, Some(3), "{table}\n{errors}");
    assert!(errors.contains("still held by /panel/button"), "{errors}");
    fleet.watch.update();
    assert!(fleet.watch.all_hold(), "{:?}", fleet.watch.robots);

    engaged.store(false, Ordering::Relaxed);
    let (code, table, errors) = stop(&["--release"]).await;
    assert_eq!(code, Some(0), "{table}\n{errors}");
}

#[test]
fn a_stranger_who_steers_a_robot_ends_the_run_and_is_named() {
    in_own_network(async || {
        let mut fleet = FleetUnderTest::new(&ROBOTS).await;
        let run = fleet.start_run("bag");
        fleet.wait_until_all_move().await;

        let session = session();
        let node = session.node("/", "teleop").expect("the name is allowed");
        let topic = topics::CMD_VEL;
        let teleop: Publisher<TwistStamped> = session
            .publish_on(&node, &topic.for_robot("robot_3"), topic.qos)
            .expect("it is allowed");
        let (code, _, errors) = ended(run).await;
        drop(teleop);
        session.close().await;

        assert_eq!(code, Some(1), "{errors}");
        let expected = "run aborted: a second publisher of /robot_3/cmd_vel: node /teleop";
        assert!(errors.contains(expected), "{errors}");
        assert_eq!(ending_of(&fleet.bag("bag")).kind, EndingKind::Aborted);
        fleet.close().await;
    });
}
