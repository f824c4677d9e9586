//! A terminal that is stopped while robots move: nothing that it is to show may hold up their leases.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::fleet::{ROBOTS, experiment, node};
use crate::processes::{Process, in_own_network, rsrs};
use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_testing::network::TIMEOUT;

/// How long the robots move: many times longer than a lease.
const RUN_S: u64 = 6;

/// Reads what the program writes, until it has written this.
fn read_until(pipe: &mut impl Read, expected: &str) -> String {
    let mut read = String::new();
    let mut buffer = [0; 256];
    while !read.contains(expected) {
        let n_bytes = pipe.read(&mut buffer).expect("it can be read");
        assert!(n_bytes > 0, "the program ended before \u{201c}{expected}\u{201d}:\n{read}");
        read.push_str(&String::from_utf8_lossy(&buffer[..n_bytes]));
    }
    read
}

/// Fills a pipe that nobody reads, through an end of its own, so that the program's end still blocks.
fn fill(pipe: &impl AsRawFd) {
    let path = format!("/proc/self/fd/{}", pipe.as_raw_fd());
    let open = OpenOptions::new().write(true).custom_flags(libc::O_NONBLOCK).open(path);
    let mut end: File = open.expect("Linux opens pipes by their number");
    for size in [4096, 1] {
        loop {
            match end.write(&vec![b'#'; size]) {
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) => panic!("{error}"),
            }
        }
    }
}

#[test]
fn a_run_whose_output_nobody_reads_completes() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let changes = [("robots: 9", "robots: 2"), ("time: lockstep", "time: real_time")];
        let experiment = experiment(folder.path(), RUN_S, &changes);
        let _nodes = [node("sim", &ROBOTS[..2]), node("controller", &ROBOTS[..2])];
        let bag = folder.path().join("bag");
        let mut command = rsrs();
        command.args(["run", "--backend", "fleet", "--interface", "127.0.0.1"]);
        command.arg(experiment).arg("-o").arg(&bag);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut run = Process(command.spawn().expect("the program was built for this test"));
        let mut pipe = run.0.stderr.take().expect("it is piped");

        let read = read_until(&mut pipe, "the robots move in 3 s");
        fill(&pipe);
        wait_for(&bag.join("metadata.yaml"));

        let ending = Bag::open(&bag).expect("it is closed");
        let ending = Ending::from_pairs(ending.metadata(ENDING).expect("it has an ending"));
        let ending = ending.expect("one of ours");
        assert_eq!(ending.kind, EndingKind::Completed, "{}\n{read}", ending.reason);
        let (status, _) = run.wait();
        assert!(status.success(), "it ends, although nobody has read a word since");
        drop(pipe);
    });
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < TIMEOUT, "the bag is never closed");
        std::thread::sleep(Duration::from_millis(50));
    }
}
