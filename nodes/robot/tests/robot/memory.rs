//! What a robot's node keeps in memory while it drives: little, and no more with time.
//!
//! `RSRS_MEMORY_S` sets for how many seconds it is watched.

use std::io::Write;
use std::time::Duration;

use super::safety::Scene;
use rsrs_testing::environment::number;
use rsrs_testing::network::in_own_network;

/// The most that a robot's computer has to spare, in KiB.
const MOST_KIB: u64 = 25 * 1024;
/// What the allocator may add until its size settles, in KiB.
const GROWTH_KIB: u64 = 512;
/// A node that has driven for so long has met all that it ever meets.
const WARM: Duration = Duration::from_secs(5);
const WATCH_S: u64 = 15;

/// Resident memory of a process, in KiB.
fn resident_kib(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("it is there");
    let number = line.trim().trim_end_matches(" kB");
    number.parse().expect("it is a number of KiB")
}

#[test]
fn a_driving_node_is_small_and_does_not_grow() {
    in_own_network("memory::a_driving_node_is_small_and_does_not_grow", async || {
        let watch_s = number("RSRS_MEMORY_S").unwrap_or(WATCH_S);
        let scene = Scene::commanded(&[]).await;
        let pid = scene.node.id();

        tokio::time::sleep(WARM).await;
        let before_kib = resident_kib(pid);
        tokio::time::sleep(Duration::from_secs(watch_s)).await;
        let after_kib = resident_kib(pid);

        let (reason, pause) = (scene.why_it_stands(), scene.micro.inside().longest_pause);
        assert_eq!(
            scene.micro.wheels(),
            (100, 500),
            "it drove all the time: {reason}; its microcontroller had no processor for up to {pause:?}"
        );
        writeln!(
            std::io::stdout(),
            "{before_kib} KiB after {WARM:?}, {after_kib} KiB {watch_s} s later"
        )
        .expect("somebody reads");
        assert!(after_kib <= MOST_KIB, "{after_kib} KiB, expected at most {MOST_KIB}");
        assert!(after_kib <= before_kib + GROWTH_KIB, "{before_kib} KiB grew to {after_kib} KiB");
        scene.end().await;
    });
}
