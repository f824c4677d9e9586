//! What a robot's node keeps in memory while it drives: little, and no more with time.
//!
//! `RSRS_MEMORY_S` sets for how many seconds it is watched.

use std::collections::VecDeque;
use std::io::Write;
use std::time::{Duration, Instant};

use super::safety::Scene;
use rsrs_testing::environment::number;
use rsrs_testing::network::in_own_network;
use rsrs_testing::processor::{STARVED, waited};

/// The most that a robot's computer has to spare, in KiB.
const MOST_KIB: u64 = 25 * 1024;
/// What the allocator may add until its size settles, in KiB.
const ALLOCATOR_KIB: u64 = 256;
/// Where a best-effort reader has missed a sample of a publisher, or found it after its first one, `rustdds` keeps the
/// numbers of the last 8,192 samples (`MAX_TRACKED_CHANGES_PER_WRITER`), 27 bytes each.
const NUMBERS_KIB: u64 = 8192 * 27 / 1024;
/// Of leases, of the controller's statuses, and of commands, which are also read as best effort.
const BEST_EFFORT_READERS: u64 = 3;
const GROWTH_KIB: u64 = ALLOCATOR_KIB + BEST_EFFORT_READERS * NUMBERS_KIB;
/// A node that has driven for so long has met all that it ever meets.
const WARM: Duration = Duration::from_secs(5);
const WATCH_S: u64 = 8;

/// Resident memory of a process, in KiB: all of it, and what it has asked for itself. The rest is code, of which
/// there is more once it has met a fault.
fn resident_kib(pid: u32) -> [u64; 2] {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).expect("it runs");
    ["VmRSS:", "RssAnon:"].map(|key| {
        let line = status.lines().find_map(|line| line.strip_prefix(key)).expect("it is there");
        line.trim().trim_end_matches(" kB").parse().expect("it is a number of KiB")
    })
}

/// How long ago the machine may have kept a robot waiting that stands.
const JUST_NOW: Duration = Duration::from_secs(2);
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Watches a robot that drives.
struct Watch<'a> {
    scene: &'a Scene,
    epoch: u64,
    /// How long this task overslept so far: a machine that stood still lets nobody wait for a processor.
    overslept: Duration,
}

impl Watch<'_> {
    /// How long its node, its microcontroller and what commands it had no processor so far.
    fn waited(&self) -> Duration {
        waited(self.scene.node.id()) + waited(std::process::id()) + self.overslept
    }

    async fn sleep(&mut self) {
        let begun = Instant::now();
        tokio::time::sleep(LOOK_EVERY).await;
        self.overslept += begun.elapsed().saturating_sub(LOOK_EVERY);
    }

    /// Watches it, and starts another run when it stands, which it may only where the machine had no time for it.
    async fn drive(&mut self, watched: Duration) {
        let end = Instant::now() + watched;
        let mut looks = VecDeque::new();
        while Instant::now() < end {
            looks.push_back((Instant::now(), self.waited()));
            self.sleep().await;
            if self.scene.drives() {
                looks.retain(|look: &(Instant, Duration)| look.0.elapsed() < JUST_NOW);
                continue;
            }
            let (stood, before) = (Instant::now(), looks[0].1);
            while self.waited() < before + STARVED {
                let why = self.scene.why_it_stands();
                assert!(stood.elapsed() < JUST_NOW, "it stands on a machine with time: {why:?}");
                self.sleep().await;
            }
            self.start_again().await;
            looks.clear();
        }
    }

    /// Starts another run, and one more if the machine had no time for that.
    async fn start_again(&mut self) {
        loop {
            self.epoch += 1;
            let before = self.waited();
            self.scene.start_epoch(self.epoch).await;
            let started = Instant::now();
            while started.elapsed() < JUST_NOW {
                self.sleep().await;
                if self.scene.drives() {
                    return;
                }
            }
            let why = self.scene.why_it_stands();
            assert!(self.waited() >= before + STARVED, "it never drives: {why:?}");
        }
    }
}

#[test]
fn a_driving_node_is_small_and_does_not_grow() {
    in_own_network("memory::a_driving_node_is_small_and_does_not_grow", async || {
        let watch_s = number("RSRS_MEMORY_S").unwrap_or(WATCH_S);
        let scene = Scene::commanded(&[]).await;
        let pid = scene.node.id();
        let mut watch = Watch { scene: &scene, epoch: 1, overslept: Duration::ZERO };

        watch.drive(WARM).await;
        let [all_kib, before_kib] = resident_kib(pid);
        watch.drive(Duration::from_secs(watch_s)).await;
        let [_, after_kib] = resident_kib(pid);

        writeln!(
            std::io::stdout(),
            "{all_kib} KiB after {WARM:?}, of which {before_kib} KiB are no code, {after_kib} KiB {watch_s} s \
             later; the machine stopped it {} times",
            watch.epoch - 1
        )
        .expect("somebody reads");
        assert!(all_kib <= MOST_KIB, "{all_kib} KiB, expected at most {MOST_KIB}");
        assert!(after_kib <= before_kib + GROWTH_KIB, "{before_kib} KiB grew to {after_kib} KiB");
        scene.end().await;
    });
}
