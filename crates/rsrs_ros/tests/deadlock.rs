//! A middleware whose threads wait for each other, in a program that starts while others come and go.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rsrs_msgs::topics;
use rsrs_ros::session::start_again_after_deadlock;
use rsrs_testing::network::{TIMEOUT, in_own_network, session};

const TEST: &str = "a_program_whose_middleware_waits_for_itself_starts_again";
/// Names the part of a process of this test.
const PART: &str = "RSRS_DEADLOCK_PART";
/// Readers of one topic; each writer of it is matched with all of them, which is more than `RustDDS` has
/// room for at a time.
const READERS: usize = 40;
/// Writers that a program makes at its start: without a cure about every second one comes to no end.
const WRITERS: usize = 120;
const STARTS: usize = 4;
/// For how long those are there that come and go.
const STAYS: Duration = Duration::from_millis(1200);

#[test]
fn a_program_whose_middleware_waits_for_itself_starts_again() {
    if let Ok(part) = std::env::var(PART) {
        take(&part);
        return;
    }
    in_own_network(TEST, async || {
        let _lasting: Vec<Part> = (0..3).map(|_| Part::start("reads")).collect();
        let mut visitors: Vec<(Part, Instant)> = Vec::new();
        for start in 0..STARTS {
            let mut writes = Part::start("writes");
            let begun = Instant::now();
            let status = loop {
                visitors.retain(|(_, came)| came.elapsed() < STAYS);
                while visitors.len() < 2 {
                    visitors.push((Part::start("reads"), Instant::now()));
                    std::thread::sleep(STAYS / 2);
                }
                if let Some(status) = writes.0.try_wait().expect("it is our child") {
                    break status;
                }
                assert!(begun.elapsed() < TIMEOUT, "start {start} does not end");
                std::thread::sleep(Duration::from_millis(20));
            };
            assert!(status.success(), "start {start}: {status}");
        }
    });
}

/// What the processes of this test do.
fn take(part: &str) {
    start_again_after_deadlock();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.expect("a runtime needs no rights").block_on(async {
        let session = session();
        let (topic, type_name, qos) = ("/common", "std_msgs/msg/Bool", topics::LEASE.qos);
        if part == "writes" {
            let write = |_| session.publish_raw(topic, type_name, qos).expect("it is allowed");
            let writers: Vec<_> = (0..WRITERS).map(write).collect();
            drop(writers);
            session.close().await;
            return;
        }
        let read = |_| session.subscribe_raw(topic, type_name, qos, |_| ()).expect("it is allowed");
        let _readers: Vec<_> = (0..READERS).map(read).collect();
        tokio::time::sleep(Duration::from_secs(600)).await;
    });
}

/// A process of this test, until it is dropped.
struct Part(Child);

impl Part {
    fn start(part: &str) -> Self {
        let executable = std::env::current_exe().expect("a running test has an executable");
        let mut command = Command::new(executable);
        command.args(["--exact", TEST, "--nocapture"]).env(PART, part).stdout(Stdio::null());
        Self(command.spawn().expect("it was built"))
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // One that has ended cannot be killed, and needs not.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}
