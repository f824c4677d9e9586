//! A hundred robots of one simulator, with the test as everybody else.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::conductor::{Conductor, Pace, names};
use crate::fleet::Node;
use crate::support::{in_own_network, session};

const N_ROBOTS: usize = 100;

#[test]
fn of_a_hundred_virtual_robots_nothing_is_lost() {
    in_own_network("scale::of_a_hundred_virtual_robots_nothing_is_lost", hundred);
}

async fn hundred() {
    let child = Command::new(env!("CARGO_BIN_EXE_sim_node"))
        .args(["--interface", "127.0.0.1", "--robots", &names(N_ROBOTS).join(",")])
        .env("ROS_DOMAIN_ID", "42")
        .stdout(Stdio::null())
        .spawn()
        .expect("the node was built for this test");
    let _simulator = Node(child);
    let session = session();
    let mut conductor = Conductor::new(&session, N_ROBOTS, Pace::RealTime).await;
    conductor.place().await;

    let report = conductor.conduct(Duration::from_secs(6)).await;

    assert_eq!(report.lost, 0, "{report:?}");
    // Even on a busy machine more than the first few periods come, and of every robot.
    assert!(report.steps >= 10, "{report:?}");
    let n_robots = N_ROBOTS as u64;
    assert!(report.detections + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    assert!(report.poses + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    drop(conductor);
    session.close().await;
}
