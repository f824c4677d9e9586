//! Many robots of one simulator, with the test as everybody else.

use std::time::Duration;

use crate::fleet::start_with;
use crate::fleet_runner::{FleetRunner, TimeMode, names};
use rsrs_testing::network::{in_own_network, session};

const N_ROBOTS: usize = 100;

#[test]
fn of_a_hundred_virtual_robots_nothing_is_lost() {
    in_own_network("scale::of_a_hundred_virtual_robots_nothing_is_lost", hundred);
}

async fn hundred() {
    let _simulator = start_with(&names(N_ROBOTS).join(","));
    let session = session();
    let mut fleet_runner = FleetRunner::new(&session, N_ROBOTS, TimeMode::RealTime).await;
    fleet_runner.place().await;

    let report = fleet_runner.run(Duration::from_secs(6)).await;

    assert_eq!((report.lost, report.moving), (0, N_ROBOTS), "{report:?}");
    // Even on a busy machine more than the first few periods come, and of every robot.
    assert!(report.steps >= 10, "{report:?}");
    let n_robots = N_ROBOTS as u64;
    assert!(report.detections + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    assert!(report.poses + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    drop(fleet_runner);
    session.close().await;
}
