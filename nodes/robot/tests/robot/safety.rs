//! When the wheels of a real process stop, over real DDS, seen by the microcontroller that turns
//! them. Each test in a network of its own.

use std::time::{Duration, Instant};

use super::micro::{self, Micro, Socket};
use super::rest_of_fleet::{DIGEST, Node, Runner};
use rsrs_fleet::timing::RESUME_TIMEOUT;
use rsrs_msgs::rsrs::{LeaseState, RobotState};
use rsrs_ros::session::{NodeHandle, Session};
use rsrs_testing::network::{eventually, in_own_network, session};

/// What a busy machine adds to a bound of the protocol.
const SLACK: Duration = Duration::from_millis(250);
/// How long wheels are watched that should stand.
const WATCH: Duration = Duration::from_millis(700);

/// A robot with a microcontroller, and everybody else.
pub struct Scene {
    pub micro: Micro,
    pub node: Node,
    runner: Runner,
    _visitor: NodeHandle,
    session: Session,
    socket: Socket,
}

impl Scene {
    fn start(arguments: &[&str]) -> Self {
        let socket = Socket::new();
        let micro = Micro::plug_in(&socket.path());
        let port = socket.path().display().to_string();
        let node = Node::start(&[&["--driver", "serial", "--port", &port], arguments].concat());
        let session = session();
        let visitor = session.node("/", "visitor").expect("the name is allowed");
        let runner = Runner::start(&session, &visitor);
        Self { micro, node, runner, _visitor: visitor, session, socket }
    }

    /// One that somebody else commands, and that obeys.
    pub async fn commanded(arguments: &[&str]) -> Self {
        let scene = Self::start(&[&["--without-controller"], arguments].concat());
        scene.runner.messages().foreign_controller = Some(DIGEST);
        scene.runner.messages().command = Some((0.1, 0.5));
        scene.drive_in_epoch(1).await;
        scene
    }

    /// Starts a run, in which it may drive.
    pub async fn start_epoch(&self, epoch: u64) {
        self.runner.start_epoch(epoch).await;
    }

    /// Starts a run, in which it drives as it is commanded.
    async fn drive_in_epoch(&self, epoch: u64) {
        self.runner.run_epoch(epoch).await;
        self.wheels_turn().await;
    }

    /// Whether its wheels do what was commanded.
    pub fn drives(&self) -> bool {
        self.micro.wheels() == (100, 500)
    }

    /// The reason in its last status.
    pub fn why_it_stands(&self) -> String {
        self.runner.messages().status.stop_reason.clone()
    }

    async fn wheels_turn(&self) {
        eventually("the wheels do what was commanded", || self.drives()).await;
    }

    /// Waits until the wheels stand, and returns when they did.
    async fn wheels_stand(&self) -> Instant {
        eventually("the wheels stand", || self.micro.wheels() == (0, 0)).await;
        self.micro.inside().wheels.last().expect("they moved before").at
    }

    /// Wheels that stand go on standing.
    async fn still(&self) {
        let before = self.micro.inside().wheels.len();
        tokio::time::sleep(WATCH).await;
        assert_eq!(self.micro.inside().wheels.len(), before, "the wheels moved");
    }

    pub async fn end(self) {
        let Self { node, runner, session, .. } = self;
        drop((node, runner));
        session.close().await;
    }
}

fn assert_within(from: Instant, stood: Instant, bound_ms: u64) {
    let took = stood.saturating_duration_since(from);
    let bound = Duration::from_millis(bound_ms) + SLACK;
    assert!(took <= bound, "the wheels stood after {took:?}, expected at most {bound:?}");
}

#[test]
fn a_robot_mills_by_its_own_controller_and_a_killed_node_stops_the_wheels() {
    in_own_network(
        "safety::a_robot_mills_by_its_own_controller_and_a_killed_node_stops_the_wheels",
        async || {
            let start_values = ["--ros-args", "-p", "speed:=0.15", "-p", "turn_rate:=0.75"];
            let mut scene = Scene::start(&start_values);
            eventually("the controller reports what it drives with", || {
                scene.runner.messages().controller_digest != 0
            })
            .await;
            let digest = scene.runner.messages().controller_digest;
            scene.runner.messages().digest = digest;
            scene.runner.run_epoch(1).await;

            eventually("it turns right", || scene.micro.wheels() == (150, -750)).await;
            scene.micro.inside().seen = "1";
            eventually("it turns left", || scene.micro.wheels() == (150, 750)).await;
            assert!((scene.runner.messages().status.battery_v - 7.4).abs() < 1e-3);

            scene.node.signal(libc::SIGKILL);
            scene.node.wait();
            let killed = Instant::now();
            let stood = scene.wheels_stand().await;
            assert_within(killed, stood, 250);
            scene.end().await;
        },
    );
}

