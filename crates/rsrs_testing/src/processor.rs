//! Processes that wait for a processor.

use std::fs;
use std::time::Duration;

/// How long a machine may keep processes waiting of which none may stand for that; the shortest of the protocol's
/// timeouts is 250 ms.
pub const STARVED: Duration = Duration::from_millis(100);

/// For how long the threads of a process have waited for a processor while they had something to do; a wait
/// counts when it is over.
pub fn waited(pid: u32) -> Duration {
    let Ok(threads) = fs::read_dir(format!("/proc/{pid}/task")) else { return Duration::ZERO };
    let waited = threads.filter_map(|thread| {
        let text = fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        Some(Duration::from_nanos(text.split(' ').nth(1)?.parse().ok()?))
    });
    waited.sum()
}
