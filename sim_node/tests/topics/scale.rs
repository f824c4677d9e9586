//! Many robots of one simulator, with the test as everybody else.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::conductor::{Conductor, TimeMode, names};
use crate::fleet::Node;
use rsrs_testing::network::{in_own_network, session};

const N_ROBOTS: usize = 100;

#[test]
fn of_a_hundred_virtual_robots_nothing_is_lost() {
    in_own_network("scale::of_a_hundred_virtual_robots_nothing_is_lost", hundred);
}

#[test]
fn ten_virtual_robots_go_to_the_end_in_lockstep() {
    in_own_network("scale::ten_virtual_robots_go_to_the_end_in_lockstep", ten);
}

async fn hundred() {
    let _simulator = simulator(N_ROBOTS);
    let session = session();
    let mut conductor = Conductor::new(&session, N_ROBOTS, TimeMode::RealTime).await;
    conductor.place().await;

    let report = conductor.conduct(Duration::from_secs(6)).await;

    assert_eq!((report.lost, report.moving), (0, N_ROBOTS), "{report:?}");
    // Even on a busy machine more than the first few periods come, and of every robot.
    assert!(report.steps >= 10, "{report:?}");
    let n_robots = N_ROBOTS as u64;
    assert!(report.detections + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    assert!(report.poses + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    drop(conductor);
    session.close().await;
}

async fn ten() {
    let (n_robots, steps) = (10, 30);
    let _simulator = simulator(n_robots);
    let session = session();
    let mut conductor = Conductor::new(&session, n_robots, TimeMode::Lockstep { steps }).await;
    conductor.place().await;

    let report = conductor.conduct(Duration::from_secs(60)).await;

    assert_eq!((report.steps, report.lost, report.moving), (steps, 0, n_robots), "{report:?}");
    drop(conductor);
    session.close().await;
}

fn simulator(n_robots: usize) -> Node {
    let child = Command::new(env!("CARGO_BIN_EXE_sim_node"))
        .args(["--interface", "127.0.0.1", "--robots", &names(n_robots).join(",")])
        .env("ROS_DOMAIN_ID", "42")
        .stdout(Stdio::null())
        .spawn()
        .expect("the node was built for this test");
    Node(child)
}
