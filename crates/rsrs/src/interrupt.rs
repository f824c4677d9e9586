//! Ctrl-C and SIGTERM: as a flag that long work looks at, and as something to wait for.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use anyhow::Context;
use rsrs_ros::runtime::runtime;
use rsrs_ros::shutdown::{self, Request, Requests};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Number of the signal that was received; 0 while none was.
static SIGNAL: AtomicU8 = AtomicU8::new(0);

/// The exit code of a program that a signal has ended, as shells expect it: 130 for Ctrl-C, 143 for
/// SIGTERM, `None` without a signal.
pub fn exit_code() -> Option<u8> {
    let signal = SIGNAL.load(Ordering::Relaxed);
    (signal > 0).then_some(128 + signal)
}

fn note(request: Request) {
    let signal = match request {
        Request::Interrupt => 2,
        Request::Terminate => 15,
    };
    SIGNAL.store(signal, Ordering::Relaxed);
}

/// Listens for SIGINT and SIGTERM from now on. The flag becomes true at the first one; work then
/// ends and leaves nothing half-written.
pub fn listen() -> anyhow::Result<&'static AtomicBool> {
    let runtime = runtime()?;
    // Before this returns, and not when the thread comes to it.
    let mut requests = {
        let _context = runtime.enter();
        Requests::new().context("receiving signals")?
    };
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            note(runtime.block_on(requests.next()));
            REQUESTED.store(true, Ordering::Relaxed);
        })
        .context("starting the signal listener")?;
    Ok(&REQUESTED)
}

/// Waits until this process is requested to stop; for ever where signals cannot be received.
pub async fn requested() {
    if shutdown::requested().await.is_err() {
        std::future::pending::<()>().await;
    }
}

/// Waits until this process is requested to stop, and returns how.
pub async fn asked_to_stop() -> String {
    let requested = shutdown::requested().await;
    if let Ok(request) = requested {
        note(request);
    }
    match requested {
        Ok(Request::Interrupt) => "interrupted".to_owned(),
        Ok(Request::Terminate) => "asked to terminate".to_owned(),
        Err(error) => format!("signals cannot be received: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_listens_is_not_killed_any_more() {
        listen().unwrap();

        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        let caught = u64::from_str_radix(caught.trim(), 16).unwrap();
        for signal in [2, 15] {
            assert_eq!(caught >> (signal - 1) & 1, 1, "{signal} is not caught: {caught:x}");
        }
    }
}
