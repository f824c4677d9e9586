//! Many robots of one simulator, with the test as everybody else.

use std::time::Duration;

use crate::fleet::start_with;
use crate::fleet_runner::{FleetRunner, Report, TimeMode, names};
use rsrs_testing::network::{in_own_network, session};
use rsrs_testing::processor::{STARVED, waited};

const N_ROBOTS: usize = 100;
/// How often a machine that is busy may stop them.
const TRIES: usize = 3;

#[test]
fn of_a_hundred_virtual_robots_nothing_is_lost() {
    in_own_network("scale::of_a_hundred_virtual_robots_nothing_is_lost", hundred);
}

async fn hundred() {
    let mut tries = 1;
    let report = loop {
        let (report, waited) = lead().await;
        if report.moving == N_ROBOTS || waited < STARVED || tries == TRIES {
            break report;
        }
        tries += 1;
    };

    assert_eq!((report.lost, report.moving), (0, N_ROBOTS), "{report:?}, try {tries}");
    // Even on a busy machine more than the first few periods come, and of every robot.
    assert!(report.steps >= 10, "{report:?}");
    let n_robots = N_ROBOTS as u64;
    assert!(report.detections + 2 * n_robots >= report.steps * n_robots, "{report:?}");
    assert!(report.poses + 2 * n_robots >= report.steps * n_robots, "{report:?}");
}

/// Six seconds of a new fleet, and how long its processes had to wait for a processor.
async fn lead() -> (Report, Duration) {
    let simulator = start_with(&names(N_ROBOTS).join(","));
    let session = session();
    let mut fleet_runner = FleetRunner::new(&session, N_ROBOTS, TimeMode::RealTime).await;
    fleet_runner.place().await;
    let all_waited = || waited(simulator.0.id()) + waited(std::process::id());
    let before = all_waited();

    let report = fleet_runner.run(Duration::from_secs(6)).await;

    let waited = all_waited().saturating_sub(before);
    drop(fleet_runner);
    session.close().await;
    (report, waited)
}