#[test]
fn a_command_beyond_the_limits_stops_the_wheels_at_once() {
    in_own_network("safety::a_command_beyond_the_limits_stops_the_wheels_at_once", async || {
        // With this period, a command is stale after 2.5 s only.
        let scene = Scene::commanded(&["--ros-args", "-p", "period:=1.0"]).await;

        for command in [(f64::NAN, 0.5), (0.1, f64::INFINITY), (1e9, 0.0), (0.31, 0.0)] {
            scene.runner.messages().command = Some(command);
            let refused = Instant::now();
            let stood = scene.wheels_stand().await;
            // It is published with the next beat.
            assert_within(refused, stood, 100);
            scene.still().await;
            assert_eq!(scene.runner.state(), u8::from(RobotState::Moving));
            scene.runner.messages().command = Some((0.1, 0.5));
            scene.wheels_turn().await;
        }

        let allowed = |given: &micro::Wheels| {
            (0..=100).contains(&given.speed_mm_s) && (0..=500).contains(&given.turn_rate_mrad_s)
        };
        assert!(scene.micro.inside().wheels.iter().all(allowed));
        scene.end().await;
    });
}

#[test]
fn a_stale_command_stops_the_wheels_until_a_fresh_one_comes() {
    in_own_network(
        "safety::a_stale_command_stops_the_wheels_until_a_fresh_one_comes",
        async || {
            let scene = Scene::commanded(&[]).await;

            scene.runner.messages().command = None;
            let silent = Instant::now();
            let stood = scene.wheels_stand().await;
            // 2.5 periods of 130 ms.
            assert_within(silent, stood, 325);
            scene.still().await;
            assert_eq!(
                scene.runner.state(),
                u8::from(RobotState::Moving),
                "a stale command is no latch"
            );

            scene.runner.messages().command = Some((0.1, 0.5));
            scene.wheels_turn().await;
            scene.end().await;
        },
    );
}

#[test]
fn an_e_stop_latches_until_a_newer_epoch_arms() {
    in_own_network("safety::an_e_stop_latches_until_a_newer_epoch_arms", async || {
        let scene = Scene::commanded(&[]).await;

        scene.runner.messages().e_stop = Some(true);
        let engaged = Instant::now();
        let stood = scene.wheels_stand().await;
        // It is published with the next beat.
        assert_within(engaged, stood, 100 + 200);
        scene.runner.messages().e_stop = Some(false);
        scene.still().await;
        assert!(scene.runner.messages().status.stop_reason.contains("e-stop"));

        scene.drive_in_epoch(2).await;

        // Whoever was received once and falls silent locks as well.
        scene.runner.messages().e_stop = None;
        scene.wheels_stand().await;
        scene.end().await;
    });
}

#[test]
fn a_runner_that_falls_silent_stops_the_wheels_and_may_let_them_go_on_within_a_second() {
    in_own_network(
        "safety::a_runner_that_falls_silent_stops_the_wheels_and_may_let_them_go_on_within_a_second",
        async || {
            let scene = Scene::commanded(&[]).await;

            scene.runner.messages().lease = None;
            let silent = Instant::now();
            let stood = scene.wheels_stand().await;
            assert_within(silent, stood, 500);
            scene.runner.messages().lease = Some((1, u8::from(LeaseState::Running)));
            scene.wheels_turn().await;

            scene.runner.messages().lease = None;
            scene.wheels_stand().await;
            tokio::time::sleep(RESUME_TIMEOUT + WATCH).await;
            scene.runner.messages().lease = Some((1, u8::from(LeaseState::Running)));
            scene.still().await;
            assert_eq!(scene.runner.messages().status.stop_reason, "lease ran out");
            scene.end().await;
        },
    );
}

#[test]
fn another_digest_stops_the_wheels_for_good() {
    in_own_network("safety::another_digest_stops_the_wheels_for_good", async || {
        let scene = Scene::commanded(&[]).await;

        scene.runner.messages().foreign_controller = Some(DIGEST + 1);
        scene.wheels_stand().await;
        scene.runner.messages().foreign_controller = Some(DIGEST);
        scene.still().await;
        scene.end().await;
    });
}

#[test]
fn an_unplugged_robot_stays_out_of_its_run_and_joins_the_next() {
    in_own_network(
        "safety::an_unplugged_robot_stays_out_of_its_run_and_joins_the_next",
        async || {
            let mut scene = Scene::commanded(&[]).await;

            let path = scene.socket.path();
            drop(std::mem::replace(&mut scene.micro, Micro::plug_in(&path)));
            eventually("the robot reports that its hardware failed", || {
                scene.runner.state() == RobotState::Fault
            })
            .await;
            eventually("the robot has found its hardware again", || {
                scene.runner.state() == RobotState::Stopped
            })
            .await;
            scene.still().await;
            let reason = scene.runner.messages().status.stop_reason.clone();
            assert!(reason.contains("hardware fault: the other end has gone"), "{reason}");

            scene.drive_in_epoch(2).await;
            scene.end().await;
        },
    );
}

#[test]
fn a_terminated_node_stops_the_wheels_first_and_reports_it() {
    in_own_network("safety::a_terminated_node_stops_the_wheels_first_and_reports_it", async || {
        let mut scene = Scene::commanded(&[]).await;

        scene.node.signal(libc::SIGTERM);
        let asked = Instant::now();
        let stood = scene.wheels_stand().await;
        assert_within(asked, stood, 0);
        let commanded = scene.micro.inside().commanded.expect("commands came");
        let since_command = stood.saturating_duration_since(commanded);
        assert!(since_command < Duration::from_millis(100), "it was the timeout that stopped them");
        eventually("the robot reports that it has ended", || {
            scene.runner.messages().status.stop_reason.contains("the robot's node has ended")
        })
        .await;
        let status = scene.node.wait();
        assert!(status.success(), "the node ended with {status}");
        scene.end().await;
    });
}
