//! What a robot's node keeps in memory while it drives: little, and no more with time.
//!
//! `RSRS_MEMORY_S` sets for how many seconds it is watched.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::time::{Duration, Instant};

use super::safety::Scene;
use rsrs_testing::environment::number;
use rsrs_testing::network::in_own_network;

/// The most that a robot's computer has to spare, in KiB.
const MOST_KIB: u64 = 25 * 1024;
/// What the allocator may add until its size settles, in KiB.
const GROWTH_KIB: u64 = 512;
/// A node that has driven for so long has met all that it ever meets.
const WARM: Duration = Duration::from_secs(5);
const WATCH_S: u64 = 8;

/// Resident memory of a process, in KiB.
fn resident_kib(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("it is there");
    let number = line.trim().trim_end_matches(" kB");
    number.parse().expect("it is a number of KiB")
}

/// A wait for a processor that may stop a robot; the shortest of the protocol's timeouts is 250 ms.
const STARVED: Duration = Duration::from_millis(100);
/// How long ago that may have been when the robot stands.
const JUST_NOW: Duration = Duration::from_secs(2);
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// How long each thread of a process has waited for a processor so far, by its number.
fn waited(pid: u32) -> BTreeMap<OsString, Duration> {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).expect("it runs");
    let waited = threads.filter_map(|thread| {
        let thread = thread.expect("it can be listed");
        // A thread may have ended since.
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        let waited_ns = text.split_whitespace().nth(1)?.parse().expect("it is a number of ns");
        Some((thread.file_name(), Duration::from_nanos(waited_ns)))
    });
    waited.collect()
}

/// Watches a robot that drives, which stands only where the machine had no time for its node, for its
/// microcontroller or for what commands it, and is armed anew then; returns how often that was.
async fn watch_driving(scene: &Scene, watched: Duration) -> u64 {
    let processes = [scene.node.id(), std::process::id()];
    let look = || processes.map(waited);
    let end = Instant::now() + watched;
    let (mut n_stops, mut before, mut starved) = (0, look(), None);
    while Instant::now() < end {
        tokio::time::sleep(LOOK_EVERY).await;
        let now = look();
        let waits = before.iter().zip(&now).flat_map(|(before, now)| {
            now.iter().filter_map(|(thread, waited)| waited.checked_sub(*before.get(thread)?))
        });
        if waits.max().is_some_and(|longest| longest >= STARVED) {
            starved = Some(Instant::now());
        }
        before = now;
        if !scene.drives() {
            let was_starved = starved.is_some_and(|at| at.elapsed() < JUST_NOW);
            let why = scene.why_it_stands();
            assert!(was_starved, "it stood on a machine with time for it: {why:?}");
            n_stops += 1;
            scene.drive_in_epoch(1 + n_stops).await;
        }
    }
    n_stops
}

#[test]
fn a_driving_node_is_small_and_does_not_grow() {
    in_own_network("memory::a_driving_node_is_small_and_does_not_grow", async || {
        let watch_s = number("RSRS_MEMORY_S").unwrap_or(WATCH_S);
        let scene = Scene::commanded(&[]).await;
        let pid = scene.node.id();

        tokio::time::sleep(WARM).await;
        let before_kib = resident_kib(pid);
        let n_stops = watch_driving(&scene, Duration::from_secs(watch_s)).await;
        let after_kib = resident_kib(pid);

        writeln!(
            std::io::stdout(),
            "{before_kib} KiB after {WARM:?}, {after_kib} KiB {watch_s} s later; \
             the machine stopped it {n_stops} times"
        )
        .expect("somebody reads");
        assert!(after_kib <= MOST_KIB, "{after_kib} KiB, expected at most {MOST_KIB}");
        assert!(after_kib <= before_kib + GROWTH_KIB, "{before_kib} KiB grew to {after_kib} KiB");
        scene.end().await;
    });
}
